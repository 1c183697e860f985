// Sums over particles, exact in any order: totals, histograms, tallies (API: System.total, histogram, tally).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "actions/action.h"
#include "base/bytes.h"
#include "particles/exact_sum.h"
#include "particles/store.h"
#include "shapes/shape.h"
#include "threads/pool.h"

namespace motes::program {

/// A dimension that particles are binned by: bin i holds those with edges[i] <= value < edges[i + 1].
struct Dimension {
  actions::Expression value;
  std::vector<double> edges;  // ascending; the outer ones may be infinite
  bool closed = false;        // the last edge belongs to the last bin

  bool operator==(const Dimension&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Dimension& dimension) {
  visit(dimension.value, dimension.edges, dimension.closed);
}

/// A sum over all ranks. Without dimensions there is one bin, for all particles, and one result per weight; with
/// dimensions there is at most one weight. Without weights, particles are counted.
struct Sum {
  std::vector<Dimension> dimensions;  // the last one varies fastest
  std::vector<actions::Expression> weights;
  actions::Expression where;  // a condition; empty: all particles
  std::vector<shapes::Shape> shapes;  // those that the expressions use
  double time = 0;  // of the animation, seconds

  bool operator==(const Sum&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Sum& sum) {
  visit(sum.dimensions, sum.weights, sum.where, sum.shapes, sum.time);
}

/// The maximum number of bins: 128 MB of counts, or 768 MB of weighted sums, on each rank.
inline constexpr std::size_t kMostBins = std::size_t{1} << 24;

/// Returns the number of results: one per bin, or per weight. Throws std::invalid_argument if there are too many bins.
std::size_t results(const Sum& sum);

/// Checks a sum. Throws std::invalid_argument naming the argument and what is allowed.
void check(const Sum& sum, const particles::Schema& schema);

/// Returns whether a sum reads a *_b attribute.
bool uses_copies(const Sum& sum, const particles::Schema& schema);

/// Returns 32 hexadecimal digits, which differ if sums differ.
std::string fingerprint(const Sum& sum);

/// The bins of a dimension; finds the bin of a number.
class Bins {
 public:
  explicit Bins(const Dimension& dimension);

  std::uint32_t count() const { return count_; }
  /// Returns the bin, or count() for NaN and for numbers outside all bins.
  std::uint32_t of(float value) const {
    if (!(value >= starts_.front() && value < starts_.back())) {
      return holds_infinity_ && value == std::numeric_limits<float>::infinity() ? count_ - 1 : count_;
    }
    if (!regular_) return search(value);
    auto bin = static_cast<std::uint32_t>(std::clamp((value - first_) * per_width_, 0.0, last_));
    while (value < starts_[bin]) --bin;
    while (value >= starts_[bin + 1]) ++bin;
    return bin;
  }

 private:
  std::uint32_t search(float value) const;

  std::vector<float> starts_;  // the smallest float32 of each bin, and the first one beyond the last bin
  std::uint32_t count_;
  bool regular_;  // bins of nearly the same width: a division finds nearly the right one
  bool holds_infinity_;  // the last bin does
  double first_, per_width_, last_;  // edge; bins per unit; the number of the last bin
};

/// Counts or sums, of one part of the particles or of all.
using Summed = std::variant<std::vector<std::int64_t>, std::vector<particles::ExactSum>>;
Summed nothing(const Sum& sum);

/// Sums over the first `count` particles of the store, which does not change. The result does not depend on the
/// threads.
Summed sum_up(const Sum& sum, particles::Store& store, std::size_t count, threads::Pool& pool = threads::alone());

/// Writes which results are not 0, and these results.
void write(const Summed& summed, base::Bytes& out);
/// Adds what write() wrote. Throws std::runtime_error if it has another number of results.
void add(base::Reader& in, Summed& to);

/// The results for the script: counts, or the nearest doubles.
using Totals = std::variant<std::vector<std::int64_t>, std::vector<double>>;
Totals totals(Summed summed);

}  // namespace motes::program
