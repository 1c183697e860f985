// Crash reports: when a rank crashes, a message names the rank and the frame before the process ends.
#pragma once

#include <string>

namespace motes::comm {

/// Makes a crash (SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT) print "*** motes: rank 2 (calculator 0), frame 7:
/// segmentation fault" before it calls the handlers that were installed earlier. Stack overflows are reported only on
/// the thread that called this. `mark`: path of a folder that the first process to report creates; where it exists, a
/// crash prints nothing. Empty: every crash prints. `lost_line`: printed before the report of a crash during a
/// recovery, for a program that reads it.
void name_crashes(const std::string& mark, const std::string& lost_line);

/// Sets the rank and frame that a crash report names. They are kept in a buffer that a signal handler can read.
void set_place(const std::string& place);

/// Exists while ranks recover from a loss: crash reports then add ", while ranks were lost".
class WhileLost {
 public:
  WhileLost();
  ~WhileLost();
  WhileLost(const WhileLost&) = delete;
  WhileLost& operator=(const WhileLost&) = delete;
};

}  // namespace motes::comm
