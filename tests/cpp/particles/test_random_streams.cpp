// Statistical tests of the engine's streams of random numbers: words of neighbouring ids, of ids far apart or above
// 2^32, of neighbouring steps, places in the list, draws and seeds. Everything is a fixed function, so a test that
// passes once always passes. docs/lab/speed.md reports what larger tests found.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "particles/streams.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_random_streams {
namespace {

constexpr std::uint64_t kCount = std::uint64_t{1} << 18;
// Standard deviations. Among the tens of thousands of figures below, chance alone exceeds this once in a hundred runs.
constexpr double kLimit = 5.5;

struct Words {
  std::vector<std::uint32_t> of[4];  // by the place of a word in its draw
};

struct Where {
  std::uint64_t id = 0;
  std::uint32_t step = 0, stream = particles::action;
  int draw = 0;
  std::uint64_t seed = 1;
  std::uint32_t system = 0;

  bool shares_key_with(const Where& other) const {
    return step == other.step && stream == other.stream && draw == other.draw && seed == other.seed &&
           system == other.system;
  }
};

// Returns the words of `total` draws: number n is that of where(n). Ids that share the rest are drawn together.
Words words(const std::function<Where(std::uint64_t)>& where, std::uint64_t total = kCount) {
  const test::Probe& probe = test::builds().back().probe;
  Words all;
  for (auto& of : all.of) of.reserve(total);
  std::vector<std::uint64_t> ids;
  std::vector<std::uint32_t> out;
  for (std::uint64_t n = 0; n < total;) {
    const Where first = where(n);
    ids.assign(1, first.id);
    for (++n; n < total && ids.size() < 512; ++n) {
      const Where next = where(n);
      if (!next.shares_key_with(first)) break;
      ids.push_back(next.id);
    }
    const std::size_t count = ids.size();
    ids.resize(count + 32);
    const particles::IdList halves_of_ids(ids);
    out.resize(4 * ids.size());
    const particles::Key key = particles::system_key(first.seed, first.system);
    const std::uint32_t halves[2] = {key.low, key.high};
    probe.draws(halves_of_ids, count, first.step, first.stream, halves, first.draw, out.data());
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < 4; ++k) all.of[k].push_back(out[4 * i + k]);
    }
  }
  return all;
}

// Returns how far chi-square is from its mean, in standard deviations (E. Wilson, M. Hilferty, PNAS 17, 1931).
double deviation(const std::vector<std::uint32_t>& counts, double total) {
  const double expected = total / static_cast<double>(counts.size());
  double chi = 0;
  for (const std::uint32_t count : counts) chi += (count - expected) * (count - expected) / expected;
  const double freedom = static_cast<double>(counts.size()) - 1;
  return (std::cbrt(chi / freedom) - (1 - 2 / (9 * freedom))) / std::sqrt(2 / (9 * freedom));
}

class Figures {
 public:
  void note(const std::string& what, double deviation) {
    if (std::fabs(deviation) > std::fabs(worst_)) {
      worst_ = deviation;
      what_ = what;
    }
  }
  double worst() const { return worst_; }
  const std::string& what() const { return what_; }

 private:
  double worst_ = 0;
  std::string what_;
};

// Notes how evenly `cell(n)` fills the cells 0 .. cells - 1.
template <class Cell>
void uniform(Figures& figures, const std::string& what, std::size_t cells, std::size_t total, const Cell& cell) {
  std::vector<std::uint32_t> counts(cells);
  for (std::size_t n = 0; n < total; ++n) ++counts[cell(n)];
  figures.note(what, deviation(counts, static_cast<double>(total)));
}

// Notes how many bits of two series are equal: each of the 32 bits is a coin.
void coins(Figures& figures, const std::string& what, const std::uint32_t* one, const std::uint32_t* other,
           std::size_t total) {
  std::uint32_t ones[32] = {};
  for (std::size_t n = 0; n < total; ++n) {
    for (int b = 0; b < 32; ++b) ones[b] += (one[n] ^ other[n]) >> b & 1u;
  }
  const auto t = static_cast<double>(total);
  for (int b = 0; b < 32; ++b) figures.note(what + ", bit " + std::to_string(b), (ones[b] - t / 2) / std::sqrt(t / 4));
}

