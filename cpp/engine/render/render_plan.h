// Plans who draws what of a frame's picture. The manager decides from the last pictures and tells all ranks with
// *begin*.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/render/draw_speeds.h"
#include "engine/render/render_costs.h"
#include "engine/render/render_order.h"
#include "image/grid.h"
#include "image/scene.h"
#include "roles/cast.h"

namespace motes::engine {

/// Each rank draws a stretch of the picture's tiles in some order (slots): what it needs of a batch of records is then
/// one range, and its part of the picture is nearly a rectangle.
struct RenderPlan {
  image::View::Path path = image::View::Path::gather;  // never automatic
  image::TileOrder order = image::TileOrder::rows;  // order of slots; rows if one rank draws all
  std::vector<std::uint32_t> firsts, ends;  // rank r draws slots firsts[r] .. ends[r] - 1

  int first(int rank) const { return static_cast<int>(firsts[static_cast<std::size_t>(rank)]); }
  int end(int rank) const { return static_cast<int>(ends[static_cast<std::size_t>(rank)]); }
  bool draws(int rank) const { return first(rank) < end(rank); }
  /// Tells whether the plan deals exactly `tiles` tiles to `ranks` ranks.
  bool covers(int tiles, int ranks) const;

  bool operator==(const RenderPlan&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, RenderPlan& plan) {
  visit(plan.path, plan.order, plan.firsts, plan.ends);
}

/// The newest numbers that the manager has about the work of a picture.
struct RenderLoad {
  /// One calculator.
  struct Calculator {
    double particles = 0;
    double act_s = 0;  // seconds of its list in a frame
    double active = 0;  // tiles that its particles touch
  };

  image::Grid grid;  // grid of the counted picture; 0x0: none
  std::vector<std::uint32_t> counts;  // records in each of its tiles
  std::vector<Calculator> calculators;  // in the order of the domains
  double scale = 1;  // under a simulator: what each particle and record stands for
  double record_bytes = 0;  // mean bytes per record; 0: unknown
  double crossing = -1;  // the part of records that went to other ranks' tiles; below 0: not known
  RenderPlan last;  // plan of the last picture
  DrawSpeeds speeds;  // drawing speeds of ranks
  double assembled_pixel_s = 0;  // time to put a pixel of another rank into the picture, s; 0: unknown
  int axis = 0;  // axis of the domains
};

/// Seconds that a rank of speed 1 takes to draw so many records, on tiles of so many pixels.
double drawing_s(const image::View& view, std::span<const image::Sprite> sprites, double records, double pixels);

/// Estimated time of a picture on one path, s, from the first projected particle to the last actions of the next frame,
/// on ranks with a processor each.
struct RenderEstimate {
  RenderPlan plan;
  double seconds = 0;
};

/// Plans one path. Without counts of a picture of this size, particles are taken to be everywhere in it.
RenderEstimate estimate(image::View::Path path, const image::View& view, std::span<const image::Sprite> sprites,
                        const RenderLoad& load, const roles::Cast& cast, int ranks);

/// The path that the view asks for, or the one of the least estimate; another one where the picture cannot be made that
/// way: see below. The pixels are the same.
RenderPlan plan_render(const image::View& view, std::span<const image::Sprite> sprites, const RenderLoad& load,
                       const roles::Cast& cast, int ranks);

/// The blend of the particles that calculators may draw into partial tiles, which then are merged in any order: light
/// where all particles of the picture only add it; else opaque ones, but not for the layer of velocities, which partial
/// tiles do not have. The others go to the owners of tiles as records, also on the path composite. None: all do.
std::optional<image::Sprite::Blend> merged_blend(const image::View& view, std::span<const image::Sprite> sprites);

}  // namespace motes::engine
