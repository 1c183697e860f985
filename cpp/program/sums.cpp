#include "program/sums.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

#include "actions/action.h"
#include "actions/kernels.h"
#include "base/fields.h"
#include "base/hash.h"
#include "base/invalid_argument.h"
#include "program/planes.h"
#include "recording/record.h"

namespace motes::program {
namespace {

using actions::Expression;
using particles::ExactSum;
using particles::kBlock;
using particles::Store;

constexpr std::size_t kParticlesAtOnce = std::size_t{64} * kBlock;  // particles of one thread at a time

// Visits all expressions of a sum.
template <class Visit>
void each_expression(const Sum& sum, const Visit& visit) {
  for (const Dimension& dimension : sum.dimensions) visit(dimension.value);
  for (const Expression& weight : sum.weights) visit(weight);
  visit(sum.where);
}

std::uint64_t columns_of(const Sum& sum, const particles::Schema& schema) {
  std::uint64_t columns = 0;
  each_expression(sum, [&](const Expression& one) { columns |= actions::columns_of(one, schema); });
  return columns;
}

void check_edges(const std::vector<double>& edges) {
  const auto unordered = [](double a, double b) { return !(a < b); };
  if (edges.size() < 2 || std::adjacent_find(edges.begin(), edges.end(), unordered) != edges.end()) {
    throw base::InvalidArgument("edges", "be at least 2 ascending numbers");
  }
}

/// The values of expressions, block by block. Each thread has its own instance.
class Values {
 public:
  Values(const Sum& sum, Store& store) : sum_(sum), store_(store), planes_(store, columns_of(sum, store.schema())) {
    chosen_.fill(~0u);
  }

  /// Enters a block, and finds which of its particles count.
  void enter(std::size_t at, std::size_t count) {
    block_ = {count, planes_.at(at), store_.ids().from(at), nullptr};
    if (!sum_.where.empty()) std::memcpy(chosen_.data(), of(sum_.where), count * sizeof(float));
  }
  /// Returns masks with all bits set for particles that count, and none for the others.
  const std::uint32_t* chosen() const { return chosen_.data(); }

  /// Returns the values of an expression, valid until the next call.
  const float* of(const Expression& expression) {
    if (expression.size() == 1 && expression[0].op == actions::Op::column) {
      return block_.component[expression[0].index];
    }
    actions::kernels().evaluate(expression.data(), expression.size(), sum_.shapes.data(), block_,
                                static_cast<float>(sum_.time), stack_.data());
    return stack_.data();
  }

 private:
  const Sum& sum_;
  const Store& store_;
  Planes planes_;
  actions::Block block_{};
  std::array<std::uint32_t, kBlock> chosen_;
  std::vector<float> stack_ = std::vector<float>(actions::kScratch);
};

// Calls work(first particle of the block, how many) for the blocks of a range.
template <class Work>
void over_blocks(std::size_t first, std::size_t last, const Work& work) {
  for (std::size_t at = first; at < last; at += kBlock) work(at, std::min(kBlock, last - at));
}

// Adds a block of values. Particles that do not count are added as 0, since branches on them would be unpredictable.
void add_block(const std::uint32_t* chosen, const float* value, std::size_t count, particles::FloatTable& table) {
  std::array<float, kBlock> counted;
  for (std::size_t i = 0; i < count; ++i) {
    counted[i] = std::bit_cast<float>(std::bit_cast<std::uint32_t>(value[i]) & chosen[i]);
  }
  table.add({counted.data(), count});
}

// Sums all particles in one bin: each range has its own tables, which are then added.
std::vector<ExactSum> sum_all(const Sum& sum, Store& store, std::size_t count, threads::Pool& pool) {
  constexpr std::size_t kBest = 16 * kParticlesAtOnce;
  const std::size_t range = pool.items(kBest);
  std::vector<std::vector<ExactSum>> parts((count + range - 1) / range);
  pool.run(parts.size(), [&](std::size_t part, std::size_t) {
    Values values(sum, store);
    std::vector<particles::FloatTable> tables(sum.weights.size());
    over_blocks(part * range, std::min(count, (part + 1) * range), [&](std::size_t at, std::size_t length) {
      values.enter(at, length);
      for (std::size_t w = 0; w < tables.size(); ++w) {
        add_block(values.chosen(), values.of(sum.weights[w]), length, tables[w]);
      }
    });
    parts[part].resize(tables.size());
    for (std::size_t w = 0; w < tables.size(); ++w) tables[w].add_to(parts[part][w]);
  });
  std::vector<ExactSum> all(sum.weights.size());
  for (const std::vector<ExactSum>& part : parts) {
    for (std::size_t w = 0; w < all.size(); ++w) all[w] += part[w];
  }
  return all;
}

/// The bins and weights of some particles, before they are added.
struct Sorted {
  std::vector<std::uint32_t> bins;
  std::vector<float> weights;
};

class Sorter {
 public:
  Sorter(const Sum& sum, Store& store) : sum_(sum), store_(store), none_(static_cast<std::uint32_t>(results(sum))) {
    for (const Dimension& dimension : sum.dimensions) bins_.emplace_back(dimension);
  }
  /// Returns the number that stands for no bin.
  std::uint32_t none() const { return none_; }

