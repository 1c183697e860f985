// When a rank crashes, one message says which and when, before the process ends.
#pragma once

#include <string>

namespace motes::comm {

/// From now on a crash (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT) prints "*** motes: rank 2 (calculator 0), frame 7:
/// segmentation fault", then the handlers that were installed before run. A stack overflow does so too on the thread
/// that called this. `mark`: a folder that the reporter of a failed job makes first; a crash is silent where it exists.
/// Empty: no such folder.
void name_crashes(const std::string& mark);

/// Who and when, for that text: kept in a buffer that a signal handler can read.
void set_place(const std::string& place);

/// While it lives, that text says besides what was going on: `what`, which must be a literal. Of several the last that
/// began is told until all have ended.
class Meanwhile {
 public:
  explicit Meanwhile(const char* what);
  ~Meanwhile();
  Meanwhile(const Meanwhile&) = delete;
  Meanwhile& operator=(const Meanwhile&) = delete;
};

}  // namespace motes::comm
