// A rank that fails in the middle of a picture: all ranks that need its part learn why, on every path and in any order
// of events.
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "comm/simulated_ranks.h"
#include "engine/engine.h"
#include "support/check.h"
#include "support/drawn_scene.h"

namespace motes::test_render_failures {
using comm::SimulatedRank;
using Path = image::View::Path;

namespace {

constexpr int kFrame = 2;  // in which the rank fails

image::ProjectedCount no_projection(const image::ProjectTask&, std::size_t, std::size_t, const image::ProjectedBatch&) {
  throw std::runtime_error("the projection broke");
}
void no_light(const image::TilePlanes&, const image::Splat&, const unsigned char*, std::size_t) {
  throw std::runtime_error("the brush broke");
}

// Rows of tiles that are shown before showing one breaks.
int rows_to_go = 0;
void no_tone(const std::uint32_t* light, std::size_t count, int x, int y, const std::uint16_t* table,
             std::uint8_t* to) {
  if (--rows_to_go < 0) throw std::runtime_error("the brush broke");
  image::splat_lanes().tone(light, count, x, y, table, to);
}

struct Fault {
  int ranks;
  bool shared;
  Path path;
  int rank;
  bool projecting;     // whether it fails while projecting; else while painting
  bool later = false;  // whether a message of tiles has been sent already
  float bloom = 0;     // above 0: each rank needs light of all
};

void break_down(engine::Painter& painter, bool projecting) {
  static const image::ProjectLanes kProject{no_projection};
  static const image::SplatLanes kSplat = [] {
    image::SplatLanes lanes = image::splat_lanes();
    lanes.add = no_light;
    return lanes;
  }();
  if (projecting) {
    painter.projectors.clear();
    painter.projectors.emplace_back(kProject);
  } else {
    painter.workers = image::TileWorkers(kSplat);
    painter.canvas = image::Canvas(kSplat);
  }
}

// Fails in the second message, in a picture for which each rank sends several.
void break_down_later(engine::Painter& painter) {
  static const image::SplatLanes kSplat = [] {
    image::SplatLanes lanes = image::splat_lanes();
    lanes.tone = no_tone;
    return lanes;
  }();
  rows_to_go = 60 * 64;
  painter.workers = image::TileWorkers(kSplat);
}

// How each rank ended: "", its own exception, or the one that was reported to it.
using Ends = std::map<int, std::string>;

void play(SimulatedRank& self, const Fault& fault, Ends& ends, engine::RenderPlan& plan) {
  const roles::Cast cast = fault.shared ? roles::cast_shared(fault.ranks) : roles::cast_auto(fault.ranks);
  engine::Settings settings;
  settings.costs.act.fill(1000);
  auto communicator = std::make_unique<comm::Communicator>(self.transport(), comm::Watch{});
  engine::Engine engine(std::move(communicator), cast, std::move(settings));
  test::add_drawn_system(engine);
  image::View view = test::drawn_view(fault.later ? 1280 : 200, fault.later ? 960 : 150, fault.path);
  view.bloom = fault.bloom;
  try {
    engine.start();
    for (int i = 0; i <= kFrame; ++i) {
      engine.record(0, test::drawn_source(300));
      engine.record(0, actions::make(actions::numbers::move<>{.rotational = 1}));
      if (i == kFrame && self.rank() == fault.rank) {
        fault.later ? break_down_later(engine.painter()) : break_down(engine.painter(), fault.projecting);
      }
      engine.run_frame(view);
      plan = engine.painter().plan;
    }
    engine.digest();  // no rank gets past this
    ends[self.rank()] = "all went well";
  } catch (const engine::Agreed& agreed) {
    ends[self.rank()] = "rank " + std::to_string(agreed.verdict().failed_rank) + ": " + agreed.verdict().failure.text;
  } catch (const comm::Deadlock&) {
    ends[self.rank()] = "waits";  // for ranks that gave up; a real job would end now
  } catch (const std::runtime_error& error) {
    ends[self.rank()] = error.what();
  }
}

// Returns the ends of all ranks; sets the plan of the last frame.
Ends run(const Fault& fault, std::uint64_t seed, engine::RenderPlan& plan) {
  Ends ends;
  try {
    test::on_ranks(fault.ranks, seed, [&](SimulatedRank& self) { play(self, fault, ends, plan); });
  } catch (const comm::Deadlock&) {
    return ends;  // seen by the ranks that wait
  }
  return ends;
}

void check_fault(const Fault& fault, std::uint64_t seed) {
  const roles::Cast cast = fault.shared ? roles::cast_shared(fault.ranks) : roles::cast_auto(fault.ranks);
  const bool calculates = cast.calculator_of(fault.rank) >= 0;
  engine::RenderPlan plan;
  Ends ends = run(fault, seed, plan);
  const bool paints = fault.path == Path::composite ? calculates : plan.draws(fault.rank);
  const bool fails = fault.projecting ? calculates : paints;
  const bool needs_all = fault.bloom > 0 && fault.path != Path::gather && !fault.later;
  const std::string text = fault.projecting ? "the projection broke" : "the brush broke";
  const std::string told = "rank " + std::to_string(fault.rank) + ": " + text;
  for (int r = 0; r < fault.ranks; ++r) {
    if (!fails) {
      CHECK(ends[r] == "all went well");
    } else if (r == fault.rank) {
      CHECK(ends[r] == text);
    } else if (r == cast.image_generator || (plan.draws(r) && (fault.projecting || needs_all))) {
      CHECK(ends[r] == told);  // it has no picture, or no tile, without this part
    } else {
      CHECK(ends[r] == told || ends[r] == "waits");
    }
  }
}

}  // namespace

TEST(a_rank_that_fails_in_a_picture_tells_all_who_need_its_part) {
  std::uint64_t seed = 0;
  for (const int ranks : {1, 2, 3, 5}) {
    for (const bool shared : {false, true}) {
      for (const Path path : {Path::gather, Path::tiles, Path::composite}) {
        for (int rank = 0; rank < ranks; ++rank) {
          for (const float bloom : {0.0f, 0.2f}) {
            if (bloom > 0 && ranks != 3) continue;
            check_fault({ranks, shared, path, rank, true, false, bloom}, ++seed);
            check_fault({ranks, shared, path, rank, false, false, bloom}, ++seed);
          }
        }
      }
    }
  }
}

TEST(a_rank_that_fails_when_it_has_sent_some_of_its_tiles_tells_the_image_generator) {
  std::uint64_t seed = 0;
  for (const int ranks : {2, 3}) {
    for (const Path path : {Path::tiles, Path::composite}) {
      for (int rank = 1; rank < ranks; ++rank) {
        for (const float bloom : {0.0f, 0.2f}) check_fault({ranks, true, path, rank, false, true, bloom}, ++seed);
      }
    }
  }
}

}  // namespace motes::test_render_failures
