// gravitate. With far="cells", groups distant particles into cells (Barnes-Hut) of a pyramid of levels over a cube that
// holds all particles. Moments of cells are integers, so their sums over all ranks have the same bits in any order.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "interactions/kinds/families.h"
#include "interactions/kinds/sweeping.h"
#include "particles/blocks.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using particles::Store;

// Bounds of finite particles: maxima of x, y, z and of -x, -y, -z; -infinity if there are none.
using Bounds = std::vector<float>;

// The cube: 2^bits leaves along each axis. Leaves are anchored at the origin; their edge is a power of two.
struct Cube {
  int bits = 2;
  double leaf = 1;  // m
  std::array<std::int32_t, 3> low{};  // index of its first leaf along each axis

  // Returns a cube around `bounds`, with about twelve particles per leaf if they are spread evenly. All ranks must
  // agree on the arguments.
  static Cube around(const Bounds& bounds, std::uint64_t particles);

  std::size_t leaves() const { return std::size_t{1} << 3 * bits; }
};

// Four integers per leaf; coordinates are in units of the cube's edge / 2^20:
//
//   [count, sum of x, sum of y, sum of z] [count, ...] ...
using Moments = std::vector<std::int64_t>;

constexpr double kPerLeaf = 12;
constexpr int kMostBits = 7;
constexpr double kCoordinates = 1048576;  // 2^20: integer coordinates along the cube's edge
constexpr double kFarthestLeaf = 524288;  // 2^19: cell numbers reach up to 2^20

struct Index {
  std::int32_t x, y, z;
};

std::size_t place(int bits, const Index& at) {
  return static_cast<std::size_t>(at.x) << 2 * bits | static_cast<std::size_t>(at.y) << bits |
         static_cast<std::size_t>(at.z);
}

bool inside(std::int32_t number, int bits) { return number >= 0 && number < 1 << bits; }

// A level of the pyramid: weight and centre of mass of each cell.
struct Level {
  int bits = 0;
  std::vector<std::int64_t> moments;
  std::vector<float> weight, at[3];
};

Level level_of(const Cube& cube, int bits, std::vector<std::int64_t> moments, float strength) {
  Level level;
  level.bits = bits;
  level.moments = std::move(moments);
  const std::size_t cells = std::size_t{1} << 3 * bits;
  const double edge = cube.leaf * static_cast<double>(1 << cube.bits);
  level.weight.resize(cells);
  for (std::vector<float>& at : level.at) at.resize(cells);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const std::int64_t* m = &level.moments[4 * cell];
    level.weight[cell] = strength * static_cast<float>(m[0]);
    for (std::size_t c = 0; c < 3 && m[0] != 0; ++c) {
      const double mean = static_cast<double>(m[1 + c]) / static_cast<double>(m[0]) / kCoordinates;
      level.at[c][cell] = static_cast<float>(cube.leaf * static_cast<double>(cube.low[c]) + mean * edge);
    }
  }
  return level;
}

std::vector<std::int64_t> parents_of(const std::vector<std::int64_t>& moments, int bits) {
  std::vector<std::int64_t> sums(4 * (std::size_t{1} << 3 * (bits - 1)), 0);
  const std::int32_t side = 1 << bits;
  for (std::int32_t x = 0; x < side; ++x) {
    for (std::int32_t y = 0; y < side; ++y) {
      for (std::int32_t z = 0; z < side; ++z) {
        const std::size_t from = place(bits, {x, y, z});
        const std::size_t to = place(bits - 1, {x / 2, y / 2, z / 2});
        for (std::size_t k = 0; k < 4; ++k) sums[4 * to + k] += moments[4 * from + k];
      }
    }
  }
  return sums;
}

// Returns the levels from the leaves up to level 2; above it, no two cells are far apart.
std::vector<Level> levels_of(const Cube& cube, const Moments& moments, float strength) {
  std::vector<Level> levels;
  std::vector<std::int64_t> sums = moments;
  for (int bits = cube.bits; bits >= 2; --bits) {
    std::vector<std::int64_t> above = parents_of(sums, bits);
    levels.push_back(level_of(cube, bits, std::move(sums), strength));
    sums = std::move(above);
  }
  return levels;
}

// The sources of one leaf, in this order: near particles, then cells, level by level.
struct Sources {
  std::vector<float> column[4];  // x, y, z, weight

  void clear() {
    for (std::vector<float>& values : column) values.clear();
  }
  void add(float x, float y, float z, float weight) {
    const float values[4] = {x, y, z, weight};
    for (std::size_t c = 0; c < 4; ++c) column[c].push_back(values[c]);
  }
  std::size_t size() const { return column[0].size(); }
};

class Seeing {
 public:
  Seeing(const Cube& cube, const std::vector<Level>& levels, const Cells& cells, const float* const (&column)[3],
         float strength)
      : cube_(cube), levels_(levels), cells_(cells), column_(column), strength_(strength) {}

