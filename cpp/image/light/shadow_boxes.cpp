#include "image/light/shadow_boxes.h"

#include <algorithm>
#include <array>

#include "image/light/light_lanes.h"

namespace motes::image {
namespace {

constexpr int kColumns = kShadowColumns, kLayers = kShadowLayers, kBoxes = kShadowBoxes;
constexpr std::size_t kLayer = ShadowGrids::kLayer, kBox = ShadowGrids::kBox, kPlanes = kLayer * (kLayers + 1);

// The light that is left at each border between layers of a box: planes of kLayer numbers.
using Planes = std::vector<float>;

std::size_t at(int column, int row) {
  return static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column);
}
std::size_t plane(int number) { return static_cast<std::size_t>(number) * kLayer; }

void multiply(float* planes, const float* by) {
  for (std::size_t i = 0; i < kPlanes; ++i) planes[i] *= by[i];
}

// Writes the light that the particles of one box leave.
void set_own(const std::int64_t* sums, float* planes) {
  std::fill_n(planes, kLayer, 0.0f);
  for (std::size_t i = 0; i < kBox; ++i) {
    planes[kLayer + i] = planes[i] + static_cast<float>(sums[i]) * (1 / kShadowUnit);
  }
  light_lanes().let_through(planes, kPlanes);
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

// Multiplies the light of a box by that of the next finer one: the mean of four columns; all of it outside.
void multiply_by_finer(const float* fine, const Offset& offset, float* planes) {
  const int first[2] = {offset[0] / 2, offset[1] / 2}, half = kColumns / 2;
  for (int layer = 0; layer <= kLayers; ++layer) {
    const int from = 2 * layer - offset[2];
    if (from <= 0) continue;
    const float* const there = fine + plane(std::min(from, kLayers));
    float* const here = planes + plane(layer);
    for (int row = 0; row < half; ++row) {
      for (int column = 0; column < half; ++column) {
        const float* const four = there + at(2 * column, 2 * row);
        here[at(first[0] + column, first[1] + row)] *=
            0.25f * ((four[0] + four[1]) + (four[kColumns] + four[kColumns + 1]));
      }
    }
  }
}

// The two columns or rows of the coarser box around the middle of a finer one: the nearer and the farther one.
struct Nearby {
  int near, far;
};
Nearby nearby(int i) { return {i >> 1, (i & 1) == 0 ? (i >> 1) - 1 : (i >> 1) + 1}; }

// Returns the light of a box in the cells of the next finer one, interpolated.
Planes finer(const Planes& coarse, const Offset& offset) {
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

void set_light_left(const ShadowSpace& space, const std::int64_t* sums, unsigned boxes, std::vector<float>& left) {
  left.resize(boxes == 0 ? 0 : kBoxes * kPlanes);
  if (boxes == 0) return;
  const auto planes = [&](int box) { return left.data() + static_cast<std::size_t>(box) * kPlanes; };
  for (int box = 0; box < kBoxes; ++box) {
    if ((boxes >> box & 1u) != 0) {
      set_own(sums + static_cast<std::size_t>(box) * kBox, planes(box));
    } else {
      std::fill_n(planes(box), kPlanes, 1.0f);
    }
  }
  std::array<Planes, kBoxes> around;  // light that all coarser boxes leave, in the cells of a box; empty: all
  for (int box = kBoxes - 2; box >= 0; --box) {
    if (boxes >> (box + 1) == 0) continue;
    Planes coarse(planes(box + 1), planes(box + 1) + kPlanes);
    const Planes& beyond = around[static_cast<std::size_t>(box) + 1];
    if (!beyond.empty()) multiply(coarse.data(), beyond.data());
    around[static_cast<std::size_t>(box)] = finer(coarse, offset_of(space, box));
  }
  for (int box = 1; box < kBoxes; ++box) {
    multiply_by_finer(planes(box - 1), offset_of(space, box - 1), planes(box));
  }
  for (int box = 0; box < kBoxes; ++box) {
    const Planes& beyond = around[static_cast<std::size_t>(box)];
    if (!beyond.empty()) multiply(planes(box), beyond.data());
  }
}

}  // namespace motes::image
