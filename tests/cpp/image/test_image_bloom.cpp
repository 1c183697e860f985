// Bloom: light spreads without changing in total, alike at any resolution and in every build.
#include <cmath>
#include <cstdint>
#include <deque>
#include <stdexcept>
#include <vector>

#include "base/sha256.h"
#include "image/post/bloom.h"
#include "image/post/bloom_tiles.h"
#include "image/raster/splat_lanes.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_image_bloom {
using image::Area;
using image::Bloom;
using image::BloomLanes;
using image::BloomPlan;
using image::BloomTiles;
using image::CellArea;
using image::Grid;
using image::kUnit;

namespace {

// The part of the glow that a message holds.
struct GlowAround {
  std::vector<std::uint64_t> memory;
  image::BloomCells cells;
};
GlowAround glow_around(const Bloom& bloom, const CellArea& area) {
  GlowAround part;
  for (int y = area.y; y < area.y + area.height; ++y) {
    const std::uint64_t* row = bloom.cells().row(y) + 3 * area.x;
    part.memory.insert(part.memory.end(), row, row + area.row_lanes());
  }
  part.cells = {area, part.memory.data(), area.row_lanes()};
  return part;
}

struct Picture {
  int width, height;
  std::vector<std::uint32_t> light;

  Picture(int w, int h, std::uint32_t all = 0) : width(w), height(h), light(static_cast<std::size_t>(3 * w * h), all) {}
  std::uint32_t& at(int x, int y, int c) { return light[static_cast<std::size_t>(3 * (y * width + x) + c)]; }
  double sum(int c) const {
    double total = 0;
    for (std::size_t i = static_cast<std::size_t>(c); i < light.size(); i += 3) total += light[i];
    return total;
  }
  // Applies bloom as ranks do that draw some tiles each, in `threads` threads.
  void bloom(float part, const BloomLanes& lanes = image::bloom_lanes(), int ranks = 1, int threads = 1) {
    const Grid grid{width, height};
    image::View view;
    view.width = width;
    view.height = height;
    view.bloom = part;
    const auto row = static_cast<std::size_t>(3 * width);
    const auto at = [&](const Area& area) {
      return light.data() + static_cast<std::size_t>(area.y) * row + 3 * area.x;
    };
    std::vector<std::vector<Area>> tiles(static_cast<std::size_t>(ranks));
    for (int tile = 0; tile < grid.tiles(); ++tile) {
      tiles[static_cast<std::size_t>(tile % ranks)].push_back(grid.area(tile));
    }
    std::deque<BloomTiles> owners;
    threads::Pool pool(threads);
    for (std::size_t r = 0; r < tiles.size(); ++r) {
      owners.emplace_back(lanes).begin(view, tiles[r], threads);
      pool.run(tiles[r].size(), [&](std::size_t i, std::size_t worker) {
        const Area& area = tiles[r][i];
        owners[r].keep(i, {at(area), row, area.width, area.height}, worker);
      });
    }
    Bloom all(lanes);
    all.begin(owners[0].plan());
    for (const BloomTiles& owner : owners) {
      for (std::size_t i = 0; i < owner.tiles(); ++i) all.add(owner.cells(i), std::as_bytes(owner.averages(i)));
    }
    all.spread(pool);
    for (std::size_t r = 0; r < owners.size(); ++r) {
      pool.run(tiles[r].size(), [&](std::size_t i, std::size_t worker) {
        owners[r].mix(i, glow_around(all, owners[r].cells(i)).cells, worker).copy_to(at(tiles[r][i]), row);
      });
    }
  }
  void square(int x, int y, int side, std::uint32_t value) {
    for (int row = y; row < y + side; ++row) {
      for (int column = x; column < x + side; ++column) {
        for (int c = 0; c < 3; ++c) at(column, row, c) = value;
      }
    }
  }
};

Picture noise(int width, int height, std::uint64_t seed) {
  Picture picture(width, height);
  test::Dice dice(seed);
  for (auto& one : picture.light) {
    const std::uint64_t word = dice.word();
    one = static_cast<std::uint32_t>(word) >> (word >> 59);  // from dark to saturated
  }
  return picture;
}

std::vector<const BloomLanes*> usable_bloom_lanes() { return test::runnable<BloomLanes>(MOTES_BUILDS(bloom_lanes)); }

}  // namespace

TEST(bloom_keeps_all_light) {
  for (const int height : {45, 180, 400, 1080}) {
    Picture picture(height * 16 / 9, height);
    picture.square(picture.width / 3, height / 2, 5, 8 * kUnit);
    picture.at(picture.width / 2, height / 4, 1) = 4000u * kUnit;
    const Picture before = picture;
    picture.bloom(0.3f);
    for (int c = 0; c < 3; ++c) CHECK_NEAR(picture.sum(c) / before.sum(c), 1, 4e-3);
    CHECK_NEAR(picture.at(picture.width / 3 + 2, height / 2 + 2, 0), 0.7 * 8 * kUnit, 0.3 * 8 * kUnit);
    CHECK(picture.at(picture.width / 3 - 1 - height / 60, height / 2, 0) > 0);
  }
}

TEST(bloom_keeps_light_near_the_edges) {
  for (const int x : {0, 5, 310, 319}) {
    for (const int y : {0, 7, 178, 179}) {
      Picture picture(320, 180);
      picture.at(x, y, 2) = 1000 * kUnit;
      picture.bloom(1);
      CHECK_NEAR(picture.sum(2) / kUnit, 1000, 25);
    }
  }
}

