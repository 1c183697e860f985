#include "image/light/shadow_boxes.h"

#include <algorithm>
#include <array>
#include <functional>

#include "image/light/light_lanes.h"

namespace motes::image {
namespace {

constexpr int kColumns = kShadowColumns, kLayers = kShadowLayers, kBoxes = kShadowBoxes;
constexpr std::size_t kLayer = ShadowGrids::kLayer, kBox = ShadowGrids::kBox, kPlanes = kLayer * (kLayers + 1);

// The light that is left at each border between layers of a box, as planes of kLayer numbers; empty: all of it.
using Planes = std::vector<float>;

std::size_t at(int column, int row) {
  return static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column);
}
std::size_t plane(int number) { return static_cast<std::size_t>(number) * kLayer; }

void multiply(Planes& planes, const Planes& by) {
  if (planes.empty()) {
    planes = by;
  } else if (!by.empty()) {
    std::transform(planes.begin(), planes.end(), by.begin(), planes.begin(), std::multiplies<>());
  }
}

// Returns the light that the particles of one box leave.
Planes of_box(const std::int64_t* sums) {
  if (std::all_of(sums, sums + kBox, [](std::int64_t sum) { return sum == 0; })) return {};
  Planes planes(kPlanes);
  for (std::size_t i = 0; i < kBox; ++i) {
    planes[kLayer + i] = planes[i] + static_cast<float>(static_cast<double>(sums[i]) / double{kShadowUnit});
  }
  light_lanes().let_through(planes.data(), planes.size());
  return planes;
}

// Where a box begins in the next coarser one, in halves of its cells: along columns, rows and layers.
using Offset = std::array<int, 3>;
Offset offset_of(const ShadowSpace& space, int box) {
  Offset offset{};
  for (std::size_t i = 0; i < 3; ++i) {
    offset[i] = static_cast<int>(space.first[box][i] - 2 * space.first[box + 1][i]);
  }
  return offset;
}

// Returns the light of a box in the cells of the next coarser one: the mean of four columns; all of it outside.
Planes coarser(const Planes& fine, const Offset& offset) {
  if (fine.empty()) return {};
  Planes planes(kPlanes, 1.0f);
  const int first[2] = {offset[0] / 2, offset[1] / 2}, half = kColumns / 2;
  for (int layer = 0; layer <= kLayers; ++layer) {
    const int from = 2 * layer - offset[2];
    if (from <= 0) continue;
    const float* const there = fine.data() + plane(std::min(from, kLayers));
    float* const here = planes.data() + plane(layer);
    for (int row = 0; row < half; ++row) {
      for (int column = 0; column < half; ++column) {
        const float* const four = there + at(2 * column, 2 * row);
        here[at(first[0] + column, first[1] + row)] =
            0.25f * ((four[0] + four[1]) + (four[kColumns] + four[kColumns + 1]));
      }
    }
  }
  return planes;
}

// The two columns or rows of the coarser box around the middle of a finer one: the nearer and the farther one.
struct Nearby {
  int near, far;
};
Nearby nearby(int i) { return {i >> 1, (i & 1) == 0 ? (i >> 1) - 1 : (i >> 1) + 1}; }

// Returns the light of a box in the cells of the next finer one, interpolated.
Planes finer(const Planes& coarse, const Offset& offset) {
  if (coarse.empty()) return {};
  Planes planes(kPlanes);
  std::vector<float> between(kLayer), rows(kLayer);
  for (int layer = 0; layer <= kLayers; ++layer) {
    const int from = layer + offset[2];
    const float* const one = coarse.data() + plane(from / 2);
    const float* const other = coarse.data() + plane((from + 1) / 2);
    for (std::size_t i = 0; i < kLayer; ++i) between[i] = 0.5f * (one[i] + other[i]);
    float* const to = planes.data() + plane(layer);
    for (int row = 0; row < kColumns; ++row) {
      const Nearby v = nearby(row + offset[1]);
      const float *const near = between.data() + at(0, v.near), *const far = between.data() + at(0, v.far);
      for (int column = 0; column < kColumns; ++column) {
        rows[static_cast<std::size_t>(column)] = 0.75f * near[column] + 0.25f * far[column];
      }
      for (int column = 0; column < kColumns; ++column) {
        const Nearby u = nearby(column + offset[0]);
        to[at(column, row)] =
            0.75f * rows[static_cast<std::size_t>(u.near)] + 0.25f * rows[static_cast<std::size_t>(u.far)];
      }
    }
  }
  return planes;
}

}  // namespace

std::vector<float> light_left(const ShadowSpace& space, const std::int64_t* sums) {
  std::array<Planes, kBoxes> own;
  for (int box = 0; box < kBoxes; ++box)
    own[static_cast<std::size_t>(box)] = of_box(sums + kBox * static_cast<std::size_t>(box));
  if (std::all_of(own.begin(), own.end(), std::mem_fn(&Planes::empty))) return {};
  std::array<Planes, kBoxes> and_finer = own;  // of a box and all within it
  for (int box = 1; box < kBoxes; ++box) {
    const auto i = static_cast<std::size_t>(box);
    multiply(and_finer[i], coarser(and_finer[i - 1], offset_of(space, box - 1)));
  }
  std::vector<float> left(kBoxes * kPlanes, 1.0f);
  Planes around;  // of all coarser boxes, in the cells of a box
  for (int box = kBoxes - 1; box >= 0; --box) {
    const auto i = static_cast<std::size_t>(box);
    Planes& all = and_finer[i];
    multiply(all, around);
    if (!all.empty()) std::copy(all.begin(), all.end(), left.begin() + static_cast<std::ptrdiff_t>(i * kPlanes));
    if (box == 0) break;
    multiply(around, own[i]);
    around = finer(around, offset_of(space, box - 1));
  }
  return left;
}

}  // namespace motes::image
