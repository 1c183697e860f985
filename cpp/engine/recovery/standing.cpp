#include "engine/recovery/standing.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace motes::engine {
namespace {

// Returns the rank that holds each calculator's particles of a generation; nothing if some particles are lost or a rank
// does not have the generation.
std::optional<std::vector<int>> holders_of(const std::vector<Standing>& standings, GenerationId of) {
  std::vector<int> holders, owners;
  for (std::size_t rank = 0; rank < standings.size(); ++rank) {
    const std::vector<Holding>& holdings = standings[rank].holdings;
    const auto holding = std::find_if(holdings.begin(), holdings.end(), [&](const Holding& h) { return h.of == of; });
    if (holding == holdings.end()) return {};
    if (rank == 0) holders.assign(holding->parts, -1);
    if (holding->own >= 0) holders.at(static_cast<std::size_t>(holding->own)) = static_cast<int>(rank);
    owners.push_back(holding->other);
  }
  for (std::size_t rank = 0; rank < owners.size(); ++rank) {
    if (owners[rank] < 0) continue;
    int& holder = holders.at(static_cast<std::size_t>(owners[rank]));
    if (holder < 0) holder = static_cast<int>(rank);
  }
  if (std::find(holders.begin(), holders.end(), -1) != holders.end()) return {};
  return holders;
}

void refuse(WayBack& way, const std::string& why) {
  if (way.refusal.empty()) way.refusal = why;
}

// Refuses recovery if frames cannot run again without the script.
void check_lists(const std::vector<Standing>& standings, WayBack& way) {
  for (const Standing& standing : standings) {
    const bool ahead = standing.call > way.call;
    for (const std::uint64_t frame : standing.needs_script) {
      if (frame < way.from.frame || (frame >= way.frame && !ahead)) continue;
      refuse(way, "frame " + std::to_string(frame) +
                      " cannot run again without the script: it called functions of the script, or the script wrote to "
                      "particles");
    }
    if (standing.wrote) {
      refuse(way,
             "the script wrote to particles in frame " + std::to_string(standing.frame) + ", which cannot be repeated");
    }
    if (ahead && !standing.repeatable) {
      refuse(way, "particles of frame " + std::to_string(way.frame) + " were being written to files");
    }
  }
}

}  // namespace

WayBack way_back(const std::vector<Standing>& standings) {
  WayBack way;
  const auto by_call = [](const Standing& a, const Standing& b) { return a.call < b.call; };
  const Standing& last = *std::min_element(standings.begin(), standings.end(), by_call);
  way.call = last.call;
  way.frame = last.frame;
  for (const Standing& standing : standings) {
    if (!standing.refusal.empty()) refuse(way, standing.refusal);
    if (standing.call > way.call) {
      way.anyone_ahead = true;
      way.announced = standing.announced;  // the same on all ranks that are ahead
    }
    way.unsaved_from = std::min(way.unsaved_from, standing.unsaved_from);
  }
  const std::vector<Holding>& known = standings.front().holdings;
  std::optional<std::vector<int>> holders;
  for (auto holding = known.rbegin(); !holders && holding != known.rend(); ++holding) {
    if (holding->of.frame > std::min(way.frame, way.unsaved_from)) continue;
    holders = holders_of(standings, holding->of);
    way.from = holding->of;
  }
  if (holders) {
    way.holders = std::move(*holders);
  } else {
    refuse(way, way.unsaved_from < way.frame
                    ? "the pictures of the frames from " + std::to_string(way.unsaved_from) +
                          " on are lost, and replicas of particles do not go back that far"
                    : "no rank holds a replica of its particles: a calculator was lost together with the next one");
  }
  check_lists(standings, way);
  return way;
}

}  // namespace motes::engine
