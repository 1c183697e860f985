#include "image/raster/tile_painter.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <memory>
#include <stdexcept>

#include "base/memory.h"
#include "image/raster/partial_tile.h"

namespace motes::image {
namespace {

// Least number of records that must fit before sums may overflow; below this, saturating sums are cheaper than
// searching for the greatest sum.
constexpr std::uint32_t kWorthCounting = 256;

// Returns the most that a record of this alpha adds to a sum.
std::uint32_t most_light(std::uint32_t alpha) {
  constexpr auto kOfAlpha = static_cast<std::uint32_t>(kUnit * kMostLight / 255) + 1;
  return kOfAlpha * (alpha + 1);  // one more, for rounding
}

// Returns what can be added to sums without overflow if the greatest is `brightest`.
std::uint32_t room(std::uint32_t brightest) { return std::numeric_limits<std::uint32_t>::max() - brightest; }

// Number of pieces whose records are prefetched.
constexpr std::size_t kAhead = 2;

[[gnu::always_inline]] inline void prefetch(const Piece& piece) {
  base::prefetch(piece.records, std::min<std::size_t>(piece.count * piece.brush->record_bytes(), 4096));
}

// Fewest records of one colour for which a Cover pays: it costs a pass over the tile.
constexpr std::size_t kWorthCovering = 256;

// Colour and light of a piece's first record.
struct Paint {
  std::uint32_t color;
  std::uint16_t light;
  bool operator==(const Paint&) const = default;
};
Paint paint_of(const Piece& piece) {
  const RecordForm f = piece.brush->form();
  Paint paint{piece.color, 0};
  if (f.color != 0) std::memcpy(&paint.color, piece.records + f.color, sizeof paint.color);
  std::memcpy(&paint.light, piece.records + f.size + 2, sizeof paint.light);
  return paint;
}

// Surfaces are measured once the tile has been covered kFirstLook times (before that, hardly anything is hidden), then
// whenever half as much again has been drawn. Measuring does not pay if less than kWorthLooking times the tile is left.
constexpr std::size_t kFirstLook = 6, kWorthLooking = 2;

// Returns roughly the pixels that one opaque record covers.
std::size_t pixels_of(const Piece& piece) {
  const int size = piece.brush->footprint_pixels();
  return size > 0 ? static_cast<std::size_t>(size) * static_cast<std::size_t>(size) : 64;
}
std::size_t pixels_of(std::span<const Piece> pieces) {
  std::size_t sum = 0;
  for (const Piece& piece : pieces) {
    if (piece.brush->blends(Sprite::Blend::opaque)) sum += piece.count * pixels_of(piece);
  }
  return sum;
}

const unsigned char* raw(const std::byte* bytes) { return reinterpret_cast<const unsigned char*>(bytes); }

template <class Number>
Number* cleared(BufferOf<Number>& plane, std::size_t numbers, int first) {
  plane.resize(numbers);
  std::fill_n(plane.data(), numbers, Number{0});
  return plane.data() + first;
}

}  // namespace

TilePainter::TilePainter(const SplatLanes& lanes, const WideLanes& wide) : lanes_(&lanes), wide_lanes_(&wide) {
  planes_.light = cleared(light_, kLightNumbers, kFirstLight);
  planes_.depth = cleared(depth_, kPixelNumbers, kFirstPixel);
  planes_.surfaces = cleared(nearest_, kPixelNumbers, kFirstPixel);
}

void TilePainter::begin(const PreparedScene& scene) { scene_ = &scene; }

void TilePainter::clear(const Area& area, std::uint32_t brightest) {
  area_ = area;
  brush_ = nullptr;
  blocks_.forget();
  surfaces_ = false;
  room_ = room(brightest);
  saturating_ = false;
  const Scenery& scenery = scene_->scenery();
  behind_.start(scenery, area, *lanes_);
  take_depth();
}

// Takes the depth of the sharp scenery.
void TilePainter::take_depth() {
  const Scenery& scenery = scene_->scenery();
  planes_.hides = scenery.occupied(area_.tile);
  if (!planes_.hides) return;
  planes_.nearest = scenery.nearest(area_.tile);
  planes_.farthest = scenery.farthest(area_.tile);
  for (int y = 0; y < area_.height; ++y) {
    std::memcpy(planes_.depth + y * kPixelStride, scenery.depth(area_.x, area_.y + y),
                static_cast<std::size_t>(area_.width) * 4);
  }
}

void TilePainter::start(const Area& area) {
  bare_ = false;
  const Scenery& scenery = scene_->scenery();
  clear(area, std::max(scenery.brightest(area.tile), most_light(255)));  // opaque particles may add this much
  show_scenery();
}

// Sets the light to that of the sharp scenery.
void TilePainter::show_scenery() {
  const Scenery& scenery = scene_->scenery();
  const auto lanes = static_cast<std::size_t>(area_.width) * 3;
  if (planes_.hides) {
    for (int y = 0; y < area_.height; ++y) {
      std::copy_n(scenery.light(area_.x, area_.y + y), lanes, planes_.light + y * kLightStride);
    }
  } else {
    std::uint32_t background[3 * kTile];
    for (std::size_t i = 0; i < lanes; ++i) background[i] = scenery.background()[i % 3];
    for (int y = 0; y < area_.height; ++y) std::copy_n(background, lanes, planes_.light + y * kLightStride);
  }
}

void TilePainter::start_bare(const Area& area) {
  bare_ = true;
  clear(area, 0);
  for (int y = 0; y < area.height; ++y) std::fill_n(planes_.light + y * kLightStride, 3 * area.width, 0u);
}

void TilePainter::start_surfaces() {
  if (surfaces_) return;
  surfaces_ = true;
  for (int y = 0; y < area_.height; ++y) {
    std::uint32_t* depth = planes_.depth + y * kPixelStride;
    if (!planes_.hides) std::fill_n(depth, area_.width, Scenery::kNothing);
    NearestSurface* nearest = planes_.surfaces + y * kPixelStride;
    for (int x = 0; x < area_.width; ++x) nearest[x] = no_surface(depth[x]);
  }
}

void TilePainter::merge(std::span<const std::byte> partial) {
  const PartialTile part(partial, area_);
  part.add_light(planes_.light);
  room_ = 0;  // unknown until the next search
  if (!part.has_surfaces()) return;
  start_surfaces();
  part.keep_nearest(planes_.surfaces);
}

void TilePainter::paint(std::span<const Piece> pieces) {
  if (bare_) return paint_bare(pieces);
  if (has_exposures(pieces)) return paint_exposures(pieces);
  if (any(pieces, Sprite::Blend::opaque) || surfaces_) {
    paint_surfaces(pieces);
    show_surfaces();
  }
  paint_blended(pieces);
}

// Shows the nearest opaque particles.
void TilePainter::show_surfaces() {
  if (!planes_.hides) {
    for (int y = 0; y < area_.height; ++y)
      std::fill_n(planes_.depth + y * kPixelStride, area_.width, Scenery::kNothing);
  }
  const DepthRange range = lanes_->show_surfaces(planes_, area_.height, area_.width);
  planes_.hides = true;
  planes_.nearest = range.nearest;
  planes_.farthest = range.farthest;
  blocks_.forget();
  room_ = 0;  // what is shown may be bright
}

// Draws what is blended, in front of the nearest surfaces.
void TilePainter::paint_blended(std::span<const Piece> pieces) {
  if (any(pieces, Sprite::Blend::alpha)) {
    ordered_.sort(pieces);
    for (const Piece& run : ordered_.runs()) blend(run);
    return;
  }
  add(pieces);
}

void TilePainter::paint_bare(std::span<const Piece> pieces) {
  const bool opaque = any(pieces, Sprite::Blend::opaque), added = any(pieces, Sprite::Blend::add);
  if (any(pieces, Sprite::Blend::alpha) || (added && (opaque || surfaces_))) {
    throw std::logic_error("TilePainter: a partial tile has either opaque records or additive ones");
  }
  if (opaque) paint_surfaces(pieces);
  if (added) add(pieces);
}

void TilePainter::add(std::span<const Piece> pieces) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (i + kAhead < pieces.size()) prefetch(pieces[i + kAhead]);
    if (pieces[i].count == 0 || !pieces[i].brush->blends(Sprite::Blend::add)) continue;
    start_cover(pieces.subspan(i));
    blend(pieces[i]);
  }
  end_cover();
}

