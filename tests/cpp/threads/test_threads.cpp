// The pool: each part runs once, failures, sleep; and the engine's loops give the same bits as one thread.
#include "threads/pool.h"

#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "support/check.h"

namespace motes::test_threads {
using threads::Pool;

namespace {

double process_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void work_for(double seconds) {
  for (const double start = thread_seconds(); thread_seconds() - start < seconds;) {
  }
}

}  // namespace

TEST(a_pool_runs_each_part_once) {
  for (const int threads : {1, 2, 3, 7}) {
    Pool pool(threads);
    for (std::size_t parts = 0; parts < 300; parts += parts < 10 ? 1 : 97) {
      std::vector<std::atomic<int>> runs(parts);
      std::atomic<bool> known{true};
      pool.run(parts, [&](std::size_t part, std::size_t worker) {
        ++runs[part];
        if (worker >= static_cast<std::size_t>(threads)) known = false;
      });
      for (const std::atomic<int>& count : runs) CHECK(count == 1);
      CHECK(known);
    }
  }
}

TEST(a_worker_runs_one_part_at_a_time) {
  Pool pool(3);
  std::array<std::atomic<int>, 3> inside{};
  std::atomic<int> at_once{0};
  for (int task = 0; task < 200; ++task) {
    pool.run(50, [&](std::size_t, std::size_t worker) {
      if (++inside[worker] > 1) ++at_once;
      --inside[worker];
    });
  }
  CHECK(at_once == 0);
}

TEST(ranges_cover_all_and_do_not_overlap) {
  Pool pool(2);
  for (const std::size_t count : {0u, 1u, 9u, 10u, 11u, 95u}) {
    std::vector<std::atomic<int>> seen(count);
    threads::over_ranges(pool, count, 10, [&](std::size_t first, std::size_t last) {
      CHECK(first % 10 == 0 && last <= count && first < last);
      for (std::size_t i = first; i < last; ++i) ++seen[i];
    });
    for (const std::atomic<int>& once : seen) CHECK(once == 1);
  }
}

TEST(the_calling_thread_does_what_is_to_be_done_meanwhile_behind_each_of_its_parts) {
  for (const int threads : {1, 2, 3}) {
    Pool pool(threads);
    pool.pause();  // nothing is to be done yet
    int calls = 0;
    const std::thread::id caller = std::this_thread::get_id();
    bool called_by_others = false;
    pool.meanwhile([&] {
      ++calls;
      called_by_others |= std::this_thread::get_id() != caller;
    });
    int own_parts = 0;
    pool.run(60, [&](std::size_t, std::size_t worker) {
      if (worker == 0) ++own_parts;
      work_for(1e-5);
    });
    CHECK(calls == own_parts && !called_by_others);
    CHECK(threads > 1 || own_parts == 60);
    pool.pause();
    CHECK(calls == own_parts + 1);
  }
}

TEST(each_worker_begins_with_its_own_share) {
  for (const int threads : {2, 3, 5}) {
    Pool pool(threads);
    const auto workers = static_cast<std::size_t>(threads);
    for (const std::size_t each : {std::size_t{1}, std::size_t{4}}) {
      std::atomic<std::size_t> begun{0};
      std::vector<std::size_t> first_part(workers, SIZE_MAX);  // of each worker
      pool.run(workers * each, [&](std::size_t part, std::size_t worker) {
        if (first_part[worker] != SIZE_MAX) return;
        first_part[worker] = part;
        ++begun;  // no worker continues before all are here
        for (int wait = 0; wait < 5000 && begun < workers; ++wait) {
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
      });
      for (std::size_t worker = 0; worker < workers; ++worker) CHECK(first_part[worker] == worker * each);
    }
  }
}

TEST(falling_ranges_cover_all_in_equal_shares_and_end_small) {
  for (const int threads : {1, 2, 3, 8}) {
    for (const std::size_t count : {0u, 1u, 63u, 64u, 65u, 1000u, 100000u, 400001u}) {
      const Pool pool(threads);
      const std::vector<std::size_t> starts = threads::falling_ranges(pool, count, 131072, 2048, 64);
      CHECK(starts.front() == 0 && starts.back() == count && std::is_sorted(starts.begin(), starts.end()));
      CHECK(std::adjacent_find(starts.begin(), starts.end()) == starts.end());
      for (std::size_t i = 0; i + 1 < starts.size(); ++i)
        CHECK(starts[i] % 64 == 0 && starts[i + 1] - starts[i] <= 131072);
      if (count < 100000) continue;
      const auto shares = static_cast<std::size_t>(threads);
      CHECK((starts.size() - 1) % shares == 0);
      for (std::size_t share = 0; share < shares; ++share) {  // each share is one worker's
        const std::size_t first = starts[(starts.size() - 1) * share / shares];
        CHECK(first >= count / shares * share - 64 * share && first <= count / shares * share);
      }
      CHECK(starts.back() - starts[starts.size() - 2] <= 2 * 2048);
    }
  }
  CHECK(threads::falling_ranges(Pool(2, 1), 1000, 131072, 2048, 64).size() == 17);  // a small grain: whole vectors
}

TEST(a_task_throws_what_its_lowest_failing_part_threw) {
  for (const int threads : {1, 2, 5}) {
    Pool pool(threads);
    for (int round = 0; round < 50; ++round) {
      std::string what;
      try {
        pool.run(100, [](std::size_t part, std::size_t) {
          if (part % 7 == 6) throw std::runtime_error("part " + std::to_string(part));
        });
      } catch (const std::runtime_error& error) {
        what = error.what();
      }
      CHECK(what == "part 6");
      int runs = 0;
      pool.run(1, [&](std::size_t, std::size_t) { ++runs; });
      CHECK(runs == 1);  // the pool still works
    }
  }
}

TEST(a_part_that_fails_later_counts_if_it_is_lower) {
  Pool pool(2);
  std::atomic<bool> other_failed{false};
  std::string what;
  try {
    pool.run(2, [&](std::size_t part, std::size_t) {
      for (int wait = 0; part == 0 && wait < 2000 && !other_failed; ++wait) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      if (part == 1) other_failed = true;
      throw std::runtime_error("part " + std::to_string(part));
    });
  } catch (const std::runtime_error& error) {
    what = error.what();
  }
  CHECK(what == "part 0");
}

TEST(a_pool_that_waits_uses_no_processor) {
  Pool pool(4);
  std::atomic<int> runs{0};
  pool.run(100, [&](std::size_t, std::size_t) { ++runs; });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // all threads have gone to sleep
  const double before = process_seconds();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  CHECK(process_seconds() - before < 0.02);
}

// A forked copy has none of the threads.
TEST(a_copy_of_the_process_can_use_and_destroy_a_pool) {
  auto pool = std::make_unique<Pool>(3);
  const auto work = [&] {
    std::atomic<int> ran{0};
    pool->run(8, [&](std::size_t, std::size_t) { ++ran; });
    return ran.load();
  };
  for (int number = 0; number < 20; ++number) {
    CHECK(work() == 8);
    // In every other copy all threads are asleep; otherwise some may hold what the copy would wait for.
    if (number % 2 != 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const pid_t copy = fork();
    if (copy == 0) {
      const bool all = work() == 8;
      pool.reset();
      _exit(all ? 0 : 1);
    }
    int status = -1;
    for (int i = 0; i < 1000 && waitpid(copy, &status, WNOHANG) == 0; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    CHECK(status == 0);
    if (status != 0) kill(copy, SIGKILL);
  }
  CHECK(work() == 8);
}

TEST(shared_work_counts_as_its_share_of_processor_time) {
  Pool pool(2);
  const double caller = thread_seconds();
  pool.run(200, [](std::size_t, std::size_t) { work_for(1e-3); });
  const double seconds = thread_seconds() - caller + pool.beyond_caller_s();
  CHECK(seconds > 0.09 && seconds < 0.13);  // of 0.2 on two threads
  Pool one(1);
  one.run(2, [](std::size_t, std::size_t) { work_for(1e-3); });
  CHECK(one.beyond_caller_s() == 0);
}

TEST(a_pool_has_1_to_1024_threads) {
  CHECK_THROWS(Pool(0), std::invalid_argument);
  CHECK_THROWS(Pool(-1), std::invalid_argument);
  CHECK_THROWS(Pool(1025), std::invalid_argument);
}

}  // namespace motes::test_threads
