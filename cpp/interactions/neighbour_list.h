// Neighbour lists: pairs that may come within reach, kept until a particle has moved by half of the skin (Verlet 1967,
// "Computer experiments on classical fluids"). A particle's neighbours are sorted by id, so sums over those within
// reach depend neither on the skin nor on when the list was built.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "interactions/extent.h"
#include "interactions/kernels.h"
#include "interactions/near_pairs.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::interactions {

/// Positions and radii of particles by place (their order in the cells), as kernels read them.
struct PlacedSpheres {
  const float* at[3];   // metres
  const float* radius;  // metres
};

/// Returns the id of a clump's sphere, made of the clump's id and the sphere's number.
constexpr std::uint64_t sphere_id(std::uint64_t clump, std::size_t sphere) {
  return clump * actions::kMostSpheres + sphere;
}
constexpr std::uint64_t clump_of(std::uint64_t sphere_id) { return sphere_id / actions::kMostSpheres; }
constexpr std::uint32_t number_of(std::uint64_t sphere_id) {
  return static_cast<std::uint32_t>(sphere_id % actions::kMostSpheres);
}

/// The radii of a system's own particles, by index. Points that interact within a reach count as spheres with half of
/// it as radius.
struct Radii {
  float given = 0;  // metres; 0: half of each one's size
  Column size, mass;
  bool skips_massless = false;  // spheres without a positive mass have no contacts

  float of(std::size_t i) const {
    if (skips_massless && !(mass.of(i, SIZE_MAX) >= kLeastMass)) return 0;
    return given > 0 ? given : radius_of_size(size.of(i, SIZE_MAX));
  }
};

/// How a list has worn out, from which the next skin is chosen. All ranks use the maxima over all ranks, so they choose
/// the same skin.
struct Wear {
  float step = -1;  // largest displacement since the list was built, per step, m; -1: unknown
  float age = 0;    // steps since the list was built
};

template <class Visitor>
constexpr void fields(Visitor& visit, Wear& wear) {
  visit(wear.step, wear.age);
}

/// Returns the skin, m, of the next list: the one with the lowest expected cost per step. `near`: see Law.
float skin_of(const Wear& wear, float reach, bool near);

/// The pairs of one law in one system. The first particle of a pair is this rank's own; the second may be a ghost.
class NeighbourList {
 public:
  explicit NeighbourList(const Kernels& kernels = interactions::kernels()) : near_(kernels) {}

  const Cells& cells() const { return cells_; }

  /// Returns whether the list is still valid for own particles: they are the listed ones in the same order, none has
  /// moved or grown by half of the skin, and the list was used in the previous sub-step. Ghosts are checked by their
  /// owners. Particles at NaN have no contacts.
  /// `periods`: of space, if the law sees the nearest image of each particle.
  bool holds(const Crowd& own, const Radii& radii, std::uint32_t now, threads::Pool& pool,
             const particles::Periods& periods = {});
  const Wear& wear() const { return wear_; }
  float skin() const { return skin_; }

  /// Records particles that are sources in another system's list, so that holds() checks them, too. `radius`: the
  /// radius they count with, m.
  void note(const Crowd& own, float radius, float skin);

  /// Sorts the particles into cells. The caller then arranges their columns and calls build().
  void sort(const Crowd& crowd, float reach, float skin, threads::Pool& pool);

  /// Lists all pairs whose surfaces are closer than the skin. Takes their states, of this law and sub-step `now - 1`,
  /// from the previous list or from the store. `originals`: of the crowd's last particles, which are images across the
  /// ends of periodic space; pairs are listed with the originals instead.
  void build(const Crowd& crowd, const PlacedSpheres& spheres, const particles::Store& store, std::uint32_t law,
             std::uint32_t now, threads::Pool& pool, const std::vector<std::uint32_t>& originals = {});

  /// Returns the pairs for sub-step `now`, in which kernels update their states.
  PairsView view(std::uint32_t now) {
    now_ = now;
    pending_ = kind_.parts > 0;
    return {begin_.data(), second_.data(), ids_.data(), state_.data(), kind_.parts};
  }
  /// Returns the pairs as the kernels of touches see them, in sub-step `now`. Only lists of near pairs have them.
  TouchTask touches(std::uint32_t now);
  NearPairs& near() { return near_; }

