#include "comm/stop_signals.h"

#include <signal.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace motes::comm {
namespace {

// A signal and its previous handler. The signal handler uses this and the variables below without locks.
struct Noted {
  int signal = 0;
  const char* text = "";
  struct sigaction before{};
};
std::array<Noted, 3> watched = {
    Noted{SIGINT, "motes: SIGINT: the run stops when this frame is done; a second one ends it at once\n"},
    Noted{SIGTERM, "motes: SIGTERM: the run stops when this frame is done; a second one ends it at once\n"},
    Noted{SIGUSR1, "motes: SIGUSR1: the run stops when this frame is done\n"}};
std::atomic<int> first{0};
std::atomic<std::int64_t> urgent_ns{0};  // when the first SIGINT or SIGTERM came; 0: none yet
std::atomic<std::int64_t> same_ns{0};
std::atomic<bool> speaks_up{false};
std::atomic<pid_t> owner{0};
std::atomic<int> exit_code{0};
static_assert(std::atomic<std::int64_t>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

Noted* noted(int signal) {
  for (Noted& one : watched) {
    if (one.signal == signal) return &one;
  }
  return nullptr;
}

// Has the effect that the signal had before it was noted.
void do_as_before(const Noted& one, siginfo_t* facts, void* context) {
  if ((one.before.sa_flags & SA_SIGINFO) != 0) {
    one.before.sa_sigaction(one.signal, facts, context);
  } else if (one.before.sa_handler == SIG_DFL) {
    sigaction(one.signal, &one.before, nullptr);
    raise(one.signal);  // acts once this handler has returned
  } else if (one.before.sa_handler != SIG_IGN) {
    one.before.sa_handler(one.signal);
  }
}

// Returns whether the user insists: the first SIGINT or SIGTERM came at least same_s ago.
bool insists(int signal) {
  if (signal == SIGUSR1) return false;
  const std::int64_t now = now_ns();
  std::int64_t before = 0;
  if (urgent_ns.compare_exchange_strong(before, now)) return false;
  return now - before >= same_ns;
}

// Async-signal-safe: atomics, clock_gettime, getpid, write, sigaction and raise only.
void on_signal(int signal, siginfo_t* facts, void* context) {
  const int error = errno;
  const Noted& one = *noted(signal);
  if (getpid() != owner || insists(signal)) {
    do_as_before(one, facts, context);
  } else {
    int none = 0;
    if (first.compare_exchange_strong(none, signal) && speaks_up) {
      // Nothing can be done about a closed stderr here.
      [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, one.text, std::strlen(one.text));
    }
  }
  errno = error;
}

bool is_ours(const struct sigaction& action) {
  return (action.sa_flags & SA_SIGINFO) != 0 && action.sa_sigaction == on_signal;
}

#ifdef __GLIBC__
void end_with(int status, void* process) {
  if (status != 0 || getpid() != *static_cast<pid_t*>(process) || exit_code == 0) return;
  std::fflush(nullptr);
  _exit(exit_code);
}
#endif

}  // namespace

void note_stop_signals(const std::vector<int>& signals, double same_s, bool speaks) {
  owner = getpid();
  same_ns = static_cast<std::int64_t>(same_s * 1e9);
  speaks_up = speaks;
  struct sigaction action{};
  action.sa_sigaction = on_signal;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;  // no SA_RESTART: Python's own handlers interrupt system calls, too
  sigemptyset(&action.sa_mask);
  for (const int signal : signals) {
    Noted* const one = noted(signal);
    struct sigaction now{};
    sigaction(signal, nullptr, &now);
    if (one == nullptr || is_ours(now)) continue;
    one->before = now;
    sigaction(signal, &action, nullptr);
  }
}

int stop_signal() { return first; }

void forget_stop_signal() {
  urgent_ns = 0;
  first = 0;
}

void release_stop_signals() {
  for (const Noted& one : watched) {
    struct sigaction now{};
    sigaction(one.signal, nullptr, &now);
    if (is_ours(now)) sigaction(one.signal, &one.before, nullptr);
  }
}

void end_with_code(int code) {
  exit_code = code;
#ifdef __GLIBC__
  static pid_t process = 0;
  if (process == 0) on_exit(end_with, &process);
  process = getpid();
#else
  std::atexit([] {
    std::fflush(nullptr);
    if (exit_code != 0) _exit(exit_code);
  });
#endif
}

}  // namespace motes::comm
