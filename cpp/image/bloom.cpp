#include "image/bloom.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace motes::image {
namespace {

// The glow's parts: standard deviation as a part of the picture's height, and share of the light that spreads.
struct Glow {
  double radius, share;
};
constexpr std::array<Glow, 3> kGlow{{{0.004, 0.5}, {0.016, 0.3}, {0.064, 0.2}}};

// Bits of weights that add up to one, and bits after the point of averages: what spreads far is faint.
constexpr int kWeightBits = 10;
constexpr int kBetweenBits = 16;
constexpr std::uint64_t kBetween = std::uint64_t{1} << kBetweenBits;
constexpr int kFraction = 12;

// exp(-x) for x >= 0 up to about 10, built from + * / only: see curves.h.
double decay(double x) {
  double sum = 1;
  for (int i = 60; i >= 1; --i) sum = 1 + x / i * sum;
  return 1 / sum;
}

// A Gauss curve of this variance in cells; its integers add up to 2^16.
Taps gauss(double variance) {
  Taps taps;
  std::array<double, Taps::kMost + 1> weights{1};
  double sum = 1;
  for (int k = 1; k <= Taps::kMost && k * k <= 16 * variance; ++k) {
    taps.reach = k;
    weights[static_cast<std::size_t>(k)] = decay(k * k / (2 * variance));
    sum += 2 * weights[static_cast<std::size_t>(k)];
  }
  taps.taps[0] = std::uint64_t{1} << Taps::kShift;
  for (int k = 1; k <= taps.reach; ++k) {
    const double weight = weights[static_cast<std::size_t>(k)] / sum * (1 << Taps::kShift);
    taps.taps[k] = static_cast<std::uint64_t>(weight + 0.5);
    taps.taps[0] -= 2 * taps.taps[k];
  }
  return taps;
}

// The cell whose content is seen at index i: cells are reflected at both edges.
int reflected(int i, int count) {
  while (i < 0 || i >= count) i = i < 0 ? -1 - i : 2 * count - 1 - i;
  return i;
}

std::uint32_t parts(float part) { return static_cast<std::uint32_t>(part * 65536.0 + 0.5); }

}  // namespace

int Bloom::Axis::before(int i) const {
  const int twice = 2 * i + 1;  // in half finer ones, from the edge: the centre of cell c is at (2 c + 1) fine / cells
  return static_cast<int>((std::int64_t{twice} * cells + fine) / (2 * std::int64_t{fine})) - 1;
}

std::uint64_t Bloom::Axis::beyond(int i) const {
  const std::int64_t place = (2 * std::int64_t{i} + 1) * cells + fine;
  return static_cast<std::uint64_t>((place % (2 * std::int64_t{fine}) << kBetweenBits) / (2 * std::int64_t{fine}));
}

// The cells, of about `cell` pixels, of a level whose curve has this radius in pixels. `widened`: the variance, in
// pixels, that averaging and enlarging add between the picture and this level; the filter adds the rest.
Bloom::Axis Bloom::divided(int pixels, int fine, double cell, double radius, double& widened) {
  Axis axis;
  axis.fine = fine;
  axis.cells = std::clamp(static_cast<int>(pixels / cell), 1, fine);
  if (2 * axis.cells > fine) axis.cells = fine;  // averages of less than two weigh them unevenly
  const double side = static_cast<double>(pixels) / axis.cells, part = static_cast<double>(pixels) / fine;
  if (axis.cells != fine) widened += 2 * (side * side / 6 + part * part / 12);
  axis.taps = gauss(std::max(0.0, radius * radius - widened) / (side * side));

  // Each finer one is shared out between the two cells that it lies between: what moves takes its glow along smoothly.
  const auto cells = static_cast<std::size_t>(axis.cells);
  std::vector<std::vector<std::uint64_t>> shares(cells);
  axis.first.resize(cells);
  for (int i = 0; i < fine; ++i) {
    const std::uint64_t beyond = axis.beyond(i);
    for (const auto& [cell, share] : {std::pair{axis.before(i), kBetween - beyond}, {axis.before(i) + 1, beyond}}) {
      const auto c = static_cast<std::size_t>(std::clamp(cell, 0, axis.cells - 1));
      if (share == 0) continue;
      if (shares[c].empty()) axis.first[c] = i;
      shares[c].resize(static_cast<std::size_t>(i - axis.first[c] + 1));
      shares[c].back() += share;
    }
  }
  for (const std::vector<std::uint64_t>& share : shares) {
    const std::uint64_t all = std::accumulate(share.begin(), share.end(), std::uint64_t{0});
    axis.begin.push_back(axis.weights.size());
    std::uint32_t left = 1u << kWeightBits;
    for (const std::uint64_t one : share) {
      axis.weights.push_back(static_cast<std::uint32_t>((one << kWeightBits) / all));
      left -= axis.weights.back();
    }
    *std::max_element(axis.weights.begin() + static_cast<std::ptrdiff_t>(axis.begin.back()), axis.weights.end()) +=
        left;
  }
  axis.begin.push_back(axis.weights.size());
  return axis;
}

