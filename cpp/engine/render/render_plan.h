// Plans which rank draws which part of a frame's picture. The manager plans from the last pictures and sends the plan
// to all ranks with *begin*.
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

/// The plan of a picture: each rank draws a stretch of its tiles in the order of slots. The records that it needs from
/// a batch are then one range, and its part of the picture is nearly a rectangle.
struct RenderPlan {
  image::View::Path path = image::View::Path::gather;  // never automatic
  image::TileOrder order = image::TileOrder::rows;  // order of slots; rows if one rank draws all
  std::vector<std::uint32_t> firsts, ends;  // rank r draws slots firsts[r] .. ends[r] - 1

  int first(int rank) const { return static_cast<int>(firsts[static_cast<std::size_t>(rank)]); }
  int end(int rank) const { return static_cast<int>(ends[static_cast<std::size_t>(rank)]); }
  bool draws(int rank) const { return first(rank) < end(rank); }
  /// Returns whether the plan deals exactly `tiles` tiles to `ranks` ranks.
  bool covers(int tiles, int ranks) const;

  bool operator==(const RenderPlan&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, RenderPlan& plan) {
  visit(plan.path, plan.order, plan.firsts, plan.ends);
}

/// The latest numbers that the manager has about the work of pictures.
struct RenderLoad {
  /// The work of one calculator.
  struct Calculator {
    double particles = 0;
    double act_s = 0;  // seconds to run its list in a frame
    double active = 0;  // number of tiles that its particles touch
  };

  image::Grid grid;  // grid of the counted picture; 0x0: none
  std::vector<std::uint32_t> counts;  // records in each of its tiles
  std::vector<Calculator> calculators;  // in the order of the domains
  double scale = 1;  // under a simulator: how many particles and records each computed one stands for
  double record_bytes = 0;  // mean bytes per record; 0: unknown
  double crossing = -1;  // fraction of records that went to other ranks' tiles; below 0: unknown
  RenderPlan last;  // plan of the last picture
  DrawSpeeds speeds;  // drawing speeds of ranks
  double assembled_pixel_s = 0;  // seconds to assemble a pixel of another rank; 0: unknown
  int axis = 0;  // axis of the domains
};

/// Returns the seconds that a rank of speed 1 takes to draw `records` records on tiles of `pixels` pixels.
double drawing_s(const image::View& view, std::span<const image::Sprite> sprites, double records, double pixels);

/// The plan of a picture on one path and its estimated time, from the first projected particle to the last action of
/// the next frame, with one processor per rank.
struct RenderEstimate {
  RenderPlan plan;
  double seconds = 0;
};

/// Plans a picture on one path. Without counts of a picture of this size, assumes that particles are spread evenly over
/// it.
RenderEstimate estimate(image::View::Path path, const image::View& view, std::span<const image::Sprite> sprites,
                        const RenderLoad& load, const roles::Cast& cast, int ranks);

/// Plans a picture on the path that the view asks for or, if automatic, the fastest one by estimate. If nothing can be
/// merged (merged_blend), `tiles` replaces `composite`; a liquid's surface needs the whole picture in one place, so
/// `gather` replaces all others. The pixels are the same on all paths.
RenderPlan plan_render(const image::View& view, std::span<const image::Sprite> sprites, const RenderLoad& load,
                       const roles::Cast& cast, int ranks);

/// Returns the blend of the particles that calculators may draw into partial tiles, which can be merged in any order:
/// `add` if all particles are additive; otherwise `opaque`, unless the view has a velocity layer, which partial tiles
/// lack. Other particles go to the tiles' owners as records, even on path composite. None: all particles do.
std::optional<image::Sprite::Blend> merged_blend(const image::View& view, std::span<const image::Sprite> sprites);

}  // namespace motes::engine