  /// What a list is for. `parts`: PairStates per pair; `first_part`: a touch's part that the first of them becomes;
  /// `ghosts_alone`: all second particles are ghosts; `of_clumps`: the particles are spheres of clumps, those of one
  /// clump are no pair, and a touch's part is the sphere's number; `near`: the law looks at near pairs, and a pair of
  /// own particles is listed once, with one state; `apart`: with one state per end. Another kind clears the list.
  struct Kind {
    std::uint32_t parts = 1, first_part = 0;
    bool ghosts_alone = false;
    bool of_clumps = false;
    bool near = false, apart = false;

    bool operator==(const Kind&) const = default;
    std::size_t states() const { return apart ? 2 : parts; }  // per pair
  };
  void set_kind(const Kind& kind);
  bool of_clumps() const { return kind_.of_clumps; }

  /// Writes the touches of this law's pairs to the store. Keeps the touches that earlier laws wrote in sub-step `now`,
  /// and those that later laws wrote in the previous one.
  void write_down(particles::Store& store, std::uint32_t law, std::uint32_t now);

  std::size_t pairs() const { return begin_.empty() ? 0 : begin_.back(); }

  const std::vector<std::uint64_t>& ids() const { return ids_; }  // by place
  bool owns(std::size_t place) const { return cells_.order()[place] < own_; }

  /// Returns whether the store lacks the states of pairs. Between frames it has them all.
  bool pending() const { return pending_; }

  /// Appends the touches of the particle at a place in the last sub-step.
  void recall(std::size_t place, std::uint32_t law, std::vector<particles::Touch>& to) const;

 private:
  // Calls visit(index, other, back) for the pairs of a place that may touch. `index`: of its state; `other`: place;
  // `back`: the state is as the other end sees it.
  template <class Visit>
  static void each_pair(const Kind& kind, const NearLinks& near, const std::vector<std::uint32_t>& begin,
                        const std::vector<std::uint32_t>& second, std::size_t place, const Visit& visit) {
    const std::size_t states = kind.states();
    if (!kind.near) {
      for (std::uint32_t e = begin[place]; e < begin[place + 1]; ++e) visit(e * states, second[e], false);
      return;
    }
    near.each(place, [&](const NearLinks::Seen& seen) {
      const bool own_state = kind.apart && seen.back;
      visit(seen.pair * states + static_cast<std::size_t>(own_state), seen.other, seen.back && !kind.apart);
    });
  }
  struct Known {
    std::uint64_t id;
    std::uint32_t place;

    auto operator<=>(const Known&) const = default;
  };
  // The list that a new one replaces.
  struct Remembered {
    std::vector<std::uint64_t> ids;
    std::vector<std::uint32_t> begin, second;
    std::vector<PairState> state;
    NearLinks near;

    std::vector<Known> touching(std::uint32_t step, const Kind& kind) const;
  };
  bool lists(const Crowd& own, std::uint32_t now) const;
  void find_pairs(const Crowd& crowd, const PlacedSpheres& spheres, threads::Pool& pool);
  void drop_pairs(const Crowd& crowd, const std::vector<std::uint32_t>& originals);
  void sort_pairs(std::size_t place);
  void find_places();
  void put_far_state(std::size_t place, std::uint64_t id, const PairState& remembered);
  void put_state(std::size_t place, std::uint64_t id, std::uint32_t part, const PairState& remembered);
  void carry(const Remembered& before, std::uint32_t from, std::uint32_t step, std::size_t to);

  Cells cells_;
  float skin_ = 0;      // metres
  Wear wear_;
  std::uint32_t now_ = 0;  // the last sub-step
  bool pending_ = false;
  std::size_t own_ = 0;
  Kind kind_;
  // Own particles by index, as they were when the list was built.
  std::vector<std::uint64_t> listed_;
  std::vector<float> at_[3], radius_;
  std::vector<std::uint64_t> ids_;  // by place, of ghosts too
  std::vector<Known> own_places_;  // by id, if ends have states of their own
  std::vector<std::uint32_t> begin_, second_, first_;
  std::vector<PairState> state_;
  NearPairs near_;
};

/// Kept lists, by system and law: see SideList::law.
using NeighbourLists = std::map<std::pair<std::size_t, std::uint32_t>, NeighbourList>;

/// Writes to the store the touches of migrants that only lists hold so far. `migrants`: new owners, by index.
void write_down_touches(const NeighbourLists& lists, std::size_t system, const std::map<std::uint32_t, int>& migrants,
                        particles::Store& store);

}  // namespace motes::interactions
