#include "image/raster/behind.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace motes::image {
namespace {

// Within a tile, planes are nowhere nearer than this fraction of the depth at their nearest pixel.
constexpr float kNearer = 0.9f;
// A solid hides particles from a relative depth of 1/4096 + 3 slope, at most 1/50, behind its surface on (see
// CastLanes::measure). Below 1/50, this yields the slope. Here the slopes along x and y are added, which is at most
// 1.42 times as much.
constexpr float kPerBias = 1.42f / 3;
// Greatest radius, px, of records with sizes for which bands are measured; larger ones are rare.
constexpr float kOftenRadius = 8;
constexpr int kBlock = 1 << kBlockBits;
constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNone = std::numeric_limits<float>::max();  // Scenery::surface_depth() where there is no surface
// Greatest number of lanes of a vector.
constexpr std::size_t kVectorRoom = 16;

}  // namespace

void Behind::start(const Scenery& scenery, const Area& area, const SplatLanes& lanes) {
  scenery_ = scenery.occupied(area.tile) ? &scenery : nullptr;
  area_ = area;
  lanes_ = &lanes;
  if (scenery_ == nullptr) return;
  const Scenery::Eye& eye = scenery.eye();
  settling_.last_column = area.width - 1;
  settling_.last_row = area.height - 1;
  settling_.blocks = blocks_[0];
  settling_.often_radius = kOftenRadius;
  settling_.low = kNearer * std::bit_cast<float>(scenery.nearest(area.tile));
  settling_.hides = scenery.depth(area.x, area.y);
  settling_.steep = scenery.blocks(area.tile).steep[0];
  settling_.surfaces = scenery.surface_depth(area.x, area.y);
  settling_.plane = scenery.surface_plane(area.tile);
  std::copy_n(eye.right.data(), 3, settling_.right);
  std::copy_n(eye.up.data(), 3, settling_.up);
  std::copy_n(eye.forward.data(), 3, settling_.forward);
  settling_.pixel = eye.pixel;
  settling_.left = static_cast<float>(area.x) + 0.5f - 0.5f * static_cast<float>(scenery.grid().width);
  settling_.top = static_cast<float>(area.y) + 0.5f - 0.5f * static_cast<float>(scenery.grid().height);
  measure_blocks();
}

Piece Behind::settled(const Piece& piece) {
  const RecordForm form = piece.brush->form();
  if (scenery_ == nullptr || form.depth == 0) return piece;
  const std::size_t bytes = piece.brush->record_bytes();
  numbers_.resize(piece.count + kVectorRoom);
  depths_.resize(piece.count + kVectorRoom);
  const std::size_t deeper =
      lanes_->settle(*settling(*piece.brush), reinterpret_cast<const unsigned char*>(piece.records), piece.count,
                     numbers_.data(), depths_.data());
  if (deeper == 0) return piece;
  records_.resize(piece.count * bytes);
  std::memcpy(records_.data(), piece.records, piece.count * bytes);
  for (std::size_t k = 0; k < deeper; ++k) {
    std::memcpy(records_.data() + numbers_.data()[k] * bytes + form.depth, depths_.data() + k, sizeof(std::uint32_t));
  }
  Piece changed = piece;
  changed.records = records_.data();
  return changed;
}

const Settling* Behind::settling(const Brush& brush) {
  if (scenery_ == nullptr) return nullptr;
  const Grid& grid = scenery_->grid();
  const bool fixed = of_fixed_size(brush.layout());
  const int bits = fixed ? grid.sub_bits() : is_wide(brush.layout()) ? kWideBits : grid.far_bits();
  const auto first = [&](int pixels, int from) { return (pixels << bits) - (from << (bits + 1)) + (fixed ? 1 : 0); };
  settling_.layout = brush.layout();
  settling_.form = brush.form();
  settling_.record_bytes = static_cast<int>(brush.record_bytes());
  settling_.shift = bits + 1;
  settling_.first_column = first(grid.width, area_.x);
  settling_.first_row = first(grid.height, area_.y);
  settling_.radius = 0.5f * static_cast<float>(brush.footprint_pixels());
  settling_.blur = 1.0f / static_cast<float>(1 << bits);
  settling_.flat = !brush.sprite().is(Sprite::Kind::sphere) && !is_posed(brush.sprite());
  return &settling_;
}

// Computes bounds on the depths that settle() changes, for centres nearest to a pixel of a block. They are at most
// half a pixel from its middle along x and y or, at the tile's border, a footprint's reach, which ends in the next
// block.
void Behind::measure_blocks() {
  const Scenery::Blocks& blocks = scenery_->blocks(area_.tile);
  const int last_row = (area_.height - 1) / kBlock, last_column = (area_.width - 1) / kBlock;
  settling_.high = *std::max_element(blocks.hides[0], blocks.hides[0] + kBlocks * kBlocks);
  for (int row = 0; row < kBlocks; ++row) {
    for (int column = 0; column < kBlocks; ++column) {
      const bool border = row == 0 || column == 0 || row == last_row || column == last_column;
      const float surface = blocks.nearest[row][column], bias = blocks.bias[row][column] / surface;
      const float away = border ? 2 * (kOftenRadius + 1) : 1;
      const float least = bias < Scenery::kSteepBias ? 0.9999f * surface / (1 + bias * kPerBias * away) : settling_.low;
      SurfaceBlock& block = blocks_[row][column];
      block = {surface == kNone ? kInfinite : least, 0, bias * surface, std::min(bias, Scenery::kSteepBias) * kPerBias};
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, last_row); ++y) {
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, last_column); ++x) {
          block.high = std::max(block.high, blocks.hides[y][x]);
        }
      }
    }
  }
}

}  // namespace motes::image
