// Ghosts that are kept together with a neighbour list: which particles are sent to which calculator.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "domains/domains.h"
#include "interactions/sides.h"

namespace motes::engine {

/// The ghosts of one interaction in one system, on one calculator. While the list is kept, owners send only columns;
/// both ends know the order, ascending by id.
struct KeptGhosts {
  interactions::Ghosts ghosts;
  domains::Domains domains;  // domains when the ghosts were chosen
  std::map<int, std::vector<std::uint32_t>> sent;      // by calculator: indices of own particles
  std::map<int, std::vector<std::uint32_t>> received;  // by calculator: indices into `ghosts`
  std::map<int, std::vector<float>> last_sent;  // by calculator: the columns as last sent, concatenated
};

/// Kept ghosts by system and interaction, with the same keys as neighbour lists.
using AllKeptGhosts = std::map<std::pair<std::size_t, std::uint32_t>, KeptGhosts>;

}  // namespace motes::engine
