#include "domains/divide.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace motes::domains {
namespace {

// Returns the axis, one of `axes`, along which a room is longest.
int longest_axis(const Room& room, Axes axes) {
  int best = axes.first();
  for (int axis = best + 1; axis < 3; ++axis) {
    if (axes.has(axis) && room.side(axis) > room.side(best)) best = axis;
  }
  return best;
}

// Halves rooms, and the particles in them, until each domain has its own room. Indices are those of a room's particles.
class Halving {
 public:
  Halving(Axes axes, const Places& places, int count, Across across)
      : axes_(axes), places_(places), across_(across), tree_(static_cast<std::size_t>(count) - 1) {}

  // `before`: the axis of the cut that made this room.
  void divide(int first, int last, const Room& room, std::span<std::uint32_t> indices, int before = 2) {
    if (last - first < 2) return;
    const int left = left_part(last - first);
    const double part = static_cast<double>(left) / (last - first);
    const Cut cut = cut_of(room, indices, part, before);
    tree_[static_cast<std::size_t>(first + left - 1)] = cut;
    const auto axis = static_cast<std::size_t>(cut.axis);
    Room below = room;
    Room above = room;
    // Particles may lie outside of the room at the start.
    below.high[axis] = above.low[axis] = static_cast<double>(cut.at);
    below.low[axis] = std::min(below.low[axis], below.high[axis]);
    above.high[axis] = std::max(above.high[axis], above.low[axis]);
    const float* x = places_.position[axis];
    const auto middle = std::partition(indices.begin(), indices.end(), [&](std::uint32_t p) { return x[p] < cut.at; });
    const auto given = static_cast<std::size_t>(middle - indices.begin());
    divide(first, first + left, below, indices.first(given), cut.axis);
    divide(first + left, last, above, indices.subspan(given), cut.axis);
  }

  Domains domains() const { return Domains::of(tree_); }

 private:
  static bool finite(float x) { return std::abs(x) <= std::numeric_limits<float>::max(); }

  // Returns the coordinates along an axis, without those that are not finite and so cannot be sorted.
  std::vector<float> coordinates(std::span<const std::uint32_t> indices, int axis) const {
    std::vector<float> found;
    found.reserve(indices.size());
    for (const std::uint32_t p : indices) {
      const float x = places_.position[static_cast<std::size_t>(axis)][p];
      if (finite(x)) found.push_back(x);
    }
    return found;
  }

  Cut cut_of(const Room& room, std::span<const std::uint32_t> indices, double part, int before) const {
    std::vector<float> longest;
    int along = longest_axis(room, axes_);
    float reach = -1;
    for (int turn = 1; turn <= 3; ++turn) {
      const int axis = across_ == Across::in_turn ? (before + turn) % 3 : turn - 1;
      if (!axes_.has(axis)) continue;
      std::vector<float> x = coordinates(indices, axis);
      if (x.empty()) continue;
      const auto [least, most] = std::minmax_element(x.begin(), x.end());
      if (!(*most - *least > reach)) continue;
      reach = *most - *least;
      longest = std::move(x);
      along = axis;
      if (across_ == Across::in_turn && reach > 0) break;
    }
    const auto axis = static_cast<std::size_t>(along);
    if (longest.empty()) return {along, static_cast<float>(room.low[axis] + room.side(along) * part)};
    const auto nth = longest.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(longest.size()));
    std::nth_element(longest.begin(), nth, longest.end());
    return {along, *nth};
  }

  Axes axes_;
  const Places& places_;
  Across across_;
  std::vector<Cut> tree_;
};

Room room_between(double low, double high) { return {{low, low, low}, {high, high, high}}; }

Domains bricks(Axes axes, const Room& room, const Places& places, int count, Across across) {
  std::vector<std::uint32_t> indices(places.count);
  std::iota(indices.begin(), indices.end(), 0u);
  Halving halving(axes, places, count, across);
  halving.divide(0, count, room, indices);
  return halving.domains();
}

}  // namespace

Domains equal_slices(double low, double high, int count, int axis) {
  std::vector<float> cuts;
  for (int i = 1; i < count; ++i) cuts.push_back(static_cast<float>(low + (high - low) * i / count));
  return Domains(std::move(cuts), axis);
}

Room room_of(const Space& space, const particles::Periods& periods) {
  const bool finite = space.kind == Space::Kind::finite;
  const double edge = static_cast<double>(kInfinite);
  Room room = room_between(finite ? space.low : -edge, finite ? space.high : edge);
  for (int axis = 0; axis < 3; ++axis) {
    if (!periods.has(axis)) continue;
    room.low[static_cast<std::size_t>(axis)] = static_cast<double>(periods[axis].low);
    room.high[static_cast<std::size_t>(axis)] = static_cast<double>(periods[axis].high);
  }
  return room;
}

bool has_ends(const Space& space, const particles::Periods& periods) {
  return space.kind == Space::Kind::finite || (periods.has(0) && periods.has(1) && periods.has(2));
}

Domains equal_parts(Axes axes, const Room& room, int count) {
  if (axes.by_id()) return equal_slices(0, 1, count, kById);
  if (axes.curve()) {
    return {equal_slices(0, 1, count).cuts(), std::make_shared<const Curve>(axes.first(), room)};
  }
  const auto first = static_cast<std::size_t>(axes.first());
  if (axes.row()) return equal_slices(room.low[first], room.high[first], count, axes.first());
  return bricks(axes, room, {}, count, Across::farthest);
}

Domains equal_parts(Axes axes, double low, double high, int count) {
  return equal_parts(axes, room_between(low, high), count);
}

Domains quantiles(std::span<const float> coordinates, int count, int axis) {
  std::vector<float> sorted(coordinates.begin(), coordinates.end());
  std::erase_if(sorted, [](float x) { return std::isnan(x); });
  if (sorted.empty()) return equal_slices(-kInfinite, kInfinite, count, axis);
  std::vector<float> cuts;
  auto from = sorted.begin();
  for (int i = 1; i < count; ++i) {
    const auto nth = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * static_cast<std::size_t>(i) /
                                                                  static_cast<std::size_t>(count));
    std::nth_element(from, nth, sorted.end());
    cuts.push_back(*nth);
    from = nth;
  }
  return Domains(std::move(cuts), axis);
}

Domains quantiles(std::shared_ptr<const Curve> curve, const Places& places, int count) {
  std::vector<float> along(places.count);
  curve->places_of(places, 0, places.count, along.data());
  std::vector<float> cuts = quantiles(along, count).cuts();
  return {std::move(cuts), std::move(curve)};
}

Domains quantiles(Axes axes, const Places& places, int count, Across across) {
  if (axes.by_id()) return equal_parts(axes, 0, 1, count);
  if (axes.row()) {
    const float* x = places.position[static_cast<std::size_t>(axes.first())];
    return quantiles({x, places.count}, count, axes.first());
  }
  return bricks(axes, room_between(-kInfinite, kInfinite), places, count, across);
}

}  // namespace motes::domains
