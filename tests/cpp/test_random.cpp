// Random numbers: Philox4x32 against the vectors that its authors publish (Random123, tests/kat_vectors), draws against
// the same function written plainly, in every lane of every build.
#include <vector>

#include "check.h"
#include "isas.h"
#include "particles/streams.h"

namespace {

struct Known {
  std::uint32_t counter[4];
  std::uint32_t key[2];
  std::uint32_t after7[4];
  std::uint32_t after10[4];
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

// The generator once more, written plainly.
void plain_philox(std::uint32_t c[4], std::uint32_t low, std::uint32_t high, int rounds) {
  for (int round = 0; round < rounds; ++round, low += 0x9E3779B9u, high += 0xBB67AE85u) {
    const std::uint64_t first = std::uint64_t{0xD2511F53u} * c[0];
    const std::uint64_t second = std::uint64_t{0xCD9E8D57u} * c[2];
    const std::uint32_t next[4] = {
        static_cast<std::uint32_t>(second >> 32) ^ c[1] ^ low, static_cast<std::uint32_t>(second),
        static_cast<std::uint32_t>(first >> 32) ^ c[3] ^ high, static_cast<std::uint32_t>(first)};
    for (int i = 0; i < 4; ++i) c[i] = next[i];
  }
}

// The words of a particle in one draw.
void plain_draw(std::uint64_t id, std::uint32_t step, std::uint32_t stream_and_draw, const std::uint32_t key[2],
                std::uint32_t out[4]) {
  std::uint32_t k[8] = {step, stream_and_draw, 0x6d6f7465u, 0, step, stream_and_draw, 0x6d6f7465u, 1};
  plain_philox(k, key[0], key[1], 10);
  plain_philox(k + 4, key[0], key[1], 10);
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
  for (const test::Build& build : test::builds()) {
    std::vector<std::uint32_t> out(4 * build.probe.lanes);
    for (const Known& known : kKnown) {
      // Each lane's counter is one higher: the published vector appears in lane 0 and, shifted, in every other lane.
      for (std::size_t lane = 0; lane < build.probe.lanes; ++lane) {
        std::uint32_t counter[4] = {known.counter[0] - static_cast<std::uint32_t>(lane), known.counter[1],
                                    known.counter[2], known.counter[3]};
        build.probe.philox7(counter, known.key, out.data());
        for (std::size_t i = 0; i < 4; ++i) CHECK(out[4 * lane + i] == known.after7[i]);
        build.probe.philox10(counter, known.key, out.data());
        for (std::size_t i = 0; i < 4; ++i) CHECK(out[4 * lane + i] == known.after10[i]);
      }
    }
  }
}

TEST(philox_agrees_with_plain_words) {
  test::Dice dice(1);
  for (int round = 0; round < 2000; ++round) {
    const std::uint64_t words[3] = {dice.word(), dice.word(), dice.word()};
    const auto half = [&](int i) { return static_cast<std::uint32_t>(words[i / 2] >> (32 * (i % 2))); };
    const std::uint32_t counter[4] = {half(0), half(1), half(2), half(3)};
    const std::uint32_t key[2] = {half(4), half(5)};
    for (const test::Build& build : test::builds()) {
      std::vector<std::uint32_t> out(4 * build.probe.lanes);
      build.probe.philox10(counter, key, out.data());
      for (std::size_t lane = 0; lane < build.probe.lanes; ++lane) {
        std::uint32_t plain[4] = {counter[0] + static_cast<std::uint32_t>(lane), counter[1], counter[2], counter[3]};
        plain_philox(plain, key[0], key[1], 10);
        for (std::size_t i = 0; i < 4; ++i) CHECK(out[4 * lane + i] == plain[i]);
      }
    }
  }
}

TEST(draws_are_a_function_of_id_step_stream_and_draw) {
  test::Dice dice(2);
  for (int round = 0; round < 200; ++round) {
    const auto half = [&] { return static_cast<std::uint32_t>(dice.word()); };
    const std::uint32_t step = half(), stream = half() >> motes::particles::draw_bits, key[2] = {half(), half()};
    const int skip = round % 16;
    const std::size_t count = 1 + dice.word() % 100;
    std::vector<std::uint64_t> ids(count + 16);
    for (std::uint64_t& id : ids) id = round % 2 == 0 ? dice.word() : dice.word() >> 40;
    for (const test::Build& build : test::builds()) {
      std::vector<std::uint32_t> out(4 * ids.size());
      build.probe.draws(ids.data(), count, step, stream, key, skip, out.data());
      for (std::size_t i = 0; i < count; ++i) {
        std::uint32_t plain[4];
        plain_draw(ids[i], step, stream << motes::particles::draw_bits | static_cast<std::uint32_t>(skip), key, plain);
        for (std::size_t k = 0; k < 4; ++k) CHECK(out[4 * i + k] == plain[k]);
      }
    }
  }
}

TEST(keys_differ_by_seed_and_system) {
  std::vector<motes::particles::Key> keys;
  for (const std::uint64_t seed : {0ull, 1ull, 1ull << 32, ~0ull}) {
    for (std::uint32_t system = 0; system < 8; ++system) keys.push_back(motes::particles::system_key(seed, system));
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) CHECK(keys[i].low != keys[k].low || keys[i].high != keys[k].high);
  }
}
