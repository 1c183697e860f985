// Positions and widths of a vector of particles. Compiled once for each instruction set.
#pragma once

#include "image/light/light_lanes.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

MOTES_INLINE Floats value_or(const float* plane, std::size_t i, float of_all) {
  return plane != nullptr ? load(plane + i) : all(of_all);
}
MOTES_INLINE Floats3 particle_place(const image::ParticlePlanes& p, std::size_t i) {
  return {load(p.position[0] + i), load(p.position[1] + i), load(p.position[2] + i)};
}
MOTES_INLINE Floats length_of_way(Floats3 v) { return sqrt(max(dot(v, v), all(1e-30f))); }

MOTES_INLINE Floats diameter_at(const image::ParticleWidth& w, const image::ParticlePlanes& p, Floats3 place,
                                std::size_t i) {
  if (w.own) return max(value_or(p.size, i, p.size_of_all), Floats{});
  return length_of_way(place - all3(w.eye)) * w.per_metre;
}

}  // namespace motes::MOTES_ISA
