// Wide records compared with projections in double precision: position, size, direction and tiles.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/vectors.h"
#include "image/camera.h"
#include "image/layout.h"
#include "image/project/projector.h"
#include "image/test_image_scene.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_image_wide {
using namespace image_test;
using test::Dice;

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Particles with all columns that pictures use.
struct WideCloud : Cloud {
  std::vector<float> size, up[3], velocity[3];

  explicit WideCloud(std::size_t n) : Cloud(n, true) {
    size.assign(n + 16, 1.0f);
    for (auto& u : up) u.assign(n + 16, 0.0f);
    for (auto& v : velocity) v.assign(n + 16, 0.0f);
    up[1].assign(n + 16, 1.0f);
  }
  Drawn drawn(std::size_t first = 0, std::size_t end = SIZE_MAX) const {
    Drawn d = Cloud::drawn();
    d.size = size.data() + first;
    d.alpha += first;
    for (std::size_t c = 0; c < 3; ++c) {
      d.position[c] += first;
      d.color[c] += first;
      d.up[c] = up[c].data() + first;
      d.velocity[c] = velocity[c].data() + first;
    }
    d.count = std::min(end, count) - first;
    return d;
  }
};

WideCloud wide_cloud(std::size_t count, std::uint64_t seed) {
  Dice dice(seed);
  WideCloud cloud(count);
  for (std::size_t i = 0; i < count; ++i) {
    const float place[] = {dice.between(-6, 6), dice.between(-4, 4), dice.between(-5, 11)};
    cloud.place(i, place[0], place[1], place[2]);
    cloud.size[i] = dice.between(0, i % 3 == 0 ? 0.05f : i % 3 == 1 ? 1.0f : 8.0f);
    const float speed = i % 5 == 0 ? 400 : 40;
    for (std::size_t c = 0; c < 3; ++c) {
      cloud.up[c][i] = dice.between(-1, 1);
      cloud.velocity[c][i] = dice.between(-speed, speed);
      cloud.color[c][i] = dice.between(0.1f, 1);
    }
    cloud.alpha[i] = dice.between(0.1f, 1);
  }
  return cloud;
}

// A record and the tiles that list it.
struct Found {
  WideRecord record{};
  std::set<int> tiles;
};

// Records by their content; each must be listed once per tile.
std::vector<Found> found_in(const RecordsView& view) {
  std::map<std::string, Found> found;
  for (const auto& batch : view.batches()) {
    for (int tile = 0; tile < view.grid().tiles(); ++tile) {
      const auto piece = view.piece(batch, tile);
      for (std::size_t i = 0; i < piece.count; ++i) {
        const std::byte* from = piece.records + i * view.record_bytes();
        Found& one = found[std::string(reinterpret_cast<const char*>(from), view.record_bytes())];
        one.record = wide_record(form(view.layout(), view.colored()), view.grid().far_bits(), from, view.color());
        CHECK(one.tiles.insert(tile).second);
      }
    }
  }
  std::vector<Found> list;
  for (const auto& [bytes, one] : found) list.push_back(one);
  return list;
}

std::vector<std::byte> wide_message(const Drawn& drawn, const Sprite& sprite, const View& view, double dt,
                                    const ProjectWideLanes& lanes = project_wide_lanes()) {
  Projection projection;
  projection.dt = dt;
  projection.any_depth = true;
  return projected(drawn, sprite, view, projection, project_lanes(), lanes);
}

std::vector<Found> project_one(const WideCloud& cloud, std::size_t i, const Sprite& sprite, const View& view,
                               double dt = 0) {
  WideCloud one(1);
  one.place(0, cloud.plane[0][i], cloud.plane[1][i], cloud.plane[2][i]);
  one.size[0] = cloud.size[i];
  one.alpha[0] = cloud.alpha[i];
  for (std::size_t c = 0; c < 3; ++c) {
    one.up[c][0] = cloud.up[c][i];
    one.velocity[c][0] = cloud.velocity[c][i];
    one.color[c][0] = cloud.color[c][i];
  }
  const auto bytes = wide_message(one.drawn(), sprite, view, dt);
  CHECK(!of_fixed_size(RecordsView(bytes).layout()));
  return found_in(RecordsView(bytes));
}

Vector place_of(const WideCloud& cloud, std::size_t i) {
  return {cloud.plane[0][i], cloud.plane[1][i], cloud.plane[2][i]};
}

