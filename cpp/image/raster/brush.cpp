#include "image/raster/brush.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <tuple>
#include <type_traits>

#include "base/fields.h"
#include "image/camera.h"
#include "image/footprint.h"
#include "image/light/daylight.h"
#include "image/mesh_corners.h"

namespace motes::image {
namespace {

constexpr double kWholeByte = 255;

// Calls use(row in tables, column, x, y) for each pixel of each phase; (x, y) is the pixel's centre relative to the
// particle's, px, right and down.
template <class Use>
void for_each_pixel(int size, int phase_bits, const Use& use) {
  const int phases = 1 << phase_bits;
  std::size_t row = 0;
  for (int py = 0; py < phases; ++py) {
    for (int px = 0; px < phases; ++px) {
      for (int r = 0; r < size; ++r, ++row) {
        for (int c = 0; c < size; ++c) {
          use(row, static_cast<std::size_t>(c), c + 1 - (px + 0.5) / phases - 0.5 * size,
              r + 1 - (py + 0.5) / phases - 0.5 * size);
        }
      }
    }
  }
}

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(value + 0.5); }

std::size_t rows_of(int size, int phase_bits) { return static_cast<std::size_t>(size) << (2 * phase_bits); }

// Makes tables that cover every pixel whose centre is inside a disc; a point covers the pixel it is in.
SurfaceTables flat_surface(bool point, float diameter, const Footprint& f) {
  SurfaceTables t;
  t.covered.assign(rows_of(f.size, f.phase_bits), 0);
  const double radius = 0.5 * diameter;
  for_each_pixel(f.size, f.phase_bits, [&](std::size_t row, std::size_t column, double x, double y) {
    const bool inside = point ? std::fabs(x) < 0.5 && std::fabs(y) < 0.5 : x * x + y * y < radius * radius;
    t.covered[row] |= static_cast<std::uint16_t>(inside ? 1u << column : 0u);
  });
  return t;
}

// Makes tables of spheres, whose light is in Balls. The cover of all phases has the sum of the disc's.
SurfaceTables round_surface(float diameter, const Footprint& f) {
  SurfaceTables t;
  const std::size_t rows = rows_of(f.size, f.phase_bits);
  const auto surface = static_cast<std::size_t>(surface_row(f.size)), row_bytes = static_cast<std::size_t>(f.row_bytes);
  const auto in_phase = static_cast<std::size_t>(f.size) * static_cast<std::size_t>(f.size);
  t.cover.assign(rows * row_bytes, 0);
  t.covered.assign(rows, 0);
  t.bulge.assign((rows + 1) * surface, 0);
  const double radius = 0.5 * diameter;
  std::vector<double> edges;
  for_each_pixel(f.size, f.phase_bits, [&](std::size_t row, std::size_t column, double x, double y) {
    const double distance = std::sqrt(x * x + y * y);
    edges.push_back(std::clamp(radius - distance + 0.5, 0.0, 1.0));
    if (distance >= radius) return;
    t.covered[row] |= static_cast<std::uint16_t>(1u << column);
    t.bulge[row * surface + column] = static_cast<float>(std::sqrt(1 - (x * x + y * y) / (radius * radius)));
  });
  double scale = 0;
  std::size_t i = 0;
  for_each_pixel(f.size, f.phase_bits, [&](std::size_t row, std::size_t column, double, double) {
    if (i % in_phase == 0) {
      const auto first = edges.begin() + static_cast<std::ptrdiff_t>(i);
      scale = std::numbers::pi * radius * radius /
              std::accumulate(first, first + static_cast<std::ptrdiff_t>(in_phase), 0.0);
    }
    const std::uint8_t cover = to_byte(std::min(kWholeByte, kWholeByte * edges[i++] * scale));
    std::fill_n(t.cover.begin() + static_cast<std::ptrdiff_t>(row * row_bytes + 3 * column), 3, cover);
  });
  return t;
}

// Returns the ratio of a footprint's light to that of the profile it samples.
float gain_at(Sprite::Kind kind, int pixels) {
  const Footprint& f = footprint({kind, pixels});
  double sum = 0;
  for (int i = 0; i < f.size * f.row_bytes; ++i) sum += f.weights[static_cast<std::size_t>(i)];
  return static_cast<float>(sum / 3 / (kWholeByte * (std::numbers::pi / 12) * f.size * f.size));
}

// What kernels of each kind need.

SurfaceSplat surface_splat(const View& view) {
  const Daylight daylight(view);
  SurfaceSplat s{};
  for (std::size_t i = 0; i < 3; ++i) {
    s.toward_sun[i] = static_cast<float>(daylight.toward_sun()[i]);
    s.upward[i] = static_cast<float>(daylight.upward()[i]);
  }
  s.sun = static_cast<float>(daylight.sun());
  s.low = static_cast<float>(daylight.low());
  s.high = static_cast<float>(daylight.high());
  return s;
}

SpaceSplat space_splat(const View& view) {
  return {static_cast<float>(lens(view).focal_px), static_cast<float>(view.camera.near),
          static_cast<float>(view.camera.focus), static_cast<float>(0.5 * blur_of(view))};
}

PictureSplat picture_splat(const Sheet& sheet) {
  const ImageLevels& picture = image_levels(sheet.picture, sheet.tiles);
  return {picture.levels().data(), picture.number(), static_cast<int>(sheet.tiles.count), picture.cover().data()};
}

DiscSplat splat_of(const DiscSprite&, const View&) {
  DiscSplat s{};
  for (int pixels = 2; pixels <= kMaxFootprint; ++pixels) s.gain[pixels] = gain_at(Sprite::Kind::disc, pixels);
  return s;
}
DiscSplat splat_of(const PointSprite&, const View& view) { return splat_of(DiscSprite{}, view); }
SphereSplat splat_of(const SphereSprite&, const View& view) { return {space_splat(view), surface_splat(view)}; }
PictureSplat splat_of(const ImageSprite& image, const View&) { return picture_splat(image.sheet); }
CardSplat splat_of(const CardSprite& card, const View& view) { return {space_splat(view), picture_splat(card.sheet)}; }
MeshSplat splat_of(const MeshSprite& sprite, const View& view) {
  const MeshCorners& mesh = mesh_corners(sprite.mesh);
  const auto planes = [](const std::vector<float>& of) { return of.empty() ? nullptr : of.data(); };
  return {space_splat(view),
          surface_splat(view),
          mesh.planes.data(),
          planes(mesh.colors),
          planes(mesh.normals),
          planes(mesh.uv),
          sprite.picture == 0 ? Texture{} : texture(sprite.picture),
          mesh.triangles,
          mesh.room,
          mesh.closed,
          reach_of_mesh(sprite.mesh)};
}
SpaceSplat splat_of(const RibbonSprite&, const View& view) { return space_splat(view); }
DiscSplat splat_of(const LiquidSprite&, const View& view) { return splat_of(DiscSprite{}, view); }

// Each is of the type that the kernels of its kind read.
#define MOTES_SPRITE_KIND(kind, Name) \
  static_assert(std::is_same_v<decltype(splat_of(Name##Sprite{}, View{})), Name##Splat>);
#include "image/sprites/list.inc"

// Returns what orders brushes. The bytes at its end also tell apart sprites that differ in nothing before them.
auto key(const Sprite& s, Layout layout, bool colored) {
  base::Bytes bytes;
  base::write_fields(s, bytes);
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  return std::tuple(s.kind(), s.blend, layout, colored, s.pixels, std::bit_cast<std::uint32_t>(s.of_height),
                    std::bit_cast<std::uint32_t>(s.softness), s.asset(), s.sheet() ? s.sheet()->tiles : Tiles{},
                    std::string(text, bytes.size()));
}

}  // namespace

Brush::Brush(const Sprite& sprite, Layout layout, const View& view, bool colored)
    : sprite_(sprite), layout_(layout), colored_(colored),
      record_bytes_(image::record_bytes(layout, colored) + (with_velocity(sprite, view) ? kVelocityBytes : 0)),
      width_(view.width), height_(view.height), blurs_(space_splat(view).blur > 0) {
  of_fixed_size(layout) ? set_splat(view) : set_wide(view);
}

void Brush::set_records(RecordSplat& to) const {
  to.record_bytes = static_cast<int>(record_bytes_);
  to.form = form();
  to.fade = sprite_.softness > 0 ? 1 / sprite_.softness : 0;
}

void Brush::set_splat(const View& view) {
  const float diameter = diameter_of(sprite_, height_);
  const bool point = drawn_as_point(sprite_);
  const bool sphere = sprite_.is(Sprite::Kind::sphere) && !point;
  if (!point && sprite_.of_height > 0) own_ = footprint_of(diameter);
  const Footprint& f = footprint_in_use();
  splat_.size = f.size;
  splat_.phase_bits = f.phase_bits;
  splat_.row_bytes = f.row_bytes;
  splat_.sub_bits = Grid{width_, height_}.sub_bits();
  set_records(splat_);
  splat_.radius = static_cast<float>(0.5 * (point ? 2 : diameter) / lens(view).focal_px);
  if (sphere && fogged_by_painter(sprite_, view)) {
    std::copy(view.fog.color.begin(), view.fog.color.end(), splat_.fog);
    splat_.fog_density = 1 / view.fog.metres;
    splat_.per_unit = static_cast<float>(1 / (lens(view).focal_px * (1 << splat_.sub_bits)));
  }
  if (sphere) {
    tables_ = round_surface(diameter, f);
    const bool grey = !lit_by_painter(sprite_) || has_grey_light(view);
    const BallForm form = sprite_.blend != Sprite::Blend::opaque ? BallForm::weights
                          : grey && !(splat_.fog_density > 0)    ? BallForm::shades
                                                                 : BallForm::surfaces;
    balls_ = std::make_shared<Balls>(Grid{width_, height_}, f, diameter, lens(view).focal_px, form, grey,
                                     grey ? grey_light(view) : surface_light(sprite_, view));
  } else if (sprite_.blend == Sprite::Blend::opaque) {
    tables_ = flat_surface(point, diameter, f);
  }
}

const Footprint& Brush::footprint_in_use() const {
  if (own_.size != 0) return own_;
  Sprite outline = sprite_;
  if (!outline.is(Sprite::Kind::point)) outline.look = Sprite::Kind::disc;
  return footprint(outline);
}

// Sets pointers to its own tables on each call, as wide_at() does, because a brush may have been moved.
Splat Brush::splat_at(int x, int y) const {
  Splat s = splat_;
  s.balls = balls_ == nullptr ? nullptr : &balls_->tile(x, y);
  s.weights = tables_.cover.empty() ? footprint_in_use().weights.data() : tables_.cover.data();
  s.covered = tables_.covered.data();
  s.bulge = tables_.bulge.empty() ? nullptr : tables_.bulge.data();
  const int half = 1 << (s.sub_bits - 1);
  s.origin_x = 2 * half * x - (width_ + 1 - s.size) * half;
  s.origin_y = 2 * half * y - (height_ + 1 - s.size) * half;
  return s;
}

void Brush::set_wide(const View& view) {
  set_records(wide_);
  wide_.bits = Grid{width_, height_}.far_bits();
  light_ = surface_light(sprite_, view);
  wide_.radius = static_cast<float>(1 / lens(view).focal_px);
  kind_ = std::visit([&](const auto& own) { return KindSplat(splat_of(own, view)); }, sprite_.look);
  if (sprite_.blend == Sprite::Blend::opaque) {  // exposures blur what is opaque
    std::visit(
        [](auto& own) {
          if constexpr (requires { own.blur; }) own.blur = 0;
        },
        kind_);
  }
  if (auto* discs = std::get_if<DiscSplat>(&kind_)) {
    const float diameter = diameter_of(sprite_, height_);
    discs->one_size = wide_.form.way != 0 && wide_.form.color != 8 && diameter > 0 && diameter < kMaxDiameter;
    if (drawn_as_point(sprite_)) {
      discs->gain[2] = gain_at(Sprite::Kind::point, 1);
      discs->key_shift = 1;
    }
  }
}

WideSplat Brush::wide_at(const Area& area) const {
  WideSplat t = wide_;
  t.light = light_.get();
  t.kind = std::visit([](const auto& kind) -> const void* { return &kind; }, kind_);
  constexpr int kUnitsPerPixel = 1 << kWideBits, kHalf = kUnitsPerPixel / 2;
  t.origin_x = kUnitsPerPixel * area.x + kHalf - kHalf * width_;
  t.origin_y = kUnitsPerPixel * area.y + kHalf - kHalf * height_;
  t.columns = area.width;
  t.rows = area.height;
  return t;
}

std::strong_ordering Brush::operator<=>(const Brush& other) const {
  return key(sprite_, layout_, colored_) <=> key(other.sprite_, other.layout_, other.colored_);
}

}  // namespace motes::image
