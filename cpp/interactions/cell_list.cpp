#include "interactions/cell_list.h"

#include <algorithm>
#include <array>

namespace motes::interactions {

namespace {

constexpr std::int32_t kFarthest = 1 << 20;
constexpr int kDigit = 11;  // bits per digit of the radix sort: its counters fit the L1 cache
constexpr std::size_t kDigits = std::size_t{1} << kDigit;

// Returns the cell number of a coordinate. Computed in double: float32 would put particles far from the origin into the
// wrong cells.
std::int32_t cell_of(float x, double cells_per_metre) {
  const double q = static_cast<double>(x) * cells_per_metre;
  if (!(q > -kFarthest)) return -kFarthest;
  if (q >= kFarthest) return kFarthest;
  const auto toward_zero = static_cast<std::int32_t>(q);
  return toward_zero - static_cast<std::int32_t>(toward_zero > q);
}

void number_column(const Crowd& crowd, const Column& at, double cells_per_metre, std::size_t first, std::size_t last,
                   std::int32_t* cells) {
  const std::size_t own = std::min(last, std::max(first, crowd.own));
  const std::int32_t uniform = cell_of(at.value, cells_per_metre);
  for (std::size_t i = first; i < own; ++i) cells[i] = at.own ? cell_of(at.own[i], cells_per_metre) : uniform;
  for (std::size_t i = own; i < last; ++i) cells[i] = cell_of(at.ghosts[i - crowd.own], cells_per_metre);
}

int bits_of(std::uint64_t values) {
  int bits = 0;
  while (bits < 64 && (values - 1) >> bits != 0) ++bits;
  return bits;
}

// One pass of a stable radix sort, by one digit of the keys; digits run from the lowest up.
struct Pass {
  const std::uint64_t* keys;
  const std::uint32_t* order;
  std::uint64_t* sorted_keys;
  std::uint32_t* sorted_order;
  int shift;

  std::size_t digit(std::size_t i) const { return keys[i] >> shift & (kDigits - 1); }

  void count(std::size_t first, std::size_t last, std::uint32_t* counts) const {
    for (std::size_t i = first; i < last; ++i) ++counts[digit(i)];
  }
  void scatter(std::size_t first, std::size_t last, std::uint32_t* places) const {
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t place = places[digit(i)]++;
      sorted_keys[place] = keys[i];
      sorted_order[place] = order[i];
    }
  }
};

// Splits items among threads: few parts, since each part has its own counters.
struct Shares {
  Shares(std::size_t count, threads::Pool& pool)
      : size(count),
        parts(std::clamp<std::size_t>(count / pool.items(kRange), 1, static_cast<std::size_t>(pool.threads()))) {}
  std::size_t first(std::size_t part) const { return size * part / parts; }

  /// Like first(), but moved past items with together(i - 1, i), so no group is split.
  template <class Together>
  std::size_t first_apart(std::size_t part, const Together& together) const {
    std::size_t at = first(part);
    while (at > 0 && at < size && together(at - 1, at)) ++at;
    return at;
  }

  std::size_t size;
  std::size_t parts;
};

void run(const Pass& pass, const Shares& shares, std::vector<std::uint32_t>& counts, threads::Pool& pool) {
  counts.assign(shares.parts * kDigits, 0);
  pool.run(shares.parts, [&](std::size_t part, std::size_t) {
    pass.count(shares.first(part), shares.first(part + 1), &counts[part * kDigits]);
  });
  std::uint32_t before = 0;
  for (std::size_t digit = 0; digit < kDigits; ++digit) {
    for (std::size_t part = 0; part < shares.parts; ++part) {
      const std::uint32_t here = counts[part * kDigits + digit];
      counts[part * kDigits + digit] = before;
      before += here;
    }
  }
  pool.run(shares.parts, [&](std::size_t part, std::size_t) {
    pass.scatter(shares.first(part), shares.first(part + 1), &counts[part * kDigits]);
  });
}

// Returns whether a table of z pays: the row has not many more cells than particles.
bool worth_a_table(const Row& row, std::uint32_t particles) {
  return static_cast<std::int64_t>(row.z_high) - row.z_low < std::int64_t{8} * particles + 64;
}

}  // namespace

std::vector<std::uint32_t> Cells::places() const {
  std::vector<std::uint32_t> places(order_.size());
  for (std::uint32_t k = 0; k < places.size(); ++k) places[order_[k]] = k;
  return places;
}