void Bloom::plan(int width, int height, float part) {
  if (width == width_ && height == height_ && part == part_) return;
  width_ = width;
  height_ = height;
  part_ = part;
  std::uint32_t left = parts(part);
  double widened_across = 0, widened_down = 0;
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    Level& level = levels_[i];
    const double radius = kGlow[i].radius * height;
    const double cell = i == 0 ? radius : radius / 2;  // a wide glow would show that it is linear between cells
    level.across = divided(width, i == 0 ? width : levels_[i - 1].across.cells, cell, radius, widened_across);
    level.down = divided(height, i == 0 ? height : levels_[i - 1].down.cells, cell, radius, widened_down);
    level.share = i + 1 == levels_.size() ? left : static_cast<std::uint32_t>(parts(part) * kGlow[i].share);
    left -= level.share;
    level.light.resize(level.lanes() * static_cast<std::size_t>(level.down.cells));
  }
}

void Bloom::spread(std::span<std::uint32_t> light, int width, int height, float part, threads::Pool& pool) {
  const auto lanes = static_cast<std::size_t>(width) * 3;
  if (width < 1 || height < 1 || light.size() != lanes * static_cast<std::size_t>(height)) {
    throw std::invalid_argument("light must be height * width * 3 sums");
  }
  if (!(part >= 0 && part <= 1)) throw std::invalid_argument("bloom must be in 0..1");
  if (part == 0) return;
  plan(width, height, part);
  rows_.resize(std::max(rows_.size(), static_cast<std::size_t>(pool.threads())));
  average(light.data(), levels_[0], pool);
  for (std::size_t i = 1; i < levels_.size(); ++i) average(levels_[i - 1], levels_[i]);
  for (Level& level : levels_) {
    blur(level);
    for (std::uint64_t& one : level.light) one = (one * level.share) >> 16;
  }
  for (std::size_t i = levels_.size() - 1; i > 0; --i) {
    Level& fine = levels_[i - 1];
    enlarge(levels_[i], pool, [&](int y, Rows& rows) {
      std::uint64_t* to = fine.row(y);
      for (std::size_t lane = 0; lane < fine.lanes(); ++lane) {
        to[lane] += rows.glow[lane] >> kBetweenBits;
        rows.glow[lane] += rows.step[lane];
      }
    });
  }
  enlarge(levels_[0], pool, [&](int y, Rows& rows) {
    std::uint32_t* to = light.data() + static_cast<std::size_t>(y) * lanes;
    lanes_->mix(to, rows.glow.data(), rows.step.data(), parts(part), kBetweenBits + kFraction, lanes);
  });
}

void Bloom::average(const std::uint32_t* light, Level& level, threads::Pool& pool) {
  const auto lanes = static_cast<std::size_t>(width_) * 3;
  const Axis& down = level.down;
  pool.run(static_cast<std::size_t>(down.cells), [&](std::size_t row, std::size_t worker) {
    std::vector<std::uint64_t>& sums = rows_[worker].sums;
    sums.assign(lanes, 0);
    auto y = static_cast<std::size_t>(down.first[row]);
    for (std::size_t k = down.begin[row]; k < down.begin[row + 1]; ++k, ++y) {
      lanes_->add(sums.data(), light + y * lanes, down.weights[k], lanes);
    }
    average_row(sums, level, static_cast<int>(row), 2 * kWeightBits - kFraction);
  });
}

void Bloom::average(Level& fine, Level& coarse) {
  const Axis& down = coarse.down;
  for (int row = 0; row < down.cells; ++row) {
    std::vector<std::uint64_t>& sums = rows_[0].sums;
    sums.assign(fine.lanes(), 0);
    int y = down.first[static_cast<std::size_t>(row)];
    const std::size_t end = down.begin[static_cast<std::size_t>(row) + 1];
    for (std::size_t k = down.begin[static_cast<std::size_t>(row)]; k < end; ++k, ++y) {
      const std::uint64_t* from = fine.row(y);
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += from[i] * down.weights[k];
    }
    for (std::uint64_t& sum : sums) sum >>= kWeightBits;
    average_row(sums, coarse, row, kWeightBits);
  }
}

// A row of cells from `sums`, a row of finer ones, divided by 2^shift.
void Bloom::average_row(const std::vector<std::uint64_t>& sums, Level& level, int row, int shift) {
  const Axis& across = level.across;
  std::uint64_t* to = level.row(row);
  for (std::size_t cell = 0; cell < static_cast<std::size_t>(across.cells); ++cell, to += 3) {
    const std::uint64_t* from = sums.data() + 3 * across.first[cell];
    std::uint64_t sum[3] = {};
    for (std::size_t k = across.begin[cell]; k < across.begin[cell + 1]; ++k, from += 3) {
      for (int c = 0; c < 3; ++c) sum[c] += from[c] * across.weights[k];
    }
    for (int c = 0; c < 3; ++c) to[c] = sum[c] >> shift;
  }
}

