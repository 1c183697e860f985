// What a system contributes to a picture.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/state/population.h"
#include "engine/state/script.h"
#include "image/project/projector.h"
#include "image/scene.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::engine {

/// The columns that a picture shows. They point into the store.
image::Drawn drawn(const particles::Store& store);

/// What a picture shows of a system: its particles, or the spheres of its clumps (but where each clump is a mesh or a
/// ribbon), whose columns live as long as this.
class DrawnSystem {
 public:
  DrawnSystem(const Script& script, std::size_t system, particles::Store& store, threads::Pool& pool);
  DrawnSystem(DrawnSystem&&) noexcept = default;
  /// Which system it is.
  std::size_t number() const { return number_; }
  const image::Drawn& columns() const { return drawn_; }

 private:
  void expand(const particles::Store& store, actions::TableKey clumps, threads::Pool& pool);
  const float* repeat(const float* plane, std::size_t clumps);

  std::size_t number_;
  image::Drawn drawn_;
  std::vector<std::vector<float>> planes_;
  particles::IdList ids_;  // of spheres
};

/// What pictures show of all systems.
std::vector<DrawnSystem> drawn_systems(const Script& script, const Calculator& calculator, threads::Pool& pool);

/// `count` of them, from the first one on.
image::Drawn part_of(const image::Drawn& all, std::size_t first, std::size_t count);

/// Returns how records of a system are made, if the current record has a view; equal on every rank.
image::Projection projection(const Script& script, std::size_t system);

}  // namespace motes::engine
