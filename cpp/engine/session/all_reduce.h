// All-reduce among calculators: every calculator gets the maximum, or the sum, of each number.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "engine/session/rank.h"
#include "engine/session/round.h"

namespace motes::engine {

/// Element 0 is a failure flag; a calculator that has failed may send only that.
using Maxima = std::vector<float>;

/// Returns the elementwise maxima over all calculators. Collective over calculators. Each sends log2(n) messages: in
/// step s, its maxima so far, to the calculator 2^s places ahead (dissemination; Hensgen, Finkel, Manber 1988).
Maxima all_reduce_max(Rank& rank, const Round& round, Maxima numbers);

/// Visits the floats of a struct with fields(), and of lists in it, one by one.
template <class Work>
class EachFloat {
 public:
  explicit EachFloat(Work work) : work_(std::move(work)) {}

  template <class... T>
  constexpr void operator()(T&... values) {
    (one(values), ...);
  }

 private:
  void one(float& number) { work_(number); }
  void one(std::vector<float>& numbers) { std::for_each(numbers.begin(), numbers.end(), std::ref(work_)); }
  template <class T>
  constexpr void one(T& part) {
    fields(*this, part);
  }

  Work work_;
};

/// Replaces each float of a struct with its maximum over all calculators. Returns false, and changes nothing, if one of
/// them has failed. Collective over calculators.
template <class Numbers>
bool agree_on_maxima(Rank& rank, const Round& round, Numbers& own) {
  Maxima numbers = {rank.session.failed() ? 1.0f : 0.0f};
  EachFloat list([&](const float& number) { numbers.push_back(number); });
  fields(list, own);
  numbers = all_reduce_max(rank, round, std::move(numbers));
  if (numbers[0] != 0) return false;
  std::size_t at = 0;
  EachFloat take([&](float& number) { number = numbers[++at]; });
  fields(take, own);
  return true;
}

/// Replaces `numbers`, equally many on all calculators, with their elementwise sums over all of them. Returns the bytes
/// sent. Collective over calculators. Each sums one part and sends it to the others (reduce-scatter, then all-gather):
/// 2 (n - 1) messages per calculator, in which each number is sent twice.
std::uint64_t all_reduce_sum(Rank& rank, const Round& round, comm::Phase phase, std::vector<std::int64_t>& numbers);

}  // namespace motes::engine
