// This rank's side of conversations: communicator, relay, turn, and a failure until all ranks have agreed on it.
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>

#include "comm/communicator.h"
#include "engine/session/item_failure.h"
#include "engine/session/relay.h"
#include "engine/session/report.h"
#include "engine/session/round.h"
#include "roles/cast.h"
#include "simd/float_mode.h"

namespace motes::engine {

/// Thrown on all ranks when they agree that one of them failed or that their scripts differ. The rank whose compute
/// failed throws its original exception instead.
class Agreed : public std::runtime_error {
 public:
  Agreed(Verdict verdict, std::uint64_t frame, std::string role, const std::string& text)
      : std::runtime_error(text), verdict_(std::move(verdict)), frame_(frame), role_(std::move(role)) {}
  const Verdict& verdict() const { return verdict_; }
  const std::string& role() const { return role_; }  // role of verdict().failed_rank
  std::uint64_t frame() const { return frame_; }

 private:
  Verdict verdict_;
  std::uint64_t frame_;
  std::string role_;
};

/// Compute may fail, conversations may not: work() keeps the failure and skips this rank's later work. The rank keeps
/// taking part in conversations, with empty payloads, until all ranks agree on the failure and give up together.
class Session {
 public:
  Session(std::unique_ptr<comm::Communicator> comm, roles::Cast cast);

  comm::Communicator& comm() { return *comm_; }
  const comm::Communicator& comm() const { return *comm_; }
  Relay& relay() { return relay_; }
  const Relay& relay() const { return relay_; }
  const roles::Cast& cast() const { return cast_; }

  int rank() const { return comm_->rank(); }
  int size() const { return comm_->size(); }
  bool manages() const { return rank() == cast_.manager; }
  bool draws() const { return rank() == cast_.image_generator; }
  /// This rank's number among the calculators, or -1.
  int calculator() const { return cast_.calculator_of(rank()); }
  bool calculates() const { return calculator() >= 0; }
  std::size_t calculators() const { return cast_.calculators.size(); }
  int rank_of(int calculator) const { return cast_.calculators[static_cast<std::size_t>(calculator)]; }

  std::uint64_t frame = 0;
  std::uint32_t turn = 0;  // rounds so far
  int stop = 0;            // number of the signal that stops all ranks after the last frame, or 0
  std::uint64_t unsaved_from = UINT64_MAX;      // the first frame whose picture, made here, is not yet in a file
  std::uint64_t all_unsaved_from = UINT64_MAX;  // minimum of `unsaved_from` over all ranks, from the last verdict
  std::string orders;      // viewers' orders from the last conversation that could carry them
  comm::Stamp stamp() const { return {frame, turn}; }
  comm::Stamp stamp(const Round& round) const { return {frame, round.turn}; }

  /// Runs `compute` unless this rank has failed already; an exception becomes the rank's failure, attributed to
  /// `action`.
  template <class Work>
  void work(const std::string& action, const Work& compute) {
    if (failure_.failed()) return;
    const simd::FloatMode mode;
    try {
      compute();
    } catch (const comm::RankLost&) {
      throw;  // not a failure of this rank
    } catch (const ItemFailure& error) {
      failure_ = {Failure::Kind::compute, error.action(), error.what(), error.place()};
      own_exception_ = error.original();
    } catch (const std::exception& error) {
      failure_ = {Failure::Kind::compute, action, error.what(), {}};
      own_exception_ = std::current_exception();
    }
  }
  bool failed() const { return failure_.failed(); }
  /// Returns the list item of this rank's last failure.
  ItemPlace failed_at() const { return failed_at_; }
  const Failure& failure() const { return failure_; }
  void fail(Failure failure) { failure_ = std::move(failure); }

  /// Ends the run: throws the original exception if this rank failed, otherwise Agreed.
  [[noreturn]] void give_up(Verdict verdict);
  /// Throws this rank's failure, if any, for failures that must not reach the script. The original exception is thrown
  /// only once, since a Python exception must not be raised again.
  void rethrow();
  /// Returns whether all ranks have given up, so no rank waits for this one.
  bool over() const { return broken_; }
  /// Throws std::runtime_error if all ranks have given up.
  void check_alive() const;

 private:
  std::unique_ptr<comm::Communicator> comm_;
  roles::Cast cast_;
  Relay relay_;
  Failure failure_;
  ItemPlace failed_at_;
  std::exception_ptr own_exception_;
  bool broken_ = false;  // all ranks have given up, with particles halfway through a frame
};

}  // namespace motes::engine