struct Screen {
  double x, y, depth;  // px right of and below the centre; m
};
Screen seen_by(const Lens& l, const Vector& place) {
  const Vector offset = place - l.eye;
  const double z = dot(offset, l.forward);
  return {l.focal_px * dot(offset, l.right) / z, -l.focal_px * dot(offset, l.up) / z, z};
}

float depth_of(const WideRecord& r) {
  float depth;
  std::memcpy(&depth, &r.depth, sizeof depth);
  return depth;
}

const Sprite kInMetres{Sprite::Kind::disc, 0};

Sprite leaf() {
  Sprite sprite{ImageSprite{{1}}, 0};
  return sprite;
}

View slanted_view(int width, int height) {
  View view = small_view(width, height);
  view.camera = {{3, 4, 9}, {0.5, -1, 0}, {0.1, 1, 0}, 55, 0.1};
  return view;
}

std::vector<const ProjectWideLanes*> usable_wide_lanes() {
  return test::runnable<ProjectWideLanes>(MOTES_BUILDS(project_wide_lanes));
}

// Returns the tiles with a pixel whose centre is within `reach` px of the line from (x0, y0) to (x1, y1), px from the
// corner.
std::set<int> tiles_near(const View& view, double x0, double y0, double x1, double y1, double reach) {
  std::set<int> tiles;
  const double dx = x1 - x0, dy = y1 - y0, square = dx * dx + dy * dy;
  const auto pixels = [reach](double from, double to, int size) {  // the first and last pixel that may be near
    const auto [low, high] = std::minmax(from, to);
    return std::pair{static_cast<int>(std::clamp(low - reach - 1, 0.0, size - 1.0)),
                     static_cast<int>(std::clamp(high + reach + 1, 0.0, size - 1.0))};
  };
  const auto [left, right] = pixels(x0, x1, view.width);
  const auto [top, bottom] = pixels(y0, y1, view.height);
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const double px = x + 0.5 - x0, py = y + 0.5 - y0;
      const double along = square > 0 ? std::clamp((px * dx + py * dy) / square, 0.0, 1.0) : 0;
      if (std::hypot(px - along * dx, py - along * dy) < reach) {
        tiles.insert(y / 64 * ((view.width + 63) / 64) + x / 64);
      }
    }
  }
  return tiles;
}

bool within(const std::set<int>& some, const std::set<int>& all) {
  return std::includes(all.begin(), all.end(), some.begin(), some.end());
}

}  // namespace

TEST(image_sizes_in_metres_agree_with_double_precision) {
  const View view = slanted_view(640, 360);
  const Lens l = lens(view);
  const WideCloud cloud = wide_cloud(3000, 7);
  int seen = 0, narrow = 0, widest = 0;
  for (std::size_t i = 0; i < cloud.count; ++i) {
    const auto found = project_one(cloud, i, kInMetres, view);
    const Screen at = seen_by(l, place_of(cloud, i));
    const double diameter = cloud.size[i] * l.focal_px / at.depth;
    const double reach = std::min(diameter, double{kMostDiameter}) / 2;
    const bool inside = at.depth > 0.11 && std::fabs(at.x) < 319 + reach && std::fabs(at.y) < 179 + reach;
    if (found.empty()) {
      CHECK(!inside || diameter * diameter < 1e-4);
      continue;
    }
    ++seen;
    CHECK(found.size() == 1);
    const WideRecord& r = found[0].record;
    // To the nearest 1/16 px; of big sprites, 1/4 px.
    const double unit = diameter > 511.9 ? 33 : 9;
    CHECK_NEAR(r.x, std::floor(at.x * 256), unit + std::fabs(at.x) * 1e-3);
    CHECK_NEAR(r.y, std::floor(at.y * 256), unit + std::fabs(at.y) * 1e-3);
    CHECK_NEAR(depth_of(r), at.depth, 1e-5 * at.depth);
    CHECK_NEAR(size_units(r.size) / 64.0, std::clamp(diameter, 2.0, double{kMostDiameter}),
               diameter > 512 ? 0.15 : 0.02);
    const double part = std::min(diameter / 2, 1.0);
    CHECK_NEAR(r.light / 32768.0, part * part, 1e-4);
    CHECK(r.dx == 0 && r.dy == 0 && r.up_x == 0 && r.up_y == 0);
    narrow += diameter < 2;
    widest += diameter > 512;
  }
  CHECK(seen > 500 && narrow > 100 && widest > 3);
}

