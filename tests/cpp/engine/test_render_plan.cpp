// Which rank draws what: the plan of a picture from counts and seconds; and the order in which tiles are dealt out.
#include <numeric>

#include "engine/render/render_load.h"
#include "engine/render/render_plan.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_render_plan {
using engine::RenderLoad;
using engine::RenderPlan;
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

// Returns a load of `records`, evenly over the tiles first .. end - 1.
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
  return engine::plan_render(view, kDiscs, load, cast, ranks);
}

double records_of(const RenderPlan& plan, const RenderLoad& load, int rank) {
  const image::Slots slots = image::slots_of(plan.order, load.grid);
  double records = 0;
  for (int s = plan.first(rank); s < plan.end(rank); ++s)
    records += load.counts[static_cast<std::size_t>(slots.tile(s))];
  return records;
}

// Checks that every slot has one owner, in the order in which the tiles are dealt out.
void check_owners(const RenderPlan& plan, int ranks, int slots) {
  std::vector<int> owners(static_cast<std::size_t>(slots), 0);
  for (int r = 0; r < ranks; ++r) {
    CHECK(plan.first(r) <= plan.end(r));
    for (int s = plan.first(r); s < plan.end(r); ++s) ++owners[static_cast<std::size_t>(s)];
  }
  for (const int n : owners) CHECK(n == 1);
}

image::View seen_from(Vector position, Vector up = {0, 1, 0}) {
  image::View view = test_render_plan::view(Path::tiles);
  view.camera.position = position;
  view.camera.look_at = {0, 0, 0};
  view.camera.up = up;
  return view;
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
          CHECK(p.path != Path::automatic);
          CHECK(path == Path::automatic || p.path == path);
          check_owners(p, ranks, kTiles);
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
  // The image generator draws while the calculators act; the manager must announce the births before they do.
  const roles::Cast cast = roles::cast_auto(4);
  const RenderLoad some = load(cast, 3.2e6, 0, kTiles, 0.02);
  const RenderPlan p = plan(view(Path::tiles), some, cast, 4);
  const double generator = records_of(p, some, 0), manager = records_of(p, some, 1);
  CHECK(generator > 1.5 * manager);
  for (const int c : cast.calculators) CHECK_NEAR(records_of(p, some, c) / manager, 1, 0.2);
  // Seconds of one frame promise nothing for the next, so no rank draws much more than twice an even share.
  const RenderLoad busy = load(cast, 3.2e6, 0, kTiles, 100);
  const RenderPlan q = plan(view(Path::tiles), busy, cast, 4);
  CHECK(records_of(q, busy, 0) >= generator);
  CHECK(records_of(q, busy, 0) < 0.5 * 3.2e6 && q.draws(2));
  // If the manager assembles the picture, no calculator acts before that is done.
  const roles::Cast shared = roles::cast_shared(4);
  RenderLoad uneven = load(shared, 3.2e6);
  uneven.calculators[2].act_s *= 3;
  CHECK(plan(view(Path::tiles), uneven, shared, 4) == plan(view(Path::tiles), load(shared, 3.2e6), shared, 4));
}

TEST(slow_ranks_draw_as_much_less_as_they_are_slower) {
  const roles::Cast cast = roles::cast_shared(4);
  RenderLoad some = load(cast, 3.2e6);
  const RenderPlan even = plan(view(Path::tiles), some, cast, 4);
  for (int picture = 0; picture < 20; ++picture) {  // ranks 2 and 3 take twice as long
    std::vector<engine::DrawSample> samples;
    for (int r = 0; r < 4; ++r) samples.push_back({r, 0.01, r < 2 ? 0.01 : 0.02});
    some.speeds.add(samples);
  }
  const RenderPlan p = plan(view(Path::tiles), some, cast, 4);
  check_owners(p, 4, kTiles);
  for (int r = 0; r < 4; ++r) {
    CHECK_NEAR(records_of(p, some, r) / records_of(even, some, r), r < 2 ? 4.0 / 3 : 2.0 / 3, 0.1);
  }
  const image::View v = view(Path::tiles);
  CHECK(engine::estimate(Path::tiles, v, kDiscs, some, cast, 4).seconds <
        1.2 * engine::estimate(Path::tiles, v, kDiscs, load(cast, 3.2e6), cast, 4).seconds);
}

