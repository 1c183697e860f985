// Particles in the order (cell, id): which ones can be near each other, and the order in which their parts are summed.
// It depends on positions, ids and the edge alone: never on the order in memory, nor on which of them are ghosts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "particles/ids.h"
#include "threads/pool.h"

namespace motes::interactions {

/// A column of particles: this rank's own, then ghosts of others. Without a plane all own ones have the same value.
struct Column {
  const float* own = nullptr;
  const float* ghosts = nullptr;
  float value = 0;

  /// Of particle i, where the first `count` are this rank's own.
  float of(std::size_t i, std::size_t count) const {
    return i >= count ? ghosts[i - count] : own != nullptr ? own[i] : value;
  }
};

/// Particles that meet.
struct Crowd {
  Column at[3];  // metres
  particles::Ids own_ids;
  const std::uint64_t* copied_ids = nullptr;
  std::size_t own = 0;
  std::size_t ghosts = 0;

  std::size_t size() const { return own + ghosts; }
  std::uint64_t id(std::size_t i) const { return i < own ? own_ids[i] : copied_ids[i - own]; }
};

/// The cells with the same x and y that hold particles, and their particles, which follow each other by z and id.
struct Row {
  std::int32_t x = 0, y = 0;
  std::uint32_t first = 0;   // its first particle; the next row's first one ends it
  std::int32_t z_low = 0, z_high = 0;
  std::int64_t table = -1;   // where its part of the table begins; -1: z is searched for
};

/// Kernels see this.
struct CellsView {
  const Row* rows = nullptr;  // ascending in (x, y), with one more behind the last
  std::size_t row_count = 0;
  const std::uint32_t* table = nullptr;  // for a row: the first particle of each z from z_low to z_high + 1
  const std::int32_t* z = nullptr;       // of each particle
  const std::uint32_t* order = nullptr;  // the index of each particle in its crowd
  std::uint32_t own = 0;                 // indices below are this rank's own
};

/// Cells are cubes anchored at the origin of space, numbered -2^20..2^20 along each axis; whatever is farther out is in
/// the outermost ones, NaN in the lowest. Neighbours stay neighbours by that.
class Cells {
 public:
  /// `edge`: metres, > 0.
  void sort(const Crowd& crowd, double edge, threads::Pool& pool);

  std::size_t size() const { return order_.size(); }
  const std::vector<std::uint32_t>& order() const { return order_; }
  const std::vector<Row>& rows() const { return rows_; }
  /// `own`: as in the crowd that was sorted.
  CellsView view(std::size_t own) const;

  /// The most particles in one cell.
  std::uint32_t most_in_a_cell() const { return most_; }

  /// Puts a column into the order: to[k] is the value of particle order()[k]. `to` has room for size() values.
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

/// The rows of `cells` around (x, y), ascending; nobody is in those that are missing.
std::vector<const Row*> rows_around(const Cells& cells, std::int32_t x, std::int32_t y);

/// Numbers of rows, from 0 on: between two of them are about as many particles as a thread takes at once.
std::vector<std::size_t> parts_of(const Cells& cells, threads::Pool& pool);

/// Calls work(place) for the particles of a row in the cells z - 1 .. z + 1, in their order.
template <class Work>
void each_near(const CellsView& cells, const Row& row, std::int32_t z, const Work& work) {
  const std::uint32_t end = (&row)[1].first;
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
