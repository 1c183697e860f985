#include "domains/curve.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/invalid_argument.h"
#include "domains/hilbert.h"
#include "domains/morton.h"

namespace motes::domains {

namespace {

// Maps floats to integers in the same order.
std::int32_t rank_of(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  return bits < 0 ? std::bit_cast<std::int32_t>(0x80000000u - static_cast<std::uint32_t>(bits)) : bits;
}

float of_rank(std::int32_t rank) {
  const std::uint32_t bits = static_cast<std::uint32_t>(rank);
  return std::bit_cast<float>(rank < 0 ? 0x80000000u - bits : bits);
}

Box around(const std::vector<Box>& boxes) {
  Box all = boxes.front();
  for (const Box& box : boxes) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      all.low[axis] = std::min(all.low[axis], box.low[axis]);
      all.high[axis] = std::max(all.high[axis], box.high[axis]);
    }
  }
  return all;
}

}  // namespace

Curve::Curve(int axis, const Room& room) : axis_(axis), turns_(kMortonTurns), blocks_(kBlocks) {
  if (axis == kHilbert) turns_ = kHilbertTurns;
  for (std::size_t a = 0; a < 3; ++a) {
    low_[a] = static_cast<float>(room.low[a]);
    high_[a] = static_cast<float>(room.high[a]);
    const bool has_extent = high_[a] > low_[a] && std::isfinite(high_[a] - low_[a]);
    if (!has_extent) throw base::InvalidArgument("space", "have a finite extent along each axis of a curve");
    scale_[a] = static_cast<float>(kAlong / (static_cast<double>(high_[a]) - static_cast<double>(low_[a])));
    if (!std::isfinite(scale_[a])) throw base::InvalidArgument("space", "be wider along each axis of a curve");
    for (std::uint32_t cell = 0; cell <= kAlong; ++cell) faces_[a].push_back(face(a, cell));
  }
  for (std::uint32_t place = 0; place < kBlocks; ++place) {
    constexpr std::uint32_t kMask = (1u << kBlockLevels) - 1;
    const Cell block{place & kMask, place >> kBlockLevels & kMask, place >> 2 * kBlockLevels};
    blocks_[place] = static_cast<std::uint16_t>(number_of(block, kBlockLevels));
  }
}

float Curve::farthest_end() const {
  float most = 0;
  for (std::size_t a = 0; a < 3; ++a) most = std::max({most, std::abs(low_[a]), std::abs(high_[a])});
  return most;
}

// Finds the lowest coordinate in a cell, or in one above it. The numbers of cells grow with the coordinates, so it is
// found by bisecting all floats between the ends of the room.
float Curve::face(std::size_t axis, std::uint32_t cell) const {
  if (cell == 0) return -Box::kInf;
  if (cell == kAlong) return Box::kInf;
  std::int64_t below = rank_of(low_[axis]), above = rank_of(high_[axis]);
  while (above - below > 1) {
    const std::int64_t middle = (below + above) / 2;
    (index(axis, of_rank(static_cast<std::int32_t>(middle))) >= cell ? above : below) = middle;
  }
  return of_rank(static_cast<std::int32_t>(above));
}

std::uint32_t Curve::number_of(const Cell& cell, int levels) const {
  std::uint32_t number = 0;
  std::uint32_t state = 0;
  for (int level = levels - 1; level >= 0; --level) {
    const std::uint32_t part = (cell[0] >> level & 1u) | (cell[1] >> level & 1u) << 1 | (cell[2] >> level & 1u) << 2;
    const CurveStep turn = turns_[state][part];
    number = number << 3 | turn.place;
    state = turn.next;
  }
  return number;
}

std::uint32_t Curve::number_of(const Cell& cell) const { return number_of(cell, kLevels); }

void Curve::places_of(const Places& places, std::size_t first, std::size_t last, float* along) const {
  const auto& [x, y, z] = places.position;
  for (std::size_t p = first; p < last; ++p) {
    const bool nowhere = std::isnan(x[p]) || std::isnan(y[p]) || std::isnan(z[p]);
    *along++ = nowhere ? std::numeric_limits<float>::quiet_NaN() : place_of(number_of(cell_of(x[p], y[p], z[p])));
  }
}

std::uint32_t Curve::first_behind(float cut) {
  const double cells = std::ceil(static_cast<double>(cut) * kCells);
  return static_cast<std::uint32_t>(std::clamp(cells, 0.0, static_cast<double>(kCells)));
}

// Covers a stretch of the curve with boxes, going down the tree of cells. Cells entirely in the stretch become boxes,
// and so do the smallest cells that are partly in it.
class Covering {
 public:
  Covering(const Curve& curve, std::uint32_t first, std::uint32_t last) : curve_(curve), first_(first), last_(last) {
    // The smallest cells are two levels below the largest one that fits in the stretch: then at most forty boxes are
    // needed, and their parts outside of the stretch are small compared with it.
    std::uint32_t largest = 1;
    for (std::uint32_t size = 8; size <= Curve::kCells && fits(size); size *= 8) largest = size;
    smallest_ = std::max(largest / 64, 1u);
  }

  BoxCover cover() {
    divide(0, 0, {0, 0, 0}, Curve::kAlong);
    BoxCover found{std::move(whole_), 0, {}};
    found.whole = found.boxes.size();
    found.boxes.insert(found.boxes.end(), partial_.begin(), partial_.end());
    found.around = around(found.boxes);
    return found;
  }

 private:
  bool fits(std::uint32_t size) const { return (first_ + size - 1) / size * size + size <= last_; }

  void divide(std::uint32_t number, std::uint32_t state, const Curve::Cell& corner, std::uint32_t side) {
    const std::uint32_t size = side * side * side;
    if (number + size <= first_ || number >= last_) return;
    const bool whole = number >= first_ && number + size <= last_;
    if (whole || size <= smallest_) return add(whole ? whole_ : partial_, corner, side);
    for (std::uint32_t part = 0; part < 8; ++part) {
      const CurveStep turn = curve_.turns_[state][part];
      const std::uint32_t half = side / 2;
      const Curve::Cell at{corner[0] + (part & 1u) * half, corner[1] + (part >> 1 & 1u) * half,
                           corner[2] + (part >> 2) * half};
      divide(number + turn.place * (size / 8), turn.next, at, half);
    }
  }

  void add(std::vector<Box>& boxes, const Curve::Cell& corner, std::uint32_t side) const {
    Box box;
    for (std::size_t a = 0; a < 3; ++a) {
      box.low[a] = curve_.faces_[a][corner[a]];
      box.high[a] = curve_.faces_[a][corner[a] + side];
    }
    boxes.push_back(box);
  }

  const Curve& curve_;
  std::uint32_t first_, last_;
  std::uint32_t smallest_ = 1;
  std::vector<Box> whole_, partial_;
};

BoxCover Curve::cover(std::uint32_t first, std::uint32_t last) const {
  if (first < last) return Covering(*this, first, last).cover();
  const std::uint32_t next = std::min(first, kCells - 1);
  BoxCover found = Covering(*this, next, next + 1).cover();
  found.whole = 0;  // nothing belongs to it
  return found;
}

}  // namespace motes::domains
