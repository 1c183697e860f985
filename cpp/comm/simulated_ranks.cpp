#include "comm/simulated_ranks.h"

#include <utility>

#include "comm/clock.h"
#include "comm/simulated_scheduler.h"

namespace motes::comm {
namespace {

using simulation::Connections;
using simulation::Scheduler;
using simulation::WaitFor;

class SimulatedTransport final : public Transport {
 public:
  /// `self`: the rank among all; `rank`: its number among these connections.
  SimulatedTransport(Scheduler& scheduler, std::shared_ptr<Connections> among, int self, int rank, bool survives)
      : scheduler_(scheduler), among_(std::move(among)), self_(self), rank_(rank), survives_(survives) {}

  int rank() const override { return rank_; }
  int size() const override { return among_->size(); }
  bool entered() override { return arrive_at(WaitFor::entered, "enters"); }
  void send(int to, Phase phase, std::shared_ptr<const Message> message) override {
    charge_for(message->header());
    scheduler_.point(self_, "sends", number(to), name(phase), Simulation::Death::At::send);
    among_->send(rank_, to, phase, std::move(message));
  }
  void await(int, Phase, int) override {}
  std::optional<base::Bytes> receive(int from, Phase phase) override {
    scheduler_.point(self_, "polls", number(from), name(phase));
    scheduler_.will_wait(self_, *among_, rank_, WaitFor::message, {from, phase});
    std::optional<base::Bytes> bytes = among_->receive(rank_, {from, phase});
    if (bytes && bytes->size() >= sizeof(Header)) charge_for(base::Reader(bytes->view()).get<Header>());
    return bytes;
  }
  std::optional<int> unsent() override {
    scheduler_.point(self_, "asks what has left", self_, "");
    scheduler_.will_wait(self_, *among_, rank_, WaitFor::sent);
    return among_->unsent(rank_);
  }
  bool finished() override { return arrive_at(WaitFor::finished, "finishes"); }
  void pause(int, double until_s) override { scheduler_.pause(self_, until_s); }
  void weigh(Weights weights) override { weights_ = weights; }

  bool survives() const override { return survives_; }
  void revoke() override {
    if (!survives_) return Transport::revoke();
    scheduler_.point(self_, "revokes", self_, "");
    among_->revoke(rank_);
  }
  std::unique_ptr<Transport> shrink(std::vector<int>& survivors) override {
    if (!survives_) return Transport::shrink(survivors);
    scheduler_.point(self_, "shrinks", self_, "", Simulation::Death::At::shrink);
    scheduler_.will_wait(self_, *among_, rank_, WaitFor::shrunk);
    const std::shared_ptr<Connections> left = among_->shrink(rank_, survivors);
    if (!left) return nullptr;
    scheduler_.keep(left);
    int now = 0;
    while (survivors[static_cast<std::size_t>(now)] != rank_) ++now;
    auto made = std::make_unique<SimulatedTransport>(scheduler_, left, self_, now, survives_);
    made->weights_ = weights_;
    return made;
  }

 private:
  int number(int rank) const { return among_->machine(rank).number; }

  bool arrive_at(WaitFor point, const char* what) {
    scheduler_.point(self_, what, self_, "");
    scheduler_.will_wait(self_, *among_, rank_, point);
    return among_->arrive_at(rank_, point);
  }

  // Spends the time that a message takes at one end.
  void charge_for(const Header& header) const {
    const double bytes = static_cast<double>(sizeof header + header.payload_bytes);
    execute(weights_.message + weights_.byte * bytes * (header.count > 0 ? weights_.scale : 1));
  }

  Scheduler& scheduler_;
  std::shared_ptr<Connections> among_;
  int self_;
  int rank_;
  bool survives_;
  Weights weights_;
};

class Self final : public SimulatedRank {
 public:
  Self(Scheduler& scheduler, int self, bool survives) : scheduler_(scheduler), self_(self), survives_(survives) {}
  int rank() const override { return self_; }
  std::unique_ptr<Transport> transport() override {
    return std::make_unique<SimulatedTransport>(scheduler_, scheduler_.all(), self_, self_, survives_);
  }
  bool alive(int rank) const override { return scheduler_.machine(rank).live(); }

 private:
  Scheduler& scheduler_;
  int self_;
  bool survives_;
};

}  // namespace

SimulatedRun simulate(const Simulation& simulation, const std::function<void(SimulatedRank&)>& body) {
  Scheduler* started = nullptr;
  const std::function<void(int)> live = [&](int rank) {
    Self self(*started, rank, simulation.survives);
    body(self);
  };
  Scheduler scheduler(simulation, live);
  started = &scheduler;
  return scheduler.run();
}

}  // namespace motes::comm
