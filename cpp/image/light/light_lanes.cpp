// Compiled once for each instruction set: see simd/simd.h for the rules.
#include "image/light/light_lanes.h"

#include "image/light/depth_sight.h"
#include "image/light/lamp_lanes.h"
#include "image/light/particle_lanes.h"
#include "image/light/shadow_lanes.h"
#include "image/light/sky_lanes.h"
#include "simd/elementary.h"
#include "simd/floats3.h"
#include "simd/rotations.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {
namespace {

constexpr float kHalfTurnRadians = 3.14159265359f;
constexpr float kMostFloat = 3.402823466e38f;
constexpr int kColumns = image::kShadowColumns;

// Returns the mean light over the visible disc of a sphere that is lit at an angle a to the eye's direction:
// 2 / (3 pi) (sin a + (pi - a) cos a) (J. H. Lambert).
MOTES_INLINE Floats of_sphere(Floats cosine) {
  const Floats c = min(max(cosine, all(-1.0f)), all(1.0f));
  const Floats sine = sqrt(max(1.0f - c * c, Floats{}));
  return max(0.21220659f * (sine + (kHalfTurnRadians - acos(c)) * c), Floats{});
}

MOTES_INLINE Floats light_left(const image::Lighting& t, const image::Obstacles& o, Floats3 place, Floats diameter) {
  if (o.shadow == nullptr) return all(1.0f);
  Floats left = all(1.0f);
  if (o.shadow->left != nullptr) {
    const Floats back = t.own_shadow > 0 ? own_shadow(o.shadow->space, place, diameter) : Floats{};
    left = light_through(*o.shadow, place, back);
  }
  if (o.shadow->sharp.texels != nullptr) {
    const Floats reach = diameter * t.reach;
    left *= light_past(o.shadow->sharp, place, reach * 1.05f, reach);
  }
  return left;
}

// The lit surface of a particle: the visible side of a card, or a ball.
struct LitSide {
  bool flat;
  Floats3 normal;  // of a ball: direction to the eye

