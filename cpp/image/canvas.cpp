#include "image/canvas.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "image/camera.h"
#include "image/tone.h"

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

void prefetch(const RecordsView::Piece& piece, std::size_t record_bytes) {
  const std::size_t bytes = std::min<std::size_t>(piece.count * record_bytes, 4096);
  for (std::size_t i = 0; i < bytes; i += 64) __builtin_prefetch(piece.records + i);
}

const unsigned char* raw(const std::byte* bytes) { return reinterpret_cast<const unsigned char*>(bytes); }

}  // namespace

Canvas::Canvas(const SplatLanes& lanes) : lanes_(&lanes) {
  light_.resize(kLanesInAll);
  depth_.resize(kLanesInAll);
  std::fill_n(light_.data(), kLanesInAll, 0u);
  std::fill_n(depth_.data(), kLanesInAll, 0u);
  sums_.light = light_.data() + kFirst;
  sums_.stride = kStride;
}

std::size_t Canvas::at(int x, int y) const {
  return (static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.width) + static_cast<std::size_t>(x)) * 3;
}

void Canvas::begin(const View& view, bool keep_linear) {
  check(view);
  const bool same = scenery_current_ && same_scenery(view, view_);
  if (!same || view.exposure != view_.exposure) {
    scenery_current_ = false;
    view_ = view;
    grid_ = {view.width, view.height};
    scenery_.prepare(view);
    scenery_.render_all();
    tone_ = tone_table(view.exposure);
    render_scenery();
    scenery_current_ = true;
  }
  parts_.clear();
  keep_linear_ = keep_linear;
  linear_.clear();
}

void Canvas::add(std::span<const std::byte> records) {
  RecordsView seen(records);
  if (seen.grid().width != grid_.width || seen.grid().height != grid_.height ||
      seen.with_depth() != !view_.objects.empty()) {
    throw std::runtime_error("image records: made for a different view");
  }
  const Footprint& f = footprint(seen.sprite());
  Splat splat{};
  splat.weights = f.weights.data();
  splat.size = f.size;
  splat.phase_bits = f.phase_bits;
  splat.row_bytes = f.row_bytes;
  splat.sub_bits = grid_.sub_bits();
  splat.with_depth = seen.with_depth();
  parts_.push_back({std::move(seen), splat});
}

std::vector<std::uint8_t> Canvas::finish() {
  std::vector<std::uint8_t> pixels(at(0, view_.height));
  finish(pixels);
  return pixels;
}

void Canvas::finish(std::span<std::uint8_t> pixels) {
  if (!scenery_current_) throw std::logic_error("Canvas::finish before begin");
  if (pixels.size() != at(0, view_.height)) throw std::invalid_argument("pixels must be height * width * 3 bytes");
  if (keep_linear_) linear_.resize(pixels.size());
  for (int y = 0; y < view_.height; y += kTile) {
    for (int x = 0; x < view_.width; x += kTile) {
      const int tile = (y >> kTileBits) * grid_.columns() + (x >> kTileBits);
      const Area area{tile, x, y, std::min(kTile, view_.width - x), std::min(kTile, view_.height - y)};
      if (collect(tile) == 0 && !keep_linear_) {
        copy_scenery(area, pixels.data());
        continue;
      }
      start_tile(area);
      splat_tile(area);
      show_tile(area, pixels.data());
    }
  }
  parts_.clear();
}

// Collects the records of this tile and returns how many there are.
std::size_t Canvas::collect(int tile) {
  pieces_.clear();
  std::size_t count = 0;
  for (const Part& part : parts_) {
    for (const RecordsView::Batch& batch : part.records.batches()) {
      const RecordsView::Piece piece = part.records.piece(batch, tile);
      if (piece.count == 0) continue;
      pieces_.push_back({&part, piece});
      count += piece.count;
    }
  }
  return count;
}

