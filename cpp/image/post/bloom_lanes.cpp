// Compiled once for each instruction set: see simd/simd.h for the rules. Integers only, in loops that the compiler
// vectorises.
#include "image/post/bloom_lanes.h"

#include "simd/simd.h"

namespace motes::MOTES_ISA {
namespace {

constexpr int kBetweenBits = image::BetweenLanes::kBits;

void add(std::uint64_t* __restrict sums, const std::uint32_t* __restrict light, std::uint32_t weight,
         std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) sums[i] += static_cast<std::uint64_t>(light[i]) * weight;
}

void add_cells(std::uint64_t* __restrict sums, const std::uint64_t* __restrict light, std::uint32_t weight,
               std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) sums[i] += light[i] * weight;
}

template <int kReach>
void filter_by(std::uint64_t* __restrict to, const std::uint64_t* const* rows, const image::Taps& taps,
               std::size_t count) {
  const std::uint64_t* row[2 * kReach + 1];
  std::uint64_t tap[kReach + 1];
  for (int k = -kReach; k <= kReach; ++k) row[k + kReach] = rows[k];
  for (int k = 0; k <= kReach; ++k) tap[k] = taps.taps[k];
  for (std::size_t i = 0; i < count; ++i) {
    std::uint64_t sum = row[kReach][i] * tap[0];
    for (int k = 1; k <= kReach; ++k) sum += (row[kReach - k][i] + row[kReach + k][i]) * tap[k];
    to[i] = sum >> image::Taps::kShift;
  }
}

// Selects a loop whose number of taps is a constant.
template <int kReach>
void filter_from(std::uint64_t* to, const std::uint64_t* const* rows, const image::Taps& taps, std::size_t count) {
  if constexpr (kReach < image::Taps::kMost) {
    if (kReach < taps.reach) return filter_from<kReach + 1>(to, rows, taps, count);
  }
  filter_by<kReach>(to, rows, taps, count);
}

void filter(std::uint64_t* to, const std::uint64_t* const* rows, const image::Taps& taps, std::size_t count) {
  filter_from<0>(to, rows, taps, count);
}

void widen(std::uint64_t* __restrict to, const std::uint64_t* __restrict cells, const image::BetweenLanes& between,
           std::size_t count) {
  const std::uint32_t* left = between.left;
  const std::uint32_t* right = between.right;
  const std::uint64_t* beyond = between.beyond;
  const std::uint32_t first = between.first;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t far = beyond[i], near = (std::uint64_t{1} << kBetweenBits) - far;
    to[i] = (cells[left[i] - first] * near + cells[right[i] - first] * far) >> kBetweenBits;
  }
}

void start(std::uint64_t* __restrict glow, std::uint64_t* __restrict step, const std::uint64_t* __restrict near,
           const std::uint64_t* __restrict far, std::uint64_t beyond, std::uint64_t slope, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t more = far[i] - near[i];
    glow[i] = (near[i] << kBetweenBits) + more * beyond;
    step[i] = more * slope;
  }
}

void mix(std::uint32_t* __restrict light, std::uint64_t* __restrict glow, const std::uint64_t* __restrict step,
         std::uint32_t part, int shift, std::size_t count) {
  const std::uint64_t half = shift == 0 ? 0 : std::uint64_t{1} << (shift - 1);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t before = light[i];
    const std::uint32_t taken = (before >> 16) * part + ((before & 0xffffu) * part >> 16);
    const auto more = static_cast<std::uint32_t>((glow[i] + half) >> shift);
    const std::uint32_t after = before - taken + more;
    light[i] = after < more ? 0xffffffffu : after;
    glow[i] += step[i];
  }
}

void mix_cells(std::uint64_t* __restrict light, std::uint64_t* __restrict glow, const std::uint64_t* __restrict step,
               std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    light[i] += glow[i] >> kBetweenBits;
    glow[i] += step[i];
  }
}

}  // namespace

extern const image::BloomLanes bloom_lanes = {add, add_cells, filter, widen, start, mix, mix_cells};

}  // namespace motes::MOTES_ISA
