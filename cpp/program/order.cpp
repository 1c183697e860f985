#include "program/order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "program/select.h"

namespace motes::program {
namespace {

/// A particle being sorted; a smaller key means farther away.
struct SortEntry {
  std::uint64_t key;
  std::uint32_t index;
};

std::uint64_t key_of(double distance) {
  if (std::isnan(distance)) distance = -std::numeric_limits<double>::infinity();
  const auto bits = std::bit_cast<std::uint64_t>(distance + 0.0);  // both zeros are the same distance
  constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
  const std::uint64_t ascending = (bits & kSign) != 0 ? ~bits : bits | kSign;  // ordered like the numbers
  return ~ascending;
}

constexpr int kDigitBits = 11, kDigits = 4, kRest = 64 - kDigits * kDigitBits;
constexpr std::size_t kPlacesAtOnce = std::size_t{1} << 14;  // places of one thread at a time
constexpr std::size_t kValues = std::size_t{1} << kDigitBits;

std::size_t digit_of(std::uint64_t key, int digit) { return key >> (kRest + digit * kDigitBits) & (kValues - 1); }

// A radix sort by all bits of the key except the last kRest: digit by digit from the least significant one, each pass
// stable.
void sort_by_digits(std::vector<SortEntry>& places) {
  std::vector<std::array<std::size_t, kValues>> counts(kDigits);
  for (const SortEntry& place : places) {
    for (int d = 0; d < kDigits; ++d) ++counts[static_cast<std::size_t>(d)][digit_of(place.key, d)];
  }
  std::vector<SortEntry> sorted(places.size());
  for (int d = 0; d < kDigits; ++d) {
    auto& count = counts[static_cast<std::size_t>(d)];
    if (*std::max_element(count.begin(), count.end()) == places.size()) continue;  // all keys have the same digit
    std::exclusive_scan(count.begin(), count.end(), count.begin(), std::size_t{0});
    for (const SortEntry& place : places) sorted[count[digit_of(place.key, d)]++] = place;
    places.swap(sorted);
  }
}

void sort_places(std::vector<SortEntry>& places, const particles::Ids& ids) {
  const auto before = [&ids](const SortEntry& a, const SortEntry& b) {
    return a.key != b.key ? a.key < b.key : ids[a.index] < ids[b.index];
  };
  if (places.size() < kValues) return std::sort(places.begin(), places.end(), before);
  sort_by_digits(places);
  for (auto run = places.begin(); run != places.end();) {
    const auto end =
        std::find_if(run, places.end(), [&](const SortEntry& p) { return p.key >> kRest != run->key >> kRest; });
    if (end - run > 1) std::sort(run, end, before);
    run = end;
  }
}

}  // namespace

std::vector<std::uint32_t> order(const actions::Action& sort, double time, particles::Store& store,
                                 threads::Pool& pool) {
  const auto given = actions::numbers_of<actions::numbers::sort>(sort);
  const std::vector<std::uint32_t> chosen = select(sort.where, sort.shapes, time, store);
  const particles::Value everywhere = store.uniform_value(particles::position);
  std::vector<SortEntry> places(chosen.size());
  const auto distance_of = [&](std::uint32_t particle) {
    double distance = 0;
    for (int c = 0; c < 3; ++c) {
      const float* x = store.plane(particles::position, c);
      const double at = x != nullptr ? x[particle] : everywhere[static_cast<std::size_t>(c)];
      distance += (at - given.eye[c]) * given.look[c];
    }
    return distance;
  };
  threads::over_ranges(pool, chosen.size(), kPlacesAtOnce, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) places[k] = {key_of(distance_of(chosen[k])), chosen[k]};
  });
  sort_places(places, store.ids());
  std::vector<std::uint32_t> from(store.size());
  std::iota(from.begin(), from.end(), 0u);
  for (std::size_t k = 0; k < chosen.size(); ++k) from[chosen[k]] = places[k].index;
  store.permute(from, pool);
  return from;
}

}  // namespace motes::program
