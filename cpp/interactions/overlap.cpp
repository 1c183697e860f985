#include "interactions/overlap.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace motes::interactions {

namespace {

constexpr std::size_t kLooked = 1024;  // number of particles to sample

// Reads the present position of particle i.
void place_of(const Crowd& crowd, std::size_t i, float (&x)[3]) {
  for (std::size_t c = 0; c < 3; ++c) x[c] = crowd.at[c].of(i, crowd.own);
}

}  // namespace

float overlap_99(const Spheres& first, const Spheres& second) {
  const bool same = first.cells == second.cells;
  const CellsView own = first.cells->view(first.crowd->own);
  const CellsView others = second.cells->view(second.crowd->own);
  const std::vector<Row>& rows = first.cells->rows();
  const std::size_t stride = 1 + first.crowd->own / kLooked;
  std::vector<float> found;
  std::size_t number = 0;
  for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
    for (std::uint32_t i = rows[r].first; i < rows[r].end(); ++i) {
      if (own.order[i] >= own.own || number++ % stride != 0) continue;
      float x[3];
      place_of(*first.crowd, own.order[i], x);
      for (const Row* row : rows_around(*second.cells, rows[r].x, rows[r].y)) {
        each_near(others, *row, own.z[i], [&](std::uint32_t j) {
          if (same && (i == j || (first.ghosts_alone && others.order[j] < others.own))) return;
          float y[3];
          place_of(*second.crowd, others.order[j], y);
          const float reach = first.radius_at(i) + second.radius_at(j);
          const float d2 =
              (x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) + (x[2] - y[2]) * (x[2] - y[2]);
          if (d2 < reach * reach) found.push_back(1 - std::sqrt(d2) / reach);
        });
      }
    }
  }
  if (found.empty()) return 0;
  const auto at = found.begin() + static_cast<std::ptrdiff_t>((found.size() - 1) * 99 / 100);
  std::nth_element(found.begin(), at, found.end());
  return *at;
}

}  // namespace motes::interactions
