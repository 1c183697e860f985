// Which build of the kernels this process runs.
#pragma once

#include <cstddef>
#include <string_view>

namespace motes::simd {

enum class Isa { sse2, avx2, avx512 };
inline constexpr Isa kIsas[] = {Isa::sse2, Isa::avx2, Isa::avx512};

/// The widest set that this process can run, or the one named by MOTES_SIMD. Decided once per process. Throws
/// std::invalid_argument where MOTES_SIMD names no known set, or one that offers() denies.
Isa isa();

std::string_view name(Isa isa);

/// Whether this process can run the kernels of a set: they are compiled in, and the processor has the instructions.
bool offers(Isa isa);

/// Whether loops that stream through memory are faster with instructions that fetch ahead: with AVX2 and AVX-512.
/// Processors of AMD foresee all columns by themselves, and such instructions are in the way (docs/notes/speed.md).
bool fetches_ahead();

/// Returns the build for isa() from those that MOTES_BUILDS(table) (written by isas.cmake) lists.
template <class Table>
const Table& choose(const Table* const (&builds)[3]) {
  return *builds[static_cast<std::size_t>(isa())];
}

}  // namespace motes::simd
