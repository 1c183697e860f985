// Reports of failed checks by the ranks of a program.
#pragma once

#include <cstdio>

inline int failures = 0;

inline void check(bool good, int rank, const char* what) {
  if (good) return;
  ++failures;
  std::fprintf(stderr, "rank %d: %s\n", rank, what);
}
