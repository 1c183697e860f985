// Compiled once for each instruction set: the table of kernels.
#include <algorithm>
#include <bit>

#include "actions/all.h"  // all headers of this folder; written by CMake, so a new action needs no line here
#include "simd/squeeze.h"

namespace motes::MOTES_ISA {
namespace {

void contains(const shapes::Shape& shape, const float* const* position, std::size_t count, std::uint8_t* inside) {
  visit(shape, [&](const auto& lanes) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < count; i += kLanes) {
      const Mask mask = lanes.contains({load(position[0] + i), load(position[1] + i), load(position[2] + i)});
      for (std::size_t k = 0; k < kLanes && i + k < count; ++k) inside[i + k] = mask[k] != 0;
    }
  });
}

// A kernel sees only one block of particles and cannot sort them all, so the store is sorted after the list has run
// (program/order.h), and the list skips this action.
void sort(const actions::Parameters&, const actions::Block&, const actions::Step&) {}

// Usually at most one of 32 particles is dead, so that case has no branches.
void collect_dead(const actions::Block& b, std::uint32_t base, std::uint32_t* dead, std::size_t& count) {
  for (std::size_t first = 0; first < b.count; first += 32) {
    const std::size_t beyond = 32 - std::min<std::size_t>(32, b.count - first);
    std::uint32_t bits = b.dead[first / 32] << beyond >> beyond;
    do {
      dead[count] = static_cast<std::uint32_t>(base + first) + static_cast<std::uint32_t>(std::countr_zero(bits));
      count += bits != 0 ? 1 : 0;
      bits &= bits - 1;
    } while (bits != 0);
  }
}

// The number of bands is a constant, so slabs, which have one, pay nothing for the support of several.
template <std::size_t Bands>
void collect_beyond(const actions::Block& b, const actions::Band* bands, std::uint32_t base, std::uint32_t* left,
                    std::size_t& count) {
  static_assert(kLanes <= particles::kPadding, "squeeze writes whole vectors");
  const auto away_at = [&](std::size_t i) __attribute__((always_inline)) {
    Mask away = Mask{};
    for (std::size_t k = 0; k < Bands; ++k) {
      const Floats x = load(bands[k].x + i);
      away = away | ~((x >= bands[k].low) & (x < bands[k].high));
    }
    return away;
  };
  where_any(b.count, away_at, [&](std::size_t i) __attribute__((always_inline)) {
    const Mask leaves = away_at(i) & ~mask_of(b.dead[i / 32] >> i % 32) & first_lanes(b.count - i);
    count += squeeze(left + count, lane_numbers() + static_cast<std::uint32_t>(base + i), leaves);
  });
}

// NOLINTBEGIN(misc-const-correctness): the functions of the table change the counts
void collect(const actions::Block& b, const actions::Band* bands, std::size_t band_count, std::uint32_t base,
             std::uint32_t* dead, std::size_t& dead_count, std::uint32_t* left, std::size_t& left_count) {
  constexpr decltype(&collect_beyond<1>) kBeyond[] = {collect_beyond<1>, collect_beyond<2>, collect_beyond<3>};
  collect_dead(b, base, dead, dead_count);
  if (band_count != 0) kBeyond[band_count - 1](b, bands, base, left, left_count);
}
// NOLINTEND(misc-const-correctness)

}  // namespace

extern const actions::Kernels action_kernels;
const actions::Kernels action_kernels = {
    {
#define MOTES_ACTION(name, ...) name,
#define MOTES_INTERACTION(name, ...) nullptr,
#include "actions/list.inc"
#undef MOTES_INTERACTION
#undef MOTES_ACTION
    },
    evaluate,
    draw,
    jitter,
    spread,
    contains,
    collect,
};

}  // namespace motes::MOTES_ISA
