#include "engine/render/render_shadows.h"

#include <algorithm>

#include "engine/render/drawn.h"
#include "engine/session/all_reduce.h"
#include "image/light/depth_casters.h"
#include "image/light/particle_light.h"

namespace motes::engine {
namespace {

using image::ShadowGrids;

constexpr std::size_t kParticles = std::size_t{1} << 16;  // particles per task of a thread; whole vectors

struct ShadowPart {
  image::ParticleShadows shadows;
  std::size_t first, last;
};

// Returns the systems of which casts(sprite) is true.
template <class Casts>
std::vector<DrawnSystem> shadowing(const Script& script, const Calculator& calculator, threads::Pool& pool,
                                   const Casts& casts) {
  std::vector<DrawnSystem> systems;
  for (std::size_t i = 0; i < calculator.populations.size(); ++i) {
    if (casts(script.record.sprites[i])) systems.emplace_back(script, i, calculator.populations[i]->store, pool);
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

// Sends the result, `per_part` numbers per 1 in `word`, from the first calculator to the ranks that draw but do not
// calculate.
template <class Number>
void tell_drawers(Rank& rank, const Painter& painter, Maxima& word, std::vector<Number>& numbers,
                  std::size_t per_part) {
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
      message.bytes().put_raw(numbers.data(), numbers.size() * sizeof(Number));
      session.comm().post(to, comm::Phase::shadows, session.stamp(), std::move(message));
    }
  } else if (listens(session.rank())) {
    const comm::Message message = session.comm().expect(calculators[0], comm::Phase::shadows, session.stamp());
    base::Reader in = message.reader();
    for (float& number : word) number = in.get<float>();
    numbers.resize(per_part * static_cast<std::size_t>(std::count(word.begin() + 1, word.end(), 1.0f)));
    for (Number& number : numbers) number = in.get<Number>();
  }
}

// Sums up the grids of all ranks.
void gather_grids(Rank& rank, const Script& script, const Calculator& calculator, const Painter& painter,
                  ShadowGrids& grids) {
  Session& session = rank.session;
  Round round;
  round.turn = session.turn;
  Depths depths(grids.lights());
  if (session.calculates()) {
    session.work("render", [&] {
      const std::vector<DrawnSystem> systems = shadowing(script, calculator, *rank.pool, image::casts_softly);
      add_depths(*rank.pool, shadow_parts(script, *script.record.view, systems, grids), depths);
    });
  }
  if (session.size() > 1) {
    Maxima word = word_of_layers(depths, session.failed());
    if (session.calculates()) {
      word = all_reduce_max(rank, round, std::move(word));
      pack(word, depths.sums);
      all_reduce_sum(rank, round, comm::Phase::shadows, depths.sums);
    }
    tell_drawers(rank, painter, word, depths.sums, ShadowGrids::kLayer);
    session.work("render", [&] { unpack(word, depths); });
  }
  session.work("render", [&] { grids.resolve(depths.sums, depths.boxes); });
}

// Draws this rank's particles of the systems of which casts(sprite) is true into depth maps.
template <class Casts>
void draw_depths(Rank& rank, const Script& script, const Calculator& calculator, const Casts& casts,
                 std::vector<image::DepthMap>& maps) {
  if (!script.record.view) return;
  const image::View& view = *script.record.view;
  threads::Pool& pool = *rank.pool;
  const std::vector<DrawnSystem> systems = shadowing(script, calculator, pool, casts);
  struct Part {
    image::DepthCasters casters;
    std::size_t first, last;
  };
  std::vector<Part> parts;
  for (const DrawnSystem& system : systems) {
    const image::Drawn& all = system.columns();
    const std::size_t size = std::max<std::size_t>(all.count / static_cast<std::size_t>(2 * pool.threads()), 64);
    for (std::size_t first = 0; first < all.count; first += size) {
      parts.push_back({{script.record.sprites[system.number()], view, all}, first, std::min(first + size, all.count)});
    }
  }
  std::vector<std::vector<image::DepthMap>> others(static_cast<std::size_t>(pool.threads()) - 1);
  pool.run(parts.size(), [&](std::size_t p, std::size_t worker) {
    std::vector<image::DepthMap>& to = worker == 0 ? maps : others[worker - 1];
    if (to.empty()) {
      to.resize(maps.size());
      for (std::size_t light = 0; light < maps.size(); ++light) to[light].begin(maps[light].space());
    }
    parts[p].casters.draw(parts[p].first, parts[p].last, to);
  });
  for (const std::vector<image::DepthMap>& other : others) {
    for (std::size_t light = 0; light < other.size(); ++light) maps[light].merge(other[light]);
  }
}

// Returns a failure flag, followed by one number per page of all maps: 1 if it is there.
Maxima word_of_pages(const std::vector<image::DepthMap>& maps, bool failed) {
  Maxima word{failed ? 1.0f : 0.0f};
  for (const image::DepthMap& map : maps) {
    for (std::size_t page = 0; page < map.pages(); ++page) word.push_back(map.has(page) ? 1.0f : 0.0f);
  }
  return word;
}

// Calls use(page) for the pages that any calculator has, in order.
template <class Use>
void for_each_page(const Maxima& word, std::vector<image::DepthMap>& maps, const Use& use) {
  std::size_t at = 1;
  for (image::DepthMap& map : maps) {
    for (std::size_t page = 0; page < map.pages(); ++page, ++at) {
      if (at < word.size() && word[at] != 0) use(map.page(page));
    }
  }
}

// Draws depth maps on all ranks, and merges them. Systems without particles that cast anything take no time.
template <class Casts>
void gather_depths(Rank& rank, const Script& script, const Calculator& calculator, const Painter& painter,
                   const Casts& casts, std::vector<image::DepthMap>& maps) {
  const std::vector<image::Sprite>& sprites = script.record.sprites;
  if (maps.empty() || std::none_of(sprites.begin(), sprites.end(), casts)) return;
  Session& session = rank.session;
  if (session.calculates()) {
    session.work("render", [&] { draw_depths(rank, script, calculator, casts, maps); });
  }
  if (session.size() > 1) {
    constexpr std::size_t kTexels = image::DepthMap::kTexels;
    Round round;
    round.turn = session.turn;
    Maxima word = word_of_pages(maps, session.failed()), texels;
    if (session.calculates()) {
      word = all_reduce_max(rank, round, std::move(word));
      texels.push_back(word[0]);
      for_each_page(word, maps, [&](const float* page) { texels.insert(texels.end(), page, page + kTexels); });
      texels = all_reduce_max(rank, round, std::move(texels));
      texels.erase(texels.begin());
    }
    tell_drawers(rank, painter, word, texels, kTexels);
    session.work("render", [&] {
      const float* from = texels.data();
      for_each_page(word, maps, [&](float* page) {
        image::keep_nearest_texels(from, page);
        from += kTexels;
      });
    });
  }
}

}  // namespace

void gather_shadows(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter) {
  std::unique_ptr<ShadowGrids> grids = std::move(painter.shadows);  // reuses its memory
  if (!script.record.view) return;
  const image::View& view = *script.record.view;
  const std::vector<image::Sprite>& sprites = script.record.sprites;
  if (!ShadowGrids::wanted(view, sprites)) return;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::project, "shadows");
  if (grids == nullptr) grids = std::make_unique<ShadowGrids>();
  grids->begin(view);
  if (std::any_of(sprites.begin(), sprites.end(), image::casts_softly)) {
    gather_grids(rank, script, calculator, painter, *grids);
  }
  gather_depths(rank, script, calculator, painter, image::casts_sharply, grids->depths());
  gather_depths(rank, script, calculator, painter, image::covers_sky, grids->sky_depths());
  rank.session.work("render", [&] { grids->resolve_depths(); });
  if (!rank.session.failed()) painter.shadows = std::move(grids);
}

}  // namespace motes::engine
