#include <algorithm>
#include <bit>
#include <limits>
#include <random>

#include "image/raster/brush.h"
#include "image/raster/depth_blocks.h"
#include "image/test_image_scene.h"
#include "support/check.h"

namespace motes::test_image_depth_blocks {
using namespace image_test;

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Slopes with infinitely deep holes: blocks that are near, far, and both.
class Depths {
 public:
  explicit Depths(unsigned seed) : bits_(kPixelNumbers, 0) {
    std::mt19937 draw(seed);
    const float slope = static_cast<float>(draw() % 100) / 300;
    const auto hole = static_cast<int>(draw() % 64);
    for (int y = 0; y < kTile; ++y) {
      for (int x = 0; x < kTile; ++x) {
        const bool far = (x - hole) * (x - hole) + (y - 30) * (y - 30) < 300;
        const float depth = 5 + slope * static_cast<float>(x) + static_cast<float>(draw() % 64) / 640;
        bits_[index(x, y)] = std::bit_cast<std::uint32_t>(far ? kInfinity : depth);
      }
    }
  }
  std::uint32_t* first() { return bits_.data() + kFirstPixel; }
  float at(int x, int y) const { return std::bit_cast<float>(bits_[index(x, y)]); }

 private:
  static std::size_t index(int x, int y) { return static_cast<std::size_t>(kFirstPixel + y * kPixelStride + x); }

  std::vector<std::uint32_t> bits_;
};

struct Range {
  float nearest = kInfinity, farthest = 0;
};

// Returns the depths of the area's pixels in columns left .. right - 1 and rows top .. bottom - 1.
Range range_of(const Depths& depths, const Area& area, int left, int right, int top, int bottom) {
  Range range;
  for (int y = std::max(top, 0); y < std::min(bottom, area.height); ++y) {
    for (int x = std::max(left, 0); x < std::min(right, area.width); ++x) {
      range.nearest = std::min(range.nearest, depths.at(x, y));
      range.farthest = std::max(range.farthest, depths.at(x, y));
    }
  }
  return range;
}

TilePlanes planes_of(std::vector<std::uint32_t>& light, Depths& depths) {
  TilePlanes planes{};
  planes.light = light.data() + kFirstLight;
  planes.depth = depths.first();
  planes.hides = true;
  return planes;
}

}  // namespace

TEST(image_blocks_of_depths_have_the_range_of_what_footprints_meet) {
  DepthBlocks blocks;
  for (unsigned seed = 0; seed < 6; ++seed) {
    Depths depths(seed);
    std::vector<std::uint32_t> light;
    const TilePlanes tile = planes_of(light, depths);
    const Area area{0, 0, 0, seed % 2 == 0 ? kTile : 37, seed % 3 == 0 ? kTile : 22};
    blocks.forget();
    for (const int size : {2, 5, 9, 10, 15, 1}) {
      const float* met = blocks.met(tile, area, size);
      bool within = true;
      for (int row = 1 - size; row < kTile; ++row) {
        for (int column = 1 - size; column < kTile; ++column) {
          const float* here = met + 2 * DepthBlocks::at(column, row);
          const Range footprint = range_of(depths, area, column, column + size, row, row + size);
          within &= here[0] <= footprint.nearest && here[1] >= footprint.farthest;
        }
      }
      CHECK(within);
      // The range covers no more than what footprints reach that begin in the same block.
      bool least = true;
      const int reach = 8 * (1 + (size + 6) / 8);
      for (int row = 0; row < kTile; row += 8) {
        for (int column = 0; column < kTile; column += 8) {
          const Range most = range_of(depths, area, column, column + reach, row, row + reach);
          const float* here = met + 2 * DepthBlocks::at(column, row);
          least &= here[0] == most.nearest && here[1] == most.farthest;
        }
      }
      CHECK(least);
    }
  }
}

TEST(image_depths_that_changed_are_measured_again) {
  Depths depths(1);
  std::vector<std::uint32_t> light;
  const TilePlanes tile = planes_of(light, depths);
  const Area area{0, 0, 0, kTile, kTile};
  DepthBlocks blocks;
  CHECK(blocks.met(tile, area, 5)[2 * DepthBlocks::at(8, 8)] >= 5);
  depths.first()[9 * kPixelStride + 9] = std::bit_cast<std::uint32_t>(2.0f);
  CHECK(blocks.met(tile, area, 5)[2 * DepthBlocks::at(8, 8)] >= 5);
  blocks.forget();
  CHECK(blocks.met(tile, area, 5)[2 * DepthBlocks::at(8, 8)] == 2);
}

// Records that are drawn whole or skipped because of the blocks give the same light as a test of each pixel.
TEST(image_light_among_solids_is_that_of_a_test_of_each_pixel) {
  const View view = [] {
    View seen = small_view(kTile, kTile);
    Solid ball;  // its presence gives records depths
    ball.shape.kind = shapes::Kind::sphere;
    ball.shape.number[3] = 1;
    seen.objects.push_back(ball);
    return seen;
  }();
  const Cloud cloud = random_cloud(4000, 7);
  const Area area{0, 0, 0, kTile, kTile};
  std::vector<float> any(2 * DepthBlocks::kSide * DepthBlocks::kSide);  // nothing is known
  for (std::size_t i = 1; i < any.size(); i += 2) any[i] = kInfinity;
  for (unsigned seed = 0; seed < 3; ++seed) {
    Depths depths(seed);
    for (const float softness : {0.0f, 0.8f}) {
      for (const int pixels : {1, 5, 12}) {
        Sprite sprite{Sprite::Kind::disc, pixels};
        sprite.softness = softness;
        const auto records = message(cloud, sprite, view);
        const RecordsView seen(records);
        const Brush brush(sprite, seen.layout(), view);
        const Splat splat = brush.splat_at(0, 0);
        const RecordsView::RecordRun piece = seen.piece(seen.batches()[0], 0);
        const auto light_by = [&](const SplatLanes& lanes, bool by_pixel) {
          std::vector<std::uint32_t> light(kLightNumbers);
          TilePlanes planes = planes_of(light, depths);
          DepthBlocks blocks;
          planes.blocks = by_pixel ? any.data() : blocks.met(planes, area, splat.size);
          planes.farthest = std::bit_cast<std::uint32_t>(kInfinity);
          lanes.add(planes, splat, reinterpret_cast<const unsigned char*>(piece.records), piece.count);
          std::vector<std::uint32_t> shown;
          for (int y = 0; y < kTile; ++y) {
            shown.insert(shown.end(), planes.light + y * kLightStride, planes.light + y * kLightStride + 3 * kTile);
          }
          return shown;
        };
        const auto expected = light_by(splat_lanes(), true);
        CHECK(*std::max_element(expected.begin(), expected.end()) > 0);
        for (const auto* lanes : usable_splat_lanes()) CHECK(light_by(*lanes, false) == expected);
      }
    }
  }
}

}  // namespace motes::test_image_depth_blocks
