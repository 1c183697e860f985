#include "recording/source_total.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace motes::recording {
namespace {

// A number as the unevaluated sum of two doubles, of which `low` is at most half a unit in the last place of `high`.
struct Twofold {
  double high = 0, low = 0;
};

// Adds two numbers exactly (Knuth's TwoSum).
Twofold sum_of(double a, double b) {
  const double sum = a + b;
  const double part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

// Multiplies two numbers exactly (Dekker), if neither is beyond 1e300.
Twofold product_of(double a, double b) {
  const auto split = [](double x) {  // into halves of 26 bits
    const double scaled = 134217729.0 * x;
    const double high = scaled - (scaled - x);
    return Twofold{high, x - high};
  };
  const double product = a * b;
  const Twofold p = split(a), q = split(b);
  return {product, ((p.high * q.high - product) + p.high * q.low + p.low * q.high) + p.low * q.low};
}

// Adds two numbers with a relative error of 2^-104.
Twofold operator+(Twofold a, Twofold b) {
  Twofold sum = sum_of(a.high, b.high);
  const Twofold rest = sum_of(a.low, b.low);
  sum = sum_of(sum.high, sum.low + rest.high);
  return sum_of(sum.high, sum.low + rest.low);
}

// Divides by an integer with a relative error of 2^-104.
Twofold operator/(Twofold a, int by) {
  const double quotient = a.high / by;
  const Twofold back = product_of(quotient, by);
  return sum_of(quotient, (((a.high - back.high) - back.low) + a.low) / by);
}

// Returns how many particles a (sub)step adds to the total: not necessarily a whole number.
Twofold emitted_in_step(const Source& source, double dt, int substep, int substeps) {
  if (source.integral.empty()) return product_of(source.rate, dt) / substeps;
  const auto step = static_cast<std::size_t>(substep);
  if (step + 1 >= source.integral.size()) return {};
  return sum_of(source.integral[step + 1], -source.integral[step]);
}

// Returns the whole particles of a total.
std::uint64_t whole(const SourceTotal& total) {
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
  constexpr double kMost = 9.0e18;  // what 64 bits hold
  const double nearest = std::nearbyint(total.high);
  const double beyond = (total.high - nearest) + total.low;
  const bool below = -beyond > kRounding * std::max(total.scale, total.high);
  return static_cast<std::uint64_t>(std::clamp(below ? nearest - 1 : nearest, 0.0, kMost));
}

}  // namespace

std::uint64_t births_in_step(const Birth& birth, double dt, int substep, int substeps, SourceTotal* total) {
  if (const auto* burst = std::get_if<Burst>(&birth)) return substep == 0 ? burst->count : 0;
  if (const auto* emit = std::get_if<Emit>(&birth)) return substep == 0 ? emit->count : 0;
  const auto& source = std::get<Source>(birth);
  const Twofold sum = Twofold{total->high, total->low} + emitted_in_step(source, dt, substep, substeps);
  total->high = sum.high;
  total->low = sum.low;
  total->scale = std::max(total->scale, source.scale);
  const std::uint64_t until_now = std::max(total->emitted, whole(*total));
  return until_now - std::exchange(total->emitted, until_now);
}

std::vector<SourceTotal*> totals_of(std::span<const Item> list, std::vector<SourceTotal>& totals) {
  const auto before = [](const SourceTotal& a, const SourceTotal& b) {
    return std::tie(a.source, a.call) < std::tie(b.source, b.call);
  };
  std::map<std::uint64_t, std::uint64_t> calls;
  std::vector<std::pair<std::size_t, SourceTotal>> wanted;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto* birth = std::get_if<Birth>(&list[i]);
    const auto* source = birth == nullptr ? nullptr : std::get_if<Source>(birth);
    if (source == nullptr) continue;
    const SourceTotal fresh{.source = source->number, .call = calls[source->number]++};
    const auto at = std::lower_bound(totals.begin(), totals.end(), fresh, before);
    if (at == totals.end() || before(fresh, *at)) totals.insert(at, fresh);
    wanted.emplace_back(i, fresh);
  }
  std::vector<SourceTotal*> by_item(list.size(), nullptr);
  for (const auto& [item, key] : wanted) by_item[item] = &*std::lower_bound(totals.begin(), totals.end(), key, before);
  return by_item;
}

}  // namespace motes::recording
