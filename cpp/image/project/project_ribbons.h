// Turns ribbons into records, and finds the tiles that they touch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/camera.h"
#include "image/layout.h"
#include "image/project/sort_tiles.h"
#include "image/scene.h"

namespace motes::image {

/// Colours of the ribbons of particles first .. last - 1: at the particle, then at each of its past positions. Planes
/// as ParticleLight writes them; null: each ribbon has its particle's colour everywhere.
struct RibbonLight {
  const float* planes = nullptr;
  std::size_t stride = 0;
  float at(std::size_t place, std::size_t channel, std::size_t i) const {
    return planes[(3 * place + channel) * stride + i];
  }
};

struct RibbonBatch {
  std::vector<RibbonRecord> records;
  std::vector<std::size_t> particles;  // the particle of each record
  std::vector<FurtherTile> tiles;      // of each record
};

/// Replaces the content of `batch` by the visible ribbons of particles first .. last - 1. `open`: exposure time, s.
void project_ribbons(const Drawn& particles, const Sprite& sprite, const View& view, double open,
                     const RibbonLight& light, std::size_t first, std::size_t last, RibbonBatch& batch);

}  // namespace motes::image
