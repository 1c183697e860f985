#include "threads/pool.h"

#include <pthread.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/invalid_argument.h"
#include "simd/float_mode.h"

namespace motes::threads {
namespace {

// A waiting thread polls this often before it sleeps: a few tens of microseconds, the cost of sleeping and waking.
constexpr int kLooks = 2000;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void rest() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Returns the text of NoThread; `running` includes the caller.
std::string refusal(int wanted, std::size_t running, const std::exception& error) {
  return "only " + std::to_string(running) + " of " + std::to_string(wanted) + " threads could be started (" +
         error.what() + "); set fewer with World(threads=) or MOTES_THREADS";
}

// Blocks signals, which belong to the thread that runs the script.
class WithoutSignals {
 public:
  WithoutSignals() {
    sigset_t all;
    sigfillset(&all);
    for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) sigdelset(&all, crash);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~WithoutSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  WithoutSignals(const WithoutSignals&) = delete;
  WithoutSignals& operator=(const WithoutSignals&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

Pool::Pool(int threads, std::size_t grain) : threads_(threads), grain_(grain), workers_(1) {
  if (grain == 0) throw base::InvalidArgument("grain", "be 1 or more", "0");
  if (threads < 1 || threads > kMost) {
    throw base::InvalidArgument("threads", "be 1.." + std::to_string(kMost), std::to_string(threads));
  }
}

Pool::~Pool() {
  if (!in_a_copy()) {
    end();
  } else {
    for (Worker& worker : workers_) {
      if (worker.thread.joinable()) worker.thread.detach();
    }
    [[maybe_unused]] const Waiting* const left = waiting_.release();
  }
}

void Pool::end() {
  {
    const std::scoped_lock lock(waiting_->mutex);
    ends_ = true;
  }
  waiting_->task_begins.notify_all();
  for (Worker& worker : workers_) {
    if (worker.thread.joinable()) worker.thread.join();
  }
}

void Pool::start() {
  const WithoutSignals blocked;
  process_ = getpid();
  while (workers_.size() < static_cast<std::size_t>(threads_)) {
    const std::size_t number = workers_.size();
    try {
      workers_.emplace_back();
      workers_.back().thread = std::thread([this, number] { serve(number); });
    } catch (const std::exception& error) {
      end();
      ends_ = false;
      workers_.resize(1);  // the caller: the next task tries again
      throw NoThread(refusal(threads_, number, error));
    }
  }
}

// Returns whether this is a forked copy of the process: it has no other threads, and locks that they held stay locked.
bool Pool::in_a_copy() const { return process_ != 0 && process_ != getpid(); }

void Pool::run(std::size_t parts, const Work& work) {
  if (threads_ == 1 || parts <= 1 || in_a_copy()) {
    for (std::size_t part = 0; part < parts; ++part) {
      work(part, 0);
      pause();
    }
    return;
  }
  if (workers_.size() < static_cast<std::size_t>(threads_)) start();
  open(parts, work);
  take_parts(0);
  close();
  note_time();
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void Pool::open(std::size_t parts, const Work& work) {
  {
    const std::scoped_lock lock(waiting_->mutex);
    const std::size_t shares = workers_.size();
    for (std::size_t share = 0; share < shares; ++share) {
      workers_[share].took_part = false;
      workers_[share].next.store(parts * share / shares, std::memory_order_relaxed);
      workers_[share].end = parts * (share + 1) / shares;
    }
    work_ = &work;
    lowest_failed_.store(SIZE_MAX, std::memory_order_relaxed);
    open_ = true;
    tasks_.fetch_add(1, std::memory_order_release);
  }
  waiting_->task_begins.notify_all();
}

void Pool::close() {
  std::unique_lock lock(waiting_->mutex);
  open_ = false;
  lock.unlock();
  for (int look = 0; look < kLooks && at_work_.load(std::memory_order_acquire) != 0; ++look) rest();
  lock.lock();
  waiting_->task_ends.wait(lock, [&] { return at_work_.load(std::memory_order_acquire) == 0; });
}

void Pool::take_parts(std::size_t worker) {
  const double start = cpu_seconds();
  bool took_part = false;
  for (std::size_t away = 0; away < workers_.size(); ++away) {
    took_part |= take_share(workers_[(worker + away) % workers_.size()], worker);
  }
  workers_[worker].took_part = took_part;
  workers_[worker].busy_s = cpu_seconds() - start;
}

// Runs the parts of a share that have not begun; returns whether there were any.
bool Pool::take_share(Worker& from, std::size_t worker) {
  bool took_part = false;
  while (from.next.load(std::memory_order_relaxed) < from.end) {  // loading takes no cache line from its owner
    const std::size_t part = from.next.fetch_add(1, std::memory_order_relaxed);
    if (part >= from.end || part > lowest_failed_.load(std::memory_order_relaxed)) break;
    took_part = true;
    try {
      (*work_)(part, worker);
    } catch (...) {
      note_failure(part);
    }
    if (worker == 0) pause();
  }
  return took_part;
}

// Call only in an exception handler.
void Pool::note_failure(std::size_t part) {
  const std::scoped_lock lock(waiting_->mutex);
  if (part > lowest_failed_.load(std::memory_order_relaxed)) return;
  failure_ = std::current_exception();
  lowest_failed_.store(part, std::memory_order_relaxed);
}

void Pool::serve(std::size_t worker) {
  const simd::FloatMode mode;
  for (std::size_t seen = 0; join_task(seen);) {
    take_parts(worker);
    const std::scoped_lock lock(waiting_->mutex);
    if (at_work_.fetch_sub(1, std::memory_order_acq_rel) == 1) waiting_->task_ends.notify_one();
  }
}

// Waits for a task that is still open. Returns false when the pool ends.
bool Pool::join_task(std::size_t& seen) {
  for (;;) {
    for (int look = 0; look < kLooks && tasks_.load(std::memory_order_acquire) == seen; ++look) rest();
    std::unique_lock lock(waiting_->mutex);
    waiting_->task_begins.wait(lock, [&] { return ends_ || tasks_.load(std::memory_order_relaxed) != seen; });
    if (ends_) return false;
    seen = tasks_.load(std::memory_order_relaxed);
    if (!open_) continue;
    at_work_.fetch_add(1, std::memory_order_relaxed);
    return true;
  }
}

void Pool::note_time() {
  double all = 0;
  int shared_by = 0;
  for (const Worker& worker : workers_) {
    all += worker.took_part ? worker.busy_s : 0;
    shared_by += worker.took_part ? 1 : 0;
  }
  const double callers = workers_[0].took_part ? workers_[0].busy_s : 0;
  beyond_caller_s_ += all / shared_by - callers;
}

Pool& alone() {
  static Pool pool(1);
  return pool;
}

std::vector<std::size_t> falling_ranges(const Pool& pool, std::size_t count, std::size_t most, std::size_t least,
                                        std::size_t whole) {
  const auto rounded = [&](std::size_t items) { return std::max(items / whole, std::size_t{1}) * whole; };
  const std::size_t upper = rounded(pool.items(most)), lower = std::min(rounded(least), upper);
  const auto threads = static_cast<std::size_t>(pool.threads());
  std::vector<std::size_t> starts{0};
  for (std::size_t share = 1; share <= threads; ++share) {
    const std::size_t end = share < threads ? std::min(rounded(count / threads) * share, count) : count;
    while (starts.back() < end) {
      const std::size_t rest = end - starts.back();
      starts.push_back(starts.back() + std::min(rest, std::clamp(rounded(rest / 2), lower, upper)));
    }
  }
  return starts;
}

}  // namespace motes::threads
