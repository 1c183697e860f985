// Compiled once for each instruction set: see simd/simd.h for the rules.
#include "image/light/light_lanes.h"

#include "image/daylight_parts.h"
#include "image/light/particle_lanes.h"
#include "image/light/shadow_lanes.h"
#include "simd/elementary.h"
#include "simd/floats3.h"
#include "simd/rotations.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {
namespace {

constexpr auto kSunOnParticles = static_cast<float>(image::kSun);
constexpr float kHalfTurnRadians = 3.14159265359f;
constexpr float kMostFloat = 3.402823466e38f;

// Returns the mean light over the visible disc of a sphere that is lit at an angle a to the eye's direction:
// 2 / (3 pi) (sin a + (pi - a) cos a) (J. H. Lambert).
MOTES_INLINE Floats of_sphere(Floats cosine) {
  const Floats c = min(max(cosine, all(-1.0f)), all(1.0f));
  const Floats sine = sqrt(max(1.0f - c * c, Floats{}));
  return max(0.21220659f * (sine + (kHalfTurnRadians - acos(c)) * c), Floats{});
}

// Returns how many layers towards the light a particle's own optical depth reaches; a particle must not shade itself.
MOTES_INLINE Floats own_layers(const image::Lighting& t, const image::ShadowMap& map, Floats3 place, Floats diameter) {
  if (!(t.own_shadow > 0)) return Floats{};
  const Floats width = in_grid(map.space, place).width, wide = diameter * 0.6f;
  Floats layers = all(1.0f);
  for (int level = 1; level < image::kShadowLevels; ++level) {
    const float scale = static_cast<float>(1 << (level - 1));
    layers = select(wide > width * scale, all(2 * scale), layers);
  }
  return layers;
}

MOTES_INLINE Floats light_left(const image::Lighting& t, const image::Obstacles& o, Floats3 place, Floats diameter) {
  if (o.shadow == nullptr) return all(1.0f);
  return light_through(*o.shadow, place, own_layers(t, *o.shadow, place, diameter));
}

MOTES_INLINE Floats3 ambient_at(const image::Ambient& a, Floats up) {
  return all3(a.low) * (1.0f - up) + all3(a.high) * up;
}

// The lit surface of a particle: the visible side of a card, or a ball.
struct LitSide {
  bool flat;
  Floats3 normal;  // of a ball: direction to the eye

  MOTES_INLINE Floats from(Floats cosine) const { return flat ? max(cosine, Floats{}) : of_sphere(cosine); }
  // Over the visible disc of a sphere, the mean normal is two thirds of the direction to the eye.
  MOTES_INLINE Floats up() const { return 0.5f + normal.y * (flat ? 0.5f : 0.33333333f); }
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

// Returns the light that a white particle sends to the eye; if t.relative, its ratio to that of sun and sky without
// shadows. `at`: the particle's index in the in_sight planes.
MOTES_INLINE Floats3 light_arriving(const image::Lighting& t, Floats3 place, const LitSide& side, Floats diameter,
                                    std::size_t at) {
  Floats3 light = ambient_at(t.ambient, side.up());
  Floats sunlight{};
  if (t.sun != nullptr) {
    sunlight = side.from(dot(side.normal, all3(t.sun))) * kSunOnParticles;
    const Floats sun =
        sunlight * light_left(t, t.sun_obstacles, place, diameter) * value_or(t.sun_obstacles.in_sight, at, 1);
    light = light + Floats3{sun, sun, sun};
  }
  const Floats3 plain = ambient_at(t.ambient, side.up()) + Floats3{sunlight, sunlight, sunlight};
  for (std::size_t k = 0; k < t.light_count; ++k) {
    const image::LightOnParticles& lamp = t.lights[k];
    const Floats3 along = all3(lamp.position) - place;
    const Floats square = max(dot(along, along), all(1e-6f));
    const Floats facing = side.from(dot(along, side.normal) / sqrt(square));
    const Floats part = light_left(t, lamp.obstacles, place, diameter) * value_or(lamp.obstacles.in_sight, at, 1);
    light = light + all3(lamp.color) * (facing * part / square);
  }
  if (!t.relative) return light;
  const auto part = [](Floats a, Floats b) { return a / max(b, all(1e-6f)); };
  return {part(light.x, plain.x), part(light.y, plain.y), part(light.z, plain.z)};
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
  const Floats3 place = particle_place(p, i), offset = place - all3(t.center);
  const Floats alpha = min(max(value_or(p.alpha, i, p.alpha_of_all), Floats{}), all(1.0f));
  Mask counts = (max(max(abs(offset.x), abs(offset.y)), abs(offset.z)) <= t.reach) & (alpha > 0.0f);
  if (last - i < kLanes) counts &= first_lanes(last - i);
  return {select(counts, place, all3(t.center)), alpha * t.shadow, counts};
}

void extend_extent(const image::ShadowTask& t, const image::ShadowSpace& space, std::size_t first, std::size_t last,
                   image::ShadowExtent& extent) {
  Floats low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) low[axis] = all(kMostFloat), high[axis] = all(-kMostFloat);
  for (std::size_t i = first; i < last; i += kLanes) {
    const ShadowCaster c = caster_at(t, i, last);
    const Floats3 offset = c.place - all3(space.origin);
    const Floats at[3] = {dot(offset, all3(space.right)), dot(offset, all3(space.up)), dot(offset, all3(space.ahead))};
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = min(low[axis], select(c.counts, at[axis], all(kMostFloat)));
      high[axis] = max(high[axis], select(c.counts, at[axis], all(-kMostFloat)));
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const float least = low[axis][lane], most = high[axis][lane];
      extent.low[axis] = least < extent.low[axis] ? least : extent.low[axis];
      extent.high[axis] = most > extent.high[axis] ? most : extent.high[axis];
    }
  }
}