  // Finds the sources of leaf z of a row.
  void find(const Row& row, std::int32_t z, Sources& to) const {
    to.clear();
    add_near(row, z, to);
    for (const Level& level : levels_) {
      const int up = cube_.bits - level.bits;
      add_far(level, {(row.x - cube_.low[0]) >> up, (row.y - cube_.low[1]) >> up, (z - cube_.low[2]) >> up}, to);
    }
  }

 private:
  void add_near(const Row& row, std::int32_t z, Sources& to) const {
    const CellsView view = cells_.view(0);
    for (const Row* near : rows_around(cells_, row.x, row.y)) {
      each_near(view, *near, z,
                [&](std::uint32_t k) { to.add(column_[0][k], column_[1][k], column_[2][k], strength_); });
    }
  }

  // Adds the children of the parent's neighbours that are not neighbours of this cell.
  static void add_far(const Level& level, const Index& own, Sources& to) {
    const std::int32_t last = (1 << level.bits) - 1;
    const auto from = [](std::int32_t n) { return std::max(0, (n / 2 - 1) * 2); };
    const auto end = [&](std::int32_t n) { return std::min(last, (n / 2 + 1) * 2 + 1); };
    for (std::int32_t x = from(own.x); x <= end(own.x); ++x) {
      for (std::int32_t y = from(own.y); y <= end(own.y); ++y) {
        for (std::int32_t z = from(own.z); z <= end(own.z); ++z) {
          const bool near = std::abs(x - own.x) <= 1 && std::abs(y - own.y) <= 1 && std::abs(z - own.z) <= 1;
          const std::size_t cell = place(level.bits, {x, y, z});
          if (near || level.weight[cell] == 0) continue;
          to.add(level.at[0][cell], level.at[1][cell], level.at[2][cell], level.weight[cell]);
        }
      }
    }
  }

  const Cube& cube_;
  const std::vector<Level>& levels_;
  const Cells& cells_;
  const float* const (&column_)[3];
  float strength_;
};

Bounds bounds_of(const Store& store) {
  Bounds bounds(6, -std::numeric_limits<float>::infinity());
  for (int c = 0; c < 3 && store.size() > 0; ++c) {
    const float* plane = store.plane(particles::position, c);
    const auto k = static_cast<std::size_t>(c);
    for (std::size_t i = 0; i < store.size(); ++i) {
      const float x = plane != nullptr ? plane[i] : store.uniform_value(particles::position)[k];
      if (!std::isfinite(x)) continue;
      bounds[k] = std::max(bounds[k], x);
      bounds[3 + k] = std::max(bounds[3 + k], -x);
    }
  }
  return bounds;
}

Cube Cube::around(const Bounds& bounds, std::uint64_t particles) {
  Cube cube;
  double farthest = 1e-30;
  double extent = 1e-30;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!std::isfinite(bounds[c]) || !std::isfinite(bounds[3 + c])) return cube;  // no finite particles
    const double high = static_cast<double>(bounds[c]);
    const double low = -static_cast<double>(bounds[3 + c]);
    extent = std::max(extent, high - low);
    farthest = std::max({farthest, std::abs(high), std::abs(low)});
  }
  while (cube.bits < kMostBits &&
         static_cast<double>(particles) > 2.83 * kPerLeaf * static_cast<double>(cube.leaves())) {
    ++cube.bits;
  }
  const double least = std::max(extent / static_cast<double>(1 << cube.bits), farthest / kFarthestLeaf);
  cube.leaf = std::exp2(std::ceil(std::log2(least)));
  const auto fits = [&] {
    for (std::size_t c = 0; c < 3; ++c) {
      const double first = std::floor(-static_cast<double>(bounds[3 + c]) / cube.leaf);
      const double last = std::floor(static_cast<double>(bounds[c]) / cube.leaf);
      if (last - first >= static_cast<double>(1 << cube.bits)) return false;
      cube.low[c] = static_cast<std::int32_t>(first);
    }
    return true;
  };
  while (!fits()) cube.leaf *= 2;
  return cube;
}

Moments moments_of(const Cube& cube, const Store& store) {
  Moments moments(4 * cube.leaves(), 0);
  const double edge = cube.leaf * static_cast<double>(1 << cube.bits);
  const float* plane[3];
  for (int c = 0; c < 3; ++c) plane[c] = store.plane(particles::position, c);
  for (std::size_t i = 0; i < store.size(); ++i) {
    std::int32_t leaf[3];
    std::int64_t coordinate[3];
    bool there = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const float x = plane[c] != nullptr ? plane[c][i] : store.uniform_value(particles::position)[c];
      const double from = static_cast<double>(x) - cube.leaf * static_cast<double>(cube.low[c]);
      there = there && std::isfinite(x);
      if (!there) break;
      leaf[c] = static_cast<std::int32_t>(std::floor(from / cube.leaf));
      coordinate[c] = static_cast<std::int64_t>(std::floor(from / edge * kCoordinates));
      there = inside(leaf[c], cube.bits);
    }
    if (!there) continue;
    std::int64_t* m = &moments[4 * place(cube.bits, {leaf[0], leaf[1], leaf[2]})];
    m[0] += 1;
    for (std::size_t c = 0; c < 3; ++c) m[1 + c] += coordinate[c];
  }
  return moments;
}

