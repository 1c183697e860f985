// Recursive bisection with memory: balanced halves keep the cut between them.
#pragma once

#include <cmath>
#include <utility>

#include "balance/policy.h"
#include "balance/shares.h"
#include "domains/divide.h"

namespace motes::balance {

/// Compares the two halves of all domains, then the halves of each half, and so on, as bricks are divided. If halves
/// differ by more than `threshold` and by more than noise can explain, the cut between them and all cuts below it are
/// placed again; other cuts stay. So an imbalance at one end moves nothing at the other.
class Bisection : public Policy {
 public:
  const char* kind() const override { return "Bisection"; }
  Options options() override {
    return {{"threshold", NumberOption{&threshold_, 1}},
            {"min_particles", CountOption{&min_particles_}},
            smoothing(),
            over()};
  }
  Plan plan(const LoadTable& table) const override;

 private:
  struct Tree;

  double threshold_ = 0.05;
  std::uint64_t min_particles_ = 64;
};

// The state of planning: complete speeds, and the shares so far.
struct Bisection::Tree {
  const Bisection& options;
  const std::vector<Load>& loads;
  std::vector<double> speeds;
  Plan plan;
  bool moves = false;

  // Returns the calculators first..last - 1 as if they were one.
  Load half(std::size_t first, std::size_t last) const {
    Load sum;
    double error2 = 0;
    for (std::size_t c = first; c < last; ++c) {
      sum.particles += loads[c].particles;
      sum.speed += speeds[c];
      error2 += speeds[c] * loads[c].error * speeds[c] * loads[c].error;
    }
    sum.error = std::sqrt(error2) / sum.speed;
    return sum;
  }

  // Divides `particles` among calculators; `anew`: a cut above has moved, so these cuts move too.
  void divide(std::size_t first, std::size_t last, double particles, bool anew) {
    if (last - first < 2) {
      plan.shares[first] = particles;
      return;
    }
    const std::size_t middle = first + static_cast<std::size_t>(domains::left_part(static_cast<int>(last - first)));
    plan.evaluated.push_back(static_cast<std::int32_t>(middle - 1));
    const Load left = half(first, middle);
    const Load right = half(middle, last);
    const double wanted = particles * (left.speed / (left.speed + right.speed));
    const auto held = static_cast<double>(left.particles);
    const bool off =
        apart(left, held / left.speed, right, static_cast<double>(right.particles) / right.speed, options.threshold_) &&
        std::abs(held - wanted) >= static_cast<double>(options.min_particles_);
    anew = anew || off;
    moves = moves || anew;
    const double in_left = anew ? wanted : held;
    divide(first, middle, in_left, anew);
    divide(middle, last, particles - in_left, anew);
  }
};

inline Plan Bisection::plan(const LoadTable& table) const {
  if (table.loads.empty()) return {};
  Tree tree{*this, table.loads, complete(table.loads), {}, false};
  tree.plan.shares.resize(table.loads.size());
  double all = 0;
  for (const Load& load : table.loads) all += static_cast<double>(load.particles);
  tree.divide(0, table.loads.size(), all, false);
  if (!tree.moves || !(all > 0)) tree.plan.shares.clear();
  return std::move(tree.plan);
}

}  // namespace motes::balance
