// A recorded list of actions, compiled: one pass over blocks that stay in the first-level cache.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <variant>
#include <vector>

#include "actions/action.h"
#include "actions/kernels.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::program {

/// The time that a run of the program covers: sub-steps `first` .. `last` - 1 of a frame.
struct Span {
  std::uint64_t frame = 0;
  int substeps = 1;
  double dt = 0;  // seconds per frame
  int first = 0;
  int last = 0;  // one past the last sub-step; 0: all
};

/// Returns when a sub-step starts, in seconds of the animation.
double time_of(const Span& span, int substep);

/// A slice of space: low <= x < high along the axis (0..2).
struct Slice {
  int axis = 0;
  float low = -std::numeric_limits<float>::infinity();
  float high = std::numeric_limits<float>::infinity();
};

/// The part of space whose particles stay: the intersection of its slices, at most one per axis; without slices,
/// everything.
class Region {
 public:
  Region() = default;
  Region(const Slice& slice) : slices_{slice}, count_(1) {}  // NOLINT(google-explicit-constructor): a slice is a region

  void limit(const Slice& slice) { slices_.at(count_++) = slice; }
  std::span<const Slice> slices() const { return {slices_.data(), count_}; }

 private:
  std::array<Slice, 3> slices_{};
  std::size_t count_ = 0;
};

/// The results of a run: indices of particles, ascending.
struct ListResult {
  std::vector<std::uint32_t> dead;
  std::vector<std::uint32_t> left;
  std::vector<std::uint32_t> hits;  // bounced at least once; kept only if `wants_hits`
  bool wants_hits = false;
  /// Whether a run may change the order of particles. Then each range's dead, and those that left, are moved to its
  /// front while they are in the caches, to be removed together later.
  bool gathers = false;

  void clear() {
    dead.clear();
    left.clear();
    hits.clear();
    gathers = false;
  }
};

/// Sorts all lists and removes duplicates, since several passes may find the same particle dead. The dead do not leave.
void tidy(ListResult& outcome);

class FetchAhead;

class Program {
 public:
  /// `place`: the position of the first action in the frame's list, which keys the random streams. `schema`: that of
  /// the systems whose particles it runs over, if the list has laws.
  explicit Program(std::vector<actions::Action> list, std::uint32_t place = 0, const particles::Schema& schema = {});

  /// Runs sub-steps span.first.. of the list over particles begin.. of the store: the first sub-step from action
  /// `entry` on, the others in full. Adds the dead and those outside the region to `outcome`; removes none. An empty
  /// list does nothing, and finds no migrants either. The threads of the pool share the particles.
  void run(particles::Store& store, std::size_t begin, std::size_t entry, const Span& span, particles::Key key,
           const Region& region, ListResult& outcome, threads::Pool& pool = threads::alone()) const;

  std::size_t size() const { return list_.size(); }

  /// Adds the particles outside the region to outcome.left.
  static void find_migrants(const particles::Store& store, std::size_t begin, const Region& region, ListResult& outcome,
                            threads::Pool& pool = threads::alone());

 private:
  // The values that most actions are called with are in one cache line. A step streams through the second-level cache,
  // which does not see what still hits the first level, and evicts such lines from both: every line that each block
  // needs is missed once in a while, and twenty of them cost more than any action.
  struct alignas(64) Operation {
    Operation() = default;
    Operation(const Operation&) = delete;  // the parameters point to the numbers
    Operation& operator=(const Operation&) = delete;

    std::array<double, 4> numbers{};  // the action's, if it has at most four
    actions::Kernel kernel = nullptr;
    actions::Parameters parameters{};
    const actions::Expression* where = nullptr;  // null: everywhere
    std::variant<std::monostate, actions::ValuesCode, actions::LawCode, actions::TableView> bound;
    std::vector<float*> planes;  // of a law's formula
    std::vector<int> written;  // components, if there is a condition
    bool moves = false;  // whether it writes positions in periodic space
  };

  // A sub-step as its actions see it; `stream` is that of the list's first action.
  struct Substep {
    actions::Step step;
    std::size_t entry;  // into the list
    std::size_t kept;  // index of the keys of its draws
  };

  // The parameters of a run, shared by all of its ranges.
  struct Pass {
    particles::Store& store;
    const Span& span;
    const Region& region;
    std::vector<Substep> steps;
    std::uint64_t at_rest;  // attributes that move leaves unchanged
    bool conditional;  // whether any action has a condition
    bool wraps;  // whether any action moves particles in periodic space
    std::uint64_t touched;  // attributes that are read or written
  };

  Pass prepare(particles::Store& store, std::size_t entry, const Span& span, particles::Key key,
               const Region& region) const;
  void run_range(const Pass& pass, std::size_t first, std::size_t last, ListResult& outcome) const;
  std::vector<Substep> steps_of(std::size_t entry, const Span& span, particles::Key key) const;
  static void run_block(const Pass& pass, const std::vector<Operation>& operations, const actions::Block& block,
                        std::vector<particles::DrawKeys>& draws, FetchAhead* ahead);
  std::vector<Operation> bind(const particles::Store& store, std::uint64_t at_rest, float* scratch, float* work) const;
  void compile_laws(const particles::Schema& schema);
  static void wrap_block(const particles::Schema& schema, const actions::Block& block);
  static void run_where(const Operation& operation, const actions::Block& block, const actions::Step& step);

  void bind_part(std::size_t number, const particles::Schema& schema, float* work, Operation& operation) const;
  const actions::LawCode* bind_law(std::size_t number, float* work, Operation& operation) const;

  // A compiled law of the list.
  struct Law {
    expressions::Formula formula;
    std::vector<actions::LawResult> outcomes;
  };

  std::vector<actions::Action> list_;
  std::uint32_t place_;
  std::vector<Law> laws_;  // one per action; empty if the list has no law
  std::size_t work_ = 0;  // planes that the largest law writes
};

}  // namespace motes::program
