#include "engine/render/render_shadows.h"

#include <algorithm>

#include "engine/render/drawn.h"
#include "engine/session/all_reduce.h"
#include "image/light/particle_light.h"

namespace motes::engine {
namespace {

using image::ShadowGrids;

constexpr std::size_t kParticles = std::size_t{1} << 16;  // particles per task of a thread; whole vectors

struct ShadowPart {
  image::ParticleShadows shadows;
  std::size_t first, last;
};

// Returns the systems that cast shadows.
std::vector<DrawnSystem> shadowing(const Script& script, const Calculator& calculator, threads::Pool& pool) {
  std::vector<DrawnSystem> systems;
  for (std::size_t i = 0; i < calculator.populations.size(); ++i) {
    if (script.record.sprites[i].shadow > 0) systems.emplace_back(script, i, calculator.populations[i]->store, pool);
  }
  return systems;
}

std::vector<ShadowPart> shadow_parts(const Script& script, const image::View& view,
                                     const std::vector<DrawnSystem>& systems, const ShadowGrids& grids) {
  std::vector<ShadowPart> parts;
  for (const DrawnSystem& system : systems) {
    const image::Sprite& sprite = script.record.sprites[system.number()];
    const image::Drawn& all = system.columns();
    for (std::size_t first = 0; first < all.count; first += kParticles) {
      parts.push_back(
          {image::ParticleShadows(sprite, view, grids, all), first, std::min(first + kParticles, all.count)});
    }
  }
  return parts;
}

// The optical depths of all lights' grids.
struct Depths {
  std::vector<std::int64_t> sums;
  std::vector<unsigned> boxes;  // see ShadowGrids::resolve

  explicit Depths(std::size_t lights) : sums(lights * ShadowGrids::numbers()), boxes(lights) {}
};

constexpr std::size_t kLayers = std::size_t{image::kShadowBoxes} * image::kShadowLayers;  // of one light

// Returns a failure flag, followed by one number per layer of all boxes of all lights: 1 if anything is in it.
Maxima word_of_layers(const Depths& depths, bool failed) {
  Maxima word{failed ? 1.0f : 0.0f};
  for (std::size_t layer = 0; layer < depths.boxes.size() * kLayers; ++layer) {
    const unsigned boxes = depths.boxes[layer / kLayers];
    const auto first = depths.sums.begin() + static_cast<std::ptrdiff_t>(layer * ShadowGrids::kLayer);
    const bool used = (boxes >> (layer % kLayers / image::kShadowLayers) & 1u) != 0 &&
                      std::any_of(first, first + ShadowGrids::kLayer, [](std::int64_t sum) { return sum != 0; });
    word.push_back(used ? 1.0f : 0.0f);
  }
  return word;
}

// Moves the layers that any calculator uses to the front, which are all that ranks send to each other.
void pack(const Maxima& word, std::vector<std::int64_t>& sums) {
  auto to = sums.begin();
  for (std::size_t layer = 0; layer + 1 < word.size(); ++layer) {
    const auto from = sums.begin() + static_cast<std::ptrdiff_t>(layer * ShadowGrids::kLayer);
    if (word[1 + layer] != 0) to = std::copy_n(from, ShadowGrids::kLayer, to);
  }
  sums.erase(to, sums.end());
}

// Moves the layers back to their places, and marks the boxes that have any.
void unpack(const Maxima& word, Depths& depths) {
  std::vector<std::int64_t> all((word.size() - 1) * ShadowGrids::kLayer);
  auto from = depths.sums.begin();
  for (std::size_t layer = 0; layer + 1 < word.size(); ++layer) {
    if (word[1 + layer] == 0) continue;
    std::copy_n(from, ShadowGrids::kLayer, all.begin() + static_cast<std::ptrdiff_t>(layer * ShadowGrids::kLayer));
    from += ShadowGrids::kLayer;
    depths.boxes[layer / kLayers] |= 1u << (layer % kLayers / image::kShadowLayers);
  }
  depths.sums = std::move(all);
}

void add_depths(threads::Pool& pool, const std::vector<ShadowPart>& parts, Depths& depths) {
  std::vector<Depths> others(static_cast<std::size_t>(pool.threads()) - 1, Depths(0));
  pool.run(parts.size(), [&](std::size_t p, std::size_t worker) {
    Depths& to = worker == 0 ? depths : others[worker - 1];
    to.sums.resize(depths.sums.size());
    to.boxes.resize(depths.boxes.size());
    parts[p].shadows.add(parts[p].first, parts[p].last, to.sums.data(), to.boxes);
  });
  for (const Depths& other : others) {
    for (std::size_t i = 0; i < other.sums.size(); ++i) depths.sums[i] += other.sums[i];
    for (std::size_t i = 0; i < other.boxes.size(); ++i) depths.boxes[i] |= other.boxes[i];
  }
}

// Sends the result from the first calculator to the ranks that draw but do not calculate.
void tell_drawers(Rank& rank, const Painter& painter, Maxima& word, std::vector<std::int64_t>& sums) {
  Session& session = rank.session;
  const std::vector<int>& calculators = session.cast().calculators;
  const auto listens = [&](int to) {
    return painter.plan.draws(to) && std::find(calculators.begin(), calculators.end(), to) == calculators.end();
  };
  if (session.calculator() == 0) {
    for (int to = 0; to < session.size(); ++to) {
      if (!listens(to)) continue;
      comm::Message message;
      message.bytes().put_raw(word.data(), word.size() * sizeof(float));
      message.bytes().put_raw(sums.data(), sums.size() * sizeof(std::int64_t));
      session.comm().post(to, comm::Phase::shadows, session.stamp(), std::move(message));
    }
  } else if (listens(session.rank())) {
    const comm::Message message = session.comm().expect(calculators[0], comm::Phase::shadows, session.stamp());
    base::Reader in = message.reader();
    for (float& number : word) number = in.get<float>();
    sums.resize(ShadowGrids::kLayer * static_cast<std::size_t>(std::count(word.begin() + 1, word.end(), 1.0f)));
    for (std::int64_t& number : sums) number = in.get<std::int64_t>();
  }
}

}  // namespace

void gather_shadows(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter) {
  std::unique_ptr<ShadowGrids> grids = std::move(painter.shadows);  // reuses its memory
  if (!script.record.view) return;
  const image::View& view = *script.record.view;
  if (!ShadowGrids::wanted(view, script.record.sprites)) return;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::project, "shadows");
  if (grids == nullptr) grids = std::make_unique<ShadowGrids>();
  grids->begin(view);
  Session& session = rank.session;
  Round round;
  round.turn = session.turn;
  Depths depths(grids->lights());
  if (session.calculates()) {
    session.work("render", [&] {
      const std::vector<DrawnSystem> systems = shadowing(script, calculator, *rank.pool);
      add_depths(*rank.pool, shadow_parts(script, view, systems, *grids), depths);
    });
  }
  if (session.size() > 1) {
    Maxima word = word_of_layers(depths, session.failed());
    if (session.calculates()) {
      word = all_reduce_max(rank, round, std::move(word));
      pack(word, depths.sums);
      all_reduce_sum(rank, round, comm::Phase::shadows, depths.sums);
    }
    tell_drawers(rank, painter, word, depths.sums);
    session.work("render", [&] { unpack(word, depths); });
  }
  session.work("render", [&] {
    grids->resolve(depths.sums, depths.boxes);
    painter.shadows = std::move(grids);
  });
}

}  // namespace motes::engine