  MOTES_INLINE Floats from(Floats cosine) const { return flat ? max(cosine, Floats{}) : of_sphere(cosine); }
  MOTES_INLINE Floats3 ambient(const image::Ambient& a) const {
    return flat ? ambient_at(a, normal) : ambient_at(a, normal, 0.66666667f, 0.25f);
  }
};

MOTES_INLINE LitSide lit_side(const image::LitShape& c, std::size_t i, Floats3 to_eye) {
  using Kind = image::LitShape::Kind;
  if (c.kind == Kind::ball) return {false, to_eye};
  Floats3 normal;
  if (c.kind == Kind::card_along_velocity) {
    const Floats3 way{value_or(c.velocity[0], i, c.velocity_of_all[0]),
                      value_or(c.velocity[1], i, c.velocity_of_all[1]),
                      value_or(c.velocity[2], i, c.velocity_of_all[2])};
    const Floats speed = sqrt(dot(way, way));
    const Mask moves = (speed > 1e-15f) & (speed < 1e15f);
    normal = select(moves, way * (1.0f / select(moves, speed, all(1.0f))), to_eye);
  } else {
    normal = turned_z(unit(Rotations{value_or(c.orientation[0], i, c.orientation_of_all[0]),
                                     value_or(c.orientation[1], i, c.orientation_of_all[1]),
                                     value_or(c.orientation[2], i, c.orientation_of_all[2]),
                                     value_or(c.orientation[3], i, c.orientation_of_all[3])}));
  }
  return {true, normal * select(dot(normal, to_eye) < 0.0f, all(-1.0f), all(1.0f))};
}

// Returns the light that a white particle sends to the eye; if t.relative, the part of it that obstacles leave. `at`:
// the particle's index in the in_sight planes.
MOTES_INLINE Floats3 light_arriving(const image::Lighting& t, Floats3 place, const LitSide& side, Floats diameter,
                                    std::size_t at) {
  Floats3 light = side.ambient(t.ambient), all_light = light;
  if (t.sky != nullptr) {
    const auto weight = [&](Floats cosine) { return side.flat ? max(cosine, Floats{}) : 0.5f + 0.5f * cosine; };
    light = light * sky_past(*t.sky, place, side.normal, diameter * (1.05f * t.reach), weight);
  }
  const auto add = [&](Floats3 more, const image::Obstacles& obstacles) __attribute__((always_inline)) {
    const Floats part = light_left(t, obstacles, place, diameter) * value_or(obstacles.in_sight, at, 1);
    light = light + more * part;
    if (t.relative) all_light = all_light + more;
  };
  if (t.sun.shines) {
    add(all3(t.sun.color) * side.from(dot(side.normal, all3(t.sun.toward))), t.sun_obstacles);
  }
  for (std::size_t k = 0; k < t.light_count; ++k) {
    const image::Lamp& lamp = t.lights[k].lamp;
    const Floats3 along = all3(lamp.position) - place;
    const Floats square = max(dot(along, along), all(1e-6f));
    Floats facing = side.from(dot(along, side.normal) / sqrt(square));
    if (lamp.per_cosine > 0) facing *= in_cone(lamp, along, square);
    add(all3(lamp.color) * (facing / square), t.lights[k].obstacles);
  }
  if (!t.relative) return light;
  const auto part = [](Floats a, Floats b) { return a / max(b, all(1e-6f)); };
  return {part(light.x, all_light.x), part(light.y, all_light.y), part(light.z, all_light.z)};
}

// Returns the factor, at least 1, by which a colour exceeds the brightest one that a particle can have.
MOTES_INLINE Floats excess(Floats3 color, Floats opacity) {
  const Floats most = max(max(color.x, color.y), color.z) * opacity;
  return min(max(most, all(1.0f)), all(kMostFloat));
}
// Dims colours that exceed the brightest one that a particle can have, keeping their hue.
MOTES_INLINE Floats3 within_white(Floats3 color, Floats opacity) { return color * (1.0f / excess(color, opacity)); }

void light_particles(const image::LightTask& t, std::size_t first, std::size_t last, float* const* to) {
  const image::ParticlePlanes& p = t.particles;
  const bool gains = t.lighting != nullptr && t.lighting->gains;
  for (std::size_t i = first; i < last; i += kLanes) {
    const Floats3 place = particle_place(p, i);
    Floats3 color{value_or(p.color[0], i, p.color_of_all[0]), value_or(p.color[1], i, p.color_of_all[1]),
                  value_or(p.color[2], i, p.color_of_all[2])};
    const Floats3 offset = all3(t.width.eye) - place;
    const Floats distance = length_of_way(offset);
    const auto seen = [&] {
      return t.adds ? min(max(value_or(p.alpha, i, p.alpha_of_all), Floats{}), all(1.0f)) : all(1.0f);
    };
    if (t.lighting != nullptr) {
      const LitSide side = lit_side(t.lighting->shape, i, offset * (1.0f / distance));
      const Floats3 light = light_arriving(*t.lighting, place, side, diameter_at(t.width, p, place, i), i - first);
      color = {color.x * light.x, color.y * light.y, color.z * light.z};
      if (!gains) color = within_white(color, seen());
    }
    if (t.fog_density > 0) {
      const Floats clear = exp(-min(distance * t.fog_density, all(80.0f)));
      const Floats fog = t.adds ? Floats{} : 1.0f - clear;
      color = color * clear + all3(t.fog) * fog;
    }
    if (gains) {
      store(to[3] + (i - first), excess(color, seen()));
      color = within_white(color, seen());
    }
    store(to[0] + (i - first), color.x);
    store(to[1] + (i - first), color.y);
    store(to[2] + (i - first), color.z);
  }
}

// A vector of particles that may cast shadows: their opacity, and which of them count.
struct ShadowCaster {
  Floats3 place;
  Floats opacity;
  Mask counts;
};
MOTES_INLINE ShadowCaster caster_at(const image::ShadowTask& t, std::size_t i, std::size_t last) {
  const image::ParticlePlanes& p = t.particles;
  const Floats3 place = particle_place(p, i);
  const Floats alpha = min(max(value_or(p.alpha, i, p.alpha_of_all), Floats{}), all(1.0f));
  Mask counts = finite(place) & (alpha > 0.0f);
  if (last - i < kLanes) counts &= first_lanes(last - i);
  return {only(counts, place), alpha * t.shadow, counts};
}

// Returns the optical depth, in 1 / kShadowUnit, of a column of which a particle of this opacity covers a part.
MOTES_INLINE Floats optical_depth(Floats part, Floats opacity) {
  const Floats kept = min(part, all(1.0f)) * opacity;
  const Floats faint = kept + kept * kept * 0.5f;  // where the logarithm would lose digits
  if (!any(kept >= 1e-3f)) return faint * image::kShadowUnit;
  return select(kept < 1e-3f, faint, -log(max(1.0f - kept, all(1e-4f)))) * image::kShadowUnit;
}

MOTES_INLINE Ints within(Ints at, int count) { return min_ints(max_ints(at, Ints{}), all_ints(count - 1)); }

// The two layers around particles, and the part of their depth that the farther one gets.
struct Layers {
  Ints near, far;  // indices of their first cells
  Floats beyond;
};
MOTES_INLINE Layers layers_of(const InBox& at) {
  const Floats from = at.layer + 0.5f;  // above 0
  const Ints k = to_ints(from), base = at.box * image::kShadowLayers;
  const auto first = [&](Ints layer) { return (base + within(layer, image::kShadowLayers)) * (kColumns * kColumns); };
  return {first(k - 1), first(k), from - to_floats(k)};
}

// Optical depths of a vector of particles, divided among the eight cells around each: pairs of cells along a row, in
// two rows of two layers.
struct Shares {
  unsigned lanes = 0;  // one bit per particle that counts
  std::int32_t cell[4][kLanes], next[kLanes];  // first cell of each pair, and offset of the second
  std::int32_t depth[8][kLanes];
};

// Divides particles of `area` cells.
MOTES_INLINE void share_depths(const InBox& at, Floats area, Floats opacity, unsigned lanes, Shares& to) {
  const Floats u = at.column + 0.5f, v = at.row + 0.5f;
  const Ints i = to_ints(u), j = to_ints(v);
  const Floats right = u - to_floats(i), below = v - to_floats(j);
  const Layers layers = layers_of(at);
  const Ints first = within(i - 1, kColumns);
  store_mask(to.next, within(i, kColumns) - first);
  for (int b = 0; b < 2; ++b) {
    const Floats in_row = area * (b == 0 ? 1.0f - below : below);
    const Ints row = within(j - 1 + b, kColumns) * kColumns + first;
    const Floats left_depth = optical_depth(in_row * (1.0f - right), opacity);
    const Floats right_depth = optical_depth(in_row * right, opacity);
    for (int c = 0; c < 2; ++c) {
      const Floats in_layer = c == 0 ? 1.0f - layers.beyond : layers.beyond;
      const int pair = 2 * c + b;
      store_mask(to.cell[pair], (c == 0 ? layers.near : layers.far) + row);
      store_mask(to.depth[2 * pair], to_ints(left_depth * in_layer + 0.5f));
      store_mask(to.depth[2 * pair + 1], to_ints(right_depth * in_layer + 0.5f));
    }
  }
  to.lanes = lanes;
}

MOTES_INLINE void prefetch(const std::int64_t* sums, const Shares& shares) {
  for (unsigned lanes = shares.lanes; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(__builtin_ctz(lanes));
    for (const std::int32_t (&cell)[kLanes] : shares.cell) __builtin_prefetch(sums + cell[lane], 1);
  }
}

MOTES_INLINE void add(std::int64_t* sums, const Shares& shares) {
  for (unsigned lanes = shares.lanes; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(__builtin_ctz(lanes));
    for (std::size_t pair = 0; pair < 4; ++pair) {
      std::int64_t* const to = sums + shares.cell[pair][lane];
      to[0] += shares.depth[2 * pair][lane];
      to[shares.next[lane]] += shares.depth[2 * pair + 1][lane];
    }
  }
}

// A disc across the light's rays, in cells of a box.
struct WideCaster {
  float column, row, radius, opacity, beyond;
  std::int32_t near, far;  // as in Layers

