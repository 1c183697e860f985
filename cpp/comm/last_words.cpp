#include "comm/last_words.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>

namespace motes::comm {
namespace {

std::array<char, 256> place{};
std::array<char, 4096> mark{};
constexpr std::array<int, 5> kSignals = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
std::array<struct sigaction, 64> before{};

const char* meaning(int signal) {
  switch (signal) {
    case SIGSEGV: return "segmentation fault";
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

// The first on a host that makes the mark speaks.
bool may_speak() {
  if (mark[0] == '\0') return true;
  const int file = open(mark.data(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0600);
  if (file < 0) return errno != EEXIST;
  close(file);
  return true;
}

void keep(const std::string& text, std::span<char> buffer) {
  const std::size_t length = std::min(text.size(), buffer.size() - 1);
  std::memcpy(buffer.data(), text.data(), length);
  buffer[length] = '\0';
}

// Async-signal-safe: open, close, write, sigaction and raise only.
void on_crash(int signal) {
  if (may_speak()) {
    say("\n*** motes: ");
    say(place.data());
    say(": ");
    say(meaning(signal));
    say("\n");
  }
  sigaction(signal, &before[static_cast<std::size_t>(signal)], nullptr);
  raise(signal);
}

}  // namespace

void name_crashes(const std::string& mark_path) {
  keep(mark_path, mark);
  struct sigaction action{};
  action.sa_handler = on_crash;
  action.sa_flags = SA_NODEFER;
  sigemptyset(&action.sa_mask);
  for (const int signal : kSignals) {
    struct sigaction current{};
    sigaction(signal, nullptr, &current);
    if (current.sa_handler == on_crash) continue;
    before[static_cast<std::size_t>(signal)] = current;
    sigaction(signal, &action, nullptr);
  }
}

void set_place(const std::string& text) { keep(text, place); }

}  // namespace motes::comm