void Cells::sort(const Crowd& crowd, double edge, threads::Pool& pool) {
  const Range range = number_cells(crowd, edge, pool);
  sort_cells(range, pool);
  sort_ids(crowd, pool);
  find_rows(range, pool);
}

Cells::Range Cells::number_cells(const Crowd& crowd, double edge, threads::Pool& pool) {
  const std::size_t count = crowd.size();
  for (auto& cells : cell_) cells.resize(count);
  const std::size_t range = pool.items(kRange);
  const Range none{{kFarthest, kFarthest, kFarthest}, {-kFarthest, -kFarthest, -kFarthest}};
  std::vector<Range> parts((count + range - 1) / range, none);
  pool.run(parts.size(), [&](std::size_t part, std::size_t) {
    const std::size_t first = part * range;
    const std::size_t last = std::min(count, first + range);
    for (std::size_t a = 0; a < 3; ++a) {
      std::int32_t* cells = cell_[a].data();
      number_column(crowd, crowd.at[a], 1 / edge, first, last, cells);
      std::int32_t low = kFarthest;
      std::int32_t high = -kFarthest;
      for (std::size_t i = first; i < last; ++i) low = std::min(low, cells[i]), high = std::max(high, cells[i]);
      parts[part].low[a] = low;
      parts[part].high[a] = high;
    }
  });
  Range all = none;
  for (const Range& part : parts) {
    for (std::size_t a = 0; a < 3; ++a) {
      all.low[a] = std::min(all.low[a], part.low[a]);
      all.high[a] = std::max(all.high[a], part.high[a]);
    }
  }
  return count == 0 ? Range{} : all;
}

void Cells::sort_cells(const Range& range, threads::Pool& pool) {
  const std::size_t count = cell_[0].size();
  keys_.resize(count);
  order_.resize(count);
  other_keys_.resize(count);
  other_order_.resize(count);
  threads::over_ranges(pool, count, kRange, [&](std::size_t first, std::size_t last) {
    const std::uint64_t y_cells = range.y_cells();
    const std::uint64_t z_cells = range.z_cells();
    for (std::size_t i = first; i < last; ++i) {
      const auto x = static_cast<std::uint64_t>(cell_[0][i] - range.low[0]);
      const auto y = static_cast<std::uint64_t>(cell_[1][i] - range.low[1]);
      const auto z = static_cast<std::uint64_t>(cell_[2][i] - range.low[2]);
      keys_[i] = (x * y_cells + y) * z_cells + z;
      order_[i] = static_cast<std::uint32_t>(i);
    }
  });
  const int bits = bits_of(range.cells());
  const Shares shares(count, pool);
  std::vector<std::uint32_t> counts;
  for (int shift = 0; shift < bits; shift += kDigit) {
    run({keys_.data(), order_.data(), other_keys_.data(), other_order_.data(), shift}, shares, counts, pool);
    keys_.swap(other_keys_);
    order_.swap(other_order_);
  }
}

// Sorts each cell by id: by insertion if it has few particles.
void Cells::sort_ids(const Crowd& crowd, threads::Pool& pool) {
  constexpr std::size_t kFew = 24;
  const std::size_t count = order_.size();
  const Shares shares(count, pool);
  std::vector<std::uint32_t> most(shares.parts, 0);
  const auto start = [&](std::size_t part) {  // a cell belongs to the part in which it begins
    return shares.first_apart(part, [&](std::size_t a, std::size_t b) { return keys_[a] == keys_[b]; });
  };
  pool.run(shares.parts, [&](std::size_t part, std::size_t) {
    const std::size_t last = start(part + 1);
    for (std::size_t begin = start(part), end = begin; begin < last; begin = end) {
      for (end = begin + 1; end < count && keys_[end] == keys_[begin];) ++end;
      most[part] = std::max(most[part], static_cast<std::uint32_t>(end - begin));
      if (end - begin > kFew) {
        std::sort(&order_[begin], &order_[begin] + (end - begin),
                  [&](std::uint32_t a, std::uint32_t b) { return crowd.id(a) < crowd.id(b); });
        continue;
      }
      for (std::size_t i = begin + 1; i < end; ++i) {
        const std::uint32_t moved = order_[i];
        const std::uint64_t id = crowd.id(moved);
        std::size_t j = i;
        for (; j > begin && crowd.id(order_[j - 1]) > id; --j) order_[j] = order_[j - 1];
        order_[j] = moved;
      }
    }
  });
  most_ = *std::max_element(most.begin(), most.end());
}