// On path composite no other rank can draw a slow calculator's particles.
TEST(a_slow_calculator_draws_its_own_particles_slowly) {
  const roles::Cast cast = roles::cast_shared(4);
  const RenderLoad alike = load(cast, 3.2e6, 200, 202);
  RenderLoad one_slow = alike;
  one_slow.speeds.add(std::vector<engine::DrawSample>{{0, 0.01, 0.01}, {1, 0.01, 0.01}, {2, 0.01, 0.04}});
  const double slower = one_slow.speeds.of(0) / one_slow.speeds.of(2);
  CHECK_NEAR(slower, 4, 1e-6);
  const auto seconds = [&](const RenderLoad& load) {
    return engine::estimate(Path::composite, view(), kDiscs, load, cast, 4).seconds;
  };
  const double drawn = engine::drawing_s(view(), kDiscs, 3.2e6 / 4, 0);
  CHECK(seconds(one_slow) - seconds(alike) > 0.8 * drawn * (1 / one_slow.speeds.of(2) - 1));
  CHECK(plan(view(), alike, cast, 4).path == Path::composite);
  for (int picture = 0; picture < 50; ++picture) {
    one_slow.speeds.add(std::vector<engine::DrawSample>{{0, 0.01, 0.01}, {1, 0.01, 0.01}, {2, 0.01, 0.3}});
  }
  CHECK(plan(view(), one_slow, cast, 4).path == Path::tiles);  // others draw for it
}

TEST(who_assembles_draws_less_by_what_that_took) {
  const roles::Cast cast = roles::cast_shared(4);
  const auto home = cast.image_generator;
  RenderLoad some = load(cast, 3.2e6);
  const auto share_with = [&](double assembled_pixel_s) {
    some.assembled_pixel_s = assembled_pixel_s;
    return records_of(plan(view(Path::tiles), some, cast, 4), some, home) / 3.2e6;
  };
  const double light = share_with(1e-12), heavy = share_with(2e-9);
  CHECK_NEAR(light, 0.25, 0.01);
  CHECK(heavy > 0.1 && heavy < 0.22);
  // On a machine of half the speed drawing takes twice as long, but these seconds were measured on it.
  some.speeds.add(std::vector<engine::DrawSample>{{0, 0.01, 0.02}, {1, 0.01, 0.02}});
  CHECK(some.speeds.slowness() == 2);
  CHECK_NEAR(light - share_with(2e-9), (light - heavy) / 2, 0.01);
  // The messages of many ranks cost more than their content.
  const roles::Cast many = roles::cast_shared(512);
  RenderLoad large = load(many, 3.2e6);
  large.assembled_pixel_s = 1e-12;
  CHECK(!plan(view(Path::tiles), large, many, 512).draws(many.image_generator));
}

TEST(seconds_of_assembly_are_those_per_pixel_of_other_ranks) {
  RenderLoad some;
  some.grid = {128, 96};  // 2x2 tiles, two of them with 32 rows
  some.counts.assign(4, 0);
  engine::Drawings drawn;
  drawn.tiles = {{0, {1, 1}, 0, 0.1f}, {2, {1, 1}, 1, 0.1f}};
  engine::note_assembly(drawn, 0, some);
  CHECK(some.assembled_pixel_s == 0);  // there was nothing to put together
  drawn.assemble_s = 3e-3;
  engine::note_assembly(drawn, 0, some);
  CHECK_NEAR(some.assembled_pixel_s * 1e9, 3e6 / (128 * 32), 1e-6);
  drawn.assemble_s = 30e-3;  // an image generator that was held up
  engine::note_assembly(drawn, 0, some);
  CHECK(some.assembled_pixel_s * 1e9 > 3e6 / (128 * 32) && some.assembled_pixel_s * 1e9 < 15e6 / (128 * 32));
}

