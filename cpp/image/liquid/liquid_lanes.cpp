// Compiled once for each instruction set: see simd/simd.h for the rules.
#include "image/liquid/liquid_lanes.h"

#include "image/light/surface_lanes.h"
#include "image/raster/patch_lanes.h"
#include "image/tile_planes.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {
namespace {

constexpr float kNowhere = 1e30f;  // beyond any depth

// The first and the last of the numbers 0..count - 1 that a ball touches.
struct Reach {
  int first, last;

  Reach(int from, int to, int count) : first(from < 0 ? 0 : from), last(to < count ? to : count - 1) {}
};

MOTES_INLINE void add_depths(image::LiquidTile& tile, const image::LiquidBall& ball) {
  const Reach rows(-floor_of(ball.radius - ball.y), floor_of(ball.y + ball.radius), tile.height);
  const Reach columns(-floor_of(ball.radius - ball.x), floor_of(ball.x + ball.radius), tile.width);
  const float per_px = 1 / ball.radius;
  for (int x = columns.first; x <= columns.last; x += static_cast<int>(kLanes)) {
    const Floats across = (to_floats((Ints)lane_numbers() + x) - ball.x) * per_px, square = across * across;
    float* depth = tile.depth + rows.first * image::LiquidTile::kRow + x;
    std::uint32_t* thickness = tile.thickness + rows.first * image::LiquidTile::kRow + x;
    for (int y = rows.first; y <= rows.last;
         ++y, depth += image::LiquidTile::kRow, thickness += image::LiquidTile::kRow) {
      const float down = (static_cast<float>(y) - ball.y) * per_px;
      const Floats bulge = sqrt(max((1.0f - down * down) - square, Floats{}));
      const Floats front = select(bulge > 0.0f, ball.depth - bulge * tile.radius, all(2 * kNowhere));
      store(depth, min(front, load(depth)));
      const Ints thick = to_ints(bulge * static_cast<float>(image::kThickness));
      store_uints(thickness, load_uints(thickness) + (Uints)thick);
    }
  }
}

// Adds to the cells that the ball touches, the more the nearer they are to its centre.
MOTES_INLINE void add_means(image::LiquidTile& tile, const image::LiquidBall& ball) {
  using Mean = image::LiquidMean;
  using Values = std::uint32_t __attribute__((vector_size(4 * Mean::kRoom)));
  using Sums = std::uint64_t __attribute__((vector_size(8 * Mean::kRoom)));
  constexpr int kCell = image::kLiquidCell;
  const auto cell = [](float px) { return floor_of((px + 0.5f) * (1.0f / kCell)); };
  const auto cells = [](int pixels) { return (pixels + kCell - 1) / kCell; };
  const Reach rows(cell(ball.y - ball.radius), cell(ball.y + ball.radius), cells(tile.height));
  const Reach columns(cell(ball.x - ball.radius), cell(ball.x + ball.radius), cells(tile.width));
  const float per_px = 1 / ball.radius;
  const auto square_beyond = [&](float center, int at) {
    const float low = static_cast<float>(at * kCell) - 0.5f, high = low + kCell;
    const float beyond = (center - (center < low ? low : center > high ? high : center)) * per_px;
    return beyond * beyond;
  };
  Values values;
  __builtin_memcpy(&values, ball.values, sizeof values);
  for (int y = rows.first; y <= rows.last; ++y) {
    const float down = square_beyond(ball.y, y);
    for (int x = columns.first; x <= columns.last; ++x) {
      const float rest = 1 - (square_beyond(ball.x, x) + down);
      if (!(rest > 0)) continue;
      const auto part = static_cast<std::uint32_t>(static_cast<std::int32_t>(rest * rest * 255 + 1));
      std::uint64_t* to = tile.cells + (y * image::kTileCells + x) * Mean::kRoom;
      Sums sums;
      __builtin_memcpy(&sums, to, sizeof sums);
      sums += __builtin_convertvector(values * part, Sums);
      __builtin_memcpy(to, &sums, sizeof sums);
    }
  }
}

void splat(image::LiquidTile& tile, const image::LiquidBall* balls, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    add_depths(tile, balls[i]);
    add_means(tile, balls[i]);
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

// Means over particles.
struct Means {
  Floats3 color;  // 0..1
  Floats alpha, speed;
};

// Interpolates a row's sums between the centres of cells.
MOTES_INLINE Means means_at(const image::LiquidRow& row, int i) {
  using Mean = image::LiquidMean;
  constexpr int kCell = image::kLiquidCell;
  // From the centre of the first cell, in half px.
  const Ints half = ((Ints)lane_numbers() + (row.first + i)) * 2 + (1 - kCell);
  const Ints left = min_ints(max_ints(half, Ints{}) / (2 * kCell), all_ints(row.cells - 1));
  const Floats right = min(max(to_floats(half - left * (2 * kCell)) * (0.5f / kCell), Floats{}), all(1.0f));
  const auto sum = [&](int k) __attribute__((always_inline)) {
    const Pair sums = gather_pairs(row.sums[k], left);
    return sums.first * (1.0f - right) + sums.second * right;
  };
  const Floats weight = sum(Mean::weight), part = only(weight > 0.0f, 1.0f / (weight * 255.0f));
  return {{sum(Mean::red) * part, sum(Mean::green) * part, sum(Mean::blue) * part},
          sum(Mean::alpha) * part,
          sum(Mean::speed) * part};
}

// Returns the light of the liquid at a vector of pixels.
MOTES_INLINE Floats3 shaded(const image::LiquidLook& look, const image::LiquidRow& row, int i, const Place& p) {
  constexpr float kDeep = 12;  // radii of particles at which the liquid has its colour
  const image::SurfaceLight& t = *look.light;
  const Floats full = to_floats((Ints)load_uints(row.thickness + i)) * look.metres;
  const Floats thick = min(full, max(load(row.opaque + i) - p.depth, Floats{}));
  const Floats3 place = in_world(t, p.place), normal = in_world(t, p.normal);
  const Floats3 eye = place * (-1.0f / sqrt(max(dot(place, place), all(1e-30f))));
  const Floats facing = dot(normal, eye), mirrored = fresnel(look, facing);
  const Floats3 out = normal * (2.0f * facing) - eye;
  const Floats3 sky = t.sky.kind == image::Sky::Kind::none ? ambient_at(t.ambient, out) : sky_light(t.sky, out, p.seen);
  const Means mean = means_at(row, i);
  const Floats3 color = mean.color;
  const Floats3 light = light_on(t, {p.place, p.normal});
  // Through the liquid: what is behind, tinted, and the liquid's own colour the deeper it is.
  const Floats deep = thick * (1.0f / (kDeep * look.radius));
  const Floats clear = fading(deep * mean.alpha);
  const Floats most = all(image::kMostShift * static_cast<float>(look.height));
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
    const Floats fast = min(mean.speed * look.per_foam, all(1.0f));
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
  if (!any(p.seen & (cover < 1.0f))) return shown;
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
