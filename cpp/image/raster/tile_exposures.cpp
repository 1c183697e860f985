// Tiles whose pixels are means of exposures: what is opaque, seen through a lens or an open shutter.
#include <algorithm>
#include <bit>
#include <cstring>

#include "image/camera.h"
#include "image/exposures.h"
#include "image/mesh_corners.h"
#include "image/raster/tile_painter.h"

namespace motes::image {
namespace {

constexpr std::size_t kTileNumbers = static_cast<std::size_t>(3 * kTile) * kTile;

// Returns an upper bound on the depths at which a record's visibility is tested, m.
float farthest_depth(const Piece& piece, const std::byte* record) {
  const Sprite& sprite = piece.brush->sprite();
  float depth = 0;
  std::memcpy(&depth, record + static_cast<std::size_t>(piece.brush->form().depth), sizeof depth);
  if (!is_posed(sprite)) return depth;
  if (sprite.is(Sprite::Kind::ribbon)) {
    RibbonRecord ribbon;
    std::memcpy(&ribbon, record, sizeof ribbon);
    for (const RibbonPoint& point : ribbon.point) depth = std::max(depth, point.depth);
    return depth;
  }
  PosedRecord posed;
  std::memcpy(&posed, record, sizeof posed);
  return depth + posed.scale * (sprite.is(Sprite::Kind::mesh) ? reach_of_mesh(sprite.asset()) : 0.7072f);
}

}  // namespace

bool TilePainter::has_exposures(std::span<const Piece> pieces) const {
  if (!image::has_exposures(scene_->view())) return false;
  return scene_->scenery().blurs() || any(pieces, Sprite::Blend::opaque);
}

// Draws the opaque records into the planes of each exposure.
void TilePainter::expose(std::span<const Piece> pieces) {
  exposed_.resize(kExposures * kPixelNumbers);
  std::fill_n(exposed_.data(), exposed_.size(), no_surface(Scenery::kNothing));
  ExposedTile to{};
  for (std::size_t k = 0; k < kExposures; ++k) to.surfaces[k] = exposed_.data() + k * kPixelNumbers + kFirstPixel;
  const View& view = scene_->view();
  to.exposures = &exposures();
  to.focus = static_cast<float>(view.camera.focus);
  to.blur = static_cast<float>(0.5 * blur_of(view));
  TilePlanes planes = planes_;
  planes.blocks = nullptr;
  for (const Piece& given : pieces) {
    if (given.count == 0 || !given.brush->blends(Sprite::Blend::opaque)) continue;
    const Piece piece = is_posed(given.brush->sprite()) ? given : behind_.settled(given);
    take_up(piece);
    wide_splat_.memory.exposed = &to;
    kernels(*piece.brush)
        .exposed(planes, wide_splat_, reinterpret_cast<const unsigned char*>(piece.records), piece.count);
    wide_splat_.memory.exposed = nullptr;
  }
}

// Starts one exposure with the scenery's light and depth then.
void TilePainter::start_exposure(int number) {
  const Scenery& scenery = scene_->scenery();
  begin_blending();
  if (scenery.blurs()) {
    exposer_.expose(number, area_, planes_.light, kLightStride, planes_.depth, kPixelStride);
    return measure_depth();
  }
  take_depth();
  show_scenery();
}

// Forgets what is known of the tile's light and depth.
void TilePainter::begin_blending() {
  blocks_.forget();
  saturating_ = false;
  room_ = 0;  // unknown until the next search
}

// Adds the tile's light to the sums of all exposures, or sets it to their mean.
void TilePainter::add_exposure() {
  for (int y = 0; y < area_.height; ++y) {
    const std::uint32_t* light = planes_.light + y * kLightStride;
    std::uint64_t* to = sums_.data() + static_cast<std::size_t>(y) * 3 * kTile;
    for (int i = 0; i < 3 * area_.width; ++i) to[i] += light[i];
  }
}
void TilePainter::show_exposures() {
  for (int y = 0; y < area_.height; ++y) {
    const std::uint64_t* sums = sums_.data() + static_cast<std::size_t>(y) * 3 * kTile;
    std::uint32_t* to = planes_.light + y * kLightStride;
    for (int i = 0; i < 3 * area_.width; ++i)
      to[i] = static_cast<std::uint32_t>((sums[i] + kExposures / 2) / kExposures);
  }
}

// Returns whether all blended records are in front of everything nearer than `nearest`, the bits of a depth.
bool TilePainter::in_front(std::span<const Piece> pieces, std::uint32_t nearest) const {
  const auto least = std::bit_cast<float>(nearest);
  for (const Piece& piece : pieces) {
    const RecordForm form = piece.brush->form();
    if (piece.count == 0 || piece.brush->blends(Sprite::Blend::opaque) || form.depth == 0) continue;
    const std::size_t bytes = piece.brush->record_bytes();
    for (std::size_t i = 0; i < piece.count; ++i) {
      const float depth = farthest_depth(piece, piece.records + i * bytes);
      if (!(depth + piece.brush->sprite().softness < least)) return false;
    }
  }
  return true;
}

// Keeps the tile's light and depth at an exposure, or takes them back.
void TilePainter::keep_exposure(int number, bool back) {
  const auto copy = [back](std::uint32_t* plane, std::uint32_t* kept, int count) {
    back ? std::copy_n(kept, count, plane) : std::copy_n(plane, count, kept);
  };
  constexpr std::size_t kBoth = kTileNumbers + static_cast<std::size_t>(kTile) * kTile;
  kept_.resize(kExposures * kBoth);
  std::uint32_t* light = kept_.data() + static_cast<std::size_t>(number) * kBoth;
  std::uint32_t* depth = light + kTileNumbers;
  for (int y = 0; y < area_.height; ++y, light += 3 * kTile, depth += kTile) {
    copy(planes_.light + y * kLightStride, light, 3 * area_.width);
    copy(planes_.depth + y * kPixelStride, depth, area_.width);
  }
}

// Finds the range of the tile's depths.
void TilePainter::measure_depth() {
  planes_.hides = true;
  planes_.nearest = Scenery::kNothing;
  planes_.farthest = 0;
  for (int y = 0; y < area_.height; ++y) {
    const std::uint32_t* row = planes_.depth + y * kPixelStride;
    const auto [least, most] = std::minmax_element(row, row + area_.width);
    planes_.nearest = std::min(planes_.nearest, *least);
    planes_.farthest = std::max(planes_.farthest, *most);
  }
}

void TilePainter::paint_exposures(std::span<const Piece> pieces) {
  const bool opaque = any(pieces, Sprite::Blend::opaque);
  const bool blended = any(pieces, Sprite::Blend::add) || any(pieces, Sprite::Blend::alpha);
  if (scene_->scenery().blurs()) exposer_.begin(scene_->scenery());
  if (opaque) expose(pieces);
  sums_.resize(kTileNumbers);
  std::fill_n(sums_.data(), kTileNumbers, std::uint64_t{0});
  NearestSurface* const sharp = planes_.surfaces;
  std::uint32_t nearest = Scenery::kNothing;
  for (int number = 0; number < kExposures; ++number) {
    start_exposure(number);
    if (opaque) {
      planes_.surfaces = exposed_.data() + static_cast<std::size_t>(number) * kPixelNumbers + kFirstPixel;
      show_surfaces();
    }
    if (planes_.hides) nearest = std::min(nearest, planes_.nearest);
    if (blended) keep_exposure(number, false);
    add_exposure();
  }
  planes_.surfaces = sharp;
  const bool front = blended && in_front(pieces, nearest);
  if (blended && !front) {
    std::fill_n(sums_.data(), kTileNumbers, std::uint64_t{0});
    for (int number = 0; number < kExposures; ++number) {
      begin_blending();
      keep_exposure(number, true);
      measure_depth();
      phases_ = exposures().of[number];
      paint_blended(pieces);
      add_exposure();
    }
    phases_ = nullptr;
  }
  show_exposures();
  if (front) {
    begin_blending();
    planes_.hides = false;
    paint_blended(pieces);
  }
  if (scene_->view().layers != 0) measure_sharp(pieces, opaque);
}

// Sets the depth and the surfaces to the sharp ones of the closing shutter, which layers show; keeps the light.
void TilePainter::measure_sharp(std::span<const Piece> pieces, bool opaque) {
  keep_exposure(0, false);
  take_depth();
  if (opaque) {
    paint_surfaces(pieces);
    show_surfaces();
  }
  const std::uint32_t* light = kept_.data();
  for (int y = 0; y < area_.height; ++y, light += 3 * kTile) {
    std::copy_n(light, 3 * area_.width, planes_.light + y * kLightStride);
  }
}

}  // namespace motes::image
