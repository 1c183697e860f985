// collide: spheres that rebound from each other. Newborn ones that overlap others are removed first.
#include <algorithm>
#include <limits>

#include "interactions/kinds/families.h"
#include "interactions/kinds/sweeping.h"

namespace motes::interactions {

namespace {

class Colliding : public Sweeping {
 public:
  using Sweeping::Sweeping;

 private:
  void prepare(InteractionCounts& seen) override {
    if (!(clear_ > 0)) return;
    for (std::size_t s = 0; s < meeting_.count; ++s) seen.dropped[s] = in_the_way(s);
    for (std::size_t s = 0; s < meeting_.count; ++s) set_newborn_apart(s);
  }

  void describe(std::size_t s, Task& task) const override {
    Sweeping::describe(s, task);
    task.fast = 2 * extent_.displacement > step_limit(reach_);  // it is along one axis only
    task.gravity = std::max(side(0).collisions.gravity, side(1).collisions.gravity);
  }

  void finish(InteractionCounts& seen) override {
    if (meeting_.step.last) seen.overlap_99 = overlaps();
  }

  bool is_newborn(std::size_t s, std::uint64_t id) const { return id >= side(s).collisions.newborn_from; }

  // Returns newborn particles that overlap others by more than the given part of their radius. Of two newborn particles
  // the one with the higher id, or of the second system, is returned.
  std::vector<std::uint32_t> in_the_way(std::size_t s) const {
    const std::size_t other = seen_by(s);
    const CellsView own = cells(s).view(crowds_[s].own);
    const CellsView others = cells(other).view(crowds_[other].own);
    std::vector<std::uint32_t> found;
    const std::vector<Row>& rows = cells(s).rows();
    for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
      for (std::uint32_t i = rows[r].first; i < rows[r].end(); ++i) {
        const std::uint32_t index = own.order[i];
        if (index >= crowds_[s].own || !is_newborn(s, crowds_[s].id(index))) continue;
        bool hit = false;
        for (const Row* row : rows_around(cells(other), rows[r].x, rows[r].y)) {
          each_near(others, *row, own.z[i], [&](std::uint32_t j) {
            const std::uint64_t id = crowds_[other].id(others.order[j]);
            const bool yields = !is_newborn(other, id) || (s != other ? s == 1 : id < crowds_[s].id(index));
            hit = hit || (yields && (s != other || i != j) && overlaps(s, i, other, j));
          });
        }
        if (hit) found.push_back(index);
      }
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  using Sweeping::overlaps;
  bool overlaps(std::size_t s, std::size_t i, std::size_t other, std::size_t j) const {
    float r2 = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const float d = party(other).column[c][j] - party(s).column[c][i];
      r2 += d * d;
    }
    const float least = radius_at(s, i) * (1 - clear_) + radius_at(other, j);
    return least > 0 && r2 < least * least;
  }

  // Moves newborn particles to NaN, where they push nothing; whether they stay is decided once all of them are known.
  void set_newborn_apart(std::size_t s) const {
    const std::vector<std::uint32_t>& order = cells(s).order();
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (is_newborn(s, crowds_[s].id(order[k]))) party(s).column[at_x][k] = std::numeric_limits<float>::quiet_NaN();
    }
  }

  const float clear_ = law_.clear(action().numbers.data());
};

}  // namespace

std::unique_ptr<PairAction> families::colliding(const Meeting& meeting) { return std::make_unique<Colliding>(meeting); }

}  // namespace motes::interactions
