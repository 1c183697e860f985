// The threads of a rank: parts of one task on several processors.
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

/// Runs the parts of a task on the calling thread and on threads of its own. What the parts compute must not depend on
/// who runs them, nor on the order. The pool's threads compute in the engine's floating-point mode. They start with the
/// first task of several parts; a while after the last part they sleep.
class Pool {
 public:
  static constexpr int kMost = 1024;

  /// A part of a task, and who runs it: worker 0..threads() - 1, for working memory that parts do not share.
  using Work = std::function<void(std::size_t part, std::size_t worker)>;

  /// `grain`: a part holds at most so many items where a task can be cut anywhere; small ones are for tests. Throws
  /// std::invalid_argument where `threads` is not 1..kMost, or `grain` is 0.
  explicit Pool(int threads = 1, std::size_t grain = SIZE_MAX);
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  int threads() const { return threads_; }

  /// Items in a part of a task for which parts of `best` items are best.
  std::size_t items(std::size_t best) const { return best < grain_ ? best : grain_; }

  /// Calls work(part, worker) for the parts 0..parts - 1, and returns when all have ended. Each worker begins with a
  /// share of its own, the same in every task of so many parts, whose memory its processor then has in its caches, and
  /// goes on with what others have left of theirs. After a part has thrown none above it begins; what the lowest of
  /// them threw is thrown. One task at a time: parts must not call this. Throws NoThread, before any part, where not
  /// all threads can be started; none of them runs then, and the next task tries again.
  void run(std::size_t parts, const Work& work);

  /// From now on the calling thread calls this between parts, and whenever it is asked to pause(): it must be short,
  /// and throw nothing.
  void meanwhile(std::function<void()> call) { meanwhile_ = std::move(call); }

  /// For long work that is not cut into parts: calls what is to be done meanwhile. Only on the calling thread.
  void pause() const {
    if (meanwhile_) meanwhile_();
  }

  /// Add this to the calling thread's processor time: then a task that n threads shared counts as one n-th of the
  /// processor time of all of them.
  double beyond_caller_s() const { return beyond_caller_s_; }

 private:
  struct alignas(64) Worker {  // a cache line of its own
    std::atomic<std::size_t> next{0};  // of its share, the part that nobody has begun
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
  int process_ = 0;  // that started the threads: a copy of it has none

  // The task under way.
  const Work* work_ = nullptr;
  std::atomic<std::size_t> lowest_failed_{0};  // part

  // A copy of the process that started the threads must not destroy these: they count threads that it does not have.
  struct Waiting {
    std::mutex mutex;  // what follows changes under it
    std::condition_variable task_begins, task_ends;
  };
  std::unique_ptr<Waiting> waiting_ = std::make_unique<Waiting>();
  std::atomic<std::size_t> tasks_{0};  // begun so far
  std::atomic<int> at_work_{0};        // threads of the pool
  bool open_ = false;  // a thread that wakes may still join; one that wakes too late is not waited for
  bool ends_ = false;
  std::exception_ptr failure_;
};

/// One thread: the caller's.
Pool& alone();

/// Cuts 0..count into equal shares, one per thread, and each share into ranges of at most `most` items, ever fewer
/// towards its end, down to `least`, so that threads end together (as in guided self-scheduling, C. Polychronopoulos
/// and D. Kuck, 1987). Returns where they start, and `count` behind them. All but the last hold a multiple of `whole`
/// items, of which `least` and `most` are multiples.
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
