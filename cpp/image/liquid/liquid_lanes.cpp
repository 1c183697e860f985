// Compiled once for each instruction set: see simd/simd.h for the rules.
#include "image/liquid/liquid_lanes.h"

#include "image/light/surface_lanes.h"
#include "image/tile_planes.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {
namespace {

constexpr float kNowhere = 1e30f;  // beyond any depth

void splat(const image::BallRow& ball, float* __restrict depth, std::uint32_t* __restrict thickness, int count) {
  const float x = ball.x, per_px = ball.per_px, rest = ball.rest, middle = ball.depth, radius = ball.radius;
  for (int i = 0; i < count; ++i) {
    const float across = (static_cast<float>(i) - x) * per_px;
    const float square = rest - across * across;
    const float bulge = __builtin_sqrtf(square > 0 ? square : 0);
    const float front = bulge > 0 ? middle - bulge * radius : 2 * kNowhere;
    depth[i] = front < depth[i] ? front : depth[i];
    thickness[i] += static_cast<std::uint32_t>(static_cast<std::int32_t>(bulge * image::kThickness));
  }
}

void smooth(float* __restrict to, const float* at, const float* const (&pairs)[4], float jump, float farthest,
            int count) {
  const float *a = pairs[0], *b = pairs[1], *c = pairs[2], *d = pairs[3];
  for (int i = 0; i < count; ++i) {
    const float middle = at[i];
    const float near = (a[i] - middle) + (b[i] - middle), far = (c[i] - middle) + (d[i] - middle);
    const float kept_near = __builtin_fabsf(near) < jump ? near : 0;
    const float kept_far = __builtin_fabsf(far) < jump ? far : 0;
    const float moved = middle + (4 * kept_near + kept_far) * (1.0f / 16);
    to[i] = middle <= farthest ? moved : middle;
  }
}

// A vector of pixels of a row, and the liquid's surface there.
struct Place {
  Mask seen;
  Floats depth;
  Floats3 place, normal;  // in the camera's axes: right, up, back
};

// Returns the slope to the side where the depth changes less; 0 if there is no liquid on either side.
MOTES_INLINE Floats slope(Floats before, Floats at, Floats after) {
  const Floats back = at - before, ahead = after - at;
  const Floats least = select(abs(back) < abs(ahead), back, ahead);
  return select(abs(least) < kNowhere, least, Floats{});
}

MOTES_INLINE Place place_at(const image::LiquidLook& look, const image::LiquidRow& row, int i, Mask inside) {
  Place p;
  p.depth = load(row.depth + i);
  p.seen = inside & (p.depth < kNowhere) & (p.depth <= load(row.opaque + i));
  const Floats depth = select(p.seen, p.depth, all(1.0f));
  const Floats column = to_floats((Ints)lane_numbers() + (row.first + i));
  const Floats x = (column + 0.5f - look.center_x) * look.per_px;
  const Floats y = all((look.center_y - 0.5f - static_cast<float>(row.y)) * look.per_px);
  p.place = {x * depth, y * depth, -depth};
  // Derivatives of the place along the row and up the column, per px.
  const Floats dx = select(p.seen, slope(load(row.depth + i - 1), p.depth, load(row.depth + i + 1)), Floats{});
  const Floats dy = select(p.seen, slope(load(row.below + i), p.depth, load(row.above + i)), Floats{});
  const Floats step = depth * look.per_px;
  const Floats3 right = {step + x * dx, y * dx, -dx}, up = {x * dy, step + y * dy, -dy};
  const Floats3 n = cross(right, up);
  p.normal = n * (1.0f / sqrt(max(dot(n, n), all(1e-30f))));
  return p;
}

MOTES_INLINE Floats fresnel(const image::LiquidLook& look, Floats cosine) {
  const Floats rest = 1.0f - min(max(cosine, Floats{}), all(1.0f));
  const Floats square = rest * rest;
  return look.reflected + (1.0f - look.reflected) * (square * square * rest);
}

// Returns the highlight of a light in the direction `toward`, a unit vector; all in the world's axes.
MOTES_INLINE Floats highlight(const image::LiquidLook& look, Floats3 normal, Floats3 eye, Floats3 toward) {
  constexpr float kBright = 24;  // the lobe's light is nearly that of a mirror
  const Floats3 sum = eye + toward;
  const Floats3 half = sum * (1.0f / sqrt(max(dot(sum, sum), all(1e-12f))));
  Floats facing = max(dot(normal, half), Floats{});
  for (int i = 0; i < 8; ++i) facing = facing * facing;  // to the 256th power
  return only(dot(normal, toward) > 0.0f, facing * fresnel(look, dot(half, toward)) * kBright);
}

MOTES_INLINE Floats3 highlights(const image::LiquidLook& look, Floats3 place, Floats3 normal, Floats3 eye) {
  const image::SurfaceLight& t = *look.light;
  Floats3 light{};
  if (t.sun.shines) light = all3(t.sun.color) * highlight(look, normal, eye, all3(t.sun.toward));
  for (std::size_t k = 0; k < t.count; ++k) {
    const image::Lamp& lamp = t.lamp[k];
    const Floats3 along = all3(lamp.position) - place;
    const Floats square = max(dot(along, along), all(1e-6f));
    Floats part = highlight(look, normal, eye, along * (1.0f / sqrt(square))) / square;
    if (lamp.per_cosine > 0) part *= in_cone(lamp, along, square);
    light = light + all3(lamp.color) * part;
  }
  return light;
}

// Returns the picture behind, seen `right` and `down` px beside each pixel, unless something in front of the liquid is
// there; 1 is white.
MOTES_INLINE Floats3 seen_behind(const image::LiquidLook& look, const image::LiquidRow& row, int i, const Place& p,
                                 Floats right, Floats down) {
  const Ints x = to_ints(min(max(to_floats((Ints)lane_numbers() + (row.first + i)) + right + 0.5f, Floats{}),
                             all(static_cast<float>(look.width - 1))));
  const Ints y =
      to_ints(min(max(down + (static_cast<float>(row.y) + 0.5f), Floats{}), all(static_cast<float>(look.height - 1))));
  Floats3 light{};
  constexpr float kPart = 1.0f / image::kUnit;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (p.seen[lane] == 0) continue;
    std::ptrdiff_t column = x[lane], line = y[lane];
    if (look.opaque[line * look.opaque_row + column] < p.depth[lane]) {
      column = row.first + i + static_cast<int>(lane);
      line = row.y;
    }
    const std::uint32_t* from = look.behind + 3 * (line * look.width + column);
    set_lane(light, lane,
             Float3{static_cast<float>(from[0]) * kPart, static_cast<float>(from[1]) * kPart,
                    static_cast<float>(from[2]) * kPart});
  }
  return light;
}