void Bloom::blur(Level& level) {
  const std::size_t lanes = level.lanes();
  const int rows = level.down.cells, columns = level.across.cells;
  std::array<const std::uint64_t*, 2 * Taps::kMost + 1> around{};
  const auto seen = [&](int k) -> const std::uint64_t*& { return around[static_cast<std::size_t>(k + Taps::kMost)]; };
  const std::uint64_t* const* middle = around.data() + Taps::kMost;

  blurred_.resize(level.light.size());
  const int high = level.down.taps.reach;
  for (int y = 0; y < rows; ++y) {
    for (int k = -high; k <= high; ++k) seen(k) = level.row(reflected(y + k, rows));
    lanes_->filter(blurred_.data() + static_cast<std::size_t>(y) * lanes, middle, level.down.taps, lanes);
  }

  const int wide = level.across.taps.reach;
  padded_.resize(lanes + static_cast<std::size_t>(6 * wide));
  std::uint64_t* padded = padded_.data() + 3 * wide;
  for (int k = -wide; k <= wide; ++k) seen(k) = padded + 3 * k;
  for (int y = 0; y < rows; ++y) {
    const std::uint64_t* from = blurred_.data() + static_cast<std::size_t>(y) * lanes;
    std::copy_n(from, lanes, padded);
    for (int k = 1; k <= wide; ++k) {
      std::copy_n(from + 3 * reflected(-k, columns), 3, padded - 3 * k);
      std::copy_n(from + 3 * reflected(columns - 1 + k, columns), 3, padded + 3 * (columns - 1 + k));
    }
    lanes_->filter(level.row(y), middle, level.across.taps, lanes);
  }
}

// A row of cells as a row of finer ones: linear between the cells' centres, even beyond the outermost.
void Bloom::widen(Level& level, int row, std::vector<std::uint64_t>& to) {
  const Axis& across = level.across;
  const std::uint64_t* from = level.row(std::clamp(row, 0, level.down.cells - 1));
  std::uint64_t* out = to.data();
  for (int i = 0; i < across.fine; ++i, out += 3) {
    const int cell = across.before(i);
    const std::uint64_t beyond = across.beyond(i);
    const std::uint64_t* left = from + 3 * std::max(cell, 0);
    const std::uint64_t* right = from + 3 * std::min(cell + 1, across.cells - 1);
    for (int c = 0; c < 3; ++c) {
      out[c] = (left[c] * (kBetween - beyond) + right[c] * beyond) >> kBetweenBits;
    }
  }
}

// Calls mix(y, rows) for each finer row, with rows.glow as its glow times 2^kBetweenBits and rows.step as the
// difference to the next row's, which mix adds. All is modulo 2^64; steps are rounded down, so a glow is never below
// the nearer cell's.
template <class Mix>
void Bloom::enlarge(Level& level, threads::Pool& pool, const Mix& mix) {
  constexpr int kCells = 16;  // of one thread at a time: the first row of a part is widened twice
  const int cells = level.down.cells;
  const int part = pool.threads() == 1 ? cells + 1 : kCells;
  pool.run(static_cast<std::size_t>((cells + part) / part), [&](std::size_t number, std::size_t worker) {
    const int first = static_cast<int>(number) * part - 1;
    enlarge_part(level, first, std::min(first + part, cells), rows_[worker], mix);
  });
}

// The finer rows between the centres of cells first .. last.
template <class Mix>
void Bloom::enlarge_part(Level& level, int first, int last, Rows& rows, const Mix& mix) {
  const Axis& down = level.down;
  const auto lanes = static_cast<std::size_t>(level.across.fine) * 3;
  for (auto* row : {&rows.near, &rows.far, &rows.glow, &rows.step}) row->resize(lanes);
  const std::uint64_t slope =
      (static_cast<std::uint64_t>(down.cells) << kBetweenBits) / static_cast<std::uint64_t>(down.fine);
  widen(level, first, rows.far);
  int y = 0;
  while (y < down.fine && down.before(y) < first) ++y;
  for (int cell = first; cell < last; ++cell) {
    std::swap(rows.near, rows.far);
    widen(level, cell + 1, rows.far);
    if (y == down.fine || down.before(y) != cell) continue;
    const std::uint64_t beyond = down.beyond(y);
    for (std::size_t i = 0; i < lanes; ++i) {
      const std::uint64_t more = rows.far[i] - rows.near[i];
      rows.glow[i] = (rows.near[i] << kBetweenBits) + more * beyond;
      rows.step[i] = more * slope;
    }
    for (; y < down.fine && down.before(y) == cell; ++y) mix(y, rows);
  }
}

}  // namespace motes::image
