// Ghosts that are kept as long as the neighbour list that they stand in: who sends which of its particles to whom.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "domains/domains.h"
#include "interactions/act.h"

namespace motes::engine {

/// The ghosts of one interaction in one system, on one calculator. Between two lists, owners send columns alone: both
/// ends know the order, ascending by id.
struct KeptGhosts {
  interactions::Ghosts ghosts;
  domains::Domains domains;  // when they were chosen
  std::map<int, std::vector<std::uint32_t>> sent;      // by calculator: indices of own particles
  std::map<int, std::vector<std::uint32_t>> received;  // by calculator: places among the ghosts
  std::map<int, std::vector<float>> told;  // by calculator: columns as they were sent last, one after another
};

/// By system and interaction, as neighbour lists are.
using AllKeptGhosts = std::map<std::pair<std::size_t, std::uint32_t>, KeptGhosts>;

}  // namespace motes::engine
