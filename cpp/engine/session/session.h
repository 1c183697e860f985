// The conversation of this rank with the others: communicator, relay, turn, and a failure that waits to be agreed on.
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

/// All ranks agreed that one of them failed, or that their scripts differ; every rank throws this, but the one whose
/// compute failed throws its original exception.
class Agreed : public std::runtime_error {
 public:
  Agreed(Verdict verdict, std::uint64_t frame, std::string role, const std::string& text)
      : std::runtime_error(text), verdict_(std::move(verdict)), frame_(frame), role_(std::move(role)) {}
  const Verdict& verdict() const { return verdict_; }
  const std::string& role() const { return role_; }  // of verdict().failed_rank
  std::uint64_t frame() const { return frame_; }

 private:
  Verdict verdict_;
  std::uint64_t frame_;
  std::string role_;
};

/// Compute may fail, conversations may not: `work` keeps a failure and skips the rank's later work; the rank goes on
/// talking with empty payloads until all have agreed on what happened, and all give up together.
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
  int stop = 0;            // the number of the signal after which all stop with the last frame, or 0
  std::uint64_t unsaved_from = UINT64_MAX;      // the first frame of which a picture made here is in no file yet
  std::uint64_t all_unsaved_from = UINT64_MAX;  // minimum of `unsaved_from` over all ranks, as agreed last
  std::string orders;      // what viewers asked for in the last conversation that could carry it
  comm::Stamp stamp() const { return {frame, turn}; }
  comm::Stamp stamp(const Round& round) const { return {frame, round.turn}; }

  /// Runs `compute` unless something failed before; what it throws becomes the rank's failure, said to be of `action`.
  template <class Work>
  void work(const std::string& action, const Work& compute) {
    if (failure_.failed()) return;
    const simd::FloatMode mode;
    try {
      compute();
    } catch (const comm::RankLost&) {
      throw;  // is nobody's failure
    } catch (const ItemFailure& error) {
      failure_ = {Failure::Kind::compute, error.action(), error.what(), error.place()};
      own_exception_ = error.original();
    } catch (const std::exception& error) {
      failure_ = {Failure::Kind::compute, action, error.what(), {}};
      own_exception_ = std::current_exception();
    }
  }
  bool failed() const { return failure_.failed(); }
  /// The item that this rank's last failure belongs to.
  ItemPlace failed_at() const { return failed_at_; }
  const Failure& failure() const { return failure_; }
  void fail(Failure failure) { failure_ = std::move(failure); }

  /// Throws what all agreed on: the original exception where it happened here, Agreed otherwise. The run is over.
  [[noreturn]] void give_up(Verdict verdict);
  /// Throws what this rank has failed with, if it has: for what may not reach the script. The exception itself comes
  /// once: Python's may not be raised again.
  void rethrow();
  /// Tells whether all ranks have given up, so that nobody waits for this one any more.
  bool over() const { return broken_; }
  /// Throws std::runtime_error where that is so.
  void check_alive() const;

 private:
  std::unique_ptr<comm::Communicator> comm_;
  roles::Cast cast_;
  Relay relay_;
  Failure failure_;
  ItemPlace failed_at_;
  std::exception_ptr own_exception_;
  bool broken_ = false;  // all agreed on a failure: particles are half-way through a frame
};

}  // namespace motes::engine