TEST(bloom_leaves_an_even_picture_as_it_is) {
  for (const std::uint32_t value : {1u, 1000u, kUnit, 0xffffffffu}) {
    for (const float part : {0.1f, 1.0f}) {
      Picture picture(203, 117, value);
      picture.bloom(part);
      bool same = true;
      for (const std::uint32_t one : picture.light) same &= one <= value && value - one <= 1;
      CHECK(same);
    }
  }
}

TEST(bloom_of_nothing_changes_nothing) {
  Picture picture = noise(71, 53, 1);
  const auto before = picture.light;
  picture.bloom(0);
  CHECK(picture.light == before);
}

TEST(bloom_is_the_same_in_all_builds) {
  for (const int height : {1, 2, 17, 63, 130, 257, 510, 1080}) {
    for (const int width : {1, 3, 64, 97}) {
      Picture first = noise(width, height, 7);
      first.bloom(0.37f, *usable_bloom_lanes()[0]);
      for (const BloomLanes* lanes : usable_bloom_lanes()) {
        Picture picture = noise(width, height, 7);
        picture.bloom(0.37f, *lanes);
        CHECK(picture.light == first.light);
      }
    }
  }
}

TEST(bloom_does_not_depend_on_who_owns_which_tile) {
  for (const int height : {50, 129, 500, 1080}) {
    Picture one = noise(200, height, 9);
    one.bloom(0.4f);
    for (const int ranks : {2, 3, 7}) {
      Picture picture = noise(200, height, 9);
      picture.bloom(0.4f, image::bloom_lanes(), ranks, ranks == 3 ? 2 : 1);
      CHECK(picture.light == one.light);
    }
  }
}

// A golden digest: all compilers, optimisation levels and machines must agree on it.
TEST(bloom_is_the_same_everywhere) {
  Picture picture = noise(201, 333, 3);
  picture.bloom(0.25f);
  const auto* bytes = reinterpret_cast<const std::byte*>(picture.light.data());
  base::Sha256 hash;
  hash.add(std::span<const std::byte>(bytes, picture.light.size() * 4));
  const std::string digest = hash.finish();
  CHECK(digest == "99c4202e12c1e723036abc8d23e17f295be9a9bb2d42872c807c17cdb211307b");
}

// The glow along a line through the middle of a square that is a tenth as wide as the picture is high.
TEST(bloom_looks_the_same_at_any_resolution) {
  std::vector<std::vector<double>> profiles;
  for (const int height : {180, 360, 720, 1440}) {
    Picture picture(height, height);
    picture.square(height * 9 / 20, height * 9 / 20, height / 10, kUnit);
    picture.bloom(1);
    std::vector<double> profile;
    const int pixels = height / 90;  // compared as if scaled down to 90 rows
    for (int x = 0; x < 90; ++x) {
      double sum = 0;
      for (int i = 0; i < pixels; ++i) {
        for (int j = 0; j < pixels; ++j) sum += picture.at(x * pixels + i, height / 2 + j, 0);
      }
      profile.push_back(sum / (pixels * pixels) / kUnit);
    }
    profiles.push_back(profile);
  }
  for (const auto& profile : profiles) {
    for (std::size_t x = 0; x < profile.size(); ++x) CHECK_NEAR(profile[x], profiles.back()[x], 0.03);
  }
}

// The variance is that of the three curves, without a shift, wherever the light is between the cells.
TEST(bloom_spreads_as_far_as_it_says) {
  const double wanted = 0.5 * 0.004 * 0.004 + 0.3 * 0.016 * 0.016 + 0.2 * 0.064 * 0.064;
  for (const int height : {200, 250, 333, 480, 700}) {
    for (int step = 0; step < 5; ++step) {
      Picture picture(height, height);
      const int middle = height / 2 + step * height / 80;
      picture.at(middle, middle, 0) = 4000u * kUnit;
      picture.bloom(1);
      const double all = picture.sum(0);
      double variance = 0, mean = 0;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < height; ++x) {
          const double light = picture.at(x, y, 0) / all;
          mean += (x - middle) * light;
          variance += (x - middle) * (x - middle) * light;
        }
      }
      CHECK_NEAR(std::sqrt(variance / wanted) / height, 1, 0.06);
      CHECK_NEAR(mean / height, 0, 0.001);
    }
  }
}

TEST(bloom_refuses_what_is_no_picture) {
  BloomPlan plan;
  CHECK_THROWS(plan.make(0, 0, 0.1f), std::invalid_argument);
  CHECK_THROWS(plan.make(3, -1, 0.1f), std::invalid_argument);
  CHECK_THROWS(plan.make(3, 3, -0.1f), std::invalid_argument);
  CHECK_THROWS(plan.make(3, 3, 1.1f), std::invalid_argument);
  CHECK_THROWS(plan.make(3, 3, std::nanf("")), std::invalid_argument);
  plan.make(3, 2, 0.1f);
  Bloom bloom;
  bloom.begin(plan);
  const std::vector<std::uint64_t> averages(18);
  const auto bytes = std::as_bytes(std::span(averages));
  bloom.add({0, 0, 3, 2}, bytes);
  CHECK_THROWS(bloom.add({0, 0, 3, 2}, bytes.first(8)), std::invalid_argument);
  CHECK_THROWS(bloom.add({0, 1, 3, 2}, bytes), std::invalid_argument);
  CHECK_THROWS(bloom.add({1, 0, 3, 2}, bytes), std::invalid_argument);
  CHECK_THROWS(bloom.add({-1, 0, 3, 2}, bytes), std::invalid_argument);
}

}  // namespace motes::test_image_bloom
