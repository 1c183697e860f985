// Random numbers: Philox4x32 compared with the vectors that its authors publish (Random123, tests/kat_vectors), and
// draws compared with the same function written plainly, in every lane of every build.
#include <algorithm>
#include <set>
#include <vector>

#include "particles/philox.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_random {
namespace {

struct Known {
  particles::Words counter;
  particles::Key key;
  particles::Words after7, after10;
};

constexpr Known kKnown[] = {
    {{0, 0, 0, 0},
     {0, 0},
     {0x5f6fb709, 0x0d893f64, 0x4f121f81, 0x4f730a48},
     {0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}},
    {{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff},
     {0xffffffff, 0xffffffff},
     {0x5207ddc2, 0x45165e59, 0x4d8ee751, 0x8c52f662},
     {0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}},
    {{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344},
     {0xa4093822, 0x299f31d0},
     {0x4dfccaba, 0x190a87f0, 0xc47362ba, 0xb6b5242a},
     {0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}},
};

// Computes the words of a particle in one draw.
void plain_draw(std::uint64_t id, std::uint32_t step, std::uint32_t stream_and_draw, const std::uint32_t key[2],
                std::uint32_t out[4]) {
  std::uint32_t k[8];
  for (std::uint32_t half = 0; half < 2; ++half) {
    const auto words = particles::philox({step, stream_and_draw, 0x6d6f7465u, half}, {key[0], key[1]}, 10);
    std::copy(words.begin(), words.end(), k + 4 * half);
  }
  const auto low = static_cast<std::uint32_t>(id);
  const auto high = static_cast<std::uint32_t>(id >> 32);
  const auto mix = [](std::uint32_t v, int first, std::uint32_t by, int then, std::uint32_t plus, std::uint32_t by_too,
                      int last) {
    v = (v ^ v >> first) * by;
    v = ((v ^ v >> then) + plus) * by_too;
    return v ^ v >> last;
  };
  const std::uint32_t a = mix((low + high * 0x9E3779B1u) ^ k[0], 16, 0x7feb352du, 15, k[1], 0x846ca68bu, 16);
  const std::uint32_t b = mix((low + high * 0x85EBCA6Au) ^ k[2], 15, 0xd168aaadu, 15, k[3], 0xaf723597u, 15);
  const auto turned = [](std::uint32_t v, int bits) { return v << bits | v >> (32 - bits); };
  const auto folded = [](std::uint32_t v, int bits) { return v ^ v >> bits; };
  out[0] = folded((a ^ k[4]) * 0x9E3779B1u, 16) + b;
  out[1] = folded((b ^ k[5]) * 0x85EBCA77u, 16) + turned(a, 16);
  out[2] = folded((a + b + k[6]) * 0xC2B2AE3Du, 16);
  out[3] = folded(((a ^ turned(b, 7)) + k[7]) * 0x27D4EB2Fu, 15);
}

}  // namespace

TEST(philox_gives_the_published_words) {
  using particles::philox;
  for (const Known& known : kKnown) {
    CHECK(philox(known.counter, known.key, 7) == known.after7);
    CHECK(philox(known.counter, known.key, 10) == known.after10);
  }
}

TEST(draws_are_a_function_of_id_step_stream_and_draw) {
  test::Dice dice(2);
  for (int round = 0; round < 600; ++round) {
    const auto half = [&] { return static_cast<std::uint32_t>(dice.word()); };
    const std::uint32_t step = half(), stream = half() >> particles::draw_bits, key[2] = {half(), half()};
    const int skip = round % 16;
    const std::size_t count = 1 + dice.word() % 100;
    std::vector<std::uint64_t> ids(count + 16);
    for (std::uint64_t& id : ids) id = round % 3 == 0 ? dice.word() : dice.word() >> 32;
    if (round % 3 == 2) ids[dice.below(count)] |= std::uint64_t{1} << (32 + dice.below(32));  // one has an upper half
    const particles::IdList halves(ids);
    for (const test::Build& build : test::builds()) {
      std::vector<std::uint32_t> out(4 * ids.size());
      build.probe.draws(halves, count, step, stream, key, skip, out.data());
      for (std::size_t i = 0; i < count; ++i) {
        std::uint32_t plain[4];
        plain_draw(ids[i], step, stream << particles::draw_bits | static_cast<std::uint32_t>(skip), key, plain);
        for (std::size_t k = 0; k < 4; ++k) CHECK(out[4 * i + k] == plain[k]);
      }
    }
  }
}

TEST(kept_keys_are_those_of_the_draw_that_is_asked_for) {
  using namespace particles;
  const auto same = [](const DrawKey& a, const DrawKey& b) {
    return std::equal(std::begin(a.word), std::end(a.word), std::begin(b.word));
  };
  DrawKeys keys;
  for (const Key key : {Key{1, 2}, Key{1, 3}}) {
    for (const std::uint32_t step : {0u, 1u}) {
      for (const std::uint32_t stream : {action, action + 1}) {
        for (int again = 0; again < 2; ++again) {
          keys.begin(key, step, stream);
          CHECK(same(keys.first(), draw_key(key, step, stream, 0)));
          for (const std::uint32_t draw : {1u, 2u, 1u}) {
            CHECK(same(keys.later(draw), draw_key(key, step, stream, draw)));
          }
        }
      }
    }
  }
}

// Streams that share all but some bits of a draw's number.
TEST(draws_that_are_made_again_are_new_ones) {
  using namespace particles;
  std::set<std::vector<std::uint32_t>> seen;
  std::size_t count = 0;
  for (const std::uint32_t stream : {birth_attribute, action, action + 1, action + 0x1000}) {
    for (std::uint32_t draw = 0; draw < 2; ++draw) {
      for (std::uint32_t attempt = 0; attempt < 40; ++attempt, ++count) {
        const DrawKey key = draw_key({1, 2}, 0, stream, made_again(draw, attempt));
        seen.emplace(std::begin(key.word), std::end(key.word));
      }
    }
  }
  CHECK(seen.size() == count);
}

TEST(keys_differ_by_seed_and_system) {
  std::vector<particles::Key> keys;
  for (const std::uint64_t seed : {0ull, 1ull, 1ull << 32, ~0ull}) {
    for (std::uint32_t system = 0; system < 8; ++system) keys.push_back(particles::system_key(seed, system));
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) CHECK(keys[i].low != keys[k].low || keys[i].high != keys[k].high);
  }
}

}  // namespace motes::test_random
