#include "image/tile_painter.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "image/partial_tile.h"

namespace motes::image {
namespace {

// Footprints extend over a tile's edges by less than the largest footprint; vectors are read and written whole.
constexpr int kMargin = kMaxFootprint - 1;
constexpr int kStride = 3 * (kTile + 2 * kMargin) + 4;
constexpr int kRows = kTile + 2 * kMargin;
constexpr int kFirst = kMargin * kStride + 3 * kMargin;
constexpr std::size_t kLanesInAll = static_cast<std::size_t>(kRows) * kStride + 64;

// With room for fewer records than this, another search for the greatest sum costs more than saturating.
constexpr std::uint32_t kWorthCounting = 256;

// How many records can be added before a sum may overflow, where the greatest is now `brightest`.
std::uint32_t room(std::uint32_t brightest) { return (std::numeric_limits<std::uint32_t>::max() - brightest) / kUnit; }

void prefetch(const Piece& piece) {
  const std::size_t bytes = std::min<std::size_t>(piece.count * piece.brush->record_bytes, 4096);
  for (std::size_t i = 0; i < bytes; i += 64) __builtin_prefetch(piece.records + i);
}

const unsigned char* raw(const std::byte* bytes) { return reinterpret_cast<const unsigned char*>(bytes); }

}  // namespace

TilePainter::TilePainter(const SplatLanes& lanes) : lanes_(&lanes) {
  light_.resize(kLanesInAll);
  depth_.resize(kLanesInAll);
  std::fill_n(light_.data(), kLanesInAll, 0u);
  std::fill_n(depth_.data(), kLanesInAll, 0u);
  sums_.light = light_.data() + kFirst;
  sums_.stride = kStride;
}

void TilePainter::begin(const PreparedScene& scene) { scene_ = &scene; }

const std::uint32_t* TilePainter::row(int y) const { return sums_.light + y * kStride; }

void TilePainter::start(const Area& area) {
  area_ = area;
  const Scenery& scenery = scene_->scenery();
  const auto lanes = static_cast<std::size_t>(area.width) * 3;
  if (scenery.occupied(area.tile)) {
    for (int y = 0; y < area.height; ++y) {
      lanes_->start(sums_.light + y * kStride, scenery.light(area.x, area.y + y), lanes);
    }
  } else {
    std::uint16_t background[3 * kTile];
    for (std::size_t i = 0; i < lanes; ++i) background[i] = scenery.background()[i % 3];
    for (int y = 0; y < area.height; ++y) lanes_->start(sums_.light + y * kStride, background, lanes);
  }
  // The scenery's light is below 2^16 << kSceneryShift.
  room_ = room(std::uint32_t{65536} << kSceneryShift);
  saturating_ = false;
  start_depth();
}

void TilePainter::start_bare(const Area& area) {
  area_ = area;
  for (int y = 0; y < area.height; ++y) std::fill_n(sums_.light + y * kStride, 3 * area.width, 0u);
  room_ = room(0);
  saturating_ = false;
  start_depth();
}

void TilePainter::start_depth() {
  const Scenery& scenery = scene_->scenery();
  sums_.depth = nullptr;
  if (!scenery.occupied(area_.tile)) return;
  const auto lanes = static_cast<std::size_t>(area_.width) * 3;
  for (int y = 0; y < area_.height; ++y) {
    const std::uint32_t* from = scenery.depth(area_.x, area_.y + y);
    std::uint32_t* to = depth_.data() + kFirst + y * kStride;
    for (std::size_t i = 0; i < lanes; ++i) to[i] = from[i / 3];
  }
  sums_.depth = depth_.data() + kFirst;
  sums_.nearest = scenery.nearest(area_.tile);
  sums_.farthest = scenery.farthest(area_.tile);
}

void TilePainter::merge(std::span<const std::byte> partial) {
  add_partial(partial, area_, sums_.light, kStride);
  room_ = 0;  // unknown: counted when records are added
}

void TilePainter::paint(std::span<const Piece> pieces) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (i + 1 < pieces.size()) prefetch(pieces[i + 1]);
    add_records(pieces[i]);
  }
}

void TilePainter::add_records(const Piece& piece) {
  const Brush& brush = *piece.brush;
  Splat splat = brush.splat;
  const int half = 1 << (splat.sub_bits - 1);
  splat.origin_x = 2 * half * area_.x - (brush.grid.width + 1 - splat.size) * half;
  splat.origin_y = 2 * half * area_.y - (brush.grid.height + 1 - splat.size) * half;
  const unsigned char* records = raw(piece.records);
  std::size_t count = piece.count;
  while (count != 0) {
    if (room_ < kWorthCounting && !saturating_) {
      room_ = room(lanes_->brightest(sums_, area_.height, 3 * area_.width));
      saturating_ = room_ < kWorthCounting;
    }
    const std::size_t part = saturating_ ? count : std::min<std::size_t>(count, room_);
    splat.saturating = saturating_;
    lanes_->splat(sums_, splat, records, part);
    records += part * brush.record_bytes;
    count -= part;
    if (!saturating_) room_ -= static_cast<std::uint32_t>(part);
  }
}

void TilePainter::save_partial(Buffer& to) const { append_partial(area_, sums_.light, kStride, to); }

void TilePainter::show(std::uint8_t* pixels, std::size_t row_bytes) const {
  const auto lanes = static_cast<std::size_t>(area_.width) * 3;
  for (int y = 0; y < area_.height; ++y, pixels += row_bytes) {
    lanes_->tone(row(y), lanes, scene_->tone().data(), pixels);
  }
}

void TilePainter::sums(std::uint32_t* to, std::size_t row_lanes) const {
  for (int y = 0; y < area_.height; ++y, to += row_lanes) std::copy_n(row(y), 3 * area_.width, to);
}

void TilePainter::light(float* linear, std::size_t row_floats) const {
  const auto lanes = static_cast<std::size_t>(area_.width) * 3;
  for (int y = 0; y < area_.height; ++y, linear += row_floats) {
    const std::uint32_t* sums = row(y);
    for (std::size_t i = 0; i < lanes; ++i) linear[i] = static_cast<float>(sums[i] / double{kUnit});
  }
}

}  // namespace motes::image
