// Declares a table of kernels in each of its builds. Files that are compiled once for each instruction set define them;
// simd::choose (simd/isa.h) chooses one.
#pragma once

// Use it at the top level of a file, after the table's type. Builds that are not compiled in are never referenced.
#define MOTES_DECLARE_BUILDS(Table, name) \
  namespace motes::sse2 {                 \
  extern const Table name;                \
  }                                       \
  namespace motes::avx2 {                 \
  extern const Table name;                \
  }                                       \
  namespace motes::avx512 {               \
  extern const Table name;                \
  }                                       \
  namespace motes::neon {                 \
  extern const Table name;                \
  }
