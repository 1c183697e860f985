// Exchanges migrants and ghosts for a pair interaction. If neighbour lists are kept, ghosts are kept with them: until
// the lists are rebuilt no particle migrates, and owners send only the changed columns of the same ghosts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "comm/message.h"
#include "engine/act/ghosts.h"
#include "engine/act/parties.h"
#include "interactions/pair_action.h"

namespace motes::engine {

/// The exchange of one interaction: a full exchange, or a refresh of kept ghosts.
class GhostExchange {
 public:
  /// Particles that have left this domain since the last exchange.
  struct Migrants {
    std::map<int, std::vector<std::uint32_t>> to;  // by new owner
    double farthest = 0;                           // maximum distance outside the domain, m
  };

  GhostExchange(const Parties& parties, interactions::PairAction& action, const Images& images)
      : in_(parties), action_(action), images_(images) {}

  bool has_lists() const { return lists_; }
  /// Returns whether this calculator's neighbour lists are still valid, and measures their wear.
  bool holds();
  const interactions::Wear& wear() const { return wear_; }

  /// Finds the particles that have left this domain since the last exchange.
  void find_migrants();
  /// Returns the maximum distance of particles outside their domain, m.
  double farthest() const { return std::max(migrants_[0].farthest, migrants_[1].farthest); }

  /// Sends migrants to their owners, and ghosts to all calculators that may see them. `farthest`: the maximum of
  /// farthest() over all calculators; `range`: the action's reach plus the skin, m. Collective over calculators.
  void exchange(double farthest, double range);
  /// Sends and receives the changed columns of kept ghosts. Collective over calculators.
  void refresh();

  interactions::Ghosts& ghosts(std::size_t side) { return lists_ ? kept_ghosts(side).ghosts : ghosts_[side]; }

 private:
  KeptGhosts& kept_ghosts(std::size_t side) const { return in_.calculator.ghosts[in_.key(side)]; }
  // Returns whether the action reads the particles of a side.
  bool seen(std::size_t side) const { return !action_.reads(side).empty(); }
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
  interactions::PairAction& action_;
  const Images& images_;
  const bool lists_ = interactions::remembers(*in_.interaction.meeting.sides[0].action);
  // Images are ghosts, too, unless the action finds the nearest image of a particle itself.
  const bool nearest_ = action_.across_ends() == interactions::PairAction::AcrossEnds::nearest;
  interactions::Wear wear_;
  Migrants migrants_[2];
  double farthest_ = 0;
  double range_ = 0;
  std::map<int, std::uint64_t> sent_;  // number of migrants and ghosts, by calculator
  interactions::Ghosts ghosts_[2];     // if no list is kept
  mutable std::map<int, domains::BoxCover> covers_[2];  // cache of cover(), by calculator
};

}  // namespace motes::engine
