// Where a rank's time goes, with a clock that the test controls.
#include "comm/clock.h"
#include "comm/ledger.h"
#include "support/check.h"

namespace motes::test_ledger {
using namespace comm;

namespace {

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

void wait(Ledger& ledger, Clock& clock, int rank, Phase phase, double seconds) {
  const double start = clock.now_s();
  clock.spend(seconds);
  ledger.note_wait(rank, static_cast<int>(phase), start, seconds);
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
  CHECK(spent.waits[0].rank == 3 && spent.waits[0].seconds == 5 && spent.waits[1].seconds == 8);
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

}  // namespace motes::test_ledger
