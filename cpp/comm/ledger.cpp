#include "comm/ledger.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "comm/clock.h"

namespace motes::comm {
namespace {

// Returns whether CPU time is measured for an activity. Reading it is a system call, so only work that grows with the
// particles, and the script, is measured.
bool measured(Activity activity) {
  return activity == Activity::script || activity == Activity::births || activity == Activity::act ||
         activity == Activity::picture;
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
  if (now_ == Activity::script) script_idle_s_ += std::exchange(taken, 0);
  at(activities_, now_) += spent - taken;
  at(activities_, Activity::other) += taken;
  now_ = next;
  since_s_ = now;
  since_cpu_s_ = cpu;
  waits_s_ = waits_cpu_s_ = 0;
}

// A wait of x seconds, read backwards from its end: while the sender was busy, the sender was late; before that, for
// as long as the sender itself had waited, the rank that caused that wait; the rest is the sender's again.
//
//   sender:    ... busy | waits for delay.rank | busy     | sends
//   this rank:      | waits                               | receives
void Ledger::note_wait(int self, const Waited& whom, double start_s, double cpu_s, const Delay& delay) {
  const double end_s = wall_seconds();
  const double seconds = end_s - start_s;
  if (told_) told_({whom.late, whom.sender, whom.phase, seconds}, start_s, end_s);
  waits_s_ += seconds;
  waits_cpu_s_ += cpu_s;
  waited_s_ += seconds;
  double of_other = 0;
  if (delay.rank >= 0 && delay.rank != self) {
    of_other = std::clamp(seconds - delay.busy_s, 0.0, delay.waited_s);
  }
  if (of_other < seconds || of_other == 0) add_wait({whom.late, whom.sender, whom.phase, seconds - of_other});
  if (of_other > 0) add_wait({delay.rank, whom.sender, whom.phase, of_other});
  remember(2 * of_other > seconds ? delay.rank : whom.late, seconds, end_s);
}

void Ledger::add_wait(Waited wait) {
  const auto same = [&](const Waited& other) {
    return other.late == wait.late && other.sender == wait.sender && other.phase == wait.phase;
  };
  const auto found = std::find_if(waits_.begin(), waits_.end(), same);
  if (found == waits_.end()) {
    waits_.push_back(wait);
  } else {
    found->seconds += wait.seconds;
  }
}

// Keeps the last long wait. A shorter one replaces it only if this rank has been busy for longer since: otherwise the
// earlier wait explains more of the delay of this rank's next messages.
void Ledger::remember(std::int32_t late, double seconds, double until_s) {
  const double since_s = until_s - seconds - waited_until_s_;
  const double waited_s = last_long_.waited_s;
  if (late == last_long_.rank && since_s < waited_s) {
    seconds += waited_s;
  } else if (2 * seconds < waited_s && since_s < waited_s) {
    return;
  }
  last_long_ = {late, seconds, 0};
  waited_until_s_ = until_s;
}

Delay Ledger::delay() const { return {last_long_.rank, last_long_.waited_s, wall_seconds() - waited_until_s_}; }

double Ledger::worked_s() const {
  const double settled = std::accumulate(activities_.begin(), activities_.end(), 0.0);
  return settled - activities_[static_cast<std::size_t>(Activity::recovery)] - messages_s_;
}

double Ledger::chain_s() const {
  const double now_s = now_ == Activity::recovery ? 0 : std::max(0.0, wall_seconds() - since_s_ - waits_s_);
  return worked_s_ + slack_s_ + worked_s() + now_s;
}

void Ledger::follow(double chain_s) { slack_s_ += std::max(0.0, chain_s - this->chain_s()); }

Spent Ledger::take() {
  settle(now_);
  Spent spent{activities_, 0, messages_s_, chain_s(), script_idle_s_, 0, std::exchange(waits_, {})};
  spent.wall_s = std::accumulate(activities_.begin(), activities_.end(), 0.0);
  for (const Waited& wait : spent.waits) spent.wall_s += wait.seconds;
  border_ = {since_s_ - paused_s_, spent.chain_s};
  spent.ended_s = border_.at_s - started_s_;
  worked_s_ += worked_s();
  forget();
  return spent;
}

void Ledger::forget() {
  activities_ = {};
  waits_.clear();
  messages_s_ = script_idle_s_ = 0;
}

void Ledger::restart() {
  settle(now_);
  forget();
  paused_s_ = since_s_ - border_.at_s;
  started_s_ = border_.at_s;
}

void Ledger::go_back(const Border& border) {
  settle(now_);
  forget();
  at(activities_, Activity::recovery) = since_s_ - paused_s_ - border.at_s;
  worked_s_ = border.chain_s;
  slack_s_ = 0;
  border_ = border;
  started_s_ = border.at_s;
  last_long_ = {};  // ranks have other numbers now
}

}  // namespace motes::comm
