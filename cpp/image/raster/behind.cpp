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

// Relative uncertainty of depths, from single precision and the picture's grid.
constexpr float kLeastMargin = 1.0f / 4096;
// Within a tile, planes are nowhere nearer than this fraction of the depth at their nearest pixel.
constexpr float kNearer = 0.9f;
// A solid hides particles from a relative depth of 1/4096 + 3 slope, at most 1/50, behind its surface on (see
// CastLanes::measure). Below 1/50, this yields the slope. Here the slopes along x and y are added, which is at most
// 1.42 times as much.
constexpr float kPerBias = 1.42f / 3, kSteep = 0.019f * kPerBias;
// Greatest radius, px, of records with sizes for which bands are measured; larger ones are rare.
constexpr float kOftenRadius = 8;
constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kNone = std::numeric_limits<float>::max();  // Scenery::surface_depth() where there is no surface
// Greatest number of lanes of a vector.
constexpr std::size_t kVectorRoom = 16;
// Greatest ratio between a surface's depth under the edge of a particle's disc, which may be beyond the horizon, and
// that at its centre.
constexpr float kHorizon = 4096;

float depth_of(const std::byte* bits) {
  float depth = 0;
  std::memcpy(&depth, bits, sizeof depth);
  return depth;
}

}  // namespace

void Behind::start(const Scenery& scenery, const Area& area, const SplatLanes& lanes) {
  scenery_ = scenery.occupied(area.tile) ? &scenery : nullptr;
  area_ = area;
  lanes_ = &lanes;
  radius_ = -1;
  if (scenery_ != nullptr) least_ = kNearer * std::bit_cast<float>(scenery.nearest(area.tile));
}

Piece Behind::settled(const Piece& piece) {
  const RecordForm form = piece.brush->form();
  if (scenery_ == nullptr || form.depth == 0) return piece;
  const std::size_t bytes = piece.brush->record_bytes(), found = find_in_bands(piece);
  Piece changed = piece;
  for (std::size_t k = 0; k < found; ++k) {
    const std::size_t i = found_.data()[k];
    const std::byte* record = piece.records + i * bytes;
    const float depth = depth_of(record + form.depth);
    if (depth < least_) continue;
    const float deeper = settled_depth(center_of(piece, record), depth);
    if (deeper == depth) continue;
    if (changed.records == piece.records) {
      records_.resize(piece.count * bytes);
      std::memcpy(records_.data(), piece.records, piece.count * bytes);
      changed.records = records_.data();
    }
    std::memcpy(records_.data() + i * bytes + form.depth, &deeper, sizeof deeper);
  }
  return changed;
}

// Lists in `found_` the records that are near a surface; returns how many.
std::size_t Behind::find_in_bands(const Piece& piece) {
  const Brush& brush = *piece.brush;
  const Grid& grid = scenery_->grid();
  const bool fixed = of_fixed_size(brush.layout());
  const float radius = fixed ? 0.5f * static_cast<float>(brush.footprint_pixels()) : kOftenRadius;
  if (radius > radius_) measure_bands(radius);
  const int bits = fixed ? grid.sub_bits() : is_wide(brush.layout()) ? 1 : grid.far_bits();
  const auto first = [&](int pixels, int from) { return (pixels << bits) - (from << (bits + 1)) + (fixed ? 1 : 0); };
  found_.resize(piece.count + kVectorRoom);
  const BandSearch search{bands_.data(),
                          brush.layout(),
                          brush.form(),
                          static_cast<int>(brush.record_bytes()),
                          bits + 1,
                          first(grid.width, area_.x),
                          first(grid.height, area_.y),
                          area_.width - 1,
                          area_.height - 1,
                          static_cast<int>(2 * kOftenRadius) << kSizeBits};
  return lanes_->find_in_bands(search, reinterpret_cast<const unsigned char*>(piece.records), piece.count,
                               found_.data());
}

void Behind::measure_bands(float radius) {
  radius_ = radius;
  bands_.resize(kTile * kTile);
  for (int row = 0; row < area_.height; ++row) measure_row(row, radius + 1);
}

// Computes the bands of a row: bounds on what settled_depth() returns for all centres nearest to a pixel. They are at
// most half a pixel from its middle along x and y or, at the tile's border, a footprint's reach.
void Behind::measure_row(int row, float reach) {
  const float* surfaces = scenery_->surface_depth(area_.x, area_.y + row);
  const std::uint32_t* hides = scenery_->depth(area_.x, area_.y + row);
  DepthBand* to = bands_.data() + row * kTile;
  std::array<float, kTile> slope, away;
  const bool outer = row == 0 || row == area_.height - 1;
  away.fill(outer ? 2 * reach : 1);
  away[0] = away[static_cast<std::size_t>(area_.width - 1)] = 2 * reach;
  for (std::size_t x = 0; x < kTile; ++x) slope[x] = (std::bit_cast<float>(hides[x]) / surfaces[x] - 1) * kPerBias;
  for (int x = 0; x < area_.width; ++x) {
    const auto i = static_cast<std::size_t>(x);
    if (slope[i] < kSteep || surfaces[x] == kNone) continue;
    const Scenery::Tilt tilt = scenery_->tilt(area_.x + x, area_.y + row);
    slope[i] = 1.001f * (std::abs(tilt.right) + std::abs(tilt.down)) / tilt.ahead;
    if (!(tilt.ahead > 0)) slope[i] = kInfinite;
  }
  const float pixel = reach * scenery_->pixel();
  for (std::size_t x = 0; x < kTile; ++x) {
    const float surface = surfaces[x], left = 1 - slope[x] * (away[x] + reach);
    const float low = 0.9999f * surface / (1 + slope[x] * away[x]);
    const float high = 1.0001f * (std::bit_cast<float>(hides[x]) + pixel * surface) / left;
    to[x] = {surface == kNone ? kInfinite : low, left > 0.25f ? high : kInfinite};
  }
}

