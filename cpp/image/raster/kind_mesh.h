// mesh: an instance of a mesh, in its own colours if it has any.
#pragma once

#include <type_traits>

#include "image/light/surface_lanes.h"
#include "image/light/texture_lanes.h"
#include "image/mesh_facets.h"
#include "image/raster/wide_sprite.h"

namespace motes::MOTES_ISA {

template <bool kColored>
struct MeshOf {
  using Splat = image::MeshSplat;
  static constexpr int kPlanes = kColored ? 4 : 2;
  static constexpr float kNarrow = 0;

  WideSprite s;
  const image::WideSplat& task;
  const Splat& mesh;
  CameraPose pose;
  float extent;  // radius of its bounding ball, m
  float box;     // half the side of its bounding square on the screen, px
  int steps = 1;  // positions along the streak; a power of two
  PosedMoments moments;
  Walls walls{};  // tested if there are moments

  MOTES_INLINE MeshOf(const image::WideSplat& t, const WideSprite& sprite)
      : s(sprite), task(t), mesh(t.own<Splat>()), pose(t, sprite), extent(pose.scale * mesh.reach),
        moments(mesh, pose, extent, 1.2f * extent * mesh.focal / pose.depth, s.half, t.memory.moments) {
    const float left = pose.depth - extent;
    box =
        extent * (mesh.focal + size_of(pose.middle_x) + size_of(pose.middle_y)) / (left > mesh.near ? left : mesh.near);
    if (moments.count != 0) box = box * moments.larger + moments.blur;
    box = (box < image::kMostPosedReach ? box : image::kMostPosedReach) + 1;
    while (steps < kMostSteps && static_cast<float>(steps) < s.half) steps *= 2;
    s.radius = box;
    own = color_times(s.color, s.gain);
    if (lit()) s.color |= 0xffffffu;
  }
  MOTES_INLINE bool tests_itself() const { return moments.count != 0; }
  MOTES_INLINE float reach() const { return box; }
  MOTES_INLINE float box_x() const { return box; }
  MOTES_INLINE float box_y() const { return box; }
  MOTES_INLINE float total() const { return s.light; }
  static MOTES_INLINE float greatest() { return kPixelWeight; }
  static MOTES_INLINE float usual_sum() { return kPixelWeight; }
  static MOTES_INLINE const std::uint16_t* measured(const Patch<kPlanes>& p) { return p.cover; }
  /// Returns the least depth of any part of it, m.
  MOTES_INLINE float front_depth() const { return pose.depth - extent; }

  /// Computes weights by samples: 4 x 4 per pixel, or 2 x 2 if the streak has many steps. All triangles that face the
  /// camera at a sample count, up to a full pixel.
  MOTES_OUTLINE void weigh(Patch<kPlanes>& p) const {
    const std::size_t bytes = sizeof p.cover[0] * static_cast<std::size_t>(kStrip * p.strips * p.stride);
    __builtin_memset(p.cover, 0, bytes);
    __builtin_memset(p.light, 0, kChannels * bytes);
    if (moments.count != 0) return weigh_moments(p);
    steps < kMany ? weigh_samples<4>(p) : weigh_samples<2>(p);
  }

  /// Keeps the nearest surface at the centres of the tile's pixels.
  MOTES_OUTLINE void draw(const image::TilePlanes& tile) const {
    if (moments.count == 0) {
      for_each_facet(pose, {}, [&](const Shown& f) {
        for_each_step([&](std::int64_t dx, std::int64_t dy) { keep<1>(tile.surfaces, f, {dx, dy}, 0); });
      });
      return;
    }
    moments.for_each([&](int, const image::Moment& m) {
      for_each_facet(pose.at(m), {}, [&](const Shown& f) { keep<1>(tile.surfaces, f, way_at(m), 0); });
    });
  }

