// What a crashing process reports. Each test makes a child process crash.
#include "comm/last_words.h"

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>

#include "support/check.h"

namespace motes::test_last_words {
namespace {

// What a child process writes to its standard error, and the signal that ended it.
struct Ended {
  std::string said;
  int signal = 0;
};

template <class Crash>
Ended child(const Crash& crash) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t process = fork();
  if (process == 0) {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    dup2(ends[1], STDERR_FILENO);
    crash();
    _exit(0);
  }
  close(ends[1]);
  Ended ended;
  char some[4096];
  for (ssize_t n = 0; (n = read(ends[0], some, sizeof some)) > 0;) ended.said.append(some, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(process, &status, 0);
  ended.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  return ended;
}

void prepare() {
  comm::name_crashes("", "one was lost\n");
  comm::set_place("rank 2 (calculator 0), frame 7");
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Recurses without a tail call; each level needs more of the stack than a compiler can keep in registers.
[[gnu::noinline]] std::size_t deep(std::size_t level) {
  if (level == SIZE_MAX) return 0;
  volatile char room[512];
  std::memset(const_cast<char*>(room), static_cast<int>(level), sizeof room);
  return deep(level + 1) + static_cast<std::size_t>(room[level % sizeof room]);
}

}  // namespace

TEST(a_crash_says_who_and_where) {
  const Ended ended = child([] {
    prepare();
    raise(SIGSEGV);
  });
  CHECK(has(ended.said, "*** motes: rank 2 (calculator 0), frame 7: segmentation fault\n"));
  CHECK(ended.signal == SIGSEGV || ended.signal == 0);  // a sanitizer's handler ends the process its own way
}

TEST(a_crash_while_ranks_were_lost_says_so) {
  const Ended ended = child([] {
    prepare();
    {
      const comm::WhileLost over;
    }
    const comm::WhileLost meanwhile;
    raise(SIGSEGV);
  });
  const char* said =
      "\none was lost\n*** motes: rank 2 (calculator 0), frame 7, while recovering from lost ranks: segmentation "
      "fault\n";
  CHECK(has(ended.said, said));
}

TEST(no_rank_is_lost_when_all_recoveries_have_ended_in_any_order) {
  const Ended ended = child([] {
    prepare();
    std::optional<comm::WhileLost> first(std::in_place), second(std::in_place);
    first.reset();
    second.reset();
    raise(SIGSEGV);
  });
  CHECK(has(ended.said, "*** motes: rank 2 (calculator 0), frame 7: segmentation fault\n"));
}

TEST(a_stack_overflow_has_last_words) {
  const Ended ended = child([] {
    prepare();
    _exit(static_cast<int>(deep(0) & 1));
  });
  CHECK(has(ended.said, "*** motes: rank 2 (calculator 0), frame 7: segmentation fault: stack overflow"));
}

TEST(a_handler_that_was_there_before_runs_behind_the_last_words) {
  const Ended ended = child([] {
    struct sigaction action{};
    action.sa_handler = [](int) {
      [[maybe_unused]] const ssize_t n = write(STDERR_FILENO, "earlier handler", 15);
      _exit(3);
    };
    sigaction(SIGBUS, &action, nullptr);
    prepare();
    prepare();  // a second world: the handler must not call itself forever
    raise(SIGBUS);
  });
  CHECK(has(ended.said, "frame 7: bus error\nearlier handler"));
}

}  // namespace motes::test_last_words
