#include "engine/render/render_order.h"

#include <algorithm>
#include <cmath>

#include "image/camera.h"

namespace motes::engine {
namespace {

// A rank and the desired position of its stretch of tiles, from 0 (first tile) to 1 (last tile).
struct Placed {
  double at;
  int rank;
};

// Orders ranks by their domains, with ranks without a domain evenly in between, so stretches of tiles are near the
// calculators' own particles.
std::vector<int> spread_out(const roles::Cast& cast, int ranks) {
  std::vector<Placed> placed;
  const auto spread = [&](const std::vector<int>& some) {
    for (std::size_t i = 0; i < some.size(); ++i) {
      placed.push_back({(static_cast<double>(i) + 0.5) / static_cast<double>(some.size()), some[i]});
    }
  };
  std::vector<int> others;
  for (int r = 0; r < ranks; ++r) {
    if (cast.calculator_of(r) < 0) others.push_back(r);
  }
  spread(cast.calculators);
  spread(others);
  // At equal positions, calculators go further outside, since their particles reach the picture's edge.
  std::stable_sort(placed.begin(), placed.end(), [&](const Placed& a, const Placed& b) {
    if (a.at != b.at) return a.at < b.at;
    const bool a_calculates = cast.calculator_of(a.rank) >= 0, b_calculates = cast.calculator_of(b.rank) >= 0;
    return a.at < 0.5 ? a_calculates && !b_calculates : !a_calculates && b_calculates;
  });
  std::vector<int> order;
  for (const Placed& p : placed) order.push_back(p.rank);
  return order;
}

}  // namespace

Deal deal_along(int axis, const image::View& view, const roles::Cast& cast, int ranks) {
  const image::Lens lens = image::lens(view);
  const auto along = static_cast<std::size_t>(axis);
  const double right = lens.right[along], down = -lens.up[along];
  Deal deal;
  deal.order = std::abs(right) > std::abs(down) ? image::TileOrder::columns : image::TileOrder::rows;
  deal.ranks = spread_out(cast, ranks);
  if ((deal.order == image::TileOrder::columns ? right : down) < 0) std::reverse(deal.ranks.begin(), deal.ranks.end());
  return deal;
}

}  // namespace motes::engine