TEST(speeds_are_those_of_many_pictures_relative_to_all_that_draw) {
  engine::DrawSpeeds speeds;
  CHECK(speeds.of(7) == 1);
  constexpr float noise = 0.03f;
  test::Dice dice(5);
  const auto picture = [&](double of_second) {
    std::vector<engine::DrawSample> samples;
    for (int r = 0; r < 3; ++r) {
      const double slower = (r == 1 ? 1 / of_second : 1) * (1 + double{dice.between(-noise, noise)});
      samples.push_back({r, 0.01, 0.05 * slower});  // the machine that costs were measured on is five times as fast
    }
    speeds.add(samples);
  };
  for (int i = 0; i < 100; ++i) picture(1);
  for (std::size_t r = 0; r < 3; ++r) CHECK(speeds.of(r) == 1);  // alike, but for noise
  for (int i = 0; i < 100; ++i) picture(0.95);  // two ranks that are a twentieth apart wait for each other, too
  CHECK_NEAR(speeds.of(1) / speeds.of(0), 0.95, 0.025);
  for (int i = 0; i < 100; ++i) picture(0.25);
  CHECK_NEAR(speeds.of(1) / speeds.of(0), 0.25, 0.03);
  CHECK_NEAR(speeds.of(2) / speeds.of(0), 1, 0.1);
  const double before = speeds.of(1);
  speeds.add(std::vector<engine::DrawSample>{{1, 1e-6, 1}, {0, 0, 0}});  // next to nothing was drawn
  CHECK(speeds.of(1) == before);
  for (int i = 0; i < 100; ++i) speeds.add(std::vector<engine::DrawSample>{{0, 1, 1}, {1, 1, 1e6}});
  CHECK(speeds.of(1) >= 1.0 / 40);  // and may show that it is faster
}

TEST(records_cost_as_many_bytes_as_they_had_in_the_last_picture) {
  const roles::Cast cast = roles::cast_auto(4);
  RenderLoad some;
  const auto seconds = [&](double record_bytes) {
    some = load(cast, 3.2e6);
    some.record_bytes = record_bytes;
    return engine::estimate(Path::gather, view(), kDiscs, some, cast, 4).seconds;
  };
  CHECK(seconds(0) == seconds(8));
  CHECK_NEAR((seconds(12) - seconds(4)) / (seconds(8) - seconds(4)), 2, 1e-6);
  CHECK(seconds(8) > 1.1 * seconds(4));
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
  small.width = 256;
  small.height = 128;
  CHECK(plan(small, load(cast, 100), cast, 4).path == Path::gather);
  small.bloom = 0.2f;  // bloom, which ranks share
  CHECK(plan(small, load(cast, 100), cast, 4).path == Path::tiles);
}

TEST(light_alone_or_opaque_particles_are_merged) {
  using Blend = image::Sprite::Blend;
  image::View plain = view();
  const auto merged = [&](std::vector<Blend> blends) {
    std::vector<image::Sprite> sprites(blends.size());
    for (std::size_t i = 0; i < blends.size(); ++i) sprites[i].blend = blends[i];
    return engine::merged_blend(plain, sprites);
  };
  CHECK(merged({Blend::add, Blend::add}) == Blend::add);
  CHECK(merged({Blend::opaque, Blend::opaque}) == Blend::opaque);
  CHECK(merged({Blend::opaque, Blend::add}) == Blend::opaque);  // which hides light of other ranks
  CHECK(merged({Blend::alpha, Blend::opaque, Blend::add}) == Blend::opaque);
  CHECK(!merged({Blend::alpha}) && !merged({Blend::alpha, Blend::add}));
  plain.layers = image::kVelocityLayer;
  CHECK(!merged({Blend::opaque}) && merged({Blend::add}) == Blend::add);
}

TEST(many_pebbles_in_few_tiles_are_merged) {
  const roles::Cast cast = roles::cast_shared(4);
  std::vector<image::Sprite> pebbles = kDiscs;
  for (image::Sprite& sprite : pebbles) sprite.blend = image::Sprite::Blend::opaque;
  const RenderLoad far = load(cast, 3.2e6, 200, 201), near = load(cast, 3.2e6);
  CHECK(engine::plan_render(view(), pebbles, far, cast, 4).path == Path::composite);
  CHECK(engine::plan_render(view(), pebbles, near, cast, 4).path == Path::tiles);
}

TEST(what_cannot_be_merged_goes_to_the_owners_of_tiles) {
  const roles::Cast cast = roles::cast_shared(4);
  const RenderLoad some = load(cast, 3.2e6, 200, 201);
  std::vector<image::Sprite> smoke = kDiscs;
  smoke.back().blend = image::Sprite::Blend::alpha;
  CHECK(engine::plan_render(view(Path::composite), smoke, some, cast, 4).path == Path::tiles);
  CHECK(engine::plan_render(view(), smoke, some, cast, 4).path != Path::composite);
}