  // Returns the part of each of a vector of columns that it covers, before that is normalised.
  MOTES_INLINE Floats cover(int first, int at_row, int columns) const {
    const Floats number = to_floats((Ints)lane_numbers() + first);
    const Floats x = number + (0.5f - column), y = all(static_cast<float>(at_row) + 0.5f - row);
    const Floats part = min(max(radius + 0.5f - sqrt(x * x + y * y), Floats{}), all(1.0f));
    return only(number < static_cast<float>(columns), part);
  }
};

MOTES_INLINE int added(Ints numbers) {
  int sum = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) sum += numbers[lane];
  return sum;
}

__attribute__((noinline)) void add_wide(const WideCaster& wide, std::int64_t* sums) {
  constexpr float kUnit = 4096;
  const auto low = [](float at) { return at > 0 ? static_cast<int>(at) : 0; };
  const auto high = [](float at) { return at + 1 < kColumns ? static_cast<int>(at) + 1 : kColumns; };
  const float reach = wide.radius + 0.5f;
  const int left = low(wide.column - reach), right = high(wide.column + reach);
  const int top = low(wide.row - reach), bottom = high(wide.row + reach);
  constexpr int kStep = static_cast<int>(kLanes);
  Ints whole{}, partly{};  // in integers: their sum does not depend on the number of lanes
  for (int row = top; row < bottom; ++row) {
    for (int column = left; column < right; column += kStep) {
      const Floats cover = wide.cover(column, row, right);
      whole -= cover >= 1.0f;
      partly += to_ints(only(cover < 1.0f, cover) * kUnit + 0.5f);
    }
  }
  // The cells at its rim make up for the difference to its area, unless it reaches beyond the box.
  const bool inside =
      wide.column >= reach && wide.column + reach <= kColumns && wide.row >= reach && wide.row + reach <= kColumns;
  const float rim = kHalfTurnRadians * wide.radius * wide.radius - static_cast<float>(added(whole));
  const float scale = inside && any(partly > 0) ? rim * kUnit / static_cast<float>(added(partly)) : 1;
  for (int row = top; row < bottom; ++row) {
    for (int column = left; column < right; column += kStep) {
      const Floats cover = wide.cover(column, row, right);
      const Floats depth = optical_depth(select(cover >= 1.0f, cover, cover * scale), all(wide.opacity));
      const Ints near = to_ints(depth * (1.0f - wide.beyond) + 0.5f), far = to_ints(depth * wide.beyond + 0.5f);
      const int number = right - column < kStep ? right - column : kStep;
      for (int lane = 0; lane < number; ++lane) {
        const int cell = row * kColumns + column + lane;
        sums[wide.near + cell] += near[lane];
        sums[wide.far + cell] += far[lane];
      }
    }
  }
}

