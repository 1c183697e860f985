// Casts rays at external objects, a vector of rays at a time: the values shared by plain code and the builds for each
// instruction set. All coordinates are metres relative to the camera's eye, along the world's axes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "image/light/lamps.h"
#include "image/light/light_lanes.h"
#include "image/light/shadow_grid.h"
#include "image/light/sky.h"
#include "meshes/bvh.h"
#include "shapes/shape.h"
#include "simd/declare_builds.h"

namespace motes::image {

/// An object prepared for ray casting. The numbers in `value` depend on its kind:
///   plane      unit normal, its distance from the eye
///   disc       those of a plane, centre, squares of the outer and inner radius
///   rectangle  those of a plane, and for each side a vector and a number: dot(vector, p) - number is 0..1 inside
///   triangle   the corners, unit normal
///   box        low and high corner
///   sphere     centre, square of the radius, square of the centre's distance minus square of the radius
///   cylinder, cone  start of the axis, its unit vector and length, outer and inner radius, middle of the axis
///   a mesh     the eye in the mesh's coordinates; if it is turned, its axes
struct CastSolid {
  shapes::Kind kind;
  std::uint32_t number;  // of the object in the view
  const meshes::BvhNode* nodes;  // null: a shape, not a mesh
  const meshes::BvhTriangle* triangles;
  float value[14];
  bool turned;  // its axes are not the world's, as those of a placed mesh
  float center[3], radius;  // of a ball around it; the radius is infinite if there is none
};

/// Room for the objects that may stand between a vector of particles and a light: as many as the view has, and one
/// mask of the particles that each may shade.
struct NearSolids {
  static constexpr std::size_t kMostLanes = 16;
  CastSolid* solids;
  std::uint32_t* masks;
};

struct CastView {
  const CastSolid* solids;  // of several at the same distance, the first one is visible
  std::size_t count;
  float right[3], up[3], forward[3];
  float middle_x, middle_y;  // pixels, from the top left corner
  float pixel;               // side of a pixel at a view depth of 1 m
  float near;
  bool colored;  // any mesh of the scene has colours, normals, or places on a picture
  bool glass;    // some of it may be visible; it is not among the solids

  /// Returns whether surfaces include the numbers of a mesh's triangles.
  bool keeps_triangles() const { return colored; }
};

/// The first surfaces that rays meet, one value per ray. Arrays have room for one vector more than there are rays.
struct Surfaces {
  float* distance;         // view depth, m; FLT_MAX: nothing
  float* normal[3];        // unit vector towards the eye
  std::uint32_t* surface;  // 1 + 4 * number of the object + face; 0: nothing
  std::uint32_t* triangle;  // its number in the mesh's BVH; null if no mesh has colours
};

/// Returns the number of the object to which a surface belongs.
constexpr std::uint32_t object_of(std::uint32_t surface) { return (surface - 1) >> 2; }

/// Sample points of lights that have a size, on a disc of radius 1. Those at its rim are among the first kFirst.
struct LightPlaces {
  static constexpr int kAll = 64, kFirst = 24;
  float x[kAll], y[kAll];
};

struct CastLight : Lamp {
  float radius;  // m
  const CastSolid* solids;  // that may cast a shadow
  std::size_t count;
  ShadowMap shadow;  // of particles
};

struct Material {
  float color[3];
  float emitted;  // emitted light, as a multiple of `color`
  const Texture* image;  // multiplies `color`; null: none
  float scale;           // width of the image, m
  const CastSolid* mesh;  // the mesh, if it has any of the following, or an image; otherwise null
  const float* colors;    // of the corners, which multiply `color`: see Bvh; null: none
  const float* uv;        // places of the corners on the image; null: it is projected along the mesh's axes
  const float* normals;   // of the corners, interpolated for light; null: the triangles are flat
  Finish finish;
  const Texture* finish_image;  // see Solid; null: none
  float glass;                  // index of refraction; 0: opaque
};

struct ShadeView {
  CastView cast;  // its solids are those that may cast a shadow of the sun
  const CastLight* lights;
  std::size_t light_count;
  const Material* materials;  // one per object
  Sun sun;
  float sun_right[3], sun_up[3];  // perpendicular to `sun`, of length tan(half the sun's size); 0: the sun is a point
  const LightPlaces* places;
  SkyLanes sky;
  Ambient ambient;
  bool has_images;  // any material has an image
  bool bare;  // what is met is black
  bool reflects;  // any material's finish does
  // What rays meet behind glass, and the glass. If there is any, the solids before lights are all that cast shadows.
  const CastSolid *opaque, *glass;
  std::size_t opaque_count, glass_count;
  ShadowMap sun_shadow;  // of particles
  SkyDepths sky_depths;  // of particles
  const CastSolid* around;  // that may keep the sky's light from surfaces
  std::size_t around_count;
  float occlusion, occlusion_reach;  // see View::occlusion; m
  float eye[3];  // position in the world, m
  float fog[3], fog_density;  // 1/m; 0: distant objects fade into the sky
  float fog_square;  // square of the distance at which half of the light is fog, m^2
  float grain;  // greatest distance between a surface and a ray that starts on it due to rounding, m
};

/// The light of rays, and the lights that do not reach the surface; one value per ray.
struct Shades {
  float* light[3];  // linear RGB
  /// One bit per light; some share a bit if there are more than 30. Of glass, a number that differs where another
  /// surface is seen.
  std::uint32_t* shadows;
};

/// The bounding box of the surfaces that were met; low > high if there are none.
struct Reach {
  float low[3], high[3];
};

struct ShadedParticles {
  ParticlePlanes planes;
  ParticleWidth width;
};

/// Points of the image are in px from its top left corner, in arrays that are readable to the end of the last vector.
struct CastLanes {
  /// Finds the first surface that each ray meets.
  void (*cast)(const CastView& view, const float* x, const float* y, std::size_t count, const Surfaces& to);

  /// Extends a box by the surfaces and, unless `depth` is null, computes the depth bits beyond which particles are
  /// hidden: see Scenery::depth.
  void (*measure)(const CastView& view, const float* x, const float* y, std::size_t count, const Surfaces& from,
                  Reach& reach, std::uint32_t* depth);

  /// Computes the light that the surfaces send to the eye.
  void (*shade)(const ShadeView& view, const float* x, const float* y, std::size_t count, const Surfaces& from,
                const Shades& to);

  /// Computes the part of each light with a size that is visible from particles first .. last - 1: see InSight.
  /// `near` has room for the most objects before any light.
  void (*in_sight)(const ShadeView& view, const ShadedParticles& particles, const NearSolids& near, std::size_t first,
                   std::size_t last, float* to, std::size_t stride);

  /// Moves surfaces met at points (x, y) to other points of the same pixels, on their tangent planes.
  void (*slide)(const CastView& view, const float* x, const float* y, const float* to_x, const float* to_y,
                std::size_t count, const Surfaces& surfaces);

  /// Writes the numbers, 64 y + x, of a tile's pixels whose mark differs from that of one of their four neighbours, and
  /// returns how many. Unless `normal` is null, also those whose normal differs much. Rows are `stride` marks apart;
  /// `to` has room for all pixels and one vector.
  std::size_t (*edges)(const std::uint32_t* marks, const float* const* normal, int stride, int width, int height,
                       std::uint32_t* to);

  /// Converts light to sums, as the scenery stores it: see Scenery::light.
  void (*store)(const float* const* light, std::size_t count, std::uint32_t* to);
};

/// Returns the build for this processor.
const CastLanes& cast_lanes();

}  // namespace motes::image

MOTES_DECLARE_BUILDS(motes::image::CastLanes, cast_lanes)
