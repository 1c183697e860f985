#include "interactions/clumps.h"

#include <algorithm>
#include <cmath>

#include "simd/float_mode.h"

namespace motes::interactions {

void over_clumps(const ClumpTask& task, std::size_t count, void (*kernel)(const ClumpTask&), threads::Pool& pool) {
  threads::over_ranges(pool, count, kRange, [&](std::size_t first, std::size_t last) {
    const simd::FloatMode mode;
    ClumpTask range = task;
    range.first = first;
    range.last = last;
    kernel(range);
  });
}

ClumpColumns::ClumpColumns(const Side& side, bool ghosts)
    : count_(!ghosts                  ? side.store->size()
             : side.ghosts != nullptr ? side.ghosts->ids.size()
                                      : 0) {
  const std::vector<Column> columns =
      columns_of(components_of(actions::facts(actions::Kind::contact_clumps).reads), side);
  for (std::size_t c = 0; c < clump_columns; ++c) {
    values_[c].assign(count_ + particles::kPadding, columns[c].value);
    const float* const from = ghosts ? columns[c].ghosts : columns[c].own;
    if (from != nullptr) std::copy_n(from, count_, values_[c].begin());
    columns_[c] = values_[c].data();
  }
}

ClumpTask ClumpColumns::task(const std::vector<ClumpSphere>& spheres) const {
  ClumpTask task;
  task.column = columns_;
  task.spheres = spheres.data();
  task.count = spheres.size();
  task.stride = count_;
  return task;
}

void ClumpColumns::place(const std::vector<ClumpSphere>& spheres, float* const* placed, threads::Pool& pool) const {
  ClumpTask task = this->task(spheres);
  task.placed = placed;
  over_clumps(task, count_, kernels().place_spheres, pool);
}

std::vector<ClumpSphere> spheres_of(actions::TableKey key) {
  const std::shared_ptr<const actions::LookupTable> table = actions::table(key);
  std::vector<ClumpSphere> spheres(table->values.size() / 4);
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    const float* const numbers = table->values.data() + 4 * k;
    spheres[k] = {{numbers[0], numbers[1], numbers[2]}, numbers[3]};
  }
  return spheres;
}

void place_spheres(const particles::Store& store, const std::vector<ClumpSphere>& spheres, float* const* placed,
                   threads::Pool& pool) {
  Side side;
  side.store = const_cast<particles::Store*>(&store);  // NOLINT(cppcoreguidelines-pro-type-const-cast): only read
  ClumpColumns(side, false).place(spheres, placed, pool);
}

float bounding_radius(const std::vector<ClumpSphere>& spheres) {
  double most = 0;
  for (const ClumpSphere& sphere : spheres) {
    double square = 0;
    for (const float x : sphere.at) square += double{x} * double{x};
    most = std::max(most, std::sqrt(square) + double{sphere.radius});
  }
  return static_cast<float>(most * (1 + 1e-6));
}

}  // namespace motes::interactions
