#include "image/post/bloom.h"

#include <algorithm>
#include <cstring>

#include "base/invalid_argument.h"

namespace motes::image {
namespace {

// Rows of cells that a thread takes at once.
constexpr std::size_t kRows = 8;

// Calls work(first, end, worker) for ranges of rows.
template <class Work>
void over_rows(threads::Pool& pool, int rows, const Work& work) {
  const auto all = static_cast<std::size_t>(rows);
  pool.run((all + kRows - 1) / kRows, [&](std::size_t part, std::size_t worker) {
    work(static_cast<int>(part * kRows), static_cast<int>(std::min(all, (part + 1) * kRows)), worker);
  });
}

// Returns the cell to read at index i: cells are reflected at both edges.
int reflected(int i, int count) {
  while (i < 0 || i >= count) i = i < 0 ? -1 - i : 2 * count - 1 - i;
  return i;
}

bool within(int first, int count, int all) { return first >= 0 && count >= 0 && first <= all - count; }

}  // namespace

void Bloom::begin(const BloomPlan& plan) {
  parts_.clear();
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    levels_[i].plan = &plan.levels[i];
    levels_[i].light.resize(levels_[i].lanes() * static_cast<std::size_t>(levels_[i].rows()));
  }
}

void Bloom::add(const CellArea& area, std::span<const std::byte> averages) {
  const BloomPlan::Level& plan = *levels_[0].plan;
  if (!within(area.x, area.width, plan.across.cells) || !within(area.y, area.height, plan.down.cells) ||
      averages.size() != area.lanes() * sizeof(std::uint64_t)) {
    throw base::InvalidArgument("averages", "be three 64-bit numbers per cell of the picture");
  }
  parts_.push_back({area, averages.data()});
}

void Bloom::add(const BloomTiles& tiles) {
  for (std::size_t i = 0; i < tiles.tiles(); ++i) add(tiles.cells(i), std::as_bytes(tiles.averages(i)));
}

void Bloom::spread(threads::Pool& pool) {
  rows_.resize(std::max(rows_.size(), static_cast<std::size_t>(pool.threads())));
  add_up(pool);
  for (std::size_t i = 1; i < levels_.size(); ++i) average(levels_[i - 1], levels_[i], pool);
  for (Level& level : levels_) blur(level, pool);
  for (std::size_t i = levels_.size() - 1; i > 0; --i) enlarge_level(levels_[i], levels_[i - 1], pool);
}

// Averages pixels. It adds up the exact sums of all tiles before it rounds down, so it does not matter which rank owns
// which tile.
void Bloom::add_up(threads::Pool& pool) {
  constexpr int kShift = 2 * BloomAxis::kWeightBits - BloomPlan::kFraction;
  Level& level = levels_[0];
  over_rows(pool, level.rows(), [&](int first, int end, std::size_t) {
    std::fill(level.row(first), level.row(end), std::uint64_t{0});
    for (const Part& part : parts_) {
      const CellArea& area = part.area;
      for (int y = std::max(first, area.y); y < std::min(end, area.y + area.height); ++y) {
        const std::byte* from = part.averages + static_cast<std::size_t>(y - area.y) * area.row_lanes() * 8;
        std::uint64_t* to = level.row(y) + 3 * area.x;
        for (std::size_t lane = 0; lane < area.row_lanes(); ++lane) {
          std::uint64_t one;
          std::memcpy(&one, from + lane * sizeof one, sizeof one);
          to[lane] += one;
        }
      }
    }
    for (std::uint64_t* one = level.row(first); one != level.row(end); ++one) *one >>= kShift;
  });
}

