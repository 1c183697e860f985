// The layers that a tile painter computes besides light.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "image/raster/tile_painter.h"

namespace motes::image {
namespace {

using Velocity = std::array<float, 3>;

// Orders velocities; also distinguishes zeros of different signs.
bool before(const Velocity& a, const Velocity& b) {
  using Bits = std::array<std::uint32_t, 3>;
  return std::bit_cast<Bits>(a) < std::bit_cast<Bits>(b);
}

// Writes a velocity where `alone`, a row drawn from a single record, has the nearest surface; then clears that row. Of
// records that look the same, the first velocity as ordered by before() is kept, so the records' order does not matter.
void take_fronts(NearestSurface* alone, const NearestSurface* nearest, int width, const Velocity& velocity,
                 std::uint8_t* found, float* velocities) {
  for (int x = 0; x < width; ++x) {
    if (alone[x] == no_surface(Scenery::kNothing)) continue;
    Velocity other;
    std::copy_n(velocities + 3 * x, 3, other.begin());
    if (alone[x] == nearest[x] && (found[x] == 0 || before(velocity, other))) {
      std::copy_n(velocity.begin(), 3, velocities + 3 * x);
      found[x] = 1;
    }
    alone[x] = no_surface(Scenery::kNothing);
  }
}

}  // namespace

// Draws black particles over light of 1: what remains is the part that they let through.
void TilePainter::show_passed(std::span<const Piece> pieces) {
  std::vector<std::vector<std::byte>> black;
  std::vector<Piece> hiding;
  for (const Piece& piece : pieces) {
    if (!piece.brush->blends(Sprite::Blend::alpha)) continue;
    const std::size_t bytes = piece.brush->record_bytes();
    black.emplace_back(piece.records, piece.records + piece.count * bytes);
    for (auto i = static_cast<std::size_t>(piece.brush->form().color); i < black.back().size(); i += bytes) {
      std::fill_n(black.back().begin() + static_cast<std::ptrdiff_t>(i), 3, std::byte{0});
    }
    hiding.push_back({piece.brush, black.back().data(), piece.count});
  }
  for (int y = 0; y < area_.height; ++y) std::fill_n(planes_.light + y * kLightStride, 3 * area_.width, kUnit);
  ordered_.sort(hiding);  // rounding depends on the order
  for (const Piece& run : ordered_.runs()) blend(run);
}

void TilePainter::front(std::span<const Piece> pieces, const float* depths, std::size_t row_floats, bool passed) {
  for (int y = 0; y < area_.height; ++y, depths += row_floats) {
    std::uint32_t* depth = planes_.depth + y * kPixelStride;
    for (int x = 0; x < area_.width; ++x) {
      const std::uint32_t before = planes_.hides ? depth[x] : Scenery::kNothing;
      depth[x] = std::min(before, std::bit_cast<std::uint32_t>(depths[x]));
    }
  }
  measure_depth();
  begin_blending();
  if (passed) return show_passed(pieces);
  for (int y = 0; y < area_.height; ++y) std::fill_n(planes_.light + y * kLightStride, 3 * area_.width, 0u);
  paint_blended(pieces);
}

void TilePainter::alpha(std::span<const Piece> pieces, float* alphas, std::size_t row_floats) {
  show_passed(pieces);
  const Scenery& scenery = scene_->scenery();
  const bool holds_out = scenery.view().bare && scenery.occupied(area_.tile);  // solids are not in the picture
  for (int y = 0; y < area_.height; ++y, alphas += row_floats) {
    const std::uint32_t* solid = holds_out ? scenery.depth(area_.x, area_.y + y) : nullptr;
    const std::uint32_t* light = planes_.light + y * kLightStride;
    const std::uint32_t* depth = planes_.depth + y * kPixelStride;
    for (int x = 0; x < area_.width; ++x) {
      const bool hides = planes_.hides && depth[x] != Scenery::kNothing;
      const bool surface = hides && (solid == nullptr || depth[x] != solid[x]);
      alphas[x] = surface ? 1 : 1 - static_cast<float>(light[3 * x] / double{kUnit});
    }
  }
}

void TilePainter::velocity(std::span<const Piece> pieces, float* velocities, std::size_t row_floats) {
  for (int y = 0; y < area_.height; ++y)
    std::fill_n(velocities + static_cast<std::size_t>(y) * row_floats, 3 * area_.width, 0.0f);
  if (!surfaces_) return;
  // Draw each record by itself: where it gives the nearest surface of all, it is in front.
  BufferOf<NearestSurface> alone;
  alone.resize(kPixelNumbers);
  std::fill_n(alone.data(), kPixelNumbers, no_surface(Scenery::kNothing));
  TilePlanes tile = planes_;
  tile.surfaces = alone.data() + kFirstPixel;
  tile.blocks = nullptr;  // these are bounds for all records
  std::vector<std::uint8_t> found(static_cast<std::size_t>(kTile) * kTile, 0);
  for (const Piece& piece : pieces) {
    if (!piece.brush->blends(Sprite::Blend::opaque)) continue;
    const std::size_t bytes = piece.brush->record_bytes();
    Piece one = piece;
    one.count = 1;
    for (; one.records != piece.records + piece.count * bytes; one.records += bytes) {
      draw_opaque(one, tile);
      Velocity velocity;
      std::memcpy(velocity.data(), one.records + bytes - kVelocityBytes, kVelocityBytes);
      for (int y = 0; y < area_.height; ++y) {
        float* to = velocities + static_cast<std::size_t>(y) * row_floats;
        take_fronts(tile.surfaces + y * kPixelStride, planes_.surfaces + y * kPixelStride, area_.width, velocity,
                    found.data() + y * kTile, to);
      }
    }
  }
}

}  // namespace motes::image