  /// Keeps the nearest surfaces of each exposure.
  MOTES_OUTLINE void expose(const image::ExposedTile& to) const {
    const auto for_each_exposure = [&](const auto& use) {
      for (int number = 0; number < image::kExposures; ++number) {
        for (int phase = 0; phase < image::kPhases; ++phase) {
          const image::Exposure& e = to.exposures->of[number][phase];
          image::Moment m{};
          m.time = e.time;
          Shift way = way_at(m);
          way.x -= floor_of(e.pixel_x * (1 << image::kWideBits));
          way.y -= floor_of(e.pixel_y * (1 << image::kWideBits));
          use(to.surfaces[number], phase, m, way, OnLens{e.lens_x * to.blur, e.lens_y * to.blur});
        }
      }
    };
    using Surfaces = image::NearestSurface*;
    if (!pose.turns() && !(to.blur > 0)) {
      for_each_facet(pose, {}, [&](const Shown& f) {
        for_each_exposure([&](Surfaces surfaces, int phase, const image::Moment&, Shift way, OnLens) {
          keep<2>(surfaces, f, way, phase);
        });
      });
      return;
    }
    for_each_exposure([&](Surfaces surfaces, int phase, const image::Moment& m, Shift way, OnLens lens) {
      for_each_facet(pose.at(m), lens, [&](const Shown& f) { keep<2>(surfaces, f, way, phase); });
    });
  }

 private:
  using Shown = std::conditional_t<kColored, TintedFacet, Facet>;

  Floats3 own;  // colour

  MOTES_INLINE bool lit() const { return kColored && task.light != nullptr; }

  static constexpr int kChannels = kColored ? 3 : 1;
  static constexpr float kSmall = 3, kSmallRound = 1;  // greatest width and height of a small triangle, flat or not, px
  static constexpr int kMostSteps = 32, kMany = 8;
  static constexpr float kFarthest = 32768;  // greatest distance of a corner from the tile, px

  /// A position along the streak, 1/256 px from its middle.
  struct Shift {
    std::int64_t x, y;
  };

  /// Keeps a triangle, moved by `way`, where it is the nearest surface: in all pixels, or with kPitch = 2 in those of a
  /// phase.
  template <int kPitch>
  MOTES_INLINE void keep(image::NearestSurface* surfaces, const Shown& f, Shift way, int phase) const {
    const int first_column = phase % 2, first_row = phase / 2;
    const std::int64_t dx = way.x - (first_column << image::kWideBits), dy = way.y - (first_row << image::kWideBits);
    const auto shade = static_cast<std::uint32_t>(clamped(f.shade * 255.0f, 1, 255) + 0.5f) << 24;
    const float x = static_cast<float>(f.x[0] + way.x) * kFacetPixel,
                y = static_cast<float>(f.y[0] + way.y) * kFacetPixel;
    const int columns = (task.columns - first_column + kPitch - 1) / kPitch;
    const int rows = (task.rows - first_row + kPitch - 1) / kPitch;
    for_each_sample<1, kPitch>(f, dx, dy, columns, rows, [&](int of_columns, int of_rows) {
      const int column = kPitch * of_columns + first_column, row = kPitch * of_rows + first_row;
      const float right = static_cast<float>(column) - x, down = static_cast<float>(row) - y;
      const float depth = 1 / inverse_at(f, right, down);
      std::uint32_t bits;
      __builtin_memcpy(&bits, &depth, sizeof bits);
      image::NearestSurface& there = surfaces[static_cast<std::ptrdiff_t>(row) * image::kPixelStride + column];
      const image::NearestSurface here = image::NearestSurface{bits} << 32 | surface_at(f, right, down, shade);
      there = here < there ? here : there;
    });
  }