void Canvas::start_tile(const Area& area) {
  const auto lanes = static_cast<std::size_t>(area.width) * 3;
  if (!scenery_.occupied(area.tile)) {
    std::uint16_t background[3 * kTile];
    for (std::size_t i = 0; i < lanes; ++i) background[i] = scenery_.background()[i % 3];
    for (int y = 0; y < area.height; ++y) lanes_->start(sums_.light + y * kStride, background, lanes);
    sums_.depth = nullptr;
    return;
  }
  for (int y = 0; y < area.height; ++y) {
    lanes_->start(sums_.light + y * kStride, scenery_.light(area.x, area.y + y), lanes);
    const std::uint32_t* from = scenery_.depth(area.x, area.y + y);
    std::uint32_t* to = depth_.data() + kFirst + y * kStride;
    for (std::size_t i = 0; i < lanes; ++i) to[i] = from[i / 3];
  }
  sums_.depth = depth_.data() + kFirst;
  sums_.nearest = scenery_.nearest(area.tile);
  sums_.farthest = scenery_.farthest(area.tile);
}

void Canvas::splat_tile(const Area& area) {
  // The scenery's light is below 2^16 << kSceneryShift.
  std::uint32_t left = room(std::uint32_t{65536} << kSceneryShift);
  bool saturating = false;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    if (i + 1 < pieces_.size()) prefetch(pieces_[i + 1].records, pieces_[i + 1].part->records.record_bytes());
    Splat splat = piece.part->splat;
    const int half = 1 << (splat.sub_bits - 1);
    splat.origin_x = 2 * half * area.x - (grid_.width + 1 - splat.size) * half;
    splat.origin_y = 2 * half * area.y - (grid_.height + 1 - splat.size) * half;
    const unsigned char* records = raw(piece.records.records);
    std::size_t count = piece.records.count;
    while (count != 0) {
      if (left < kWorthCounting && !saturating) {
        left = room(lanes_->brightest(sums_, area.height, 3 * area.width));
        saturating = left < kWorthCounting;
      }
      const std::size_t part = saturating ? count : std::min<std::size_t>(count, left);
      splat.saturating = saturating;
      lanes_->splat(sums_, splat, records, part);
      records += part * piece.part->records.record_bytes();
      count -= part;
      if (!saturating) left -= static_cast<std::uint32_t>(part);
    }
  }
}

void Canvas::show_tile(const Area& area, std::uint8_t* pixels) {
  const auto lanes = static_cast<std::size_t>(area.width) * 3;
  for (int y = 0; y < area.height; ++y) {
    const std::uint32_t* light = sums_.light + y * kStride;
    const std::size_t to = at(area.x, area.y + y);
    lanes_->tone(light, lanes, tone_.data(), pixels + to);
    if (!keep_linear_) continue;
    for (std::size_t i = 0; i < lanes; ++i) linear_[to + i] = static_cast<float>(light[i] / double{kUnit});
  }
}

void Canvas::copy_scenery(const Area& area, std::uint8_t* pixels) {
  for (int y = 0; y < area.height; ++y) {
    const std::size_t row = at(area.x, area.y + y);
    std::memcpy(pixels + row, scenery_pixels_.data() + row, static_cast<std::size_t>(area.width) * 3);
  }
}

void Canvas::render_scenery() {
  scenery_pixels_.resize(at(0, view_.height));
  pieces_.clear();
  for (int y = 0; y < view_.height; y += kTile) {
    for (int x = 0; x < view_.width; x += kTile) {
      const int tile = (y >> kTileBits) * grid_.columns() + (x >> kTileBits);
      const Area area{tile, x, y, std::min(kTile, view_.width - x), std::min(kTile, view_.height - y)};
      start_tile(area);
      show_tile(area, scenery_pixels_.data());
    }
  }
}

std::vector<float> Canvas::linear() const {
  if (linear_.empty()) throw std::logic_error("Canvas::linear: the frame was begun without keep_linear");
  return linear_;
}

}  // namespace motes::image
