// Trees and grids of ranks: everybody is reached, once, by few.
#include <algorithm>
#include <map>
#include <set>

#include "check.h"
#include "roles/grid.h"
#include "roles/tree.h"

using namespace motes::roles;

namespace {

const int kSizes[] = {1, 2, 3, 4, 5, 8, 9, 10, 17, 64, 100, 513};

}  // namespace

TEST(tree_reaches_all_ranks_once) {
  for (const int size : kSizes) {
    for (const int fan_out : {1, 2, 3, 8, 1000}) {
      for (const Cast& cast : {cast_auto(size), cast_shared(size)}) {
        std::map<int, int> parent;
        std::map<int, int> depth;
        int height = 0;
        for (int rank = 0; rank < size; ++rank) {
          const Tree tree(cast, size, fan_out, rank);
          CHECK(tree.size() == size && tree.rank_at(tree.own().first) == rank);
          CHECK(static_cast<int>(tree.children().size()) <= fan_out);
          CHECK(tree.root() == (rank == cast.manager) && tree.leaf() == (tree.own().size() == 1));
          int next = tree.own().first + 1;
          for (const Tree::Range& child : tree.children()) {
            CHECK(child.first == next && child.end > child.first && child.height < tree.own().height);
            next = child.end;
            CHECK(parent.emplace(tree.rank_at(child.first), rank).second);
          }
          CHECK(next == tree.own().end);
          depth[rank] = tree.depth();
          height = std::max(height, tree.depth());
          CHECK(Tree(cast, size, fan_out, cast.manager).height() == tree.height());
          if (!tree.root()) CHECK(tree.depth() + tree.own().height <= tree.height());
        }
        CHECK(static_cast<int>(parent.size()) == size - 1);
        for (const auto& [child, head] : parent) {
          CHECK(Tree(cast, size, fan_out, child).parent() == head && depth[child] == depth[head] + 1);
        }
        const Tree tree(cast, size, fan_out, cast.manager);
        CHECK(tree.height() == height && tree.own().size() == size);
        if (fan_out >= size - 1) CHECK(height <= 1);
      }
    }
  }
}

TEST(who_only_draws_holds_nobody_up) {
  for (const int size : kSizes) {
    if (size < 3) continue;
    const Cast cast = cast_auto(size);
    CHECK(Tree(cast, size, 2, cast.image_generator).leaf());
  }
  CHECK(Tree(cast_auto(4096), 4096, 8, 1).height() == 4);
}

TEST(grid_brings_everything_to_everybody) {
  for (int calculators = 1; calculators < 150; ++calculators) {
    const Grid grid(calculators);
    std::vector<std::set<int>> arrived(static_cast<std::size_t>(calculators));  // whose words for it each one has
    std::map<std::pair<int, int>, std::set<int>> between;  // who stands for whom: at, owner -> from
    for (int from = 0; from < calculators; ++from) {
      const std::vector<int> along = grid.along(from);
      CHECK(static_cast<int>(along.size()) == grid.columns());
      for (int owner = 0; owner < calculators; ++owner) {
        const int at = along[static_cast<std::size_t>(owner % grid.columns())];
        const std::vector<int> senders = grid.from_along(at);
        CHECK(std::count(senders.begin(), senders.end(), from) == 1);
        const std::vector<int> column = grid.column(at);
        CHECK(std::count(column.begin(), column.end(), owner) == 1);
        CHECK((between[{at, owner}].insert(from).second));
      }
    }
    std::size_t first = 0;
    for (int at = 0; at < calculators; ++at) {
      first += grid.from_along(at).size();
      for (const int owner : grid.column(at)) {
        for (const int from : between[{at, owner}]) CHECK(arrived[static_cast<std::size_t>(owner)].insert(from).second);
      }
    }
    CHECK(first == static_cast<std::size_t>(calculators) * static_cast<std::size_t>(grid.columns()));
    for (const std::set<int>& senders : arrived) CHECK(static_cast<int>(senders.size()) == calculators);
    CHECK(grid.direct() == (calculators <= 16));
  }
  CHECK(Grid(4094).columns() == 64);
}