// Finds all rows; each part finds those that begin in it, in its own table.
void Cells::find_rows(const Range& range, threads::Pool& pool) {
  const std::size_t count = order_.size();
  const std::uint64_t z_cells = range.z_cells();
  const Shares shares(count, pool);
  const auto start = [&](std::size_t part) {
    return shares.first_apart(part,
                              [&](std::size_t a, std::size_t b) { return keys_[a] / z_cells == keys_[b] / z_cells; });
  };
  z_.resize(count);
  parts_.resize(shares.parts);
  pool.run(shares.parts, [&](std::size_t part, std::size_t) {
    parts_[part].rows.clear();
    parts_[part].table.clear();
    const std::size_t last = start(part + 1);
    for (std::size_t begin = start(part); begin < last;) begin = find_row(range, begin, parts_[part]);
  });
  rows_.clear();
  table_.clear();
  for (const Rows& part : parts_) {
    for (Row row : part.rows) {
      if (row.table >= 0) row.table += static_cast<std::int64_t>(table_.size());
      rows_.push_back(row);
    }
    table_.insert(table_.end(), part.table.begin(), part.table.end());
  }
  rows_.push_back({INT32_MAX, INT32_MAX, static_cast<std::uint32_t>(count), 0, 0, -1});
}

// Appends the row whose first particle is at `begin`; returns its end.
std::size_t Cells::find_row(const Range& range, std::size_t begin, Rows& found) {
  const std::size_t count = order_.size();
  const std::uint64_t z_cells = range.z_cells();
  const std::uint64_t number = keys_[begin] / z_cells;
  const std::uint64_t first_key = number * z_cells;
  Row row;
  row.x = static_cast<std::int32_t>(number / range.y_cells()) + range.low[0];
  row.y = static_cast<std::int32_t>(number % range.y_cells()) + range.low[1];
  row.first = static_cast<std::uint32_t>(begin);
  std::size_t end = begin;
  for (; end < count && keys_[end] - first_key < z_cells; ++end) {
    z_[end] = static_cast<std::int32_t>(keys_[end] - first_key) + range.low[2];
  }
  row.z_low = z_[begin];
  row.z_high = z_[end - 1];
  if (worth_a_table(row, static_cast<std::uint32_t>(end - begin))) {
    row.table = static_cast<std::int64_t>(found.table.size());
    std::size_t at = begin;
    for (std::int32_t z = row.z_low; z <= row.z_high; ++z) {
      found.table.push_back(static_cast<std::uint32_t>(at));
      while (at < end && z_[at] == z) ++at;
    }
    found.table.push_back(static_cast<std::uint32_t>(end));
  }
  found.rows.push_back(row);
  return end;
}

std::vector<const Row*> rows_around(const Cells& cells, std::int32_t x, std::int32_t y) {
  const std::vector<Row>& rows = cells.rows();
  const auto end = rows.end() - 1;
  std::vector<const Row*> found;
  for (std::int32_t at_x = x - 1; at_x <= x + 1; ++at_x) {
    auto at = std::lower_bound(rows.begin(), end, y - 1, [&](const Row& row, std::int32_t first) {
      return row.x < at_x || (row.x == at_x && row.y < first);
    });
    for (; at != end && at->x == at_x && at->y <= y + 1; ++at) found.push_back(&*at);
  }
  return found;
}

CellsView Cells::view(std::size_t own) const {
  return {rows_.data(), rows_.size() - 1, table_.data(), z_.data(), order_.data(), static_cast<std::uint32_t>(own)};
}

void Cells::arrange(const Crowd& crowd, const Column& column, float* to, threads::Pool& pool) const {
  threads::over_ranges(pool, order_.size(), kRange, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) to[k] = column.of(order_[k], crowd.own);
  });
}

std::vector<std::size_t> parts_of(const Cells& cells, const threads::Pool& pool) {
  const std::vector<Row>& rows = cells.rows();
  const std::size_t most = pool.threads() == 1 ? cells.size() : pool.items(4096);
  std::vector<std::size_t> cuts{0};
  for (std::size_t r = 1; r + 1 < rows.size(); ++r) {
    if (rows[r].first - rows[cuts.back()].first >= most) cuts.push_back(r);
  }
  cuts.push_back(rows.size() - 1);
  return cuts;
}

}  // namespace motes::interactions