  /// Bins particles first .. last - 1 of the store; the results begin at index `to`.
  void sort(std::size_t first, std::size_t last, std::size_t to, Sorted& sorted) const {
    Values values(sum_, store_);
    over_blocks(first, last, [&](std::size_t at, std::size_t length) {
      values.enter(at, length);
      std::uint32_t* bins = sorted.bins.data() + (to + at - first);
      for (std::size_t i = 0; i < length; ++i) bins[i] = values.chosen()[i] != 0 ? 0 : none_;
      for (std::size_t d = 0; d < bins_.size(); ++d) {
        refine(bins_[d], values.of(sum_.dimensions[d].value), length, bins);
      }
      if (sum_.weights.empty()) return;
      std::memcpy(sorted.weights.data() + (to + at - first), values.of(sum_.weights[0]), length * sizeof(float));
    });
  }

 private:
  // Divides the bins of the dimensions so far by one more dimension.
  void refine(const Bins& dimension, const float* value, std::size_t length, std::uint32_t* bins) const {
    for (std::size_t i = 0; i < length; ++i) {
      const std::uint32_t bin = dimension.of(value[i]);
      bins[i] = bins[i] == none_ || bin == dimension.count() ? none_ : bins[i] * dimension.count() + bin;
    }
  }

  const Sum& sum_;
  Store& store_;
  std::uint32_t none_;
  std::vector<Bins> bins_;
};

// Returns the thread that adds to a bin. Neighbouring bins, which are often full together, belong to different threads.
std::uint32_t thread_of(std::uint32_t bin, std::uint32_t threads) {
  return static_cast<std::uint32_t>((std::uint64_t{bin * 0x9e3779b1u} * threads) >> 32);
}

void add_one(std::int64_t& count, const Sorted&, std::size_t) { ++count; }
void add_one(ExactSum& sum, const Sorted& sorted, std::size_t i) { sum.add(sorted.weights[i]); }

// Many bins are too large for every thread to have its own. So all threads bin a stretch of particles, and then each
// thread adds those in its share of the bins.
template <class Result>
void sum_bins(const Sum& sum, Store& store, std::size_t count, threads::Pool& pool, std::vector<Result>& into) {
  constexpr std::size_t kStretch = 32 * kParticlesAtOnce;
  constexpr std::size_t kAhead = 16;  // particles; bins are all over memory, so each is prefetched before its turn
  const Sorter sorter(sum, store);
  const std::size_t most = std::min(count, kStretch);
  Sorted sorted{std::vector<std::uint32_t>(most), std::vector<float>(sum.weights.empty() ? 0 : most)};
  const auto threads = static_cast<std::uint32_t>(pool.threads());
  for (std::size_t begin = 0; begin < count; begin += kStretch) {
    const std::size_t length = std::min(kStretch, count - begin);
    threads::over_ranges(pool, length, kParticlesAtOnce, [&](std::size_t first, std::size_t last) {
      sorter.sort(begin + first, begin + last, first, sorted);
    });
    pool.run(threads, [&](std::size_t part, std::size_t) {
      for (std::size_t i = 0; i < length; ++i) {
        if (i + kAhead < length) __builtin_prefetch(into.data() + sorted.bins[i + kAhead], 1);
        const std::uint32_t bin = sorted.bins[i];
        if (bin == sorter.none() || (threads > 1 && thread_of(bin, threads) != part)) continue;
        add_one(into[bin], sorted, i);
      }
    });
  }
}

bool zero(std::int64_t count) { return count == 0; }
bool zero(const ExactSum& sum) { return sum.zero(); }

}  // namespace

std::size_t results(const Sum& sum) {
  std::size_t bins = 1;
  for (const Dimension& dimension : sum.dimensions) {
    bins *= dimension.edges.size() - 1;
    if (bins > kMostBins) {
      throw base::InvalidArgument("a sum", "have at most " + std::to_string(kMostBins) + " bins");
    }
  }
  return sum.dimensions.empty() ? sum.weights.size() : bins;
}

void check(const Sum& sum, const particles::Schema& schema) {
  actions::check_condition(sum.where, sum.shapes, schema);
  for (const Dimension& dimension : sum.dimensions) check_edges(dimension.edges);
  if (results(sum) == 0) throw base::InvalidArgument("a sum", "have a weight or a dimension");
  if (!sum.dimensions.empty() && sum.weights.size() > 1) throw base::InvalidArgument("weights", "be one expression");
  each_expression(sum, [&](const Expression& one) {
    if (&one == &sum.where) return;
    if (check(one, schema.components(), static_cast<int>(sum.shapes.size())) != expressions::Type::number) {
      throw base::InvalidArgument("a sum", "be of numbers");
    }
  });
}

bool uses_copies(const Sum& sum, const particles::Schema& schema) {
  bool uses = false;
  each_expression(sum, [&](const Expression& one) { uses = uses || actions::uses_copies(one, schema); });
  return uses;
}

std::string fingerprint(const Sum& sum) {
  base::Bytes bytes;
  base::write_fields(sum, bytes);
  const base::Hash hash = base::hash(bytes.view());
  std::array<char, 33> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx%016llx", static_cast<unsigned long long>(hash.low),
                static_cast<unsigned long long>(hash.high));
  return digits.data();
}

