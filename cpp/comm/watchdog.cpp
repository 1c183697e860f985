#include "comm/watchdog.h"

#include <signal.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <cmath>
#include <system_error>
#include <thread>

namespace motes::comm {
namespace {

// Sets an alarm, whose default action ends the process, for when no thread can be started.
void end_by_alarm(double seconds) {
  struct sigaction action{};
  action.sa_handler = SIG_DFL;
  sigemptyset(&action.sa_mask);
  sigaction(SIGALRM, &action, nullptr);
  sigset_t alarm_only;
  sigemptyset(&alarm_only);
  sigaddset(&alarm_only, SIGALRM);
  pthread_sigmask(SIG_UNBLOCK, &alarm_only, nullptr);
  itimerval timer{};
  const double whole = std::floor(seconds);
  timer.it_value.tv_sec = static_cast<time_t>(whole);
  timer.it_value.tv_usec = static_cast<suseconds_t>((seconds - whole) * 1e6) + 1;
  setitimer(ITIMER_REAL, &timer, nullptr);
}

void sleep_then_exit(double seconds, int code) {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);  // signals belong to the script's threads
  const double whole = std::floor(seconds);
  timespec left{static_cast<time_t>(whole), static_cast<long>((seconds - whole) * 1e9)};
  while (nanosleep(&left, &left) != 0) {
  }
  _exit(code);
}

}  // namespace

void end_process_after(double seconds, int code) {
  try {
    std::thread(sleep_then_exit, seconds, code).detach();
  } catch (const std::system_error&) {
    end_by_alarm(seconds);
  }
}

}  // namespace motes::comm