constexpr std::size_t level_start(int level) {
  std::size_t start = 0;
  for (int k = 0; k < level; ++k) start += image::ShadowGrids::level_numbers(k);
  return start;
}
constexpr std::size_t kLevelStart[image::kShadowLevels] = {level_start(0), level_start(1), level_start(2),
                                                           level_start(3)};

// Optical depths of a vector of particles, divided among the eight cells around each: pairs of cells along a row, in
// two rows of two layers.
struct Shares {
  unsigned lanes = 0;  // one bit per particle that counts
  std::int32_t cell[4][kLanes], next[kLanes];  // first cell of each pair, and offset of the second
  std::int32_t depth[8][kLanes];
};

// Values that depend on the level of each particle.
struct Level {
  Floats scale;
  Ints columns, layers, start;
};

MOTES_INLINE void share_depths(const Level& level, const InGrid& at, Floats depth, unsigned lanes, Shares& to) {
  const Floats u = at.column * level.scale + 0.5f, v = at.row * level.scale + 0.5f, w = at.layer * level.scale + 0.5f;
  const Ints i = to_ints(u), j = to_ints(v), k = to_ints(w);  // above 0
  const Floats right = u - to_floats(i), below = v - to_floats(j), beyond = w - to_floats(k);
  const auto within = [](Ints at_cell, Ints count) { return min_ints(max_ints(at_cell, Ints{}), count - 1); };
  const Ints first = within(i - 1, level.columns);
  store_mask(to.next, within(i, level.columns) - first);
  const Ints js[2] = {within(j - 1, level.columns), within(j, level.columns)};
  const Ints ks[2] = {within(k - 1, level.layers), within(k, level.layers)};
  for (int c = 0; c < 2; ++c) {
    const Floats in_layer = depth * (c == 0 ? 1.0f - beyond : beyond);
    for (int b = 0; b < 2; ++b) {
      const Floats in_row = in_layer * (b == 0 ? 1.0f - below : below);
      const int pair = 2 * c + b;
      store_mask(to.cell[pair], (ks[c] * level.columns + js[b]) * level.columns + first + level.start);
      store_mask(to.depth[2 * pair], to_ints(in_row * (1.0f - right) + 0.5f));
      store_mask(to.depth[2 * pair + 1], to_ints(in_row * right + 0.5f));
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

// Returns the optical depth that a particle adds to its level, in 1 / kShadowUnit: that of a cell, through which
// 1 - part opacity of the light passes if `part` of it is covered, times the number of cells that the particle covers.
MOTES_INLINE Floats optical_depth(Floats area, Floats cell, Floats opacity) {
  const Floats cells = area / (cell * cell), part = max(min(cells, all(1.0f)), all(1e-12f));
  const Floats kept = part * opacity;
  const Floats faint = kept + kept * kept * 0.5f;  // where the logarithm would lose digits
  const Floats depth = select(kept < 1e-3f, faint, -log(max(1.0f - kept, all(1e-4f))));
  return min(depth * (cells / part), all(64.0f)) * image::kShadowUnit;
}

void add_depths(const image::ShadowTask& t, const image::ShadowSpace& space, std::size_t first, std::size_t last,
                std::int64_t* sums) {
  Shares shares[2];  // cells of one are prefetched while the other is computed
  int now = 0;
  for (std::size_t i = first; i < last; i += kLanes) {
    const ShadowCaster c = caster_at(t, i, last);
    const InGrid at = in_grid(space, c.place);
    const Mask counts = c.counts & at.known & (at.layer >= 0.0f) & (at.layer <= float{image::kShadowLayers});
    if (!any(counts)) continue;
    const Floats diameter = diameter_at(t.width, t.particles, c.place, i), wide = diameter * 0.6f;
    Level level{all(1.0f), all_ints(image::kShadowColumns), all_ints(image::kShadowLayers), Ints{}};
    Floats cell = at.width;
    for (int k = 1; k < image::kShadowLevels; ++k) {
      const Mask wider = wide > at.width * static_cast<float>(1 << (k - 1));
      level.scale = select(wider, all(1.0f / static_cast<float>(1 << k)), level.scale);
      level.columns = select(wider, all_ints(image::kShadowColumns >> k), level.columns);
      level.layers = select(wider, all_ints(image::kShadowLayers >> k), level.layers);
      level.start = select(wider, all_ints(static_cast<int>(kLevelStart[k])), level.start);
      cell = select(wider, at.width * static_cast<float>(1 << k), cell);
    }
    const Floats depth = optical_depth(diameter * diameter * (kHalfTurnRadians / 4), cell, c.opacity);
    share_depths(level, at, depth, bits_of(counts & (depth >= 1.0f)), shares[now]);
    prefetch(sums, shares[now]);
    now = 1 - now;
    add(sums, shares[now]);
  }
  add(sums, shares[1 - now]);
}

}  // namespace

extern const image::LightLanes light_lanes = {light_particles, extend_extent, add_depths};

}  // namespace motes::MOTES_ISA
