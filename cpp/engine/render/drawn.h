// The particles of a system as a picture shows them.
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

/// Returns the columns that a picture shows, as pointers into the store.
image::Drawn drawn(const particles::Store& store);

/// The particles of a system as a picture shows them: the particles themselves, or the spheres of clumps unless each
/// clump is drawn as a mesh or ribbon. Owns the columns of spheres.
class DrawnSystem {
 public:
  DrawnSystem(const Script& script, std::size_t system, particles::Store& store, threads::Pool& pool);
  DrawnSystem(DrawnSystem&&) noexcept = default;
  /// Returns the system's index.
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

/// Returns a DrawnSystem for each system.
std::vector<DrawnSystem> drawn_systems(const Script& script, const Calculator& calculator, threads::Pool& pool);

/// Returns `count` of the particles, from `first` on.
image::Drawn part_of(const image::Drawn& all, std::size_t first, std::size_t count);

/// Returns how records of a system are made, if the current record has a view; the same on all ranks.
image::Projection projection(const Script& script, std::size_t system);

}  // namespace motes::engine