Summed nothing(const Sum& sum) {
  if (sum.weights.empty()) return std::vector<std::int64_t>(results(sum));
  return std::vector<ExactSum>(results(sum));
}

Summed sum_up(const Sum& sum, Store& store, std::size_t count, threads::Pool& pool) {
  if (sum.dimensions.empty()) return sum_all(sum, store, count, pool);
  Summed summed = nothing(sum);
  std::visit([&](auto& results) { sum_bins(sum, store, count, pool, results); }, summed);
  return summed;
}

void write(const Summed& summed, base::Bytes& out) {
  std::visit(
      [&](const auto& results) {
        out.put(static_cast<std::uint64_t>(results.size()));
        std::vector<std::uint64_t> present((results.size() + 63) / 64);
        for (std::size_t i = 0; i < results.size(); ++i) {
          present[i / 64] |= std::uint64_t{!zero(results[i])} << i % 64;
        }
        out.put_raw(present.data(), present.size() * sizeof present[0]);
        for (const auto& result : results) {
          if (!zero(result)) out.put(result);
        }
      },
      summed);
}

void add(base::Reader& in, Summed& to) {
  std::visit(
      [&](auto& results) {
        using Result = std::decay_t<decltype(results[0])>;
        if (in.get<std::uint64_t>() != results.size()) throw std::runtime_error("a message has sums of different bins");
        std::vector<std::uint64_t> present((results.size() + 63) / 64);
        const auto bytes = in.take(present.size() * sizeof present[0]);
        if (!bytes.empty()) std::memcpy(present.data(), bytes.data(), bytes.size());
        for (std::size_t i = 0; i < results.size(); ++i) {
          if ((present[i / 64] >> i % 64 & 1u) != 0) results[i] += in.get<Result>();
        }
      },
      to);
}

Totals totals(Summed summed) {
  if (auto* counts = std::get_if<std::vector<std::int64_t>>(&summed)) return std::move(*counts);
  const auto& sums = std::get<std::vector<ExactSum>>(summed);
  std::vector<double> rounded(sums.size());
  std::transform(sums.begin(), sums.end(), rounded.begin(), [](const ExactSum& sum) { return sum.rounded(); });
  return rounded;
}

}  // namespace motes::program
