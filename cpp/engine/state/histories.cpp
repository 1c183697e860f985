#include "engine/state/histories.h"

#include <algorithm>

namespace motes::engine {

namespace {

// Returns the maximum size of one system's history, in bytes; all systems share a limit per rank.
std::size_t most_bytes(const Script& script) {
  constexpr std::size_t kAll = std::size_t{64} << 20;
  constexpr std::size_t kLeast = std::size_t{64} << 10;
  return std::max(kLeast, kAll / std::max<std::size_t>(1, script.systems.size()));
}

}  // namespace

void ask_for_oldest(const Script& script) {
  const std::size_t most = most_bytes(script);
  for (const auto& system : script.systems) system->asks_oldest = system->history.wants_pruning(most);
}

void bound_histories(const Script& script, const Calculator& calculator) {
  const std::size_t most = most_bytes(script);
  for (std::size_t i = 0; i < script.systems.size(); ++i) {
    System& system = *script.systems[i];
    if (system.history.bytes() > most) keep_copies(system, *calculator.populations[i]);
  }
}

}  // namespace motes::engine
