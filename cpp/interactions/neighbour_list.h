// Who may come within reach of whom, kept until something has moved by half of the skin (Verlet 1967, "Computer
// experiments on classical fluids"). A particle's neighbours stand in the order of their ids, so what is summed over
// those within reach depends neither on the skin nor on when the list was made.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "interactions/extent.h"
#include "interactions/kernels.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::interactions {

/// Where particles are, by place: what kernels read.
struct PlacedSpheres {
  const float* at[3];   // metres
  const float* radius;  // metres
};

/// The id of a clump's sphere: the clump's, and the sphere's number.
constexpr std::uint64_t sphere_id(std::uint64_t clump, std::size_t sphere) {
  return clump * actions::kMostSpheres + sphere;
}
constexpr std::uint64_t clump_of(std::uint64_t sphere_id) { return sphere_id / actions::kMostSpheres; }
constexpr std::uint32_t number_of(std::uint64_t sphere_id) {
  return static_cast<std::uint32_t>(sphere_id % actions::kMostSpheres);
}

/// The radii of a system's own particles, in the order in memory. Points that see each other within a reach are spheres
/// of half of it.
struct Radii {
  float given = 0;  // metres; 0: half of each one's size
  Column size, mass;
  bool skips_massless = false;  // spheres without a positive mass touch nobody

  float of(std::size_t i) const {
    if (skips_massless && !(mass.of(i, SIZE_MAX) > kLeastMass)) return 0;
    return given > 0 ? given : radius_of_size(size.of(i, SIZE_MAX));
  }
};

/// How lists have worn off: what the next skin is chosen by. Its maxima over all ranks give the same skin on each.
struct Wear {
  float step =
      -1;  // metres: the farthest that a particle got in a step, on average since the list was made; -1: unknown
  float age = 0;    // steps for which the list has been kept
};

/// Returns the skin, m, of the next list: as thick as the fastest particle's steps make worth it.
float skin_of(const Wear& wear, float reach);

/// The pairs of one law in one system. Only this rank's own particles have pairs; their seconds may be ghosts.
class NeighbourList {
 public:
  const Cells& cells() const { return cells_; }

  /// Tells whether all pairs of own particles that touch are listed, as far as these have moved: they are those that
  /// are listed, in the same order, none has moved or grown by half of the skin, and they met in the sub-step before
  /// this one. The owners of ghosts tell the same of them. Particles at NaN touch nobody.
  bool holds(const Crowd& own, const Radii& radii, std::uint32_t now, threads::Pool& pool);
  const Wear& wear() const { return wear_; }
  float skin() const { return skin_; }

  /// Notes particles that are seen in another system's list, for holds() to tell of them, too. `radius`: what they
  /// count as, m.
  void note(const Crowd& own, float radius, float skin);

  /// Puts the particles in order, for columns to be put in order; then build() lists pairs.
  void sort(const Crowd& crowd, float reach, float skin, threads::Pool& pool);

  /// Lists all pairs whose surfaces are closer than the skin. What they remember comes from the list before, or from
  /// the store: of sub-step `now - 1`, of this law.
  void build(const Crowd& crowd, const PlacedSpheres& spheres, const particles::Store& store, std::uint32_t law,
             std::uint32_t now, threads::Pool& pool);

  /// The pairs, of sub-step `now`: what kernels write into their states.
  PairsView view(std::uint32_t now) {
    now_ = now;
    pending_ = kind_.parts > 0;
    return {begin_.data(), second_.data(), ids_.data(), state_.data(), kind_.parts};
  }
  /// What a list is for: how many PairStates a pair has, from which part of a touch's state on, whether seconds are
  /// ghosts alone, and whether it is of spheres of clumps: those of one clump are no pair, and a touch's part is the
  /// sphere. What another kind of law has left here is forgotten.
  struct Kind {
    std::uint32_t parts = 1, first_part = 0;
    bool ghosts_alone = false;
    bool of_clumps = false;

    bool operator==(const Kind&) const = default;
  };
  void set_kind(const Kind& kind);
  bool of_clumps() const { return kind_.of_clumps; }

  /// Writes to the store what particles remember of this law's pairs, and keeps what laws before it have written in
  /// sub-step `now`, and those behind it in the last one.
  void write_down(particles::Store& store, std::uint32_t law, std::uint32_t now);

  std::size_t pairs() const { return begin_.empty() ? 0 : begin_.back(); }

  const std::vector<std::uint64_t>& ids() const { return ids_; }  // by place
  bool owns(std::size_t place) const { return cells_.order()[place] < own_; }

  /// Whether the store lacks what pairs remember. Between frames it has all.
  bool pending() const { return pending_; }

  /// Adds the touches that the particle at a place has had in the last sub-step.
  void recall(std::size_t place, std::uint32_t law, std::vector<particles::Touch>& to) const;

 private:
  struct Known {
    std::uint64_t id;
    std::uint32_t place;

    auto operator<=>(const Known&) const = default;
  };
  // A list that is replaced by another one.
  struct Remembered {
    std::vector<std::uint64_t> ids;
    std::vector<std::uint32_t> begin, second;
    std::vector<PairState> state;

    std::vector<Known> touching(std::uint32_t step, std::uint32_t parts) const;
  };
  bool lists(const Crowd& own, std::uint32_t now) const;
  void find_pairs(const Crowd& crowd, const PlacedSpheres& spheres, threads::Pool& pool);
  void drop_own_spheres();
  void sort_pairs(std::size_t place);
  void put_state(std::size_t place, std::uint64_t id, std::uint32_t part, const PairState& remembered);
  void carry(const Remembered& before, std::uint32_t from, std::uint32_t step, std::size_t to);

  Cells cells_;
  float skin_ = 0;      // metres
  Wear wear_;
  std::uint32_t now_ = 0;  // the last sub-step
  bool pending_ = false;
  std::size_t own_ = 0;
  Kind kind_;
  // Own particles, in the order in memory, as they were when the list was made.
  std::vector<std::uint64_t> listed_;
  std::vector<float> at_[3], radius_;
  std::vector<std::uint64_t> ids_;  // by place, of ghosts too
  std::vector<std::uint32_t> begin_, second_;
  std::vector<PairState> state_;
};

/// Kept lists, by system and contact: see Side::law.
using NeighbourLists = std::map<std::pair<std::size_t, std::uint32_t>, NeighbourList>;

/// Writes to the store what migrants remember in lists that have not been written since they were used. `migrants`: by
/// index.
void write_down_touches(const NeighbourLists& lists, std::size_t system, const std::map<std::uint32_t, int>& migrants,
                        particles::Store& store);

}  // namespace motes::interactions