// Decides whether streaks of the first piece are accumulated in the Cover, counting the alike pieces that follow.
void TilePainter::start_cover(std::span<const Piece> pieces) {
  const Brush* brush = pieces.front().brush;
  if (!brush->has_stamps()) return end_cover();
  const Paint paint = paint_of(pieces.front());
  if (covering_ == brush && paint == Paint{cover_.color, cover_.light}) return;
  end_cover();
  std::size_t alike = 0;
  for (const Piece& piece : pieces) {
    if (piece.count == 0) continue;
    if (piece.brush != brush || !(paint_of(piece) == paint)) return;
    alike += piece.count;
    if (alike >= kWorthCovering) break;
  }
  if (alike < kWorthCovering) return;
  if (cover_.weights == nullptr) {
    cover_.weights = cleared(cover_weights_, Cover::kNumbers, Cover::kFirst);
    cover_.sums = cleared(cover_sums_, kPixelNumbers, kFirstPixel);
  }
  cover_.color = paint.color;
  cover_.light = paint.light;
  covering_ = brush;
}

void TilePainter::show_cover() {
  cover_.saturating = saturating_;
  if (cover_.records != 0) wide_lanes_->show_cover(planes_, cover_, area_.height);
  cover_.records = 0;
}

void TilePainter::end_cover() {
  show_cover();
  covering_ = nullptr;
}

