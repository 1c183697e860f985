#include "interactions/overlap.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace motes::interactions {

namespace {

// Reads the present position of particle i.
void place_of(const Crowd& crowd, std::size_t i, float (&x)[3]) {
  for (std::size_t c = 0; c < 3; ++c) x[c] = crowd.at[c].of(i, crowd.own);
}

}  // namespace

void Overlaps::add(float distance2, float reach) {
  if (distance2 < reach * reach) found_.push_back(1 - std::sqrt(distance2) / reach);
}

float Overlaps::percentile_99() {
  if (found_.empty()) return 0;
  const auto at = found_.begin() + static_cast<std::ptrdiff_t>((found_.size() - 1) * 99 / 100);
  std::nth_element(found_.begin(), at, found_.end());
  return *at;
}

float overlap_99(const Spheres& first, const Spheres& second) {
  const bool same = first.cells == second.cells;
  const CellsView own = first.cells->view(first.crowd->own);
  const CellsView others = second.cells->view(second.crowd->own);
  const std::vector<Row>& rows = first.cells->rows();
  Overlaps overlaps(first.crowd->own);
  for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
    for (std::uint32_t i = rows[r].first; i < rows[r].end(); ++i) {
      if (own.order[i] >= own.own || !overlaps.takes_next()) continue;
      float x[3];
      place_of(*first.crowd, own.order[i], x);
      for (const Row* row : rows_around(*second.cells, rows[r].x, rows[r].y)) {
        each_near(others, *row, own.z[i], [&](std::uint32_t j) {
          if (same && i == j) return;
          float y[3];
          place_of(*second.crowd, others.order[j], y);
          const float d2 =
              (x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) + (x[2] - y[2]) * (x[2] - y[2]);
          overlaps.add(d2, first.radius_at(i) + second.radius_at(j));
        });
      }
    }
  }
  return overlaps.percentile_99();
}

}  // namespace motes::interactions
