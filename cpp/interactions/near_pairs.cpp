#include "interactions/near_pairs.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "interactions/overlap.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

// Sub-steps for which near pairs hold unless a grain strays from its course.
constexpr float kSteps = 16;
// Bounds of their skin, relative to the reach.
constexpr float kThinnest = 1.0f / 1024, kThickest = 1.0f / 16;

// Where the pairs of each part of the rows begin.
std::vector<std::size_t> places_of(const Cells& cells, const threads::Pool& pool) {
  std::vector<std::size_t> places;
  for (const std::size_t row : parts_of(cells, pool)) places.push_back(cells.rows()[row].first);
  return places;
}

}  // namespace

Ends::Ends(const particles::Periods& periods) : any(periods.any()) {
  for (int c = 0; c < 3; ++c) {
    const double along = periods.has(c) ? periods[c].length() : 0;
    half[c] = periods.has(c) ? static_cast<float>(along / 2) : std::numeric_limits<float>::infinity();
    length[c] = static_cast<float>(along);
    rest[c] = static_cast<float>(along - static_cast<double>(length[c]));
  }
}

void NearPairs::place(const Placing& placing, threads::Pool& pool) {
  const std::size_t places = placing.cells.size();
  if (!known_) grains_.assign(places + particles::kPadding, Grain{});
  PlaceTask task;
  task.columns = &placing.columns;
  task.order = placing.cells.order().data();
  task.own = static_cast<std::uint32_t>(placing.own);
  task.count = static_cast<std::uint32_t>(placing.own + placing.ghosts);
  task.grains = grains_.data();
  task.ends = &placing.ends;
  age_ += 1;
  known_ = known_ && age_ <= kSteps;
  task.courses = known_ ? courses_.data() : nullptr;
  task.age = age_;
  task.far = 0.49f * skin_;
  std::atomic<bool> strays = false;
  threads::over_ranges(pool, places, kRange, [&](std::size_t first, std::size_t last) {
    const simd::FloatMode mode;
    PlaceTask range = task;
    range.from = static_cast<std::uint32_t>(first);
    range.to = static_cast<std::uint32_t>(last);
    if (!kernels_->place_grains(range)) strays = true;
  });
  stray_ = strays;
  known_ = known_ && !stray_;
}

void NearPairs::find(TouchTask task, float reach, const std::vector<std::size_t>& parts, threads::Pool& pool) {
  if (skin_ == 0) skin_ = reach / 256;
  skin_ = std::clamp(stray_ && age_ < kSteps / 2 ? skin_ * 1.5f : skin_ * 0.9f, reach * kThinnest, reach * kThickest);
  task.skin = skin_;
  task.steps = kSteps;
  courses_.resize(task.places);
  task.courses = courses_.data();
  const std::uint32_t* const listed = task.begin;
  const std::size_t room = listed[task.places] + (parts.size() + 1) * particles::kPadding;
  for (std::vector<std::uint32_t>* column : {&links_.first, &links_.second, &links_.pair}) column->resize(room);
  task.first = links_.first.data();
  task.second = links_.second.data();
  task.pair = links_.pair.data();
  threads::over_ranges(pool, task.places, kRange, [&](std::size_t first, std::size_t last) {
    TouchTask range = task;
    range.from = static_cast<std::uint32_t>(first);
    range.to = static_cast<std::uint32_t>(last);
    kernels_->set_courses(range);
  });
  std::vector<std::uint32_t> found(parts.size() - 1);
  pool.run(found.size(), [&](std::size_t part, std::size_t) {
    const simd::FloatMode mode;
    TouchTask range = task;
    range.from = listed[parts[part]];
    range.to = listed[parts[part + 1]];
    // Whole vectors are stored, also behind the last pair of a part: it must not reach the next part's.
    for (std::uint32_t** column : {&range.first, &range.second, &range.pair}) *column += part * particles::kPadding;
    found[part] = kernels_->find_near(range);
  });
  count_ = 0;
  for (std::size_t part = 0; part < found.size(); ++part) {
    const auto from = static_cast<std::ptrdiff_t>(listed[parts[part]] + part * particles::kPadding);
    for (std::vector<std::uint32_t>* column : {&links_.first, &links_.second, &links_.pair})
      std::copy_n(column->begin() + from, found[part], column->begin() + count_);
    count_ += found[part];
  }
  touched_.assign(count_ + particles::kPadding, 0);
  const std::size_t pushes = 2 * std::size_t{count_} + 1;
  push_.clear();
  if (push_.capacity() < pushes) push_.reserve(pushes + pushes / 8);  // new pages cost more than what is written there
  push_.assign(pushes, GrainPush{});
  links_.begin.resize(task.places + 2);
  for (std::vector<std::uint32_t>* column : {&links_.pushes, &links_.pushed}) column->resize(2 * std::size_t{count_});
  task.begin = links_.begin.data();
  task.pushes = links_.pushes.data();
  task.pushed = links_.pushed.data();
  task.to = count_;
  kernels_->order_pushes(task);
  known_ = true;
  age_ = 0;
}

std::uint64_t NearPairs::act(TouchTask task, float reach, const Cells& cells, threads::Pool& pool) {
  task.grains = grains_.data();
  const std::vector<std::size_t> places = places_of(cells, pool);
  if (!known_) find(task, reach, places, pool);
  out_.resize(task.places + particles::kPadding);
  task.first = links_.first.data();
  task.second = links_.second.data();
  task.pair = links_.pair.data();
  task.touched = touched_.data();
  task.push = push_.data();
  task.begin = links_.begin.data();
  task.pushes = links_.pushes.data();
  task.pushed = links_.pushed.data();
  task.out = out_.data();
  std::vector<KernelStats> stats(places.size() - 1);
  const auto run = [&](std::size_t count, void (*kernel)(const TouchTask&), const auto& limit) {
    pool.run(count, [&](std::size_t part, std::size_t) {
      const simd::FloatMode mode;
      TouchTask range = task;
      range.from = static_cast<std::uint32_t>(limit(part));
      range.to = static_cast<std::uint32_t>(limit(part + 1));
      range.stats = stats.data() + part;
      kernel(range);
    });
  };
  const std::size_t parts = stats.size();
  run(parts, kernels_->touch, [&](std::size_t part) { return std::size_t{count_} * part / parts; });
  run(parts, kernels_->sum_pushes, [&](std::size_t part) { return places[part]; });
  std::uint64_t touches = 0;
  for (const KernelStats& part : stats) touches += part.pairs;
  return touches;
}

float NearPairs::overlap_99(const Cells& cells, std::size_t own, const Ends& ends) const {
  Overlaps overlaps(own);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (cells.order()[k] >= own || !overlaps.takes_next()) continue;
    links_.each(k, [&](const NearLinks::Seen& seen) {
      const Grain &a = grains_[k], &b = grains_[seen.other];
      float d2 = 0;
      for (int c = 0; c < 3; ++c) {
        const float way = std::abs(b.at[c] - a.at[c]);
        const float r = way > ends.half[c] ? way - ends.length[c] - ends.rest[c] : way;
        d2 += r * r;
      }
      overlaps.add(d2, a.radius + b.radius);
    });
  }
  return overlaps.percentile_99();
}

}  // namespace motes::interactions
