// Where a rank's time goes, with a clock that the test controls.
#include <chrono>
#include <thread>

#include "comm/clock.h"
#include "comm/ledger.h"
#include "support/check.h"

namespace motes::test_ledger {
using namespace comm;

namespace {

constexpr int kSelf = 9;

class Clock : public TimeSource {
 public:
  Clock() { set_time_source(this); }
  ~Clock() override { set_time_source(nullptr); }
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

  double now_s() const override { return now_; }
  void spend(double seconds) override { now_ += seconds; }
  void execute(double operations) override { now_ += operations; }

 private:
  double now_ = 100;
};

void wait(Ledger& ledger, Clock& clock, int rank, Phase phase, double seconds, const Delay& delay = {}) {
  const double start = clock.now_s();
  clock.spend(seconds);
  ledger.note_wait(kSelf, {rank, rank, static_cast<int>(phase)}, start, seconds, delay);
}

double of(const Spent& spent, Activity activity) { return spent.activities[static_cast<std::size_t>(activity)]; }

}  // namespace

TEST(ledger_gives_each_second_one_name) {
  Clock clock;
  Ledger ledger;
  ledger.restart();
  clock.spend(1);
  {
    const ActivityScope inside(ledger, Activity::other);
    clock.spend(0.25);
    {
      const ActivityScope act(ledger, Activity::act);
      clock.spend(2);
      wait(ledger, clock, 3, Phase::all_reduce, 4);
      clock.spend(0.5);
    }
    const ActivityScope talk(ledger, Activity::talk);
    wait(ledger, clock, 0, Phase::verdict, 8);
    wait(ledger, clock, 3, Phase::all_reduce, 1);
    clock.spend(0.125);
    ledger.note_messages(0.125);
  }
  const Spent spent = ledger.take();
  CHECK(of(spent, Activity::script) == 1 && of(spent, Activity::other) == 0.25);
  CHECK(of(spent, Activity::act) == 2.5 && of(spent, Activity::talk) == 0.125);
  CHECK(spent.wall_s == 16.875 && spent.messages_s == 0.125 && ledger.waited_s() == 13);
  CHECK(spent.waits.size() == 2);
  CHECK(spent.waits[0].late == 3 && spent.waits[0].seconds == 5 && spent.waits[1].seconds == 8);
  CHECK(ledger.take().wall_s == 0);
}

TEST(ledger_leaves_out_a_pause) {
  Clock clock;
  Ledger ledger;
  ledger.restart();
  clock.spend(1);
  ledger.take();
  clock.spend(50);
  wait(ledger, clock, 1, Phase::begin, 10);
  ledger.restart();
  clock.spend(2);
  const Spent spent = ledger.take();
  CHECK(spent.wall_s == 2 && spent.waits.empty());
  CHECK(spent.chain_s == 3);
}

TEST(chain_of_work_is_as_long_as_the_run_on_a_network_that_takes_no_time) {
  Clock clock;
  Ledger ledger;
  ledger.restart();
  clock.spend(2);
  CHECK(ledger.chain_s() == 2);
  wait(ledger, clock, 1, Phase::report, 7);
  ledger.follow(5);  // the other had worked for 5 s when it sent; the message took the rest
  CHECK(ledger.chain_s() == 5);
  clock.spend(1);
  ledger.note_messages(1);
  CHECK(ledger.chain_s() == 5);
  clock.spend(1);
  ledger.follow(4);  // an older message shortens nothing
  CHECK(ledger.chain_s() == 6 && ledger.take().chain_s == 6 && ledger.chain_s() == 6);
  Header header;
  header.set_chain_s(12345.678);
  CHECK_NEAR(header.chain_s(), 12345.678, 1e-7);
}

TEST(time_since_a_border_counts_as_recovery_after_a_loss) {
  Clock clock;
  Ledger ledger;
  ledger.restart();
  clock.spend(2);
  ledger.take();
  const Border border = ledger.border();
  clock.spend(3);
  CHECK(ledger.take().ended_s == 5);
  clock.spend(50);
  ledger.restart();  // a pause
  clock.spend(4);
  wait(ledger, clock, 1, Phase::report, 1);
  const ActivityScope recovers(ledger, Activity::recovery);
  ledger.go_back(border);
  clock.spend(0.5);
  ledger.note_messages(0.25);
  ledger.turn_to(Activity::act);
  clock.spend(6);
  const Spent spent = ledger.take();
  CHECK(of(spent, Activity::recovery) == 8.5 && of(spent, Activity::act) == 6 && spent.waits.empty());
  CHECK(spent.wall_s == 14.5 && spent.ended_s == 14.5 && spent.messages_s == 0);
  CHECK(spent.chain_s == 8);  // two seconds before the border, six of the frame that ran again
  ledger.go_back(border);     // a second loss
  CHECK(of(ledger.take(), Activity::recovery) == 14.5);
}

TEST(frames_end_on_a_clock_that_restarts_behind_a_pause) {
  Clock clock;
  Ledger ledger;
  ledger.restart();
  clock.spend(2);
  CHECK(ledger.take().ended_s == 2);
  clock.spend(3);
  CHECK(ledger.take().ended_s == 5);
  clock.spend(50);
  ledger.restart();
  clock.spend(4);
  CHECK(ledger.take().ended_s == 4);
}

TEST(a_wait_is_blamed_on_the_rank_that_caused_it_and_not_on_the_messenger) {
  Clock clock;
  Ledger ledger;
  ledger.restart();
  wait(ledger, clock, 1, Phase::verdict, 8, {2, 6, 1});  // rank 1 worked for 1 s; before, rank 2 made it wait for 6 s
  const std::vector<Waited> waits = ledger.take().waits;
  CHECK(waits.size() == 2);
  CHECK(waits[0].late == 1 && waits[0].sender == 1 && waits[0].seconds == 2);
  CHECK(waits[1].late == 2 && waits[1].sender == 1 && waits[1].seconds == 6);
  clock.spend(3);
  wait(ledger, clock, 4, Phase::begin, 0.5);  // too short to explain a delay
  clock.spend(1);
  const Delay told = ledger.delay();
  CHECK(told.rank == 2 && told.waited_s == 8 && told.busy_s == 4.5);
  wait(ledger, clock, 4, Phase::begin, 5);
  CHECK(ledger.delay().rank == 4);
  wait(ledger, clock, 3, Phase::report, 1, {kSelf, 50, 0});  // it waited for this rank: the message took the time
  CHECK(ledger.take().waits.back().late == 3);
  Header header;
  header.set_delay({7, 1e9, 0.25});
  CHECK(header.delay().rank == 7 && header.delay().waited_s == 400 && header.delay().busy_s == 0.25);
}

TEST(a_scripts_time_without_a_processor_is_known) {
  Ledger ledger;
  ledger.restart();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const Spent spent = ledger.take();
  CHECK(of(spent, Activity::script) > 0.045 && of(spent, Activity::other) == 0);
  CHECK(spent.script_idle_s > 0.04 && spent.script_idle_s <= of(spent, Activity::script));
}

}  // namespace motes::test_ledger
