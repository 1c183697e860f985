// The sweep over neighbours: kernels hold targets in lanes and visit sources one by one in the order (cell, id).
//
// A vector holds consecutive targets of a row of cells and visits all sources in the nine rows around it that any of
// them may see. A source out of a lane's reach adds +0 to a sum that began with +0, so the bits depend neither on the
// vector's width nor on which targets share it.
#pragma once

#include "interactions/kernels.h"
#include "simd/floats3.h"

namespace motes::MOTES_ISA {

using interactions::CellsView;
using interactions::Row;
using interactions::Task;

MOTES_INLINE bool before(const Row& row, std::int32_t x, std::int32_t y) {
  return row.x < x || (row.x == x && row.y < y);
}

/// Returns the first row that is not before (x, y); `hint`: a row that is before it, or 0.
inline std::size_t row_from(const CellsView& cells, std::size_t hint, std::int32_t x, std::int32_t y) {
  // The next row is usually near: gallop, then bisect.
  std::size_t low = hint;
  std::size_t step = 1;
  while (low + step < cells.row_count && before(cells.rows[low + step], x, y)) {
    low += step;
    step *= 2;
  }
  std::size_t high = low + step < cells.row_count ? low + step : cells.row_count;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (before(cells.rows[middle], x, y)) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

/// Returns the first particle of the row with a cell number of at least z.
MOTES_INLINE std::uint32_t first_at(const CellsView& cells, const Row& row, std::int32_t z) {
  if (z <= row.z_low) return row.first;
  const std::uint32_t end = row.end();
  if (z > row.z_high) return end;
  if (row.table >= 0) return cells.table[row.table + (z - row.z_low)];
  std::uint32_t low = row.first;
  std::uint32_t high = end;
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    if (cells.z[middle] < z) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

/// The rows whose particles can be within reach of a row, ascending.
struct Around {
  const Row* rows[9];
  int count = 0;
};

/// Finds the rows around target rows. Target rows must come in ascending order.
struct Cursor {
  std::size_t at[3] = {0, 0, 0};

  MOTES_INLINE Around around(const CellsView& sources, std::int32_t x, std::int32_t y) {
    Around found;
    for (int dx = 0; dx < 3; ++dx) {
      at[dx] = row_from(sources, at[dx], x + dx - 1, y - 1);
      for (std::size_t r = at[dx]; r < sources.row_count && r < at[dx] + 3; ++r) {
        const Row& row = sources.rows[r];
        if (row.x != x + dx - 1 || row.y > y + 1) break;
        found.rows[found.count++] = &row;
      }
    }
    return found;
  }
};

/// Returns the number of particles of a party, ghosts included.
MOTES_INLINE std::size_t count_of(const interactions::Party& party) { return party.crowd->own + party.crowd->ghosts; }

MOTES_INLINE bool any_own(const CellsView& cells, std::uint32_t first, std::uint32_t last) {
  for (std::uint32_t k = first; k < last; ++k) {
    if (cells.order[k] < cells.own) return true;
  }
  return false;
}

/// Stores the first `lanes` lanes only: what follows in memory may belong to another thread.
MOTES_INLINE void store_lanes(float* to, Floats v, std::uint32_t lanes) {
  if (lanes == kLanes) return store(to, v);
  for (std::uint32_t k = 0; k < lanes; ++k) to[k] = v[k];
}

/// Stores the first `lanes` lanes of three components to three planes.
MOTES_INLINE void store_lanes3(float* const* to, std::uint32_t i, const Floats3& v, std::uint32_t lanes) {
  store_lanes(to[0] + i, v.x, lanes);
  store_lanes(to[1] + i, v.y, lanes);
  store_lanes(to[2] + i, v.z, lanes);
}

namespace numbers = actions::numbers;

/// Returns the action's numbers by name: numbers_of<numbers::contact>(task).stiffness.
template <template <class> class Numbers, class T = float>
MOTES_INLINE Numbers<T> numbers_of(const Task& task) {
  return actions::read_numbers<Numbers, T>(task.numbers);
}

/// Adds the sources first .. last - 1. Where Sums has sees(source), one bit per lane, those that no lane sees are left
/// out before any is added: whether one is seen cannot be predicted, so a branch for each would cost more than the
/// test.
template <class Law, class Sums>
MOTES_INLINE void add_sources(const Task& task, const Law& law, Sums& sums, std::uint32_t first, std::uint32_t last) {
  if constexpr (requires { sums.sees(law, task, first); }) {
    constexpr std::uint32_t kMost = 64;
    std::uint32_t seen[kMost], by[kMost];
    for (std::uint32_t next = first; next < last;) {
      const std::uint32_t end = next + kMost < last ? next + kMost : last;
      std::uint32_t count = 0;
      for (; next < end; ++next) {
        seen[count] = next;
        by[count] = sums.sees(law, task, next);
        count += by[count] != 0;
      }
      for (std::uint32_t k = 0; k < count; ++k) sums.add(law, task, seen[k], by[k]);
    }
  } else {
    for (std::uint32_t j = first; j < last; ++j) sums.add(law, task, j);
  }
}

/// Runs a law over the task's rows. A law has a type Sums: constructed for the targets first .. last - 1 (at most one
/// vector), with add(source) and finish(around, first, last).
template <class Law>
MOTES_INLINE void sweep(const Task& task, const Law& law) {
  const CellsView& targets = task.targets.cells;
  const CellsView& sources = task.sources.cells;
  Cursor cursor;
  for (std::size_t r = task.first_row; r < task.last_row; ++r) {
    const Row& row = targets.rows[r];
    const std::uint32_t end = row.end();
    bool found = false;
    Around around;
    for (std::uint32_t i = row.first; i < end; i += kLanes) {
      const std::uint32_t last = i + kLanes < end ? i + static_cast<std::uint32_t>(kLanes) : end;
      if (!any_own(targets, i, last)) continue;
      if (!found) around = cursor.around(sources, row.x, row.y);
      found = true;
      typename Law::Sums sums(law, task, i, last);
      const std::int32_t low = targets.z[i] - 1;
      const std::int32_t high = targets.z[last - 1] + 1;
      for (int n = 0; n < around.count; ++n) {
        const std::uint32_t to = first_at(sources, *around.rows[n], high + 1);
        add_sources(task, law, sums, first_at(sources, *around.rows[n], low), to);
      }
      sums.finish(law, task, around, i, last);
    }
  }
}

/// Returns source minus targets in three columns, starting at column `first`.
MOTES_INLINE Floats3 difference(const Floats3& targets, const float* const* column, int first, std::uint32_t j) {
  return {column[first][j] - targets.x, column[first + 1][j] - targets.y, column[first + 2][j] - targets.z};
}
/// Returns a source's position relative to the targets.
MOTES_INLINE Floats3 seen_from(const Floats3& targets, const float* const* column, std::uint32_t j) {
  return difference(targets, column, interactions::at_x, j);
}
/// Returns a source's velocity relative to the targets.
MOTES_INLINE Floats3 velocity_seen_from(const Floats3& targets, const float* const* column, std::uint32_t j) {
  return difference(targets, column, interactions::velocity_x, j);
}
MOTES_INLINE Floats3 load_column(const float* const* column, int first, std::uint32_t i) {
  return {load(column[first] + i), load(column[first + 1] + i), load(column[first + 2] + i)};
}

/// Sums counts over this rank's own targets; a vector may also hold ghosts.
MOTES_INLINE std::uint64_t sum_own(const CellsView& targets, Ints counts, std::uint32_t i, std::uint32_t last) {
  std::uint64_t sum = 0;
  for (std::uint32_t k = i; k < last; ++k) {
    sum += targets.order[k] < targets.own ? static_cast<std::uint64_t>(counts[k - i]) : 0;
  }
  return sum;
}

}  // namespace motes::MOTES_ISA