Behind::Center Behind::center_of(const Piece& piece, const std::byte* record) const {
  const Brush& brush = *piece.brush;
  const Grid& grid = scenery_->grid();
  Center center{0.5f * static_cast<float>(grid.width), 0.5f * static_cast<float>(grid.height), 0, 0};
  if (of_fixed_size(brush.layout())) {
    const float unit = 1.0f / static_cast<float>(1 << grid.sub_bits());
    std::int16_t at[2];
    std::memcpy(at, record, sizeof at);
    center.x += (static_cast<float>(at[0]) + 0.5f) * unit;
    center.y += (static_cast<float>(at[1]) + 0.5f) * unit;
    center.blur = unit;
    center.radius = 0.5f * static_cast<float>(brush.footprint_pixels());
    return center;
  }
  const WideRecord r = wide_record(brush.form(), grid.far_bits(), record);
  constexpr float kPixel = 1.0f / (1 << kWideBits);
  center.x += static_cast<float>(r.x) * kPixel;
  center.y += static_cast<float>(r.y) * kPixel;
  center.blur = 1.0f / static_cast<float>(1 << (is_wide(brush.layout()) ? kWideBits : grid.far_bits()));
  center.radius = 0.5f / (1 << kSizeBits) * static_cast<float>(size_units(r.size));
  return center;
}

// Returns a depth at which the surface at the nearest pixel hides the record if its centre is behind that surface,
// otherwise `depth`. The surface is replaced by its tangent plane, whose inverse depth is linear in the image.
float Behind::settled_depth(const Center& center, float depth) const {
  const auto nearest = [](float at, int first, int count) {
    const float in_tile = std::floor(at) - static_cast<float>(first);
    return static_cast<int>(std::clamp(in_tile, 0.0f, static_cast<float>(count - 1)));
  };
  const int column = nearest(center.x, area_.x, area_.width), row = nearest(center.y, area_.y, area_.height);
  const int x = area_.x + column, y = area_.y + row;
  const float surface = *scenery_->surface_depth(x, y), hides = std::bit_cast<float>(*scenery_->depth(x, y));
  if (surface == kNone) return depth;
  const float right = center.x - (static_cast<float>(x) + 0.5f), down = center.y - (static_cast<float>(y) + 0.5f);
  const float square = right * right + down * down;
  const Scenery::Tilt tilt = scenery_->tilt(x, y);
  const float there = tilt.ahead + tilt.right * right + tilt.down * down;
  if (!(there > 0)) return depth;  // beyond the tangent plane's horizon
  const float at = surface * (tilt.ahead / there);
  const float slope = (std::abs(tilt.right) + std::abs(tilt.down)) / there;  // relative change of depth per pixel
  const float margin = kLeastMargin + slope * center.blur;
  if (!(depth > at * (1 + margin))) return depth;
  const float bent = bend(column, row) * square * scenery_->pixel() / (there * there);
  if (!(depth > at * (1 + margin + bent))) return depth;
  const float left = 1 - slope * (center.radius + 1);
  const float deepening = left * kHorizon > 1 ? 1 / left : kHorizon;
  const float needed = at * (deepening * (hides / surface) + (center.radius + 1) * scenery_->pixel());
  return std::max(depth, needed);
}

// Returns how much normals of neighbouring pixels on the same object differ from this pixel's: 0 on flat surfaces.
float Behind::bend(int column, int row) const {
  const auto normal = [&](int x, int y) { return scenery_->normal(area_.x + x, area_.y + y); };
  const auto object = [&](int x, int y) { return object_of(scenery_->surface(area_.x + x, area_.y + y)); };
  const std::array<float, 3> own = normal(column, row);
  float most = 0;
  for (const auto& [across, below] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    const int x = std::clamp(column + across, 0, area_.width - 1), y = std::clamp(row + below, 0, area_.height - 1);
    if (object(x, y) != object(column, row)) continue;
    const std::array<float, 3> other = normal(x, y);
    float sum = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) sum += std::abs(other[axis] - own[axis]);
    most = std::max(most, sum);
  }
  return most;
}

}  // namespace motes::image
