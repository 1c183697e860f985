// How many particles a call creates in a step. A source adds up its rate over all its steps, and emits the whole
// particles of this total that it has not emitted before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "recording/record.h"

namespace motes::recording {

/// The total of one source of a system since its first call. It is all that births of later frames need to know of
/// earlier rates, so it is part of a world's state between two frames.
struct SourceTotal {
  std::uint64_t source = 0;   // Source::number
  std::uint64_t call = 0;     // index among the frame's calls of this source
  double high = 0, low = 0;   // the sum of rate times step, particles: high + low, with twice the digits of a double
  double scale = 0;           // particles: rounding errors of the sum are relative to this, if it is larger
  std::uint64_t emitted = 0;  // particles so far, including those above the capacity

  bool operator==(const SourceTotal&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, SourceTotal& total) {
  visit(total.source, total.call, total.high, total.low, total.scale, total.emitted);
}

/// Returns how many particles a call creates in a (sub)step of a frame of `dt` seconds. A source adds the step to its
/// total, and emits the new whole particles; a total that is an integer up to rounding counts as that integer. A burst
/// or emit creates all its particles in the first step, and has no total.
std::uint64_t births_in_step(const Birth& birth, double dt, int substep, int substeps, SourceTotal* total);

/// Returns, for each item of a frame's list, its total among `totals` if it is a source, else null. Adds the totals of
/// sources that were not called before; `totals` stay in the order of (source, call).
std::vector<SourceTotal*> totals_of(std::span<const Item> list, std::vector<SourceTotal>& totals);

}  // namespace motes::recording
