// Which build of the kernels this process runs.
#pragma once

#include <cstddef>
#include <iterator>
#include <string_view>

namespace motes::simd {

enum class Isa { sse2, avx2, avx512, neon };
inline constexpr Isa kIsas[] = {Isa::sse2, Isa::avx2, Isa::avx512, Isa::neon};

/// Returns the widest set that this process can run, or the one named by MOTES_SIMD. Decided once per process. Throws
/// std::invalid_argument if MOTES_SIMD names an unknown set, or one that this process cannot run.
Isa isa();

std::string_view name(Isa isa);

/// Returns whether this process can run the kernels of a set: they are compiled in, and the processor has the
/// instructions.
bool offers(Isa isa);

/// Returns whether loops that stream through memory are faster with prefetch instructions: with AVX2 and AVX-512 on
/// Intel's processors. AMD's prefetch all columns by themselves, and such instructions slow them down
/// (docs/lab/speed.md).
bool fetches_ahead();

/// Returns the build for isa() from those that MOTES_BUILDS(table) (written by isas.cmake) lists.
template <class Table>
const Table& choose(const Table* const (&builds)[std::size(kIsas)]) {
  return *builds[static_cast<std::size_t>(isa())];
}

}  // namespace motes::simd
