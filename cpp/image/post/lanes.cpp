// Selects the build of the lanes that this process runs.
#include "image/light/light_lanes.h"
#include "image/liquid/liquid_lanes.h"
#include "image/post/bloom_lanes.h"
#include "image/project/project_lanes.h"
#include "image/project/project_wide_lanes.h"
#include "image/raster/splat_lanes.h"
#include "image/raster/wide_lanes.h"
#include "image/raycast/cast.h"
#include "simd/builds.h"
#include "simd/isa.h"

namespace motes::image {

const BloomLanes& bloom_lanes() { return simd::choose<BloomLanes>(MOTES_BUILDS(bloom_lanes)); }
const CastLanes& cast_lanes() { return simd::choose<CastLanes>(MOTES_BUILDS(cast_lanes)); }
const LightLanes& light_lanes() { return simd::choose<LightLanes>(MOTES_BUILDS(light_lanes)); }
const LiquidLanes& liquid_lanes() { return simd::choose<LiquidLanes>(MOTES_BUILDS(liquid_lanes)); }
const ProjectLanes& project_lanes() { return simd::choose<ProjectLanes>(MOTES_BUILDS(project_lanes)); }
const ProjectWideLanes& project_wide_lanes() {
  return simd::choose<ProjectWideLanes>(MOTES_BUILDS(project_wide_lanes));
}
const WideLanes& wide_lanes() { return simd::choose<WideLanes>(MOTES_BUILDS(wide_lanes)); }
const SplatLanes& splat_lanes() { return simd::choose<SplatLanes>(MOTES_BUILDS(splat_lanes)); }

}  // namespace motes::image
