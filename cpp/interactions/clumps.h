// Clumps: particles that are rigid groups of spheres. Each has a template, scaled by its size and turned by its
// orientation.
#pragma once

#include <cstddef>
#include <vector>

#include "actions/tables.h"
#include "interactions/kernels.h"
#include "interactions/sides.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::interactions {

/// Returns the spheres of a clump template, which is stored as a table.
std::vector<ClumpSphere> spheres_of(actions::TableKey key);
/// Writes the SphereAt columns of all spheres of a store's clumps: sphere k of clump i is at k * size + i.
void place_spheres(const particles::Store& store, const std::vector<ClumpSphere>& spheres, float* const* placed,
                   threads::Pool& pool);
/// Returns the radius, m, of the ball around its centre that encloses a clump of size 1.
float bounding_radius(const std::vector<ClumpSphere>& spheres);

/// Runs a kernel over ranges of `count` clumps.
void over_clumps(const ClumpTask& task, std::size_t count, void (*kernel)(const ClumpTask&), threads::Pool& pool);

/// Columns of clumps, readable to the end of the last vector.
class ClumpColumns {
 public:
  /// Copies the columns of a side's own clumps or of its ghosts.
  ClumpColumns(const Side& side, bool ghosts);
  ClumpColumns(const ClumpColumns&) = delete;
  ClumpColumns& operator=(const ClumpColumns&) = delete;

  std::size_t count() const { return count_; }
  ClumpTask task(const std::vector<ClumpSphere>& spheres) const;
  /// Writes the SphereAt columns of the spheres.
  void place(const std::vector<ClumpSphere>& spheres, float* const* placed, threads::Pool& pool) const;

 private:
  std::size_t count_;
  std::vector<float> values_[clump_columns];
  const float* columns_[clump_columns] = {};
};

}  // namespace motes::interactions
