// A transport that forwards every call to another one: tests override what they watch.
#pragma once

#include <memory>
#include <utility>

#include "comm/transport.h"

namespace test {

class Forwarding : public motes::comm::Transport {
 public:
  using Phase = motes::comm::Phase;

  explicit Forwarding(std::unique_ptr<Transport> under) : under_(std::move(under)) {}
  int rank() const override { return under_->rank(); }
  int size() const override { return under_->size(); }
  bool entered() override { return under_->entered(); }
  void send(int to, Phase phase, std::shared_ptr<const motes::comm::Message> message) override {
    under_->send(to, phase, std::move(message));
  }
  void await(int from, Phase phase, int messages) override { under_->await(from, phase, messages); }
  void progress() noexcept override { under_->progress(); }
  std::optional<motes::base::Bytes> receive(int from, Phase phase) override { return under_->receive(from, phase); }
  std::optional<int> unsent() override { return under_->unsent(); }
  bool finished() override { return under_->finished(); }
  void pause(int round, double until_s) override { under_->pause(round, until_s); }
  void weigh(motes::comm::Weights weights) override { under_->weigh(weights); }
  bool survives() const override { return under_->survives(); }
  void revoke() override { under_->revoke(); }
  std::unique_ptr<Transport> shrink(std::vector<int>& survivors) override { return under_->shrink(survivors); }

 private:
  std::unique_ptr<Transport> under_;
};

}  // namespace test