  /// Returns a triangle's colour in a channel, 0..1, at a position relative to its first corner, px.
  MOTES_INLINE float tint_at(const TintedFacet& f, int channel, float right, float down) const {
    if (mesh.colors == nullptr) return 1;
    const float of = f.first[channel] + f.to_right[channel] * right + f.to_below[channel] * down;
    return clamped(of / inverse_at(f, right, down), f.low[channel], f.high[channel]);
  }
  /// Returns the surface at a position relative to a triangle's first corner, px: see NearestSurface.
  MOTES_INLINE std::uint32_t surface_at(const Shown& f, float right, float down, std::uint32_t shade) const {
    if constexpr (kColored) {
      if (lit()) return surface_of(all3(shown_at(f, right, down)))[0];
      std::uint32_t color = 0;
      for (int c = 0; c < 3; ++c) {
        const auto own = static_cast<float>(s.color >> (8 * c) & 0xffu);
        color |= static_cast<std::uint32_t>(own * tint_at(f, c, right, down) + 0.5f) << (8 * c);
      }
      return color | shade;
    }
    return (s.color & 0xffffffu) | shade;
  }
  /// Light per cover: one number, or one per channel.
  struct Light {
    float channel[3];
  };
  /// Returns the light at a position relative to a triangle's first corner, px.
  MOTES_INLINE Light light_at(const Shown& f, float right, float down) const {
    if constexpr (kColored) {
      if (lit()) {
        const Floats3 light = at_most_white(all3(shown_at(f, right, down)));
        return {{light.x[0], light.y[0], light.z[0]}};
      }
      return {{f.shade * tint_at(f, 0, right, down), f.shade * tint_at(f, 1, right, down),
               f.shade * tint_at(f, 2, right, down)}};
    }
    return {{f.shade, f.shade, f.shade}};
  }

  /// Returns the lit colour at a position relative to a triangle's first corner, px.
  MOTES_INLINE Float3 shown_at(const TintedFacet& f, float right, float down) const {
    Float3 passes[2] = {f.passes[0], f.passes[1]};
    if (!f.small) set_passing(f, right, down, passes);
    if (mesh.picture.count != 0) {
      const Float3 picture = light_on_mesh(*f.level, f.uv, parts_at(f, right, down));
      passes[0] = {passes[0].x * picture.x, passes[0].y * picture.y, passes[0].z * picture.z};
    }
    return {own.x[0] * tint_at(f, 0, right, down) * passes[0].x + passes[1].x,
            own.y[0] * tint_at(f, 1, right, down) * passes[0].y + passes[1].y,
            own.z[0] * tint_at(f, 2, right, down) * passes[0].z + passes[1].z};
  }
  /// Returns the place of a point relative to a triangle's first corner, px, in metres from the eye.
  MOTES_INLINE Float3 place_on(const Facet& f, float right, float down) const {
    const float depth = 1 / inverse_at(f, right, down), per = depth / mesh.focal;
    const float x = (static_cast<float>(f.x[0]) + static_cast<float>(task.origin_x)) * kFacetPixel + right;
    const float y = (static_cast<float>(f.y[0]) + static_cast<float>(task.origin_y)) * kFacetPixel + down;
    return {x * per, -y * per, -depth};
  }
  /// Returns the unit normal of the visible side there: that of the triangle, or of its corners.
  MOTES_INLINE Float3 normal_on(const TintedFacet& f, float right, float down) const {
    if (mesh.normals == nullptr) return f.normal;
    const Float3 parts = parts_at(f, right, down);
    Float3 sum{};
    const float part[3] = {parts.x, parts.y, parts.z};
    for (int k = 0; k < 3; ++k) {
      sum = {sum.x + f.normals[k].x * part[k], sum.y + f.normals[k].y * part[k], sum.z + f.normals[k].z * part[k]};
    }
    const float square = dot(sum, sum);
    if (!(square > 1e-12f)) return f.normal;
    return times(sum, (dot(sum, f.normal) < 0 ? -1.0f : 1.0f) / __builtin_sqrtf(square));
  }
  MOTES_OUTLINE void set_passing(const TintedFacet& f, float right, float down, Float3 (&passes)[2]) const {
    const Floats3 place = all3(place_on(f, right, down)), normal = all3(normal_on(f, right, down));
    const image::SurfaceLight& light = *task.light;
    SentLight sent{};
    if (light.finish.reflects()) {
      sent = sent_by(light, {place, normal});
    } else if (light.lit) {
      sent.on_color = light_on(light, {place, normal});
    } else {
      const Floats grey = mesh.normals == nullptr ? all(f.shade) : shade(normal);
      sent.on_color = {grey, grey, grey};
    }
    const Floats3 fog = through_fog(light, Floats3{}, place), through = through_fog(light, sent.on_color, place) - fog;
    const Floats3 added = light.finish.reflects() ? through_fog(light, sent.clear, place) : fog;
    passes[0] = {through.x[0], through.y[0], through.z[0]};
    passes[1] = {added.x[0], added.y[0], added.z[0]};
  }