TEST(counts_of_another_picture_are_not_used) {
  const roles::Cast cast = roles::cast_shared(2);
  RenderLoad other = load(cast, 3.2e6, 0, 1);
  other.grid = {1080, 1920};
  CHECK_NEAR(plan(view(Path::tiles), other, cast, 2).end(0), kTiles / 2, 20);
  check_owners(plan(view(Path::tiles), {}, cast, 2), 2, kTiles);
}

TEST(slots_are_tiles_row_by_row_or_column_by_column) {
  const image::Grid grid{3 * image::kTile, 2 * image::kTile};
  const image::Slots columns = image::slots_of(image::TileOrder::columns, grid);
  const image::Slots rows = image::slots_of(image::TileOrder::rows, grid);
  const int tiles[6] = {0, 3, 1, 4, 2, 5};
  for (int s = 0; s < 6; ++s) {
    CHECK(columns.tile(s) == tiles[s] && columns.slot(tiles[s]) == s);
    CHECK(rows.tile(s) == s);
  }
}

TEST(calculators_draw_where_their_slices_are_seen) {
  const roles::Cast four = roles::cast_shared(4);
  const auto dealt = [&](int axis, const image::View& view) { return engine::deal_along(axis, view, four, 4); };
  const std::vector<int> up{0, 1, 2, 3}, down{3, 2, 1, 0};
  using image::TileOrder;
  const image::View front = seen_from({0, 1, 9}), back = seen_from({0, 1, -9}), top = seen_from({0, 9, 0}, {1, 0, 0});
  CHECK(dealt(0, front).order == image::TileOrder::columns && dealt(0, front).ranks == up);
  CHECK(dealt(0, back).order == image::TileOrder::columns && dealt(0, back).ranks == down);
  CHECK(dealt(1, front).order == image::TileOrder::rows &&
        dealt(1, front).ranks == down);  // the lowest slice is at the bottom
  CHECK(dealt(0, top).order == image::TileOrder::rows && dealt(0, top).ranks == down);
  CHECK(dealt(2, top).order == image::TileOrder::columns);
}

TEST(ranks_without_particles_draw_between_the_calculators) {
  const auto ranks = [](const roles::Cast& cast, int size) {
    return engine::deal_along(0, seen_from({0, 0, 9}), cast, size).ranks;
  };
  CHECK(ranks(roles::cast_auto(3), 3).at(1) == 2);
  CHECK((ranks(roles::cast_auto(4), 4) == std::vector<int>{2, 0, 1, 3}));
  CHECK((ranks(roles::cast_auto(6), 6) == std::vector<int>{2, 0, 3, 4, 1, 5}));
}

TEST(tiles_with_objects_stay_with_their_owners_while_others_are_no_better) {
  const roles::Cast cast = roles::cast_shared(4);
  image::View still = view(Path::tiles);
  RenderLoad some = load(cast, 3.2e6);
  some.assembled_pixel_s = 2e-10;  // 0.3 ms, where drawing takes 5
  some.last = plan(still, some, cast, 4);
  RenderLoad later = some;
  later.assembled_pixel_s *= 1.2;
  CHECK(plan(still, later, cast, 4) != some.last);
  still.objects.resize(1);
  CHECK(plan(still, later, cast, 4) == some.last);
  later.assembled_pixel_s *= 3;
  CHECK(plan(still, later, cast, 4) != some.last);
}

// Ranks report a picture while the next one is planned: with alternating sizes, the size returns before its counts do.
TEST(a_plan_for_another_size_or_for_more_ranks_is_not_taken_again) {
  image::View large = view(Path::tiles), small = large;
  small.width = 200;
  small.height = 150;
  large.objects.resize(1);
  small.objects.resize(1);
  for (const int ranks : {1, 3}) {
    const roles::Cast cast = roles::cast_shared(ranks);
    RenderLoad some = load(cast, 3.2e6);
    for (const image::View& last : {small, large}) {
      some.last = plan(last, some, cast, ranks);
      check_owners(plan(large, some, cast, ranks), ranks, kTiles);
      check_owners(plan(small, some, cast, ranks), ranks, image::Grid{small.width, small.height}.tiles());
    }
    some.last = plan(large, some, roles::cast_shared(ranks + 1), ranks + 1);
    check_owners(plan(large, some, cast, ranks), ranks, kTiles);
  }
}

}  // namespace motes::test_render_plan
