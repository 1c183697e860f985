#include "image/raster/brush.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
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

// A pixel of a sphere: the part of it that is covered, and its shade.
struct SpherePixel {
  double edge;
  std::array<double, 3> shade;
};

// The light on spheres, per channel, as a function of their normal in the camera's axes: grey, or for lit sprites under
// coloured light.
using SphereShades = std::function<std::array<double, 3>(const Vector& normal)>;

SphereShades grey_shades(const Daylight& daylight) {
  return [daylight](const Vector& normal) {
    const double shade = daylight.shade(normal);
    return std::array<double, 3>{shade, shade, shade};
  };
}

SphereShades tinted_shades(const View& view) {
  return [through = lens(view), sun = sun_of(view), sky = ambient(view)](const Vector& normal) {
    const Vector world = through.right * normal[0] + through.up * normal[1] - through.forward * normal[2];
    const double facing = sun.shines ? std::max(dot(world, vector_of(sun.toward)), 0.0) : 0;
    std::array<double, 3> shade = ambient_on(sky, world);
    for (std::size_t c = 0; c < 3; ++c) shade[c] = std::min(shade[c] + double{sun.color[c]} * facing, 1.0);
    return shade;
  };
}

// Sets the weights of channels first .. last - 1, whose shades are alike, so that a sphere has the light of
// Sphere::total() in each phase. `pixels`: in the order of for_each_pixel.
void set_weights(std::span<const SpherePixel> pixels, std::size_t first, std::size_t last, double light,
                 const Footprint& f, SurfaceTables& t) {
  const auto in_phase = static_cast<std::size_t>(f.size) * static_cast<std::size_t>(f.size);
  std::vector<double> weights;
  std::size_t i = 0;
  for_each_pixel(f.size, f.phase_bits, [&](std::size_t row, std::size_t column, double, double) {
    const SpherePixel& pixel = pixels[i];
    if (i % in_phase == 0) {
      weights.clear();
      for (const SpherePixel& p : pixels.subspan(i, in_phase)) weights.push_back(p.edge * p.shade[first]);
      scale_to(weights, kWholeByte * light);
    }
    const double weight = weights[i++ % in_phase], shade = pixel.shade[first];
    const std::size_t at = row * static_cast<std::size_t>(f.row_bytes) + 3 * column;
    const std::uint8_t cover = pixel.edge > 0 && shade > 0 ? to_byte(std::min(kWholeByte, weight / shade)) : 0;
    std::fill(t.weights.begin() + static_cast<std::ptrdiff_t>(at + first),
              t.weights.begin() + static_cast<std::ptrdiff_t>(at + last), to_byte(weight));
    std::fill(t.cover.begin() + static_cast<std::ptrdiff_t>(at + first),
              t.cover.begin() + static_cast<std::ptrdiff_t>(at + last), cover);
  });
}

// Returns the mean shade over the disc that a sphere covers in the picture.
std::array<double, 3> mean_of(const SphereShades& shades) {
  constexpr int kSteps = 64;
  std::array<double, 3> sum{};
  int count = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double x = (2 * i + 1.0) / kSteps - 1, y = (2 * j + 1.0) / kSteps - 1;
      const double under = 1 - x * x - y * y;
      if (under < 0) continue;
      const auto shade = shades({x, y, std::sqrt(under)});
      for (std::size_t c = 0; c < 3; ++c) sum[c] += shade[c];
      ++count;
    }
  }
  for (double& number : sum) number /= count;
  return sum;
}

// Packs the factors of a shade's channels on its brightest one, which is `most` of 255.
std::uint32_t tint_of(const std::array<double, 3>& shade, std::uint32_t most) {
  std::uint32_t tint = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    tint |= std::uint32_t{to_byte(std::min(kWholeByte, kWholeByte * kWholeByte * shade[c] / most))} << (8 * c);
  }
  return tint;
}

SurfaceTables sphere_tables(const Sprite& sprite, float diameter, const Footprint& f, const View& view) {
  const int size = f.size, phase_bits = f.phase_bits, row_bytes = f.row_bytes;
  SurfaceTables t;
  const std::size_t rows = rows_of(size, phase_bits);
  t.weights.assign(rows * static_cast<std::size_t>(row_bytes), 0);
  t.cover = t.weights;
  t.covered.assign(rows, 0);
  const auto surface = static_cast<std::size_t>(surface_row(size));
  t.shade.assign((rows + 1) * surface, 0);
  t.bulge.assign((rows + 1) * surface, 0);
  const bool colored = lit_by_painter(sprite) && !has_grey_light(view);
  const bool tinted = colored || fogged_by_painter(sprite, view);
  const SphereShades shades = colored ? tinted_shades(view) : grey_shades(Daylight(view));
  if (tinted) t.tint.assign(t.shade.size(), 0);
  const double radius = 0.5 * diameter;
  std::vector<SpherePixel> pixels;
  for_each_pixel(size, phase_bits, [&](std::size_t row, std::size_t column, double x, double y) {
    const double distance = std::sqrt(x * x + y * y);
    const double edge = std::clamp(radius - distance + 0.5, 0.0, 1.0);
    const double shrink =
        distance < radius ? 1 / radius : 1 / distance; // outside the sphere: the direction at the rim
    const double nx = x * shrink, ny = -y * shrink;
    const double nz = std::sqrt(std::max(0.0, 1 - nx * nx - ny * ny));
    const std::array<double, 3> shade = shades({nx, ny, nz});
    pixels.push_back({edge, shade});
    if (distance >= radius) return;
    t.covered[row] |= static_cast<std::uint16_t>(1u << column);
    const double brightest = *std::max_element(shade.begin(), shade.end());
    const std::uint32_t at_least_1 = std::max<std::uint8_t>(
        1, tinted ? static_cast<std::uint8_t>(std::ceil(kWholeByte * brightest)) : to_byte(kWholeByte * brightest));
    t.shade[row * surface + column] = at_least_1 << kShadeShift;
    if (tinted) t.tint[row * surface + column] = tint_of(shade, at_least_1);
    t.bulge[row * surface + column] = static_cast<float>(nz);
  });
  const std::array<double, 3> mean = mean_of(shades);
  const std::size_t alike = tinted ? 1 : 3;
  for (std::size_t c = 0; c < 3; c += alike) {
    set_weights(pixels, c, c + alike, std::numbers::pi * radius * radius * mean[c], f, t);
  }
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
  s.mean_shade = static_cast<float>(mean_of(grey_shades(daylight))[0]);
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
    tables_ = sphere_tables(sprite_, diameter, f, view);
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
  const bool own = !tables_.weights.empty();
  s.weights = own ? tables_.weights.data() : footprint_in_use().weights.data();
  s.cover = own ? tables_.cover.data() : s.weights;
  s.covered = tables_.covered.data();
  s.shade = tables_.shade.empty() ? nullptr : tables_.shade.data();
  s.tint = tables_.tint.empty() ? nullptr : tables_.tint.data();
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
