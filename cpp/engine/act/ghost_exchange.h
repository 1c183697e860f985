// Swaps migrants and ghosts for a pair interaction. Where neighbour lists are kept, ghosts are kept with them, and
// between two lists nobody migrates: owners send what has changed of the same ghosts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "comm/message.h"
#include "engine/act/ghosts.h"
#include "engine/act/parties.h"
#include "interactions/ties.h"

namespace motes::engine {

/// Both conversations of one interaction: a full exchange, or a refresh of the ghosts that are kept.
class GhostExchange {
 public:
  /// Who has left this domain since the last interaction.
  struct Migrants {
    std::map<int, std::vector<std::uint32_t>> to;  // by new owner
    double farthest = 0;                           // metres outside
  };

  /// `bonds`: of a tie; else null.
  GhostExchange(const Parties& parties, const interactions::Bonds* bonds, const Images& images)
      : in_(parties), bonds_(bonds), images_(images) {}

  bool has_lists() const { return lists_; }
  /// Tells whether the lists hold, as far as this calculator knows; measures how they wear off.
  bool holds();
  const interactions::Wear& wear() const { return wear_; }
  interactions::NeighbourList& list_of(std::size_t side) const { return in_.calculator.neighbours[key(side)]; }

  /// Finds who has left this domain since the last exchange.
  void find_migrants();
  /// Returns how far outside their domain particles may be, m.
  double farthest() const { return std::max(migrants_[0].farthest, migrants_[1].farthest); }

  /// Calculators, collective: migrants go to their owners, ghosts to all that may see them. What all agreed on: how far
  /// outside any migrant is, and how far the action sees with the skin, m.
  void exchange(double farthest, double range);
  /// Calculators, collective: sends and hears what has changed of kept ghosts.
  void refresh();

  interactions::Ghosts& ghosts(std::size_t side) { return lists_ ? kept(side).ghosts : ghosts_[side]; }

 private:
  // Laws are numbered by the system that they act on: what one sees of another system has a key of its own.
  std::pair<std::size_t, std::uint32_t> key(std::size_t side) const {
    const std::size_t system = in_.interaction.systems[side];
    const std::size_t seen_by = side == 0 ? 0 : in_.script.systems.size() * (1 + in_.interaction.systems[0]);
    return {seen_by + system, in_.interaction.law};
  }
  // Tells whether anybody sees the particles of a side.
  bool seen(std::size_t side) const { return !interactions::read_by(*in_.interaction.action, side == 1).empty(); }
  KeptGhosts& kept(std::size_t side) const { return in_.calculator.ghosts[key(side)]; }
  bool concerns(int from, int to) const;
  void await(const std::vector<int>& from) const;
  void send(std::map<int, comm::Message>& messages);
  template <class Unpack>
  void hear(const std::vector<int>& from, const Unpack& unpack);
  void forget_ghosts();
  void keep_ghosts(const std::vector<int>& others);
  std::uint64_t pack_changes(int target, base::Bytes& bytes);
  void unpack_changes(int source, const comm::Message& message);
  const domains::BoxCover& cover(std::size_t side, int calculator) const;
  void choose(std::size_t side, const domains::BoxCover& seer, std::uint32_t p, std::uint8_t first,
              Chosen& chosen) const;
  void refresh_own_images();
  std::vector<std::uint32_t> near_the_border(std::size_t side) const;
  void pack(std::size_t side, std::map<int, comm::Message>& messages);
  void remove_migrants(std::size_t side);
  void unpack(const comm::Message& message);

  const Parties& in_;
  const interactions::Bonds* bonds_;
  const Images& images_;
  const bool lists_ = interactions::remembers(*in_.interaction.action);
  interactions::Wear wear_;
  Migrants migrants_[2];
  double farthest_ = 0;
  double range_ = 0;
  std::map<int, std::uint64_t> sent_;  // migrants and ghosts
  interactions::Ghosts ghosts_[2];     // where no list is kept
  mutable std::map<int, domains::BoxCover> covers_[2];  // of calculators' domains, as soon as one asks
};

}  // namespace motes::engine
