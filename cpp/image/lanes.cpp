// Selects the build of the lanes that this process runs.
#include "image/bloom_lanes.h"
#include "image/cast.h"
#include "image/project_lanes.h"
#include "image/project_wide_lanes.h"
#include "image/splat_lanes.h"
#include "image/wide_lanes.h"
#include "simd/isa.h"

namespace motes::image {

const BloomLanes& bloom_lanes() { return simd::choose(sse2::bloom_lanes, avx2::bloom_lanes, avx512::bloom_lanes); }
const CastLanes& cast_lanes() { return simd::choose(sse2::cast_lanes, avx2::cast_lanes, avx512::cast_lanes); }

const ProjectLanes& project_lanes() {
  return simd::choose(sse2::project_lanes, avx2::project_lanes, avx512::project_lanes);
}

const ProjectWideLanes& project_wide_lanes() {
  return simd::choose(sse2::project_wide_lanes, avx2::project_wide_lanes, avx512::project_wide_lanes);
}

const WideLanes& wide_lanes() { return simd::choose(sse2::wide_lanes, avx2::wide_lanes, avx512::wide_lanes); }

const SplatLanes& splat_lanes() { return simd::choose(sse2::splat_lanes, avx2::splat_lanes, avx512::splat_lanes); }

}  // namespace motes::image
