// The cell list: particles sorted by (cell, id). It tells which particles can be near each other and fixes the order of
// sums. The order depends only on positions, ids and the edge length, never on the order in memory or on which
// particles are ghosts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "particles/ids.h"
#include "threads/pool.h"

namespace motes::interactions {

/// Particles that a thread takes at once.
inline constexpr std::size_t kRange = std::size_t{1} << 15;

/// A column of values: of this rank's own particles, then of ghosts. If `own` is null, all own particles have `value`.
struct Column {
  const float* own = nullptr;
  const float* ghosts = nullptr;
  float value = 0;

  /// Returns the value of particle i; the first `count` particles are this rank's own.
  float of(std::size_t i, std::size_t count) const {
    return i >= count ? ghosts[i - count] : own != nullptr ? own[i] : value;
  }
};

/// The particles of one system that take part in an interaction: own ones, then ghosts.
struct Crowd {
  Column at[3];  // metres
  particles::Ids own_ids;
  const std::uint64_t* copied_ids = nullptr;
  std::size_t own = 0;
  std::size_t ghosts = 0;

  std::size_t size() const { return own + ghosts; }
  std::uint64_t id(std::size_t i) const { return i < own ? own_ids[i] : copied_ids[i - own]; }
};

/// A row: the non-empty cells with the same x and y. Its particles are contiguous, sorted by z and id:
///
///   rows      [x0 y0 first=0] [x0 y1 first=5] ... [end first=n]
///   particles  z z z z z       z z ...                          table[row]: first particle of each z
struct Row {
  std::int32_t x = 0, y = 0;
  std::uint32_t first = 0;  // its first particle
  std::int32_t z_low = 0, z_high = 0;
  std::int64_t table = -1;  // index of its part of the table; -1: binary search for z

  /// Returns the end of its particles, where the next row begins: each row of a cell list has one behind it.
  std::uint32_t end() const { return (this + 1)->first; }
};

/// A view of the cell list for kernels.
struct CellsView {
  const Row* rows = nullptr;  // ascending in (x, y), plus one end row
  std::size_t row_count = 0;
  const std::uint32_t* table = nullptr;  // per row: first particle of each z from z_low to z_high + 1
  const std::int32_t* z = nullptr;  // cell number along z of each particle
  const std::uint32_t* order = nullptr;  // index of each particle in its crowd
  std::uint32_t own = 0;  // indices below are this rank's own
};

/// Sorts particles into cubic cells anchored at the origin, numbered -2^20..2^20 along each axis. Particles farther out
/// are clamped to the outermost cells and NaN to the lowest, so neighbours stay neighbours.
class Cells {
 public:
  /// Sorts the crowd into cells of this edge length, m, > 0.
  void sort(const Crowd& crowd, double edge, threads::Pool& pool);

  std::size_t size() const { return order_.size(); }
  const std::vector<std::uint32_t>& order() const { return order_; }
  /// Returns the inverse of order(): the place of each particle.
  std::vector<std::uint32_t> places() const;
  const std::vector<Row>& rows() const { return rows_; }
  /// Returns a view; `own` as in the crowd that was sorted.
  CellsView view(std::size_t own) const;

  /// Returns the largest number of particles in one cell.
  std::uint32_t most_in_a_cell() const { return most_; }

  /// Copies a column in sorted order: to[k] is the value of particle order()[k]. `to` must hold size() values.
  void arrange(const Crowd& crowd, const Column& column, float* to, threads::Pool& pool) const;

 private:
  struct Range {
    std::int32_t low[3], high[3];
    std::uint64_t y_cells() const { return static_cast<std::uint64_t>(high[1] - low[1]) + 1; }
    std::uint64_t z_cells() const { return static_cast<std::uint64_t>(high[2] - low[2]) + 1; }
    std::uint64_t cells() const { return (static_cast<std::uint64_t>(high[0] - low[0]) + 1) * y_cells() * z_cells(); }
  };

  Range number_cells(const Crowd& crowd, double edge, threads::Pool& pool);
  void sort_cells(const Range& range, threads::Pool& pool);
  void sort_ids(const Crowd& crowd, threads::Pool& pool);
  struct Rows {
    std::vector<Row> rows;
    std::vector<std::uint32_t> table;
  };
  void find_rows(const Range& range, threads::Pool& pool);
  std::size_t find_row(const Range& range, std::size_t begin, Rows& found);

  std::vector<std::int32_t> cell_[3];
  std::vector<std::uint64_t> keys_, other_keys_;
  std::vector<std::uint32_t> order_, other_order_;
  std::vector<Rows> parts_;
  std::vector<Row> rows_;
  std::vector<std::uint32_t> table_;
  std::vector<std::int32_t> z_;
  std::uint32_t most_ = 0;
};

/// Returns the non-empty rows among the nine around (x, y), ascending.
std::vector<const Row*> rows_around(const Cells& cells, std::int32_t x, std::int32_t y);

/// Returns row numbers, starting at 0, that split the rows into parts with about as many particles as a thread takes at
/// once.
std::vector<std::size_t> parts_of(const Cells& cells, const threads::Pool& pool);

/// Calls work(place) for the particles of a row in the cells z - 1 .. z + 1, in their order.
template <class Work>
void each_near(const CellsView& cells, const Row& row, std::int32_t z, const Work& work) {
  const std::uint32_t end = row.end();
  std::uint32_t first = row.first;
  for (std::uint32_t last = end; first < last;) {
    const std::uint32_t middle = first + (last - first) / 2;
    if (cells.z[middle] < z - 1) {
      first = middle + 1;
    } else {
      last = middle;
    }
  }
  for (std::uint32_t k = first; k < end && cells.z[k] <= z + 1; ++k) work(k);
}

}  // namespace motes::interactions