TEST(image_wide_records_stand_in_every_tile_they_touch) {
  const View view = small_view(333, 200);
  const WideCloud cloud = wide_cloud(400, 9);
  int several = 0;
  for (std::size_t i = 0; i < cloud.count; ++i) {
    const auto found = project_one(cloud, i, kInMetres, view);
    if (found.empty()) continue;
    const WideRecord& r = found[0].record;
    const double x = r.x / 256.0 + 166.5, y = r.y / 256.0 + 100, radius = size_units(r.size) / 128.0;
    CHECK(within(tiles_near(view, x, y, x, y, radius), found[0].tiles));
    // No tile lies beyond the circle around the bounding box.
    CHECK(within(found[0].tiles, tiles_near(view, x, y, x, y, (radius + 2) * 1.4143)));
    several += found[0].tiles.size() > 4;
  }
  CHECK(several > 20);
}

TEST(image_streaks_lead_from_where_particles_were) {
  View view = slanted_view(640, 360);
  view.shutter = 0.5f;
  view.before = view.camera;
  view.before->position = {3.3, 4.1, 9};
  view.before->look_at = {0.4, -1, 0.1};
  const double dt = 1.0 / 24;
  View opening = view;
  opening.camera.position = (view.camera.position + view.before->position) * 0.5;
  opening.camera.look_at = (view.camera.look_at + view.before->look_at) * 0.5;
  const Lens now = lens(view), then = lens(opening);
  const WideCloud cloud = wide_cloud(2000, 21);
  int whole = 0, clipped = 0, long_ones = 0;
  for (std::size_t i = 0; i < cloud.count; ++i) {
    const auto found = project_one(cloud, i, Sprite{Sprite::Kind::disc, 4}, view, dt);
    const Vector place = place_of(cloud, i);
    const Vector before =
        place - Vector{cloud.velocity[0][i], cloud.velocity[1][i], cloud.velocity[2][i]} * (view.shutter * dt);
    const Screen end = seen_by(now, place), start = seen_by(then, before);
    if (!(end.depth > 0.2 && start.depth > 0.2)) continue;
    const double far_out = std::max({std::fabs(end.x), std::fabs(start.x), std::fabs(end.y), std::fabs(start.y)});
    if (found.empty()) continue;
    const WideRecord& r = found[0].record;
    CHECK(r.size == 4 * 64);
    if (far_out < 400) {
      CHECK(r.light == 32768);
      // The middle to the nearest 1/16 px, the length to the nearest 1/8.
      CHECK_NEAR(r.dx, (end.x - start.x) * 256, 20);
      CHECK_NEAR(r.dy, (end.y - start.y) * 256, 20);
      CHECK_NEAR(r.x, (end.x + start.x) * 128, 12);
      CHECK_NEAR(r.y, (end.y + start.y) * 128, 12);
      ++whole;
    } else if (r.light < 32768) {
      // The visible part of a long streak has its share of the light.
      const double length = std::hypot(end.x - start.x, end.y - start.y);
      CHECK_NEAR(r.light / 32768.0, std::hypot(r.dx, r.dy) / 256 / length, 2e-3);
      ++clipped;
    }
    const double x = r.x / 256.0 + 320, y = r.y / 256.0 + 180, hx = r.dx / 512.0, hy = r.dy / 512.0;
    CHECK(within(tiles_near(view, x - hx, y - hy, x + hx, y + hy, 2), found[0].tiles));
    CHECK(within(found[0].tiles, tiles_near(view, x - hx, y - hy, x + hx, y + hy, 128)));
    long_ones += found[0].tiles.size() > 6;
  }
  CHECK(whole > 300 && clipped > 5 && long_ones > 3);
}

TEST(image_streaks_of_particles_that_came_from_behind_the_camera_begin_near_it) {
  View view = small_view(200, 150);
  view.shutter = 1;
  WideCloud cloud(1);
  cloud.place(0, 0.02f, 0, 9);
  cloud.velocity[2][0] = -24;  // 1 m in the frame: from the camera's position to 1 m in front of it
  const auto found = project_one(cloud, 0, {}, view, 1.0 / 24);
  CHECK(found.size() == 1);
  const Lens l = lens(view);
  const WideRecord& r = found[0].record;
  const double end = l.focal_px * 0.02 / 1, start = l.focal_px * 0.02 / 0.1;
  CHECK_NEAR(r.dx / 256.0, end - start, 0.1);
  CHECK_NEAR(r.x / 256.0, (end + start) / 2, 0.1);
  CHECK_NEAR(r.light / 32768.0, 0.9, 0.001);
}

