#include "comm/ledger.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "comm/clock.h"

namespace motes::comm {
namespace {

// Returns whether CPU time is measured for an activity. Reading it is a system call, so only work that grows with the
// particles is measured.
bool measured(Activity activity) {
  return activity == Activity::births || activity == Activity::act || activity == Activity::picture;
}

double& at(std::array<double, kActivities>& activities, Activity which) {
  return activities[static_cast<std::size_t>(which)];
}

}  // namespace

Activity Ledger::turn_to(Activity next) {
  const Activity before = now_;
  if (next != before) settle(next);
  return before;
}

void Ledger::settle(Activity next) {
  const double now = wall_seconds();
  const double spent = std::max(0.0, now - since_s_ - waits_s_);
  const bool reads = one_thread_ && (measured(now_) || measured(next));
  const double cpu = reads ? cpu_seconds() : 0;
  double taken = 0;
  if (one_thread_ && measured(now_)) taken = std::clamp(spent - (cpu - since_cpu_s_ - waits_cpu_s_), 0.0, spent);
  at(activities_, now_) += spent - taken;
  at(activities_, Activity::other) += taken;
  now_ = next;
  since_s_ = now;
  since_cpu_s_ = cpu;
  waits_s_ = waits_cpu_s_ = 0;
}

void Ledger::note_wait(std::int32_t rank, std::int32_t phase, double start_s, double cpu_s) {
  const double end_s = wall_seconds();
  const double seconds = end_s - start_s;
  if (told_) told_({rank, phase, seconds}, start_s, end_s);
  waits_s_ += seconds;
  waits_cpu_s_ += cpu_s;
  waited_s_ += seconds;
  const auto same = [&](const Waited& wait) { return wait.rank == rank && wait.phase == phase; };
  const auto found = std::find_if(waits_.begin(), waits_.end(), same);
  if (found == waits_.end()) {
    waits_.push_back({rank, phase, seconds});
  } else {
    found->seconds += seconds;
  }
}

double Ledger::chain_s() const {
  const double settled = std::accumulate(activities_.begin(), activities_.end(), 0.0);
  return worked_s_ + slack_s_ + settled - messages_s_ + std::max(0.0, wall_seconds() - since_s_ - waits_s_);
}

void Ledger::follow(double chain_s) { slack_s_ += std::max(0.0, chain_s - this->chain_s()); }

Spent Ledger::take() {
  settle(now_);
  Spent spent{activities_, 0, messages_s_, chain_s(), std::exchange(waits_, {})};
  const double worked = std::accumulate(activities_.begin(), activities_.end(), 0.0);
  spent.wall_s = worked;
  for (const Waited& wait : spent.waits) spent.wall_s += wait.seconds;
  worked_s_ += worked - messages_s_;
  activities_ = {};
  messages_s_ = 0;
  return spent;
}

void Ledger::restart() {
  settle(now_);
  activities_ = {};
  waits_.clear();
  messages_s_ = 0;
}

}  // namespace motes::comm