// Draws opaque records in parts. Between parts it measures how far away surfaces still are, so that farther records can
// be skipped.
void TilePainter::paint_surfaces(std::span<const Piece> pieces) {
  start_surfaces();
  planes_.blocks = nullptr;
  const auto pixels = static_cast<std::size_t>(area_.width) * static_cast<std::size_t>(area_.height);
  std::size_t left = pixels_of(pieces), drawn = 0, next = planes_.hides ? 0 : kFirstLook * pixels;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (i + kAhead < pieces.size()) prefetch(pieces[i + kAhead]);
    const Piece& piece = pieces[i];
    if (!piece.brush->blends(Sprite::Blend::opaque)) continue;
    const int size = piece.brush->footprint_pixels();
    if (planes_.blocks != nullptr) planes_.blocks = fronts_.met(planes_, area_, std::max(size, 1));
    for (Piece rest = piece; rest.count != 0;) {
      Piece part = rest;
      if (left >= kWorthLooking * pixels) {
        if (drawn >= next) {
          fronts_.measure_surfaces(planes_, area_, *lanes_);
          planes_.blocks = fronts_.met(planes_, area_, std::max(size, 1));
          next = drawn + std::max(drawn / 2, kFirstLook * pixels);
        }
        part.count = std::min(rest.count, (next - drawn) / pixels_of(piece) + 1);
      }
      draw_opaque(part, planes_);
      rest.records += part.count * piece.brush->record_bytes();
      rest.count -= part.count;
      drawn += part.count * pixels_of(piece);
      left -= part.count * pixels_of(piece);
    }
  }
}

void TilePainter::take_up(const Piece& piece) {
  set_brush(*piece.brush);
  splat_.color = wide_splat_.color = piece.color;
}

void TilePainter::set_brush(const Brush& brush) {
  if (brush_ == &brush) return;
  brush_ = &brush;
  if (of_fixed_size(brush.layout())) {
    splat_ = brush.splat_at(area_.x, area_.y);
    return;
  }
  wide_splat_ = brush.wide_at(area_);
  if (brush.has_stamps() && stamps_.size() == 0) {
    stamps_.resize(kStamps);
    std::uninitialized_fill_n(stamps_.data(), kStamps, Stamp{});
  }
  wide_splat_.memory.stamps = stamps_.data();
  if (brush.sprite().is(Sprite::Kind::image) && image_stamps_.size() == 0) {
    image_stamps_.resize(kImageStamps);
    for (std::size_t i = 0; i < image_stamps_.size(); ++i) image_stamps_.data()[i].levels = nullptr;
  }
  wide_splat_.memory.image_stamps = image_stamps_.data();
}

void TilePainter::draw_opaque(const Piece& given, const TilePlanes& planes) {
  // Cards, meshes and ribbons have depths of their own at each pixel.
  const Piece piece = is_posed(given.brush->sprite()) ? given : behind_.settled(given);
  take_up(piece);
  if (!of_fixed_size(piece.brush->layout())) {
    kernels(*piece.brush).opaque(planes, wide_splat_, raw(piece.records), piece.count);
  } else {
    lanes_->opaque(planes, splat_, raw(piece.records), piece.count);
  }
}