  MOTES_INLINE Shift way_at(const image::Moment& m) const {
    constexpr float kUnit = 1 << image::kWideBits;
    return {floor_of(m.time * pose.dx * kUnit + 0.5f), floor_of(m.time * pose.dy * kUnit + 0.5f)};
  }

  /// Per pixel of a patch: 1 + the number of the moment that last covered it, 1/depth of the nearest surface at that
  /// moment, and the weights that this surface added.
  struct Cells {
    std::uint8_t moment[kPatchPixels];
    std::uint16_t cover[kPatchPixels], light[kChannels * kPatchPixels];
    float inverse[kPatchPixels];
  };

  /// Computes weights by one sample per pixel and moment, of the nearest surface.
  MOTES_INLINE void weigh_moments(Patch<kPlanes>& p) const {
    Cells cells;
    __builtin_memset(cells.moment, 0, static_cast<std::size_t>(kStrip * p.strips * p.stride));
    const float share = kPixelWeight / (static_cast<float>(moments.shown) * moments.larger * moments.larger);
    moments.for_each([&](int number, const image::Moment& m) {
      CameraPose then = pose.at(m);
      then.scale *= moments.larger;
      const Shift way = way_at(m);
      const std::int64_t dx = way.x + m.pixel_x, dy = way.y + m.pixel_y;
      const auto marked = static_cast<std::uint8_t>(number + 1);
      for_each_facet(then, {m.lens_x * mesh.blur, m.lens_y * mesh.blur}, [&](const Shown& f) {
        const float x = static_cast<float>(f.x[0] + dx) * kFacetPixel,
                    y = static_cast<float>(f.y[0] + dy) * kFacetPixel;
        for_each_sample<1>(f, dx, dy, task.columns, task.rows, [&](int column, int row) {
          const int at = place_in(p, column, row);
          if (at < 0) return;
          const float right = static_cast<float>(column) - x, down = static_cast<float>(row) - y;
          const float here = inverse_at(f, right, down);
          const bool again = cells.moment[at] == marked;
          if (again && here <= cells.inverse[at]) return;
          const float seen = walls.depth == nullptr ? share : share * visible(m, column, row, here);
          const auto cover = static_cast<std::uint16_t>(seen + m.dither);
          p.cover[at] = static_cast<std::uint16_t>(p.cover[at] + cover - (again ? cells.cover[at] : 0));
          const Light all_light = seen > 0 ? light_at(f, right, down) : Light{};
          for (int c = 0; c < kChannels; ++c) {
            const int number = kChannels * at + c;
            const auto light = static_cast<std::uint16_t>(seen * all_light.channel[c] + m.dither);
            p.light[number] = static_cast<std::uint16_t>(p.light[number] + light - (again ? cells.light[number] : 0));
            cells.light[number] = light;
          }
          cells.moment[at] = marked;
          cells.cover[at] = cover;
          cells.inverse[at] = here;
        });
      });
    });
  }

