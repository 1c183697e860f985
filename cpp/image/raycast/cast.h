// Rays that meet external objects, one vector of them at a time: the values shared by plain code and the per-ISA
// builds. All coordinates are metres relative to the camera's eye, in the world's directions.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/light/light_lanes.h"
#include "image/light/shadow_grid.h"
#include "image/light/sky.h"
#include "meshes/bvh.h"
#include "shapes/shape.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// An object, prepared for rays. What its numbers mean depends on the kind:
///   plane      unit normal, its distance from the eye
///   disc       the same, centre, squares of the outer and inner radius
///   rectangle  the same, and for each side a vector and a number: dot(vector, p) - number is 0..1 inside
///   triangle   the corners, unit normal
///   box        low and high corner
///   sphere     centre, square of the radius, and what the square of the centre's distance has more
///   cylinder, cone  start of the axis, its unit vector and length, outer and inner radius, middle of the axis
///   a mesh     the eye in the mesh's coordinates; where it is turned, its axes
struct CastSolid {
  shapes::Kind kind;
  std::uint32_t number;  // of the object in the view
  const meshes::BvhNode* nodes;  // of a mesh; null: a shape
  const meshes::BvhTriangle* triangles;
  float value[14];
  bool turned;  // of a mesh: its axes are not the world's
};

struct CastView {
  const CastSolid* solids;  // nearer ones of equal distance are the first in the list
  std::size_t count;
  float right[3], up[3], forward[3];
  float middle_x, middle_y;  // pixels, from the top left corner
  float pixel;               // side of a pixel at a view depth of 1 m
  float near;
  bool colored;  // a mesh of the whole scene has colours of its own
};

/// The first surfaces that rays meet, one value per ray. Arrays have room for one vector more than there are rays.
struct Surfaces {
  float* distance;         // view depth, m; FLT_MAX: nothing
  float* normal[3];        // unit, towards the eye
  std::uint32_t* surface;  // 1 + 4 * number of the object + face; 0: nothing
  std::uint32_t* triangle;  // of a mesh, in its tree; null where no mesh has colours
};

/// The number of the object that shows a surface.
constexpr std::uint32_t object_of(std::uint32_t surface) { return (surface - 1) >> 2; }

/// Places on a disc of radius 1 that stand for a light with a size: first those at its rim and a few others.
struct LightPlaces {
  static constexpr int kAll = 64, kFirst = 24;
  float x[kAll], y[kAll];
};

struct CastLight {
  float position[3];
  float radius;  // m
  float color[3];  // light on a surface that faces it at 1 m
  const CastSolid* solids;  // what may throw a shadow
  std::size_t count;
  ShadowMap shadow;  // of particles
};

struct Material {
  float color[3];
  float emitted;  // how much of the colour shines by itself
  const Texture* image;  // null: there is none
  float scale;           // m that it is wide
  const CastSolid* mesh;  // whose triangles' corners have colours, which multiply its own; null: none
  const float* colors;    // of them: see Bvh
};

struct ShadeView {
  CastView cast;  // its solids: what may throw a shadow of the sun
  const CastLight* lights;
  std::size_t light_count;
  const Material* materials;  // one per object
  bool sunny;
  float sun[3];         // unit vector
  float sun_right[3], sun_up[3];  // across it, as long as the tangent of half its size; 0: it is a point
  const LightPlaces* places;
  SkyLanes sky;
  Ambient ambient;
  bool has_images;  // any material
  ShadowMap sun_shadow;  // of particles
  float eye[3];          // m, in the world
  float fog[3], fog_density;  // 1/m; 0: what is far fades into the sky
  float fog_square;     // square of the distance at which half of the light is fog
  float grain;          // how far apart a surface and a ray that starts on it may be by rounding alone, m
};

/// The light of rays, one value per ray, and which of the lights it was that did not reach the surface.
struct Shades {
  float* light[3];  // linear RGB
  std::uint32_t* shadows;
};

/// The box around surfaces that were met; low > high where there are none.
struct Reach {
  float low[3], high[3];
};

struct ShadedParticles {
  ParticlePlanes planes;
  ParticleWidth width;
};

/// Points of the image are given in pixels from its top left corner, as arrays that may be read up to the end of the
/// last vector.
struct CastLanes {
  /// The first surface that each ray meets.
  void (*cast)(const CastView& view, const float* x, const float* y, std::size_t count, const Surfaces& to);

  /// Extends a box by the surfaces, and finds the bits of depth beyond which a particle is hidden: see Scenery::depth.
  void (*measure)(const CastView& view, const float* x, const float* y, std::size_t count, const Surfaces& from,
                  Reach& reach, std::uint32_t* depth);

  /// What light the surfaces send to the eye.
  void (*shade)(const ShadeView& view, const float* x, const float* y, std::size_t count, const Surfaces& from,
                const Shades& to);

  /// Which part of each light that has a size is in sight of particles first .. last - 1: see InSight.
  void (*in_sight)(const ShadeView& view, const ShadedParticles& particles, std::size_t first, std::size_t last,
                   float* to, std::size_t stride);

  /// Moves surfaces met at points (x, y) to other points of the same pixels, on their tangent planes.
  void (*slide)(const CastView& view, const float* x, const float* y, const float* to_x, const float* to_y,
                std::size_t count, const Surfaces& surfaces);

  /// Pixels of a tile whose mark differs from that of one of their four neighbours: their numbers, 64 y + x. Rows are
  /// `stride` marks apart. With normals (else null), also pixels of one mark whose normals differ much. Room for all
  /// pixels and one vector.
  std::size_t (*edges)(const std::uint32_t* marks, const float* const* normal, int stride, int width, int height,
                       std::uint32_t* to);

  /// Light as the scenery stores it: see Scenery::light.
  void (*store)(const float* const* light, std::size_t count, std::uint32_t* to);
};

/// The build that suits this processor.
const CastLanes& cast_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::CastLanes, cast_lanes)
