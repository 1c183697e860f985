// Declares a table of kernels in each of its builds: they are defined by the files that are compiled once for each
// instruction set, and chosen with simd::choose (simd/isa.h).
#pragma once

// At the top level of a file, behind the type of the table. Builds that are not compiled in are never referred to.
#define MOTES_DECLARE_BUILDS(Table, name) \
  namespace motes::sse2 {                 \
  extern const Table name;                \
  }                                       \
  namespace motes::avx2 {                 \
  extern const Table name;                \
  }                                       \
  namespace motes::avx512 {               \
  extern const Table name;                \
  }