unsigned add_depths(const image::ShadowTask& t, const image::ShadowSpace& space, std::size_t first, std::size_t last,
                    std::int64_t* sums) {
  Shares shares[2];  // cells of one are prefetched while the other is computed
  int now = 0;
  Ints boxes{};
  for (std::size_t i = first; i < last; i += kLanes) {
    const ShadowCaster c = caster_at(t, i, last);
    const InLattice lattice = in_lattice(space, c.place);
    const Floats across = diameter_at(t.width, t.particles, c.place, i) / lattice.width;
    const InBox at = box_of_caster(space, lattice, across);
    const Mask counts = c.counts & at.known & (across > 0.0f) & (across <= kMostFloat);
    if (!any(counts)) continue;
    boxes |= (all_ints(1) << at.box) & counts;
    const Floats wide = across / at.cell;
    const Mask few = wide <= kFewCells;
    share_depths(at, wide * wide * (kHalfTurnRadians / 4), c.opacity, bits_of(counts & few), shares[now]);
    prefetch(sums, shares[now]);
    now = 1 - now;
    add(sums, shares[now]);
    shares[now].lanes = 0;
    if (!any(counts & ~few)) continue;
    const Layers layers = layers_of(at);
    for (unsigned lanes = bits_of(counts & ~few); lanes != 0; lanes &= lanes - 1) {
      const auto k = static_cast<std::size_t>(__builtin_ctz(lanes));
      add_wide({at.column[k], at.row[k], 0.5f * wide[k], c.opacity[k], layers.beyond[k], layers.near[k], layers.far[k]},
               sums);
    }
  }
  add(sums, shares[1 - now]);
  unsigned used = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) used |= static_cast<unsigned>(boxes[lane]);
  return used;
}

void keep_ball(const image::DepthBall& ball, float* texels) {
  const image::DepthBall b = ball;
  constexpr int kStep = static_cast<int>(kLanes);
  const float x = b.center[0], y = b.center[1], z = b.center[2];
  for (int row = b.rows[0]; row <= b.rows[1]; ++row) {
    const float v = b.top + static_cast<float>(row) * b.step;
    float* const to = texels + row * image::kDepthPage;
    for (int column = b.columns[0] & ~(kStep - 1); column <= b.columns[1]; column += kStep) {
      const Floats u = to_floats((Ints)lane_numbers() + column) * b.step + b.left;
      Floats rest, depth;
      if (b.point) {
        // A ray along (u, v, 1), and the part of the way to the centre that is at right angles to it.
        const Floats square = u * u + (v * v + 1.0f), along = u * x + (v * y + z);
        const Floats3 aside{all(y - v * z), u * z - x, v * x - u * y};
        rest = b.square - dot(aside, aside) / square;
        depth = (along - sqrt(max(rest, Floats{}) * square)) / square;
        rest = select(along > 0.0f, rest, all(-1.0f));
      } else {
        const Floats right = u - x;
        rest = (b.square - (v - y) * (v - y)) - right * right;
        depth = z - sqrt(max(rest, Floats{}));
      }
      const Floats here = load(to + column);
      store(to + column, select((rest > 0.0f) & (-depth > here), -depth, here));
    }
  }
}

void let_through(float* depths, std::size_t count) {
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) store(depths + i, exp(-min(load(depths + i), all(80.0f))));
  static_assert(image::ShadowGrids::kLayer % kLanes == 0);
}

}  // namespace

extern const image::LightLanes light_lanes = {light_particles, add_depths, keep_ball, let_through};

}  // namespace motes::MOTES_ISA