  MOTES_INLINE float visible(const image::Moment& m, int column, int row, float inverse) const {
    // An exposure's walls are where the lens shows them.
    const float moved = moments.one == nullptr ? image::spread_at(mesh.blur, mesh.focus, inverse) : 0;
    return walls.visible(static_cast<float>(column) - m.lens_x * moved, static_cast<float>(row) - m.lens_y * moved,
                         1 / inverse);
  }

  /// Returns the index of a pixel in a patch; -1 if it is outside.
  static MOTES_INLINE int place_in(const PatchPart& p, int column, int row) {
    const int down = row - p.first;
    if (static_cast<unsigned>(down) >= static_cast<unsigned>(p.rows)) return -1;
    const int right = column - p.start[down];
    if (static_cast<unsigned>(right) >= static_cast<unsigned>(kStrip * p.strips)) return -1;
    return kStrip * (right / kStrip * p.stride + down) + right % kStrip;
  }

  template <int kSamples>
  MOTES_INLINE void weigh_samples(Patch<kPlanes>& p) const {
    constexpr int kStep = (1 << image::kWideBits) / kSamples, kFirst = -(kSamples - 1) * kStep / 2;
    const int weight = static_cast<int>(kPixelWeight) / (kSamples * kSamples * steps);
    for_each_facet(pose, {}, [&](const Shown& f) {
      const auto plain = static_cast<std::uint16_t>(f.shade * static_cast<float>(weight) + 0.5f);
      for_each_step([&](std::int64_t dx, std::int64_t dy) {
        for_each_sample<kSamples>(f, dx, dy, task.columns, task.rows, [&](int column, int row) {
          const int at = place_in(p, column / kSamples, row / kSamples);
          if (at < 0 || p.cover[at] + weight > static_cast<int>(kPixelWeight)) return;
          p.cover[at] = static_cast<std::uint16_t>(p.cover[at] + weight);
          if constexpr (!kColored) {
            p.light[at] = static_cast<std::uint16_t>(p.light[at] + plain);
            return;
          }
          const float right = static_cast<float>(column * kStep + kFirst - f.x[0] - dx) * kFacetPixel;
          const float down = static_cast<float>(row * kStep + kFirst - f.y[0] - dy) * kFacetPixel;
          const Light all_light = light_at(f, right, down);
          for (int c = 0; c < kChannels; ++c) {
            const float light = all_light.channel[c] * static_cast<float>(weight) + 0.5f;
            std::uint16_t& to = p.light[kChannels * at + c];
            to = static_cast<std::uint16_t>(to + static_cast<std::uint16_t>(light));
          }
        });
      });
    });
  }

  /// Calls use(dx, dy) for each position along the streak, 1/256 px from its middle.
  template <class Use>
  MOTES_INLINE void for_each_step(const Use& use) const {
    image::PosedRecord r;
    __builtin_memcpy(&r, s.record, sizeof r);
    for (int i = 0; i < steps; ++i) {
      const std::int64_t part = 2 * i + 1 - steps;
      use(part * r.dx / (2 * steps), part * r.dy / (2 * steps));
    }
  }

  MOTES_INLINE Floats3 turned(const CameraPose& p, int row, std::size_t i) const {
    const float* const from = mesh.corners + static_cast<std::size_t>(3 * row * mesh.room) + i;
    const Floats x = load(from), y = load(from + mesh.room), z = load(from + 2 * mesh.room);
    return all3(p.right) * x + all3(p.up) * y + all3(p.front) * z;
  }
  /// A point on the lens, as the shift of infinitely distant points, px.
  struct OnLens {
    float x = 0, y = 0;
  };
  MOTES_INLINE FacetCorner corner(const CameraPose& p, OnLens lens, int row, std::size_t i) const {
    const Floats3 at = turned(p, row, i) * p.scale;
    const Floats depth = p.depth - at.z;
    const float per = p.depth / mesh.focal;
    FacetCorner c;
    c.in_front = depth >= mesh.near;
    c.inverse = 1.0f / select(c.in_front, depth, all(1.0f));
    const Floats scale = c.inverse * mesh.focal;
    c.x = (at.x + p.middle_x * per) * scale - (p.middle_x - s.x);
    c.y = (p.middle_y * per - at.y) * scale - (p.middle_y - s.y);
    if (lens.x != 0 || lens.y != 0) {
      const Floats part = 1.0f - c.inverse * mesh.focus;
      c.x += part * lens.x;
      c.y += part * lens.y;
    }
    return c;
  }