void TilePainter::blend(const Piece& given) {
  const Brush& brush = *given.brush;
  const bool over = brush.blends(Sprite::Blend::alpha);
  // Kernels that add records of fixed size settle them one by one.
  const bool alone = brush.tests_pixels() || (of_fixed_size(brush.layout()) && !over);
  const Piece piece = alone ? given : behind_.settled(given);
  take_up(piece);
  if (!of_fixed_size(brush.layout())) {
    WideKernel* kernel = over ? kernels(brush).over : kernels(brush).add;
    wide_splat_.memory.cover = covering_ == nullptr ? nullptr : &cover_;
    wide_splat_.memory.moments = phases_;
    in_parts(piece, [&](const unsigned char* records, std::size_t count) {
      wide_splat_.saturating = saturating_;
      kernel(planes_, wide_splat_, records, count);
    });
  } else {
    SplatKernel* kernel = over ? lanes_->over : lanes_->add;
    if (!over && splat_.form.depth != 0 && planes_.hides) {
      splat_.settling = behind_.settling(brush);
      const SurfaceBlock* surfaces = splat_.settling == nullptr ? nullptr : splat_.settling->blocks;
      planes_.blocks = blocks_.met(planes_, area_, splat_.size, surfaces);
    }
    in_parts(piece, [&](const unsigned char* records, std::size_t count) {
      splat_.saturating = saturating_;
      kernel(planes_, splat_, records, count);
    });
  }
}

// Draws a piece in parts that cannot overflow a sum; switches to saturating sums when parts would become too small.
template <class Draw>
void TilePainter::in_parts(const Piece& piece, const Draw& draw) {
  const unsigned char* records = raw(piece.records);
  std::size_t count = piece.count;
  const std::uint32_t most = most_light(piece.most_alpha);
  while (count != 0) {
    if (covering_ != nullptr && cover_.records >= Cover::kMost) show_cover();
    if (room_ / most < kWorthCounting && !saturating_) {
      show_cover();
      room_ = room(lanes_->brightest(planes_.light, area_.height, 3 * area_.width));
      saturating_ = room_ / most < kWorthCounting;
    }
    std::size_t part = saturating_ ? count : std::min<std::size_t>(count, room_ / most);
    if (covering_ != nullptr) {
      part = std::min<std::size_t>(part, Cover::kMost - cover_.records);
      cover_.records += static_cast<std::uint32_t>(part);
    }
    draw(records, part);
    records += part * piece.brush->record_bytes();
    count -= part;
    if (!saturating_) room_ -= static_cast<std::uint32_t>(part) * most;
  }
}

const WideKernels& TilePainter::kernels(const Brush& brush) const {
  return wide_lanes_->kinds[static_cast<std::size_t>(brush.sprite().kind())];
}

void TilePainter::save_partial(Buffer& to) const { append_partial(area_, planes_, surfaces_, to); }

void TilePainter::show(const TileLight& light, std::uint8_t* pixels, std::size_t row_bytes) const {
  const auto lanes = static_cast<std::size_t>(light.width) * 3;
  constexpr int kRowsAhead = 8;
  for (int y = 0; y < light.height; ++y, pixels += row_bytes) {
    if (y + kRowsAhead < light.height) base::prefetch_for_write(pixels + kRowsAhead * row_bytes, lanes);
    lanes_->tone(light.row(y), lanes, light.x, light.y + y, scene_->tone().data(), pixels);
  }
}

void TilePainter::depth(float* depths, std::size_t row_floats) const {
  const Scenery& scenery = scene_->scenery();
  const bool solids = scenery.occupied(area_.tile);
  for (int y = 0; y < area_.height; ++y, depths += row_floats) {
    const std::uint32_t* bits = planes_.depth + y * kPixelStride;
    for (int x = 0; x < area_.width; ++x) depths[x] = std::bit_cast<float>(planes_.hides ? bits[x] : Scenery::kNothing);
    if (!solids) continue;
    // Write a solid's surface depth, not the depth from which on it hides particles.
    const std::uint32_t* hides = scenery.depth(area_.x, area_.y + y);
    const float* surface = scenery.surface_depth(area_.x, area_.y + y);
    for (int x = 0; x < area_.width; ++x) {
      if (bits[x] == hides[x] && bits[x] != Scenery::kNothing) depths[x] = surface[x];
    }
  }
}

}  // namespace motes::image