TEST(image_without_motion_there_are_no_streaks) {
  View view = small_view(200, 150);
  view.shutter = 1;
  WideCloud cloud = wide_cloud(500, 4);
  for (auto& v : cloud.velocity) v.assign(v.size(), 0.0f);
  const auto found = found_in(RecordsView(wide_message(cloud.drawn(), {}, view, 1.0 / 24)));
  CHECK(found.size() > 100);
  for (const Found& one : found) CHECK(one.record.dx == 0 && one.record.dy == 0 && one.record.light == 32768);
  for (auto& v : cloud.velocity) v.assign(v.size(), kNan);  // its earlier position is unknown: no streak
  CHECK(wide_message(cloud.drawn(), {}, view, 1.0 / 24).size() > 64);
  for (const Found& one : found_in(RecordsView(wide_message(cloud.drawn(), {}, view, 1.0 / 24)))) {
    CHECK(one.record.dx == 0 && one.record.dy == 0);
  }
}

TEST(image_directions_agree_with_double_precision) {
  const View view = slanted_view(640, 360);
  const Lens l = lens(view);
  const WideCloud cloud = wide_cloud(1000, 13);
  int seen = 0;
  for (std::size_t i = 0; i < cloud.count; ++i) {
    const auto found = project_one(cloud, i, leaf(), view);
    if (found.empty()) continue;
    const Vector place = place_of(cloud, i), up{cloud.up[0][i], cloud.up[1][i], cloud.up[2][i]};
    const Screen here = seen_by(l, place), there = seen_by(l, place + up * 1e-5);
    const double x = there.x - here.x, y = there.y - here.y, length = std::hypot(x, y);
    const double expected = length * here.depth / (l.focal_px * 1e-5);  // how much of `up` is seen from the side
    if (expected < 0.05) continue;
    const WideRecord& r = found[0].record;
    CHECK_NEAR(r.up_x, x / length * 32767, 40);
    CHECK_NEAR(r.up_y, y / length * 32767, 40);
    ++seen;
  }
  CHECK(seen > 200);
  WideCloud odd(4);
  for (std::size_t i = 0; i < 4; ++i) odd.place(i, 0, 0, 0);
  odd.up[1] = {0, kNan, kInf, 1e-30f};
  odd.up[1].resize(20);
  for (std::size_t i = 0; i < 4; ++i) {
    const WideRecord r = project_one(odd, i, leaf(), small_view()).at(0).record;
    CHECK(r.up_x == 0 && r.up_y == (i < 3 ? 0 : -32767));
  }
}

TEST(image_wide_records_are_the_same_bytes_for_every_isa) {
  const WideCloud cloud = wide_cloud(20011, 3);
  View moving = slanted_view(640, 360);
  moving.shutter = 0.7f;
  moving.before = small_view().camera;
  moving.layers = kVelocityLayer;
  Sprite opaque = kInMetres, part;
  opaque.blend = Sprite::Blend::opaque;
  part.of_height = 0.05f;
  for (const View& view : {small_view(333, 65), moving}) {
    for (const Sprite& sprite : {kInMetres, leaf(), opaque, part}) {
      const auto reference = wide_message(cloud.drawn(), sprite, view, 0.04, *usable_wide_lanes().front());
      CHECK(RecordsView(reference).count() > 1000);
      for (const auto* lanes : usable_wide_lanes()) {
        CHECK(wide_message(cloud.drawn(), sprite, view, 0.04, *lanes) == reference);
      }
    }
  }
}

TEST(image_records_do_not_depend_on_which_rank_has_which_particles) {
  const WideCloud cloud = wide_cloud(5000, 17);
  View view = slanted_view(640, 360);
  view.layers = kVelocityLayer;
  Sprite ball{Sprite::Kind::sphere, 5};
  ball.blend = Sprite::Blend::opaque;
  Sprite leaves = leaf();
  leaves.blend = Sprite::Blend::opaque;
  const auto sorted = [&](const Sprite& sprite, const std::vector<std::size_t>& cuts) {
    std::vector<std::string> all;
    for (std::size_t i = 1; i < cuts.size(); ++i) {
      const auto bytes = wide_message(cloud.drawn(cuts[i - 1], cuts[i]), sprite, view, 0);
      const RecordsView seen(bytes);
      CHECK(seen.with_velocity() == (sprite.blend == Sprite::Blend::opaque));
      for (const auto& batch : seen.batches()) {
        for (int tile = 0; tile < seen.grid().tiles(); ++tile) {
          const auto piece = seen.piece(batch, tile);
          for (std::size_t r = 0; r < piece.count; ++r) {
            const char* from = reinterpret_cast<const char*>(piece.records + r * seen.record_bytes());
            all.push_back(std::to_string(tile) + " " + std::string(from, seen.record_bytes()));
          }
        }
      }
    }
    std::sort(all.begin(), all.end());
    return all;
  };
  for (const Sprite& sprite : {ball, leaves, kInMetres}) {
    const auto whole = sorted(sprite, {0, 5000});
    CHECK(whole.size() > 1000);
    CHECK(sorted(sprite, {0, 16, 1600, 1616, 4992, 5000}) == whole);
  }
}

