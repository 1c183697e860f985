// The birth history: which calls created the live particles. Births are functions of ids, so birth values can be
// recomputed when a script first uses a *_b attribute.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "particles/store.h"
#include "particles/streams.h"
#include "recording/births.h"

namespace motes::engine {

/// Records the births of one system, except those whose particles are dead on all ranks. Every rank records the same
/// calls, even if it holds none of their particles, since some may migrate there later. So all ranks prune in the same
/// frame, without further messages.
class BirthHistory {
 public:
  /// Records particles first_id .. first_id + count - 1 of a call, born in this (sub)step.
  void add(const recording::Birth& birth, std::uint64_t first_id, std::uint64_t count,
           const recording::BirthStep& moment);

  /// Returns whether the history has grown enough for pruning to be worth a pass over all ids. `limit`: the maximum
  /// size of the history, in bytes.
  bool wants_pruning(std::size_t limit) const {
    constexpr std::size_t kWorthALook = std::size_t{64} << 10;
    return bytes() > std::min(limit / 4, kWorthALook) && bytes() > 2 * pruned_bytes_;
  }

  /// Forgets the particles with ids below `oldest`, the lowest live id on any rank.
  void forget_before(std::uint64_t oldest);

  /// Returns the keys of the meshes that its calls use; a process that continues this run needs them.
  std::vector<std::uint64_t> meshes() const;

  /// Sets the *_b attributes of the particles in `store` to their values at birth; clears the history.
  void restore_copies(particles::Store& store, particles::Key key);
  void clear();

  /// Returns its size in bytes.
  std::size_t bytes() const;
  /// Returns the number of ranges of ids, each from one call.
  std::size_t size() const { return ranges_.size(); }

 private:
  struct Call {
    recording::Birth birth;
    recording::BirthStep moment;
    std::size_t bytes = 0;
  };
  struct IdRange {
    std::uint64_t first_id = 0;
    std::uint64_t count = 0;
    std::uint64_t call = 0;  // number of the call since the run's start: calls_[call - forgotten_calls_]
  };

  template <class Visitor>
  friend constexpr void fields(Visitor& visit, Call& call) {
    visit(call.birth, call.moment, call.bytes);
  }
  template <class Visitor>
  friend constexpr void fields(Visitor& visit, IdRange& range) {
    visit(range.first_id, range.count, range.call);
  }
  template <class Visitor>
  friend constexpr void fields(Visitor& visit, BirthHistory& history) {
    visit(history.calls_, history.ranges_, history.forgotten_calls_, history.call_bytes_, history.pruned_bytes_);
  }

  std::uint64_t number_of(recording::Birth birth, const recording::BirthStep& moment);

  std::vector<Call> calls_;
  std::vector<IdRange> ranges_;  // ascending ids
  std::uint64_t forgotten_calls_ = 0;
  std::size_t call_bytes_ = 0;
  std::size_t pruned_bytes_ = 0;  // bytes() after the last pruning
};

}  // namespace motes::engine
