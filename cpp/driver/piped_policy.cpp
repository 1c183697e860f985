#include "driver/piped_policy.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>

namespace motes::driver {
namespace {

std::string word_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, " %.17g", value);
  return text;
}

std::string line_of(const balance::LoadTable& table) {
  std::string line = std::to_string(table.frame) + " " + std::to_string(table.evaluation) + " " +
                     domains::name_of(table.axes) + " " + std::to_string(table.loads.size());
  for (const balance::Load& load : table.loads) {
    line += " " + std::to_string(load.particles) + word_of(load.seconds) + word_of(load.speed) + word_of(load.error);
  }
  for (const float cut : table.cuts) line += word_of(static_cast<double>(cut));
  return line + " " + table.system + "\n";
}

// While it exists, writing to a pipe without a reader fails instead of ending this process.
class NoPipeSignal {
 public:
  NoPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~NoPipeSignal() {
    constexpr timespec kNow{};
    while (sigtimedwait(&pipe_, nullptr, &kNow) < 0 && errno == EINTR) {
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoPipeSignal(const NoPipeSignal&) = delete;
  NoPipeSignal& operator=(const NoPipeSignal&) = delete;

 private:
  sigset_t pipe_{}, before_{};
};

// Two pipes to another program, which answers line by line.
class Pipes {
 public:
  explicit Pipes(const std::string& directory) {
    // Does not wait for the other end: it opened the pipe first, or it is gone.
    tables_ = open((directory + "/tables").c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    plans_ = tables_ < 0 ? -1 : open((directory + "/plans").c_str(), O_RDONLY | O_CLOEXEC);
    if (plans_ < 0) {
      const std::string why = std::strerror(errno);
      if (tables_ >= 0) close(tables_);
      throw std::runtime_error("the balancer in " + directory + " cannot be reached: " + why);
    }
    fcntl(tables_, F_SETFL, 0);
  }
  ~Pipes() {
    close(tables_);
    close(plans_);
  }
  Pipes(const Pipes&) = delete;
  Pipes& operator=(const Pipes&) = delete;

  std::string ask(const std::string& line) const {
    const NoPipeSignal quiet;
    for (std::size_t sent = 0; sent < line.size();) {
      const ssize_t written = write(tables_, line.data() + sent, line.size() - sent);
      if (written < 0 && errno != EINTR) throw std::runtime_error(kGone);
      if (written > 0) sent += static_cast<std::size_t>(written);
    }
    std::string answer;
    for (char c = 0; c != '\n';) {
      const ssize_t got = read(plans_, &c, 1);
      if (got == 0 || (got < 0 && errno != EINTR)) throw std::runtime_error(kGone);
      if (got == 1 && c != '\n') answer += c;
    }
    return answer;
  }

 private:
  static constexpr const char* kGone = "the balancer's program has ended";

  int tables_ = -1;
  int plans_ = -1;
};

class PipedPolicy : public balance::Policy {
 public:
  explicit PipedPolicy(std::string directory) : directory_(std::move(directory)) {
    std::ifstream file(directory_ + "/facts");
    std::string over;
    if (!std::getline(file, name_) || !(file >> speeds.smoothing >> over) || (over != "all" && over != "system"))
      throw std::runtime_error(directory_ + " does not describe a balancer: its file facts cannot be read");
    over_all = over == "all";
  }

  const char* kind() const override { return "Balancer"; }
  std::string name() const override { return name_; }

  balance::Plan plan(const balance::LoadTable& table) const override {
    if (!pipes_) pipes_ = std::make_unique<Pipes>(directory_);
    const std::string said = pipes_->ask(line_of(table));
    std::istringstream answer(said);
    std::string kind;
    answer >> kind;
    balance::Plan plan;
    if (kind == "shares") {
      for (double share = 0; answer >> share;) plan.shares.push_back(share);
    } else if (kind == "orders") {
      for (balance::Order order; answer >> order.from >> order.to >> order.count;) plan.orders.push_back(order);
    } else {
      throw std::runtime_error(kind == "error" ? said.substr(std::min(said.size(), kind.size() + 1))
                                               : "the balancer sent an invalid answer, '" + said + "'");
    }
    if (!answer.eof()) throw std::runtime_error("the balancer sent an invalid answer, '" + said + "'");
    return plan;
  }

 private:
  std::string directory_;
  std::string name_;
  mutable std::unique_ptr<Pipes> pipes_;  // only on the manager
};

}  // namespace

balance::PolicyPtr open_piped_policy(const std::string& directory) {
  return std::make_shared<const PipedPolicy>(directory);
}

}  // namespace motes::driver