  /// Returns the shade of surfaces with these unit normals, as for spheres.
  MOTES_INLINE Floats shade(Floats3 normal) const {
    const Floats facing = dot(normal, all3(mesh.surface.toward_sun)), up = dot(normal, all3(mesh.surface.upward));
    const Floats sky = mesh.surface.low + (mesh.surface.high - mesh.surface.low) * (0.5f + 0.5f * up);
    return min((sky + mesh.surface.sun * max(facing, Floats{})), all(1.0f));
  }

  /// Calls use(facet) for the triangles that may be visible in the tile.
  template <class Use>
  MOTES_INLINE void for_each_facet(const CameraPose& p, OnLens lens, const Use& use) const {
    const float more_x = s.half * size_of(s.along_x) + 1, more_y = s.half * size_of(s.along_y) + 1;
    const float end_x = static_cast<float>(task.columns) + more_x, end_y = static_cast<float>(task.rows) + more_y;
    for (int i = 0; i < mesh.triangles; i += kLanes) {
      const auto at = static_cast<std::size_t>(i);
      const FacetCorner c[3] = {corner(p, lens, 0, at), corner(p, lens, 1, at), corner(p, lens, 2, at)};
      const Floats right = max(max(c[0].x, c[1].x), c[2].x), left = min(min(c[0].x, c[1].x), c[2].x);
      const Floats below = max(max(c[0].y, c[1].y), c[2].y), above = min(min(c[0].y, c[1].y), c[2].y);
      Mask seen = c[0].in_front & c[1].in_front & c[2].in_front;
      seen &= (right >= -more_x) & (left <= end_x) & (below >= -more_y) & (above <= end_y);
      seen &= (left > -kFarthest) & (right < kFarthest) & (above > -kFarthest) & (below < kFarthest);
      const Floats area = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
      if (mesh.closed) seen &= area < 0.0f;  // y points down, so front faces have negative areas
      unsigned lanes = bits_of(seen & first_lanes(static_cast<std::size_t>(mesh.triangles - i)));
      if (lanes == 0) continue;
      const Floats3 normal = turned(p, 3, at);
      const Floats side = select(area > 0.0f, all(-1.0f), all(1.0f));
      const Floats shades = shade({normal.x * side, normal.y * side, normal.z * side});
      for (; lanes != 0; lanes &= lanes - 1) {
        const auto lane = static_cast<std::size_t>(__builtin_ctz(lanes));
        Shown f;
        if (!set_facet(c, lane, f)) continue;
        f.shade = shades[lane];
        if constexpr (kColored) {
          if (mesh.colors != nullptr) set_tints(c, lane, at + lane, f);
          if (mesh.normals != nullptr || mesh.picture.count != 0) set_corners(p, c, lane, at + lane, f);
          if (lit())
            set_light(right[lane] - left[lane], below[lane] - above[lane],
                      {normal.x[lane] * side[lane], normal.y[lane] * side[lane], normal.z[lane] * side[lane]}, f);
        }
        use(f);
      }
    }
  }

