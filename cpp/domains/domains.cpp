#include "domains/domains.h"

#include <algorithm>
#include <cmath>

#include "base/invalid_argument.h"

namespace motes::domains {
namespace {

// So many particles are looked up side by side: with thousands of cuts and unsorted particles, a processor that takes
// one after the other would mispredict every second branch and wait for each load.
constexpr std::size_t kAbreast = 16;

void check_axis(int axis, int most) {
  if (axis < 0 || axis > most) throw base::InvalidArgument("a cut", "have an axis of space, or be among the ids");
}

// Each cut must lie within the part of space that it halves.
void check_inside(const std::vector<Cut>& tree, int first, int last, const Box& box) {
  if (last - first < 2) return;
  const int middle = first + left_part(last - first);
  const Cut& cut = tree[static_cast<std::size_t>(middle - 1)];
  const auto axis = static_cast<std::size_t>(cut.axis);
  const bool inside = cut.at >= box.low[axis] && cut.at <= box.high[axis];
  if (!inside) throw base::InvalidArgument("a cut", "lie within the part of space that it halves");
  Box left = box;
  Box right = box;
  left.high[axis] = right.low[axis] = cut.at;
  check_inside(tree, first, middle, left);
  check_inside(tree, middle, last, right);
}

}  // namespace

Domains::Domains(std::vector<float> cuts, int axis) : cuts_(std::move(cuts)), axis_(axis) {
  check_axis(axis, kById);
  for (std::size_t i = 0; i < cuts_.size(); ++i) {
    const bool ascends = i == 0 || cuts_[i - 1] <= cuts_[i];
    if (std::isnan(cuts_[i]) || !ascends) throw base::InvalidArgument("cuts", "be in ascending order, without NaN");
  }
}

Domains Domains::of(const std::vector<Cut>& tree) {
  const auto differs = [&](const Cut& cut) { return cut.axis != tree[0].axis; };
  std::vector<float> cuts;
  for (const Cut& cut : tree) cuts.push_back(cut.at);
  if (std::none_of(tree.begin(), tree.end(), differs)) {
    return Domains(std::move(cuts), tree.empty() ? 0 : tree[0].axis);
  }
  for (const Cut& cut : tree) check_axis(cut.axis, 2);
  Domains domains;
  domains.axis_ = -1;
  domains.cuts_ = std::move(cuts);
  check_inside(tree, 0, domains.count(), {});
  domains.nodes_ = tree;
  domains.nodes_.insert(domains.nodes_.begin(), Cut{tree[0].axis, 0});  // walk() looks at it, on an axis that is there
  return domains;
}

std::vector<Cut> Domains::tree() const {
  if (!nodes_.empty()) return {nodes_.begin() + 1, nodes_.end()};
  std::vector<Cut> tree;
  tree.reserve(cuts_.size());
  for (const float at : cuts_) tree.push_back({axis_, at});
  return tree;
}

// The number of cuts at or below x. Each step halves the remaining range without a branch. NaN compares false with
// every cut: its search ends at the last domain.
void Domains::search(std::span<const float> x, std::uint32_t* below) const {
  const float* const cuts = cuts_.data();
  std::fill_n(below, x.size(), 0u);
  for (auto left = static_cast<std::uint32_t>(cuts_.size()); left > 0;) {
    const std::uint32_t half = (left + 1) / 2;
    for (std::size_t i = 0; i < x.size(); ++i) {
      below[i] += half * static_cast<std::uint32_t>(!(x[i] < cuts[below[i] + half - 1]));
    }
    left -= half;
  }
}

// Down the tree, level by level, without a branch. Who has arrived has nothing left to halve, and stays: size is then 1
// or 0, and half of it 0.
void Domains::walk(const Places& places, std::size_t first, std::size_t count, std::uint32_t* owners) const {
  std::uint32_t size[kAbreast];
  std::fill_n(size, count, static_cast<std::uint32_t>(this->count()));
  std::fill_n(owners, count, 0u);
  for (int most = this->count(); most > 1; most -= left_part(most)) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t half = size[i] / 2;
      const Cut& cut = nodes_[owners[i] + half];
      const float x = places.position[static_cast<std::size_t>(cut.axis)][first + i];
      const auto right = static_cast<std::uint32_t>(!(x < cut.at));
      owners[i] += right * half;
      size[i] = half + right * (size[i] - 2 * half);
    }
  }
}

void Domains::owners_of(const Places& places, std::uint32_t* owners) const {
  float x[kAbreast];
  for (std::size_t first = 0; first < places.count; first += kAbreast) {
    const std::size_t count = std::min(kAbreast, places.count - first);
    if (axis_ < 0) {
      walk(places, first, count, owners + first);
    } else if (axis_ == kById) {
      for (std::size_t i = 0; i < count; ++i) x[i] = scattered(places.ids[first + i]);
      search({x, count}, owners + first);
    } else {
      search({places.position[static_cast<std::size_t>(axis_)] + first, count}, owners + first);
    }
  }
}

Box Domains::box(int domain) const {
  Box box;
  if (axis_ == kById) return box;
  if (axis_ >= 0) {
    const auto axis = static_cast<std::size_t>(axis_);
    box.low[axis] = low(domain);
    box.high[axis] = high(domain);
    return box;
  }
  for (int first = 0, last = count(); last - first > 1;) {
    const int middle = first + left_part(last - first);
    const Cut& cut = nodes_[static_cast<std::size_t>(middle)];
    (domain < middle ? box.high : box.low)[static_cast<std::size_t>(cut.axis)] = cut.at;
    (domain < middle ? last : first) = middle;
  }
  return box;
}

float Domains::low(int domain) const {
  return domain == 0 ? -std::numeric_limits<float>::infinity() : cuts_[static_cast<std::size_t>(domain - 1)];
}

float Domains::high(int domain) const {
  return domain == count() - 1 ? std::numeric_limits<float>::infinity() : cuts_[static_cast<std::size_t>(domain)];
}

}  // namespace motes::domains