TEST(image_sizes_that_are_no_sizes_are_not_drawn) {
  const float sizes[] = {0, -1, -0.0f, kNan, kInf, -kInf, -1e-30f};
  for (const auto* lanes : usable_wide_lanes()) {
    for (const float size : sizes) {
      WideCloud one(1);
      one.size[0] = size;
      CHECK(RecordsView(wide_message(one.drawn(), kInMetres, small_view(), 0, *lanes)).count() == 0);
    }
    WideCloud huge(1);
    huge.size[0] = std::numeric_limits<float>::max();
    const auto found = found_in(RecordsView(wide_message(huge.drawn(), kInMetres, small_view(), 0, *lanes)));
    CHECK(found.size() == 1 && size_units(found[0].record.size) == kMostDiameter << kSizeBits &&
          found[0].tiles.size() == 12);
  }
}

TEST(image_black_particles_are_sent_where_they_hide) {
  WideCloud cloud(1);
  for (auto& c : cloud.color) c[0] = 0;
  for (const int pixels : {0, 5}) {
    Sprite smoke{Sprite::Kind::disc, pixels};
    CHECK(RecordsView(wide_message(cloud.drawn(), smoke, small_view(), 0)).count() == 0);
    smoke.blend = Sprite::Blend::alpha;
    CHECK(RecordsView(wide_message(cloud.drawn(), smoke, small_view(), 0)).count() > 0);
    cloud.alpha[0] = 0;
    CHECK(RecordsView(wide_message(cloud.drawn(), smoke, small_view(), 0)).count() == 0);
    cloud.alpha[0] = 1;
  }
}

TEST(image_nonsense_in_any_column_gives_records_within_their_limits) {
  Dice dice(99);
  const float odd[] = {0, -0.0f, kNan, kInf, -kInf, 3e38f, -3e38f, 1e-38f, -1e-45f, 1e20f, -1e20f, 1e8f, 0.1f, 10};
  const auto draw = [&] { return dice.below(3) == 0 ? odd[dice.below(std::size(odd))] : dice.between(-12, 12); };
  std::size_t count = 0;
  for (int round = 0; round < 60; ++round) {
    WideCloud cloud(500);
    for (std::size_t i = 0; i < cloud.count; ++i) {
      for (auto* three : {&cloud.plane, &cloud.up, &cloud.velocity, &cloud.color}) {
        for (auto& column : *three) column[i] = draw();
      }
      cloud.size[i] = draw();
      cloud.alpha[i] = draw();
    }
    View view = slanted_view(round % 2 == 0 ? 333 : 16384, 200);
    view.shutter = static_cast<float>(round % 3) * 0.5f;
    view.layers = kVelocityLayer;
    if (round % 5 == 0) view.before = small_view().camera;
    Sprite sprite = round % 4 == 0 ? leaf() : kInMetres;
    sprite.blend = static_cast<Sprite::Blend>(round % 3);
    const auto bytes = wide_message(cloud.drawn(), sprite, view, 1e3, *usable_wide_lanes().front());
    for (const auto* lanes : usable_wide_lanes()) {
      CHECK(wide_message(cloud.drawn(), sprite, view, 1e3, *lanes) == bytes);
    }
    for (const Found& one : found_in(RecordsView(bytes))) {
      const WideRecord& r = one.record;
      CHECK(std::abs(r.x) < 1 << 22 && std::abs(r.y) < 1 << 22 && std::abs(r.dx) < 1 << 23 && std::abs(r.dy) < 1 << 23);
      CHECK(r.size >= 128 && size_units(r.size) <= kMostDiameter << kSizeBits && r.light >= 1 && r.light <= 32768);
      CHECK(std::isfinite(depth_of(r)) && depth_of(r) >= 0.1f);
      CHECK(r.up_x >= -32767 && r.up_y >= -32767);
      ++count;
    }
  }
  CHECK(count > 1000);
}

}  // namespace motes::test_image_wide
