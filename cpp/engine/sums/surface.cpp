#include "engine/sums/surface.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/sums/sums.h"

namespace motes::engine {
namespace {

using comm::Message;
using comm::Phase;
using surfaces::Field;

// Sums the fields of all ranks up the tree; the total is sent down again. A rank that fails passes empty messages on.
void sum_fields(Rank& rank, Field& own) {
  Session& session = rank.session;
  Relay& relay = session.relay();
  const auto take = [&](const Message& message) {
    if (message.header().failed != 0) return;  // that rank raises the error when all agree
    session.work("surface", [&] {
      base::Reader in = message.reader();
      own.add(in);
    });
  };
  const auto written = [&] {
    Message message;
    session.work("surface", [&] { own.write(message.bytes()); });
    return session.failed() ? Message() : std::move(message);
  };
  for (const Message& below : relay.from_below(Phase::gather, session.stamp())) take(below);
  if (!relay.tree().root()) {
    relay.pass_up(Phase::gather, session.stamp(), written(), session.failed());
    own = Field(own.measure());
    take(relay.from_above(Phase::gather, session.stamp()));
  }
  for (const roles::Tree::Range& child : relay.tree().children()) {
    relay.pass_down(child, Phase::gather, session.stamp(), written(), session.failed());
  }
}

}  // namespace

Field field_of(Rank& rank, const ParticlesView& seen, const surfaces::Measure& measure) {
  constexpr std::size_t kParticles = std::size_t{1} << 16;
  std::array<const float*, 3> position{};
  for (int c = 0; c < 3; ++c) position[static_cast<std::size_t>(c)] = seen.store->plane(particles::position, c);
  Field field(measure);
  if (position[0] == nullptr) return field;  // there was never a particle
  std::vector<Field> others(static_cast<std::size_t>(rank.pool->threads()) - 1, field);
  const std::size_t size = rank.pool->items(kParticles);
  rank.pool->run((seen.count + size - 1) / size, [&](std::size_t part, std::size_t worker) {
    Field& to = worker == 0 ? field : others[worker - 1];
    to.add(position, part * size, std::min((part + 1) * size, seen.count));
  });
  for (const Field& other : others) field.add(other);
  return field;
}

surfaces::Skin surface_of_all(Rank& rank, Field own) {
  std::vector<std::int64_t> numbers{static_cast<std::int64_t>(own.size()), own.too_large() ? 1 : 0};
  const auto totals = std::get<std::vector<std::int64_t>>(total_of_all(rank, program::Summed(std::move(numbers))));
  if (totals[1] != 0 || totals[0] > static_cast<std::int64_t>(surfaces::kMostBlocks)) {
    surfaces::refuse_size(own.measure());
  }
  sum_fields(rank, own);
  surfaces::Skin skin;
  rank.session.work("surface", [&] { skin = surfaces::skin_of(own, *rank.pool); });
  return skin;
}

}  // namespace motes::engine