  /// Prepares what a triangle's corners have, besides colours. The visible side must be known.
  MOTES_OUTLINE void set_corners(const CameraPose& p, const FacetCorner (&c)[3], std::size_t lane, std::size_t triangle,
                                 TintedFacet& f) const {
    const int order[3] = {0, f.swapped ? 2 : 1, f.swapped ? 1 : 2};
    const auto value = [&](const float* planes, int plane) {
      return planes[static_cast<std::size_t>(plane * mesh.room) + triangle];
    };
    const auto turned_by = [&](const float* planes, int first) {
      const float x = value(planes, first), y = value(planes, first + 1), z = value(planes, first + 2);
      return Float3{p.right.x * x + p.up.x * y + p.front.x * z, p.right.y * x + p.up.y * y + p.front.y * z,
                    p.right.z * x + p.up.z * y + p.front.z * z};
    };
    for (int k = 0; k < 3; ++k) {
      f.inverses[k] = c[order[k]].inverse[lane];
      if (mesh.normals != nullptr) f.normals[k] = turned_by(mesh.normals, 3 * order[k]);
      if (mesh.picture.count == 0) continue;
      f.uv[2 * k] = value(mesh.uv, 2 * order[k]);
      f.uv[2 * k + 1] = value(mesh.uv, 2 * order[k] + 1);
    }
    if (mesh.picture.count == 0) return;
    const Float3 first = turned_by(mesh.corners, 0);
    const Float3 twice = cross(minus(turned_by(mesh.corners, 3), first), minus(turned_by(mesh.corners, 6), first));
    const Float3 place = place_on(f, to_centre(f.x), to_centre(f.y)), normal = turned_by(mesh.corners, 9);
    const float straight = size_of(dot(normal, place)) / __builtin_sqrtf(dot(place, place));
    const float footprint = -place.z / (mesh.focal * (straight > 0.05f ? straight : 0.05f));
    const float area = __builtin_sqrtf(dot(twice, twice)) * p.scale * p.scale;
    f.level = mesh.picture.levels + level_on_mesh(mesh.picture, f.uv, area, footprint);
  }

  /// Prepares the light of a triangle: `wide` and `high` px large.
  MOTES_INLINE void set_light(float wide, float high, Float3 normal, TintedFacet& f) const {
    f.normal = normal;
    const float most = mesh.normals == nullptr ? kSmall : kSmallRound;
    f.small = wide <= most && high <= most;
    if (!f.small) return;
    set_passing(f, to_centre(f.x), to_centre(f.y), f.passes);
  }

  /// Computes the colours of a triangle whose corners are set.
  MOTES_INLINE void set_tints(const FacetCorner (&c)[3], std::size_t lane, std::size_t triangle, TintedFacet& f) const {
    const int order[3] = {0, f.swapped ? 2 : 1, f.swapped ? 1 : 2};
    const auto x1 = static_cast<float>(f.x[1] - f.x[0]), y1 = static_cast<float>(f.y[1] - f.y[0]);
    const auto x2 = static_cast<float>(f.x[2] - f.x[0]), y2 = static_cast<float>(f.y[2] - f.y[0]);
    const std::int64_t area = (f.x[1] - f.x[0]) * (f.y[2] - f.y[0]) - (f.x[2] - f.x[0]) * (f.y[1] - f.y[0]);
    const float per = 1 / (static_cast<float>(area) * kFacetPixel);
    for (int channel = 0; channel < 3; ++channel) {
      float own[3], of[3];
      for (int k = 0; k < 3; ++k) {
        own[k] = mesh.colors[static_cast<std::size_t>((3 * order[k] + channel) * mesh.room) + triangle];
        of[k] = own[k] * c[order[k]].inverse[lane];
      }
      const float one = of[1] - of[0], two = of[2] - of[0];
      f.first[channel] = of[0];
      f.to_right[channel] = (one * y2 - two * y1) * per;
      f.to_below[channel] = (two * x1 - one * x2) * per;
      const float low = own[0] < own[1] ? own[0] : own[1], high = own[0] < own[1] ? own[1] : own[0];
      f.low[channel] = low < own[2] ? low : own[2];
      f.high[channel] = high < own[2] ? own[2] : high;
    }
  }
};

using Mesh = MeshOf<false>;
using ColoredMesh = MeshOf<true>;

}  // namespace motes::MOTES_ISA
