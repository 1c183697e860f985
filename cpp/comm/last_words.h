// When a rank crashes, one message says which and when, before the process ends.
#pragma once

#include <string>

namespace motes::comm {

/// From now on a crash (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT) prints "*** motes: rank 2 (calculator 0), frame 7:
/// segmentation fault", then the handlers that were installed before run. A stack overflow does so too on the thread
/// that called this. `mark`: a folder that the reporter of a failed job makes first; a crash is silent where it exists.
/// Empty: no such folder. `lost_line`: printed before the text of a crash during a recovery, for a program that reads
/// it.
void name_crashes(const std::string& mark, const std::string& lost_line);

/// Who and when, for that text: kept in a buffer that a signal handler can read.
void set_place(const std::string& place);

/// While one lives, ranks recover from a loss: the text of a crash says ", while ranks were lost" besides.
class WhileLost {
 public:
  WhileLost();
  ~WhileLost();
  WhileLost(const WhileLost&) = delete;
  WhileLost& operator=(const WhileLost&) = delete;
};

}  // namespace motes::comm
