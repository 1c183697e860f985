#include "interactions/pairs.h"

namespace motes::interactions {

namespace {

struct Listing {
  float reach2;
  const CellsView& cells;
  const Crowd& crowd;
  const float* const (&column)[6];
  PairList& list;

  void add(std::uint32_t i, std::uint32_t j) {
    float r2 = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const float d = column[c][j] - column[c][i];
      r2 += d * d;
    }
    if (!(r2 < reach2)) return;
    list.own.push_back(cells.order[i]);
    list.id.push_back(crowd.id(cells.order[i]));
    list.other_id.push_back(crowd.id(cells.order[j]));
    for (std::size_t c = 0; c < 3; ++c) {
      list.position.push_back(column[c][i]);
      list.other_position.push_back(column[c][j]);
      list.velocity.push_back(column[3 + c][i]);
      list.other_velocity.push_back(column[3 + c][j]);
    }
  }
};

}  // namespace

PairList pairs_within(float reach, const Cells& cells, const Crowd& crowd, const float* const (&column)[6],
                      const std::vector<std::uint8_t>* chosen) {
  PairList list;
  const CellsView view = cells.view(crowd.own);
  const std::vector<Row>& rows = cells.rows();
  Listing listing{reach * reach, view, crowd, column, list};
  for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
    const std::vector<const Row*> near = rows_around(cells, rows[r].x, rows[r].y);
    for (std::uint32_t i = rows[r].first; i < rows[r].end(); ++i) {
      const std::uint32_t own = view.order[i];
      if (own >= crowd.own || (chosen != nullptr && (*chosen)[own] == 0)) continue;
      for (const Row* row : near) {
        each_near(view, *row, view.z[i], [&](std::uint32_t j) {
          if (j != i) listing.add(i, j);
        });
      }
    }
  }
  return list;
}

}  // namespace motes::interactions