MOTES_INLINE Floats3 times(Floats3 a, Floats3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

MOTES_INLINE Floats fading(Floats by) { return exp(-min(max(by, Floats{}), all(80.0f))); }

// Returns the light of the liquid at a vector of pixels.
MOTES_INLINE Floats3 shaded(const image::LiquidLook& look, const image::LiquidRow& row, int i, const Place& p) {
  constexpr float kDeep = 12;  // radii of particles at which the liquid has its colour
  constexpr float kMostShift = 0.05f;  // of the picture's height
  const image::SurfaceLight& t = *look.light;
  const Floats full = to_floats((Ints)load_uints(row.thickness + i)) * look.metres;
  const Floats thick = min(full, max(load(row.opaque + i) - p.depth, Floats{}));
  const Floats3 place = in_world(t, p.place), normal = in_world(t, p.normal);
  const Floats3 eye = place * (-1.0f / sqrt(max(dot(place, place), all(1e-30f))));
  const Floats facing = dot(normal, eye), mirrored = fresnel(look, facing);
  const Floats3 out = normal * (2.0f * facing) - eye;
  const Floats3 sky = t.sky.kind == image::Sky::Kind::none ? ambient_at(t.ambient, out) : sky_light(t.sky, out, p.seen);
  const Floats3 color = {load(row.red + i), load(row.green + i), load(row.blue + i)};
  const Floats3 light = light_on(t, {p.place, p.normal});
  // Through the liquid: what is behind, tinted, and the liquid's own colour the deeper it is.
  const Floats deep = thick * (1.0f / (kDeep * look.radius));
  const Floats clear = fading(deep * load(row.alpha + i));
  const Floats most = all(kMostShift * static_cast<float>(look.height));
  const Floats shift = thick * look.bend / (p.depth * look.per_px);
  const Floats right = min(max(-(p.normal.x * shift), -most), most);
  const Floats down = min(max(p.normal.y * shift, -most), most);
  const Floats3 tint = {fading(deep * (1.0f - color.x)), fading(deep * (1.0f - color.y)),
                        fading(deep * (1.0f - color.z))};
  const Floats3 through = times(seen_behind(look, row, i, p, right, down), tint) * clear;
  const Floats3 own = times(color, light) * (1.0f - clear);
  const Floats passed = 1.0f - mirrored;
  Floats3 shown = own * passed + sky * mirrored + highlights(look, place, normal, eye);
  Floats kept = passed;
  if (look.per_foam > 0) {
    const Floats fast = min(load(row.speed + i) * look.per_foam, all(1.0f));
    const Floats white = fast * fast;
    shown = shown * (1.0f - white) + light * white;
    kept *= 1.0f - white;
  }
  if (t.fog_density > 0) {
    const Floats far = sqrt(dot(place, place)) * t.fog_density, seen = fading(far);
    shown = shown * seen + all3(t.fog) * ((1.0f - seen) * (1.0f - kept * clear));
  }
  shown = shown + through * kept;
  // Thin edges let all light pass.
  const Floats cover = min(full * (1.0f / (0.7f * look.radius)), all(1.0f));
  return shown * cover + seen_behind(look, row, i, p, Floats{}, Floats{}) * (1.0f - cover);
}

void shade(const image::LiquidLook& look, const image::LiquidRow& row) {
  constexpr float kMost = 2000;
  for (int i = 0; i < row.count; i += static_cast<int>(kLanes)) {
    const Place p = place_at(look, row, i, first_lanes(static_cast<std::size_t>(row.count - i)));
    if (!any(p.seen)) continue;
    const Floats3 light = shaded(look, row, i, p);
    const Floats most = all(kMost), unit = all(static_cast<float>(image::kUnit));
    const Ints sums[3] = {to_ints(min(max(light.x, Floats{}), most) * unit + 0.5f),
                          to_ints(min(max(light.y, Floats{}), most) * unit + 0.5f),
                          to_ints(min(max(light.z, Floats{}), most) * unit + 0.5f)};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (p.seen[lane] == 0) continue;
      std::uint32_t* to = row.light + 3 * (i + static_cast<int>(lane));
      for (std::size_t c = 0; c < 3; ++c) to[c] = static_cast<std::uint32_t>(sums[c][lane]);
    }
  }
}

}  // namespace

extern const image::LiquidLanes liquid_lanes{splat, smooth, shade};

}  // namespace motes::MOTES_ISA
