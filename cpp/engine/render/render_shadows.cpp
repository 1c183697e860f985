#include "engine/render/render_shadows.h"

#include <algorithm>

#include "engine/render/drawn.h"
#include "engine/session/all_reduce.h"
#include "image/light/particle_light.h"

namespace motes::engine {
namespace {

using image::ShadowExtent;
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

// Returns a failure flag, followed by the maximum and the negated minimum along each axis, light by light.
Maxima word_of_extents(const std::vector<ShadowExtent>& extents, bool failed) {
  Maxima word{failed ? 1.0f : 0.0f};
  for (const ShadowExtent& extent : extents) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      word.push_back(extent.high[axis]);
      word.push_back(-extent.low[axis]);
    }
  }
  return word;
}

void fit_grids(const Maxima& word, ShadowGrids& grids) {
  for (std::size_t light = 0; light < grids.lights(); ++light) {
    ShadowExtent extent;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent.high[axis] = word[1 + 6 * light + 2 * axis];
      extent.low[axis] = -word[2 + 6 * light + 2 * axis];
    }
    grids.fit(light, extent);
  }
}

std::vector<ShadowExtent> extents_of(threads::Pool& pool, const std::vector<ShadowPart>& parts, std::size_t lights) {
  std::vector<std::vector<ShadowExtent>> by_thread(static_cast<std::size_t>(pool.threads()),
                                                   std::vector<ShadowExtent>(lights));
  pool.run(parts.size(), [&](std::size_t p, std::size_t worker) {
    parts[p].shadows.extend(parts[p].first, parts[p].last, by_thread[worker]);
  });
  for (std::size_t t = 1; t < by_thread.size(); ++t) {
    for (std::size_t light = 0; light < lights; ++light) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ShadowExtent& all = by_thread[0][light];
        all.low[axis] = std::min(all.low[axis], by_thread[t][light].low[axis]);
        all.high[axis] = std::max(all.high[axis], by_thread[t][light].high[axis]);
      }
    }
  }
  return by_thread[0];
}

void add_depths(threads::Pool& pool, const std::vector<ShadowPart>& parts, std::vector<std::int64_t>& sums) {
  std::vector<std::vector<std::int64_t>> others(static_cast<std::size_t>(pool.threads()) - 1);
  pool.run(parts.size(), [&](std::size_t p, std::size_t worker) {
    std::vector<std::int64_t>& to = worker == 0 ? sums : others[worker - 1];
    to.resize(sums.size());
    parts[p].shadows.add(parts[p].first, parts[p].last, to.data());
  });
  for (const std::vector<std::int64_t>& other : others) {
    for (std::size_t i = 0; i < other.size(); ++i) sums[i] += other[i];
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
    for (std::int64_t& number : sums) number = in.get<std::int64_t>();
  }
}

}  // namespace

void gather_shadows(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter) {
  painter.shadows.reset();
  if (!script.record.view) return;
  const image::View& view = *script.record.view;
  if (!ShadowGrids::wanted(view, script.record.sprites)) return;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::project, "shadows");
  auto grids = std::make_unique<ShadowGrids>();
  grids->begin(view);
  Session& session = rank.session;
  Round round;
  round.turn = session.turn;
  std::vector<ShadowExtent> extents(grids->lights());
  std::vector<std::int64_t> sums(grids->lights() * ShadowGrids::numbers());
  std::vector<ShadowPart> parts;
  std::vector<DrawnSystem> systems;
  if (session.calculates()) {
    session.work("render", [&] {
      systems = shadowing(script, calculator, *rank.pool);
      parts = shadow_parts(script, view, systems, *grids);
      extents = extents_of(*rank.pool, parts, grids->lights());
    });
  }
  Maxima word = word_of_extents(extents, session.failed());
  if (session.calculates()) {
    word = all_reduce_max(rank, round, std::move(word));
    fit_grids(word, *grids);
    session.work("render", [&] { add_depths(*rank.pool, parts, sums); });
    all_reduce_sum(rank, round, comm::Phase::shadows, sums);
  }
  tell_drawers(rank, painter, word, sums);
  session.work("render", [&] {
    fit_grids(word, *grids);
    grids->resolve(sums);
    painter.shadows = std::move(grids);
  });
}

}  // namespace motes::engine
