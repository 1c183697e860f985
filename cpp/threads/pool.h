// The threads of a rank, which share the parts of a task.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace motes::threads {

/// The operating system refused a thread.
class NoThread : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Runs the parts of a task on the calling thread and on the pool's own threads. Results must not depend on which
/// thread runs a part, nor on the order. The pool's threads compute in the engine's floating-point mode. They start
/// with the first task of several parts, and go to sleep soon after the last part.
class Pool {
 public:
  static constexpr int kMost = 1024;

  /// A part of a task, and the worker that runs it, 0..threads() - 1, as an index of working memory that parts do not
  /// share.
  using Work = std::function<void(std::size_t part, std::size_t worker)>;

  /// `grain`: the maximum number of items in a part where a task can be cut anywhere; small values are for tests.
  /// Throws std::invalid_argument if `threads` is not in 1..kMost, or `grain` is 0.
  explicit Pool(int threads = 1, std::size_t grain = SIZE_MAX);
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  int threads() const { return threads_; }

  /// Returns the items per part of a task for which parts of `best` items are best.
  std::size_t items(std::size_t best) const { return best < grain_ ? best : grain_; }

  /// Calls work(part, worker) for the parts 0..parts - 1, and returns when all have ended. Each worker begins with its
  /// own share, then continues with what others have left of theirs. Its share is the same in every task with this
  /// number of parts, so its memory is still in the processor's caches. After a part has thrown, no part above it
  /// begins, and the exception of the lowest such part is rethrown. One task at a time: parts must not call this.
  /// Throws NoThread, before any part runs, if not all threads can be started; then none of them runs, and the next
  /// task tries again.
  void run(std::size_t parts, const Work& work);

  /// Sets a function that the calling thread calls between parts and in pause(). It must be short and must not throw.
  void meanwhile(std::function<void()> call) { meanwhile_ = std::move(call); }

  /// Calls the function of meanwhile(), for long work that is not cut into parts. Only on the calling thread.
  void pause() const {
    if (meanwhile_) meanwhile_();
  }

  /// Returns what to add to the calling thread's processor time, so that a task shared by n threads counts as one n-th
  /// of the processor time of all of them.
  double beyond_caller_s() const { return beyond_caller_s_; }

 private:
  struct alignas(64) Worker {  // on its own cache line
    std::atomic<std::size_t> next{0};  // the first part of its share that has not begun
    std::size_t end = 0;
    std::thread thread;
    double busy_s = 0;  // processor time of this task's parts
    bool took_part = false;
  };

  void start();
  void end();
  bool in_a_copy() const;
  void open(std::size_t parts, const Work& work);
  void close();
  void serve(std::size_t worker);
  bool join_task(std::size_t& seen);
  void take_parts(std::size_t worker);
  bool take_share(Worker& from, std::size_t worker);
  void note_failure(std::size_t part);
  void note_time();

  int threads_;
  std::size_t grain_;
  std::deque<Worker> workers_;  // the first is the caller
  std::function<void()> meanwhile_;
  double beyond_caller_s_ = 0;
  int process_ = 0;  // the process that started the threads; a forked copy has none

  // The task under way.
  const Work* work_ = nullptr;
  std::atomic<std::size_t> lowest_failed_{0};  // the lowest part that has thrown

  // A forked copy of the process must not destroy these: they count threads that the copy does not have.
  struct Waiting {
    std::mutex mutex;  // guards what follows
    std::condition_variable task_begins, task_ends;
  };
  std::unique_ptr<Waiting> waiting_ = std::make_unique<Waiting>();
  std::atomic<std::size_t> tasks_{0};  // begun so far
  std::atomic<int> at_work_{0};  // threads of the pool
  bool open_ = false;  // whether a thread that wakes may still join the task; others are not waited for
  bool ends_ = false;
  std::exception_ptr failure_;
};

/// Returns a pool of one thread: the caller's.
Pool& alone();

/// Cuts 0..count into equal shares, one per thread, and each share into ranges of at most `most` items, which shrink to
/// `least` towards its end, so that threads end together (as in guided self-scheduling, C. Polychronopoulos and D.
/// Kuck, 1987). Returns the starts of the ranges, followed by `count`. All ranges but the last hold a multiple of
/// `whole` items; `least` and `most` are multiples of it.
std::vector<std::size_t> falling_ranges(const Pool& pool, std::size_t count, std::size_t most, std::size_t least,
                                        std::size_t whole);

/// Cuts 0..count into ranges of `best` items, or fewer (see Pool), and calls work(first, last).
template <class Work>
void over_ranges(Pool& pool, std::size_t count, std::size_t best, const Work& work) {
  const std::size_t size = pool.items(best);
  pool.run((count + size - 1) / size, [&](std::size_t part, std::size_t) {
    const std::size_t first = part * size;
    work(first, first + size < count ? first + size : count);
  });
}

}  // namespace motes::threads
