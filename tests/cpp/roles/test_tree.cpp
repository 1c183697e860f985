// Trees and rings of ranks: every rank is reached, once, with few messages each.
#include <algorithm>
#include <map>
#include <set>

#include "roles/ring.h"
#include "roles/tree.h"
#include "support/check.h"

namespace motes::test_tree {
using namespace roles;

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

TEST(tree_finds_calculators_without_a_search) {
  const Cast in_the_middle{3, 0, {5, 4, 3, 2, 1}};  // the manager is the third calculator
  std::vector<std::pair<int, Cast>> casts{{6, in_the_middle}};
  for (const int size : kSizes) {
    casts.emplace_back(size, cast_auto(size));
    casts.emplace_back(size, cast_shared(size));
  }
  for (const auto& [size, cast] : casts) {
    for (const int fan_out : {1, 2, 8, 1000}) {
      for (int rank = 0; rank < size; ++rank) {
        const Tree tree(cast, size, fan_out, rank);
        std::map<int, int> rows;  // of the calculators of this part of the tree, by place
        for (int c = 0; c < static_cast<int>(cast.calculators.size()); ++c) {
          CHECK(tree.rank_at(tree.place_of(c)) == cast.calculators[static_cast<std::size_t>(c)]);
          if (tree.holds(tree.own(), c)) rows[tree.place_of(c)] = tree.row_of(c);
        }
        int next = 0;
        for (const auto& [place, row] : rows) CHECK(row == next++);
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

TEST(ring_brings_everything_to_everybody) {
  for (int calculators = 1; calculators < 150; ++calculators) {
    std::vector<Ring> rings;
    for (int c = 0; c < calculators; ++c) rings.emplace_back(calculators, c);
    std::vector<std::vector<std::pair<int, int>>> here(static_cast<std::size_t>(calculators));  // from, owner
    for (int c = 0; c < calculators; ++c) {
      for (int owner = 0; owner < calculators; ++owner) here[static_cast<std::size_t>(c)].emplace_back(c, owner);
    }
    for (int step = 0; step < rings[0].steps(); ++step) {
      std::vector<std::vector<std::pair<int, int>>> next(here.size());
      for (int at = 0; at < calculators; ++at) {
        const Ring& ring = rings[static_cast<std::size_t>(at)];
        const std::vector<int> ahead = ring.ahead(step);
        for (const int to : ahead) {
          const std::vector<int> senders = rings[static_cast<std::size_t>(to)].behind(step);
          CHECK(std::count(senders.begin(), senders.end(), at) == 1);
        }
        for (const auto& word : here[static_cast<std::size_t>(at)]) {
          const auto digit = static_cast<std::size_t>(ring.digit(word.second, step));
          CHECK(digit <= ahead.size());
          next[static_cast<std::size_t>(digit == 0 ? at : ahead[digit - 1])].push_back(word);
        }
      }
      here = std::move(next);
    }
    for (int at = 0; at < calculators; ++at) {
      const auto& words = here[static_cast<std::size_t>(at)];
      CHECK(static_cast<int>(words.size()) == calculators);
      for (const auto& word : words) CHECK(word.second == at);
    }
    CHECK(rings[0].steps() <= 1 || calculators > 16);
  }
}

TEST(ring_needs_few_messages) {
  const Ring ring(4094, 7);
  int messages = 0;
  for (int step = 0; step < ring.steps(); ++step) messages += static_cast<int>(ring.ahead(step).size());
  CHECK(messages == 3 * 15);
  CHECK(Ring(1, 0).steps() == 0);
  CHECK(Ring(16, 3).ahead(0).size() == 15);
}

}  // namespace motes::test_tree