// Sums the sources in the 27 leaves around a particle one by one, and the others as cells.
class ByCells : public PairAction {
 public:
  explicit ByCells(const Meeting& meeting) : PairAction(meeting) {}

  Agreement own() override {
    Agreement own;
    own.more = bounds_of(*side(0).store);
    return own;
  }
  double range(const Agreement& agreed) const override { return 2 * cube(agreed).leaf; }
  AcrossEnds across_ends() const override { return AcrossEnds::refused; }
  std::size_t to_add(const Agreement& agreed) const override { return 4 * cube(agreed).leaves(); }
  Moments own_to_add(const Agreement& agreed) const override { return moments_of(cube(agreed), *side(0).store); }
  InteractionCounts act(const Agreement& agreed) override;

 private:
  Cube cube(const Agreement& agreed) const { return Cube::around(agreed.more, side(0).everywhere); }
};

InteractionCounts ByCells::act(const Agreement& agreed) {
  const simd::FloatMode mode;
  Store& store = *side(0).store;
  if (store.size() == 0) return {};
  const Cube cube = this->cube(agreed);
  const auto given = actions::numbers_of<actions::numbers::gravitate, float>(action());
  const float strength = given.magnitude * meeting_.step.dt, epsilon = given.epsilon;
  Scratch::Party& party = meeting_.scratch->party[0];
  const Crowd crowd = crowd_of(side(0), columns_of(reads(0), side(0)));
  party.cells.sort(crowd, cube.leaf, *meeting_.pool);
  const float* column[3];
  for (std::size_t c = 0; c < 3; ++c) {
    party.column[c].resize(padded(crowd.size()));
    party.cells.arrange(crowd, crowd.at[c], party.column[c].data(), *meeting_.pool);
    column[c] = party.column[c].data();
  }
  const std::vector<Level> levels = levels_of(cube, agreed.sums, strength);
  const Seeing seeing(cube, levels, party.cells, column, strength);
  const std::vector<Row>& rows = party.cells.rows();
  const CellsView view = party.cells.view(crowd.own);
  float* const v[3] = {store.writable_plane(particles::velocity, 0), store.writable_plane(particles::velocity, 1),
                       store.writable_plane(particles::velocity, 2)};
  std::vector<std::uint64_t> seen(rows.size(), 0);
  const std::vector<std::uint8_t>* const chosen = side(0).chosen;
  meeting_.pool->run(rows.size() - 1, [&](std::size_t r, std::size_t) {
    const simd::FloatMode in_thread;
    const Row& row = rows[r];
    if (!inside(row.x - cube.low[0], cube.bits) || !inside(row.y - cube.low[1], cube.bits)) return;
    Sources sources;
    for (std::uint32_t begin = row.first, end = begin; begin < row.end(); begin = end) {
      bool own = false;
      for (end = begin; end < row.end() && view.z[end] == view.z[begin]; ++end) {
        own = own || view.order[end] < crowd.own;
      }
      if (!own || !inside(view.z[begin] - cube.low[2], cube.bits)) continue;
      seeing.find(row, view.z[begin], sources);
      const float* of[4];
      for (std::size_t c = 0; c < 4; ++c) of[c] = sources.column[c].data();
      std::vector<float> sums(3 * static_cast<std::size_t>(end - begin));
      kernels().pull(of, sources.size(), epsilon, column, begin, end, sums.data());
      seen[r] += sources.size() * (end - begin);
      for (std::uint32_t k = begin; k < end; ++k) {
        const std::uint32_t i = view.order[k];
        if (i >= crowd.own || (chosen != nullptr && (*chosen)[i] == 0)) continue;
        for (std::size_t c = 0; c < 3; ++c) v[c][i] += sums[3 * (k - begin) + c];
      }
    }
  });
  InteractionCounts all{0, party.cells.most_in_a_cell()};
  for (const std::uint64_t some : seen) all.pairs += some;
  return all;
}

}  // namespace

std::unique_ptr<PairAction> families::gravitating(const Meeting& meeting) {
  if (actions::numbers_of<actions::numbers::gravitate>(*meeting.sides[0].action).cells == 0) return sweeping(meeting);
  return std::make_unique<ByCells>(meeting);
}

}  // namespace motes::interactions
