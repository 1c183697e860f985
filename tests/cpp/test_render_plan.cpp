// Who draws what: the plan of a picture from counts and seconds.
#include <numeric>

#include "check.h"
#include "frame/render_plan.h"

using namespace motes;
using frame::RenderLoad;
using frame::RenderPlan;
using Path = image::View::Path;

namespace {

image::View view(Path path = Path::automatic) {
  image::View view;
  view.width = 1920;
  view.height = 1080;
  view.path = path;
  return view;
}

constexpr int kTiles = 30 * 17;

// `records` in all, evenly over the tiles first .. end - 1.
RenderLoad load(const roles::Cast& cast, double records, int first = 0, int end = kTiles, double act_s = 0.01) {
  RenderLoad load;
  load.grid = {1920, 1080};
  load.counts.assign(kTiles, 0);
  for (int t = first; t < end; ++t)
    load.counts[static_cast<std::size_t>(t)] = static_cast<std::uint32_t>(records / (end - first));
  const auto calculators = static_cast<double>(cast.calculators.size());
  load.calculators.assign(cast.calculators.size(), {records / calculators, act_s / calculators, double(end - first)});
  return load;
}

const std::vector<image::Sprite> kDiscs(8);

RenderPlan plan(const image::View& view, const RenderLoad& load, const roles::Cast& cast, int ranks) {
  return frame::plan_render(view, kDiscs, load, cast, ranks);
}

double records_of(const RenderPlan& plan, const RenderLoad& load, int rank) {
  return std::accumulate(load.counts.begin() + plan.first(rank), load.counts.begin() + plan.end(rank), 0.0);
}

}  // namespace

TEST(each_tile_has_one_owner_whatever_the_loads) {
  for (int ranks = 1; ranks < 40; ++ranks) {
    for (const bool shared : {false, true}) {
      const roles::Cast cast = shared ? roles::cast_shared(ranks) : roles::cast_auto(ranks);
      for (const Path path : {Path::automatic, Path::gather, Path::tiles, Path::composite}) {
        for (const double records : {0.0, 1.0, 1e4, 3.2e6, 1e9}) {
          RenderLoad some = load(cast, records, 100, 104, ranks % 3 * 0.05);
          some.calculators.front().act_s *= ranks;
          const RenderPlan p = plan(view(path), some, cast, ranks);
          CHECK(p.ends.size() == static_cast<std::size_t>(ranks));
          CHECK(p.path != Path::automatic && p.end(ranks - 1) == kTiles);
          CHECK(path == Path::automatic || p.path == path);
          for (int r = 0; r < ranks; ++r) CHECK(p.first(r) <= p.end(r));
          if (p.path == Path::gather)
            CHECK(p.first(cast.image_generator) == 0 && p.end(cast.image_generator) == kTiles);
        }
      }
    }
  }
}

TEST(equal_ranks_draw_equal_numbers_of_records) {
  const roles::Cast cast = roles::cast_shared(4);
  RenderLoad uneven = load(cast, 3.2e6);
  for (int t = 0; t < kTiles / 2; ++t) uneven.counts[static_cast<std::size_t>(t)] *= 3;
  const RenderPlan p = plan(view(Path::tiles), uneven, cast, 4);
  const double all = std::accumulate(uneven.counts.begin(), uneven.counts.end(), 0.0);
  for (int r = 0; r < 4; ++r) CHECK_NEAR(records_of(p, uneven, r) / all, 0.25, 0.03);
}

TEST(who_has_other_things_to_do_draws_less) {
  // The image generator draws while the calculators act; the manager must tell the births before they do.
  const roles::Cast cast = roles::cast_auto(4);
  const RenderLoad some = load(cast, 3.2e6, 0, kTiles, 0.02);
  const RenderPlan p = plan(view(Path::tiles), some, cast, 4);
  const double generator = records_of(p, some, 0), manager = records_of(p, some, 1);
  CHECK(generator > 1.5 * manager);
  for (const int c : cast.calculators) CHECK_NEAR(records_of(p, some, c) / manager, 1, 0.2);
  // Seconds of one frame are no promise for the next: nobody draws much more than twice an even share.
  const RenderLoad busy = load(cast, 3.2e6, 0, kTiles, 100);
  const RenderPlan q = plan(view(Path::tiles), busy, cast, 4);
  CHECK(records_of(q, busy, 0) >= generator);
  CHECK(records_of(q, busy, 0) < 0.5 * 3.2e6 && q.draws(2));
}

TEST(auto_picks_the_path_of_the_least_time) {
  const roles::Cast cast = roles::cast_shared(4);
  CHECK(plan(view(), load(cast, 3.2e6), cast, 4).path == Path::tiles);
  CHECK(plan(view(), load(cast, 3.2e6, 200, 201), cast, 4).path == Path::composite);
  CHECK(plan(view(), load(cast, 3.2e6, 200, 202), cast, 4).path == Path::composite);
  // One far fountain that takes fewer tiles than there are ranks.
  CHECK(plan(view(), load(roles::cast_shared(64), 25.6e6, 200, 212), roles::cast_shared(64), 64).path ==
        Path::composite);
  CHECK(plan(view(), load(roles::cast_shared(1), 3.2e6), roles::cast_shared(1), 1).path == Path::gather);
  image::View small = view();
  small.width = small.height = 64;
  CHECK(plan(small, load(cast, 100), cast, 4).path == Path::gather);
}

TEST(what_cannot_be_added_up_goes_to_the_owners_of_tiles) {
  const roles::Cast cast = roles::cast_shared(4);
  const RenderLoad some = load(cast, 3.2e6, 200, 201);
  std::vector<image::Sprite> smoke = kDiscs;
  smoke.back().blend = image::Sprite::Blend::alpha;
  CHECK(frame::plan_render(view(Path::composite), smoke, some, cast, 4).path == Path::tiles);
  CHECK(frame::plan_render(view(), smoke, some, cast, 4).path != Path::composite);
}

TEST(counts_of_another_picture_are_not_used) {
  const roles::Cast cast = roles::cast_shared(2);
  RenderLoad other = load(cast, 3.2e6, 0, 1);
  other.grid = {1080, 1920};
  CHECK_NEAR(plan(view(Path::tiles), other, cast, 2).end(0), kTiles / 2, 20);
  CHECK(plan(view(Path::tiles), {}, cast, 2).end(1) == kTiles);
}
