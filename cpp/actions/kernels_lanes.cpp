// Compiled once for each instruction set: the table of kernels.
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

// One band is what slabs have: the count is known to the compiler, so more of them cost slabs nothing.
template <std::size_t Bands>
void collect_beyond(const actions::Block& b, const actions::Band* bands, std::uint32_t base, std::uint32_t* dead,
                    std::size_t& dead_count, std::uint32_t* left, std::size_t& left_count) {
  constexpr std::uint32_t kNumbers[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  static_assert(kLanes <= particles::kPadding && particles::kPadding == std::size(kNumbers));
  const Uints lane = load_uints(kNumbers);
  const auto away_at = [&](std::size_t i) __attribute__((always_inline)) {
    Mask away = Mask{};
    for (std::size_t k = 0; k < Bands; ++k) {
      const Floats x = load(bands[k].x + i);
      away = away | ~((x >= bands[k].low) & (x < bands[k].high));
    }
    return away;
  };
  const auto goes = [&](std::size_t i) __attribute__((always_inline)) { return load_mask(b.dead + i) | away_at(i); };
  where_any(b.count, goes, [&](std::size_t i) __attribute__((always_inline)) {
    const Mask killed = load_mask(b.dead + i);
    const Mask here = (Mask)(lane < static_cast<std::uint32_t>(b.count - i));
    const Uints index = lane + static_cast<std::uint32_t>(base + i);
    dead_count += squeeze(dead + dead_count, index, killed & here);
    left_count += squeeze(left + left_count, index, away_at(i) & ~killed & here);
  });
}

// NOLINTBEGIN(misc-const-correctness): the functions of the table change the counts
void collect(const actions::Block& b, const actions::Band* bands, std::size_t band_count, std::uint32_t base,
             std::uint32_t* dead, std::size_t& dead_count, std::uint32_t* left, std::size_t& left_count) {
  constexpr decltype(&collect_beyond<0>) kBy[] = {collect_beyond<0>, collect_beyond<1>, collect_beyond<2>,
                                                  collect_beyond<3>};
  kBy[band_count](b, bands, base, dead, dead_count, left, left_count);
}
// NOLINTEND(misc-const-correctness)

}  // namespace

extern const actions::Kernels action_kernels;
const actions::Kernels action_kernels = {
    {
#define MOTES_ACTION(name, ...) name,
#define MOTES_MEETING(name, ...) nullptr,
#include "actions/list.inc"
#undef MOTES_MEETING
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