void Bloom::average(Level& fine, Level& coarse, threads::Pool& pool) {
  const BloomAxis &down = coarse.plan->down, &across = coarse.plan->across;
  over_rows(pool, coarse.rows(), [&](int first, int end, std::size_t worker) {
    std::vector<std::uint64_t>& sums = rows_[worker].sums;
    for (auto row = static_cast<std::size_t>(first); row < static_cast<std::size_t>(end); ++row) {
      sums.assign(fine.lanes(), 0);
      int y = down.first[row];
      for (std::size_t k = down.begin[row]; k < down.begin[row + 1]; ++k, ++y) {
        kernels_->add_cells(sums.data(), fine.row(y), down.weights[k], fine.lanes());
      }
      for (std::uint64_t& sum : sums) sum >>= BloomAxis::kWeightBits;
      std::uint64_t* to = coarse.row(static_cast<int>(row));
      for (std::size_t cell = 0; cell < static_cast<std::size_t>(across.cells); ++cell, to += 3) {
        const std::uint64_t* from = sums.data() + 3 * across.first[cell];
        std::uint64_t sum[3] = {};
        for (std::size_t k = across.begin[cell]; k < across.begin[cell + 1]; ++k, from += 3) {
          for (int c = 0; c < 3; ++c) sum[c] += from[c] * across.weights[k];
        }
        for (int c = 0; c < 3; ++c) to[c] = sum[c] >> BloomAxis::kWeightBits;
      }
    }
  });
}

void Bloom::blur(Level& level, threads::Pool& pool) {
  const std::size_t lanes = level.lanes();
  const Taps& taps = level.plan->down.taps;
  blurred_.resize(level.light.size());
  over_rows(pool, level.rows(), [&](int first, int end, std::size_t) {
    std::array<const std::uint64_t*, 2 * Taps::kMost + 1> around{};
    const auto middle = around.begin() + Taps::kMost;
    for (int y = first; y < end; ++y) {
      for (int k = -taps.reach; k <= taps.reach; ++k) middle[k] = level.row(reflected(y + k, level.rows()));
      kernels_->filter(blurred_.data() + static_cast<std::size_t>(y) * lanes, middle, taps, lanes);
    }
  });
  over_rows(pool, level.rows(), [&](int first, int end, std::size_t worker) {
    for (int y = first; y < end; ++y) blur_row(level, y, rows_[worker].sums);
  });
}

// Blurs a row along itself, after its columns were blurred; multiplies it by the level's share of the light.
void Bloom::blur_row(Level& level, int y, std::vector<std::uint64_t>& memory) {
  const std::size_t lanes = level.lanes();
  const Taps& taps = level.plan->across.taps;
  const int wide = taps.reach, columns = level.plan->across.cells;
  memory.resize(lanes + static_cast<std::size_t>(6 * wide));
  std::uint64_t* padded = memory.data() + 3 * wide;
  const std::uint64_t* from = blurred_.data() + static_cast<std::size_t>(y) * lanes;
  std::copy_n(from, lanes, padded);
  for (int k = 1; k <= wide; ++k) {
    std::copy_n(from + 3 * reflected(-k, columns), 3, padded - 3 * k);
    std::copy_n(from + 3 * reflected(columns - 1 + k, columns), 3, padded + 3 * (columns - 1 + k));
  }
  std::array<const std::uint64_t*, 2 * Taps::kMost + 1> around{};
  const auto middle = around.begin() + Taps::kMost;
  for (int k = -wide; k <= wide; ++k) middle[k] = padded + 3 * k;
  std::uint64_t* to = level.row(y);
  kernels_->filter(to, middle, taps, lanes);
  for (std::size_t lane = 0; lane < lanes; ++lane) to[lane] = (to[lane] * level.plan->share) >> 16;
}

// Adds the glow of a coarse level to the next finer one.
void Bloom::enlarge_level(Level& coarse, Level& fine, threads::Pool& pool) {
  const BloomCells cells = coarse.cells();
  over_rows(pool, fine.rows(), [&](int first, int end, std::size_t worker) {
    const Area rows{0, 0, first, fine.plan->across.cells, end - first};
    enlarge(*kernels_, *coarse.plan, cells, rows, rows_[worker].glow, [&](int y, GlowRows& glow) {
      kernels_->mix_cells(fine.row(y), glow.glow.data(), glow.step.data(), fine.lanes());
    });
  });
}

}  // namespace motes::image