Figures examine(const Words& words) {
  Figures figures;
  const std::vector<std::uint32_t> zeros(kCount);
  for (std::size_t k = 0; k < 4; ++k) {
    const std::vector<std::uint32_t>& w = words.of[k];
    const std::string name = "word " + std::to_string(k);
    coins(figures, name, w.data(), zeros.data(), kCount);
    for (const int shift : {0, 8, 22}) {
      uniform(figures, name + ", 1d", 1024, kCount, [&](std::size_t n) { return w[n] >> shift & 1023u; });
    }
    for (const std::size_t lag : {1, 2, 3, 4, 8, 16, 32, 100, 512, 1024, 65536}) {
      const std::string lagged = name + ", lag " + std::to_string(lag);
      coins(figures, lagged, w.data(), w.data() + lag, kCount - lag);
      uniform(figures, lagged + ", 2d", 4096, kCount - lag,
              [&](std::size_t n) { return w[n] >> 26 << 6 | w[n + lag] >> 26; });
    }
    uniform(figures, name + ", 3d", 4096, kCount / 3,
            [&](std::size_t n) { return w[3 * n] >> 28 << 8 | w[3 * n + 1] >> 28 << 4 | w[3 * n + 2] >> 28; });
    uniform(figures, name + ", 4d", 4096, kCount / 4, [&](std::size_t n) {
      return w[4 * n] >> 29 << 9 | w[4 * n + 1] >> 29 << 6 | w[4 * n + 2] >> 29 << 3 | w[4 * n + 3] >> 29;
    });
    for (std::size_t other = k + 1; other < 4; ++other) {
      coins(figures, name + " and " + std::to_string(other), w.data(), words.of[other].data(), kCount);
    }
  }
  uniform(figures, "words, 4d", 4096, kCount, [&](std::size_t n) {
    return words.of[0][n] >> 29 << 9 | words.of[1][n] >> 29 << 6 | words.of[2][n] >> 29 << 3 | words.of[3][n] >> 29;
  });
  return figures;
}

bool random(const char* name, const std::function<Where(std::uint64_t)>& where) {
  const Figures figures = examine(words(where));
  if (std::fabs(figures.worst()) < kLimit) return true;
  std::printf("       %s: %s is %.1f standard deviations off\n", name, figures.what().c_str(), figures.worst());
  return false;
}

std::uint32_t low(std::uint64_t n) { return static_cast<std::uint32_t>(n); }

}  // namespace

TEST(words_of_many_ids_look_random) {
  for (const std::uint64_t seed : {0, 1, 2}) {
    const auto with = [seed](std::uint64_t id) {
      Where w;
      w.id = id;
      w.seed = seed;
      return w;
    };
    CHECK(random("neighbouring ids", [&](std::uint64_t n) { return with(n); }));
    CHECK(random("ids around 2^32", [&](std::uint64_t n) { return with((std::uint64_t{1} << 32) - kCount / 2 + n); }));
  }
  for (const int shift : {10, 12, 32, 40}) {
    CHECK(random("ids apart", [&](std::uint64_t n) { return Where{.id = (n << shift) + 7}; }));
  }
  CHECK(random("ids that differ in one bit", [](std::uint64_t n) { return Where{.id = n ^ n >> 1}; }));
}

TEST(words_of_few_ids_look_random_over_steps_places_draws_seeds_and_systems) {
  CHECK(random("steps", [](std::uint64_t n) { return Where{.id = n & 7, .step = low(n >> 3)}; }));
  CHECK(random("places", [](std::uint64_t n) {
    return Where{.id = n & 7, .step = low(n >> 13), .stream = particles::action + low(n >> 3 & 1023)};
  }));
  CHECK(random("draws", [](std::uint64_t n) {
    return Where{.id = n & 7, .step = low(n >> 7), .draw = static_cast<int>(n >> 3 & 15)};
  }));
  CHECK(random("seeds", [](std::uint64_t n) { return Where{.id = n & 7, .seed = n >> 3}; }));
  CHECK(random("systems", [](std::uint64_t n) { return Where{.id = n & 7, .system = low(n >> 3)}; }));
}

TEST(words_of_many_ids_occur_twice_as_often_as_random_ones) {
  // Words that were a permutation of the ids would never occur twice. The number of repeats is a Poisson count.
  constexpr std::uint64_t kMany = std::uint64_t{1} << 20;
  Words all = words([](std::uint64_t n) { return Where{.id = n}; }, kMany);
  for (std::vector<std::uint32_t>& w : all.of) {
    std::sort(w.begin(), w.end());
    double twice = 0;
    for (std::uint64_t n = 1; n < kMany; ++n) twice += w[n] == w[n - 1];
    const double expected = 0.5 * kMany * kMany / 0x1p32;
    CHECK(std::fabs(twice - expected) < kLimit * std::sqrt(expected));
  }
}

TEST(a_bit_of_the_id_changes_each_bit_of_the_words_in_half_of_the_draws) {
  constexpr std::uint64_t kDraws = 8192;
  // Ids of 26, 40 and 64 bits: as in a short run, in a long one, and in none.
  const auto id = [](std::uint64_t n) {
    const std::uint64_t bits = test::Dice(n).word();
    return n % 3 == 0 ? bits >> 38 : n % 3 == 1 ? bits >> 24 : bits;
  };
  Figures figures;
  const Words before = words([&](std::uint64_t n) { return Where{.id = id(n)}; }, kDraws);
  for (int bit = 0; bit < 64; ++bit) {
    const Words after = words([&](std::uint64_t n) { return Where{.id = id(n) ^ std::uint64_t{1} << bit}; }, kDraws);
    for (std::size_t k = 0; k < 4; ++k) {
      coins(figures, "bit " + std::to_string(bit) + " and word " + std::to_string(k), before.of[k].data(),
            after.of[k].data(), kDraws);
    }
  }
  CHECK(std::fabs(figures.worst()) < kLimit);
}

}  // namespace motes::test_random_streams
