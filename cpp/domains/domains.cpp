#include "domains/domains.h"

#include <algorithm>
#include <cmath>

#include "base/invalid_argument.h"

namespace motes::domains {
namespace {

// Number of particles that are looked up side by side: with thousands of cuts and unsorted particles, looking them up
// one by one would mispredict every second branch and wait for each load.
constexpr std::size_t kAbreast = 16;

void check_axis(int axis, int most) {
  if (axis < 0 || axis > most) throw base::InvalidArgument("a cut", "be along an axis of space, or by id");
}

void check_order(const std::vector<float>& cuts) {
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const bool ascends = i == 0 || cuts[i - 1] <= cuts[i];
    if (std::isnan(cuts[i]) || !ascends) throw base::InvalidArgument("cuts", "be in ascending order, without NaN");
  }
}

// Marks blocks that no single domain owns.
constexpr std::uint32_t kDivided = UINT32_MAX;

// Returns the owner of each block of a curve.
std::vector<std::uint32_t> owners_of_blocks(const std::vector<float>& cuts) {
  std::vector<std::uint32_t> owners(Curve::kBlocks);
  std::size_t owner = 0;
  for (std::uint32_t block = 0; block < Curve::kBlocks; ++block) {
    const std::uint32_t begin = block * Curve::kInBlock;
    while (owner < cuts.size() && Curve::first_behind(cuts[owner]) <= begin) ++owner;
    const bool divided = owner < cuts.size() && Curve::first_behind(cuts[owner]) < begin + Curve::kInBlock;
    owners[block] = divided ? kDivided : static_cast<std::uint32_t>(owner);
  }
  return owners;
}

// Throws unless each cut is within the part of space that it halves.
void check_inside(const std::vector<Cut>& tree, int first, int last, const Box& box) {
  if (last - first < 2) return;
  const int middle = first + left_part(last - first);
  const Cut& cut = tree[static_cast<std::size_t>(middle - 1)];
  const auto axis = static_cast<std::size_t>(cut.axis);
  const bool inside = cut.at >= box.low[axis] && cut.at <= box.high[axis];
  if (!inside) throw base::InvalidArgument("a cut", "lie within the part of space that it divides");
  Box left = box;
  Box right = box;
  left.high[axis] = right.low[axis] = cut.at;
  check_inside(tree, first, middle, left);
  check_inside(tree, middle, last, right);
}

}  // namespace

Domains::Domains(std::vector<float> cuts, int axis) : cuts_(std::move(cuts)), axis_(axis) {
  check_axis(axis, kById);
  check_order(cuts_);
}

Domains::Domains(std::vector<float> cuts, std::shared_ptr<const Curve> curve)
    : cuts_(std::move(cuts)), axis_(curve->axis()), curve_(std::move(curve)) {
  check_order(cuts_);
  of_blocks_ = owners_of_blocks(cuts_);
}

Domains Domains::with(std::vector<float> cuts) const {
  return curve_ ? Domains(std::move(cuts), curve_) : Domains(std::move(cuts), axis_);
}

Domains Domains::of(const std::vector<Cut>& tree, std::shared_ptr<const Curve> curve) {
  const auto differs = [&](const Cut& cut) { return cut.axis != tree[0].axis; };
  std::vector<float> cuts;
  for (const Cut& cut : tree) cuts.push_back(cut.at);
  const bool alike = std::none_of(tree.begin(), tree.end(), differs);
  if (curve && alike && (tree.empty() || tree[0].axis == curve->axis())) {
    return {std::move(cuts), std::move(curve)};
  }
  if (alike) {
    return Domains(std::move(cuts), tree.empty() ? 0 : tree[0].axis);
  }
  for (const Cut& cut : tree) check_axis(cut.axis, 2);
  Domains domains;
  domains.axis_ = -1;
  domains.cuts_ = std::move(cuts);
  check_inside(tree, 0, domains.count(), {});
  domains.nodes_ = tree;
  domains.nodes_.insert(domains.nodes_.begin(), Cut{tree[0].axis, 0});  // walk() reads it, so its axis must be valid
  return domains;
}

std::vector<Cut> Domains::tree() const {
  if (!nodes_.empty()) return {nodes_.begin() + 1, nodes_.end()};
  std::vector<Cut> tree;
  tree.reserve(cuts_.size());
  for (const float at : cuts_) tree.push_back({axis_, at});
  return tree;
}

// Finds the number of cuts at or below each x. Each step halves the remaining range without a branch. NaN compares
// false with every cut, so its search ends at the last domain.
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

// Finds owners by going down the tree, level by level, without a branch. A particle that has arrived stays: its size is
// then 1 or 0, and half of that is 0.
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

// Finds owners along a curve. Most blocks have one owner, so most particles need only their block.
void Domains::look_up(const Places& places, std::size_t first, std::size_t count, std::uint32_t* owners) const {
  const auto& [x, y, z] = places.position;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t p = first + i;
    const bool nowhere = std::isnan(x[p]) || std::isnan(y[p]) || std::isnan(z[p]);
    owners[i] = nowhere ? kDivided : of_blocks_[curve_->block_of(curve_->cell_of(x[p], y[p], z[p]))];
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (owners[i] != kDivided) continue;
    float along = 0;
    curve_->places_of(places, first + i, first + i + 1, &along);
    search({&along, 1}, owners + i);
  }
}

void Domains::owners_of(const Places& places, std::size_t begin, std::size_t end, std::uint32_t* owners) const {
  float x[kAbreast];
  for (std::size_t first = begin; first < end; first += kAbreast) {
    const std::size_t count = std::min(kAbreast, end - first);
    if (curve_) {
      look_up(places, first, count, owners + first);
    } else if (axis_ < 0) {
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
  if (axis_ >= kById) return box;
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

BoxCover Domains::cover(int domain) const {
  if (curve_) {
    return curve_->cover(domain == 0 ? 0 : Curve::first_behind(low(domain)), Curve::first_behind(high(domain)));
  }
  const Box own = box(domain);
  const bool whole = axis_ != kById || count() == 1;
  return {{own}, whole ? std::size_t{1} : 0, own};
}

float Domains::farthest_face() const {
  float most = curve_ ? curve_->farthest_end() : 0;
  for (const float cut : cuts_) most = std::max(most, std::abs(cut));
  return most;
}

bool Domains::operator==(const Domains& other) const {
  const bool same_curve = curve_ == other.curve_ || (curve_ && other.curve_ && *curve_ == *other.curve_);
  return same_curve && axis_ == other.axis_ && cuts_ == other.cuts_ && nodes_ == other.nodes_;
}

float Domains::low(int domain) const {
  return domain == 0 ? -std::numeric_limits<float>::infinity() : cuts_[static_cast<std::size_t>(domain - 1)];
}

float Domains::high(int domain) const {
  return domain == count() - 1 ? std::numeric_limits<float>::infinity() : cuts_[static_cast<std::size_t>(domain)];
}

}  // namespace motes::domains
