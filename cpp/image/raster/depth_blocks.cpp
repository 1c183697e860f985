#include "image/raster/depth_blocks.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace motes::image {
namespace {

constexpr int kBlock = 1 << DepthBlocks::kBits;
constexpr std::uint32_t kFarAway = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::infinity());

}  // namespace

const float* DepthBlocks::met(const TilePlanes& tile, const Area& area, int size, const SurfaceBlock* blocks) {
  const int reach = (size + kBlock - 2) >> kBits;
  if (!measured_) measure(tile, area, blocks);
  if (reach_ != reach) widen(reach);
  return met_[0][0];
}

void DepthBlocks::clear() {
  // The empty range: joined with another, it gives the other.
  constexpr Range kOfNone{std::numeric_limits<float>::infinity(), 0};
  std::fill_n(own_[0], (kSide + kReach) * (kSide + kReach), kOfNone);
  measured_ = true;
  reach_ = -1;
}

void DepthBlocks::measure(const TilePlanes& tile, const Area& area, const SurfaceBlock* blocks) {
  clear();
  for (int first = 0; first < area.height; first += kBlock) {
    // Only the columns of the area count.
    std::uint32_t nearest[kTile], farthest[kTile];
    std::fill_n(nearest, kTile, kFarAway);
    std::fill_n(farthest, kTile, 0u);
    const int end = std::min(first + kBlock, area.height);
    for (int y = first; y < end; ++y) {
      const std::uint32_t* depth = tile.depth + y * kPixelStride;
      for (int x = 0; x < kTile; ++x) {
        nearest[x] = std::min(nearest[x], depth[x]);
        farthest[x] = std::max(farthest[x], depth[x]);
      }
    }
    Range* own = own_[(first + kBefore) / kBlock] + kBefore / kBlock;
    for (int x = 0; x < area.width; ++x) {
      Range& range = own[x / kBlock];
      range.nearest = std::min(range.nearest, std::bit_cast<float>(nearest[x]));
      range.farthest = std::max(range.farthest, std::bit_cast<float>(farthest[x]));
    }
    if (blocks == nullptr) continue;
    for (int i = 0; i * kBlock < area.width; ++i) own[i].nearest = std::min(own[i].nearest, blocks[i].low);
    blocks += kTile / kBlock;
  }
}

void DepthBlocks::measure_surfaces(const TilePlanes& tile, const Area& area, const SplatLanes& lanes) {
  clear();
  constexpr int kBlocks = kTile / kBlock, kFirst = kBefore / kBlock;
  std::uint32_t farthest[kBlocks][kBlocks];
  lanes.measure_surfaces(tile, area.height, area.width, farthest[0]);
  for (int row = 0; row < kBlocks; ++row) {
    for (int column = 0; column < kBlocks; ++column) {
      own_[kFirst + row][kFirst + column] = {0, std::bit_cast<float>(farthest[row][column])};
    }
  }
}

void DepthBlocks::widen(int reach) {
  reach_ = reach;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      Range range = own_[row][column];
      for (int down = 0; down <= reach; ++down) {
        for (int right = 0; right <= reach; ++right) {
          const Range& other = own_[row + down][column + right];
          range.nearest = std::min(range.nearest, other.nearest);
          range.farthest = std::max(range.farthest, other.farthest);
        }
      }
      met_[row][column][0] = range.nearest;
      met_[row][column][1] = range.farthest;
    }
  }
}

}  // namespace motes::image
