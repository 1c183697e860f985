#include "comm/last_words.h"

#include <signal.h>
#include <sys/stat.h>
#include <ucontext.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <span>

namespace motes::comm {
namespace {

std::array<char, 256> place{};
std::array<char, 4096> mark{};
std::array<char, 256> lost_line{};
std::atomic<int> recoveries{0};  // simulated ranks may have several at once
constexpr std::array<int, 5> kSignals = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
std::array<struct sigaction, 64> before{};

// A stack for the handler: after an overflow the usual one is full. Large enough for the handlers that were installed
// before, too.
alignas(16) std::array<char, 65536> spare_stack{};

// Returns the stack pointer at the time of the signal; 0 on an unknown processor.
std::uintptr_t stack_pointer(const void* context) {
  [[maybe_unused]] const auto& machine = static_cast<const ucontext_t*>(context)->uc_mcontext;
#if defined(__linux__) && defined(__x86_64__)
  return static_cast<std::uintptr_t>(machine.gregs[REG_RSP]);
#elif defined(__linux__) && defined(__aarch64__)
  return static_cast<std::uintptr_t>(machine.sp);
#else
  return 0;
#endif
}

// Returns whether the stack has overflowed: only then is memory near the stack pointer invalid.
bool overflowed(const siginfo_t& facts, const void* context) {
  if (facts.si_code <= 0) return false;  // sent by another process
  constexpr std::uintptr_t kNear = std::uintptr_t{1} << 20;
  const std::uintptr_t stack = stack_pointer(context);
  const auto address = reinterpret_cast<std::uintptr_t>(facts.si_addr);
  return stack > kNear && address > stack - kNear && address < stack + kNear;
}

const char* meaning(int signal, const siginfo_t* facts, const void* context) {
  switch (signal) {
    case SIGSEGV:
      return overflowed(*facts, context) ? "segmentation fault: stack overflow (recursion too deep?)"
                                         : "segmentation fault";
    case SIGBUS: return "bus error";
    case SIGFPE: return "arithmetic error";
    case SIGILL: return "illegal instruction";
    default: return "aborted";
  }
}

void say(const char* text) {
  // Nothing can be done about a closed stderr here.
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text, std::strlen(text));
}

// Returns whether to report: only the first process on a host that creates the mark does.
bool may_speak() {
  if (mark[0] == '\0') return true;
  return mkdir(mark.data(), 0700) == 0 || errno != EEXIST;  // a folder, since it needs no file descriptor
}

void keep(const std::string& text, std::span<char> buffer) {
  const std::size_t length = std::min(text.size(), buffer.size() - 1);
  std::memcpy(buffer.data(), text.data(), length);
  buffer[length] = '\0';
}

// Async-signal-safe: mkdir, write, sigaction and raise only.
void on_crash(int signal, siginfo_t* facts, void* context) {
  if (may_speak()) {
    const bool lost = recoveries.load() > 0;
    say("\n");
    if (lost) say(lost_line.data());
    say("*** motes: ");
    say(place.data());
    if (lost) say(", while recovering from lost ranks");
    say(": ");
    say(meaning(signal, facts, context));
    say("\n");
  }
  sigaction(signal, &before[static_cast<std::size_t>(signal)], nullptr);
  raise(signal);
}

// Installs the spare stack, unless this thread already has one that is large enough.
void use_spare_stack() {
  stack_t now{};
  sigaltstack(nullptr, &now);
  if ((now.ss_flags & SS_DISABLE) == 0 && now.ss_size >= spare_stack.size()) return;
  stack_t spare{};
  spare.ss_sp = spare_stack.data();
  spare.ss_size = spare_stack.size();
  sigaltstack(&spare, nullptr);
}

}  // namespace

void name_crashes(const std::string& mark_path, const std::string& line) {
  keep(mark_path, mark);
  keep(line, lost_line);
  use_spare_stack();
  struct sigaction action{};
  action.sa_sigaction = on_crash;
  action.sa_flags = SA_NODEFER | SA_ONSTACK | SA_SIGINFO;
  sigemptyset(&action.sa_mask);
  for (const int signal : kSignals) {
    struct sigaction current{};
    sigaction(signal, nullptr, &current);
    if ((current.sa_flags & SA_SIGINFO) != 0 && current.sa_sigaction == on_crash) continue;
    before[static_cast<std::size_t>(signal)] = current;
    sigaction(signal, &action, nullptr);
  }
}

void set_place(const std::string& text) { keep(text, place); }

WhileLost::WhileLost() { ++recoveries; }

WhileLost::~WhileLost() { --recoveries; }

}  // namespace motes::comm
