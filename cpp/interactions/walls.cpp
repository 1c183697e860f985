#include "interactions/walls.h"

#include <algorithm>
#include <memory>

#include "interactions/extent.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using particles::Touch;

// A wall, or a part of a union, which acts as a separate wall.
struct WallPart {
  const shapes::Shape* shape;
  const shapes::Shape* origin;  // see WallTask
  std::uint32_t wall;           // number among the walls of the contact
};

std::vector<WallPart> parts_of(const actions::Action& action) {
  std::vector<WallPart> parts;
  for (std::uint32_t wall = 0; wall < actions::grains_of(action)->walls.size(); ++wall) {
    const shapes::Shape& shape = action.shapes[wall];
    if (shape.parts == 0) parts.push_back({&shape, &shape, wall});
    for (int i = 0; i < shape.parts; ++i) parts.push_back({shape.part + i, shape.part, wall});
  }
  return parts;
}

using Numbers = actions::numbers::contact<double>;

// Returns contact's numbers with those of one wall.
Numbers numbers_for(const Numbers& contact, const actions::WallNumbers& wall) {
  Numbers numbers = contact;
  numbers.stiffness = wall.stiffness;
  numbers.restitution = wall.restitution;
  numbers.friction = wall.friction;
  numbers.rolling_friction = wall.rolling_friction;
  return numbers;
}

// A touch in this sub-step, and the index of its particle.
struct Touched {
  std::uint32_t index;
  Touch touch;
};

class Holding {
 public:
  Holding(const Side& side, std::uint32_t now, const PlacedGrains& placed, WallTask task)
      : side_(side), now_(now), placed_(placed), task_(task), law_(side.kept.law | particles::kWall),
        found_(std::make_unique<WallTouches>()) {}

  void hold(std::uint32_t first, std::uint32_t last) {
    task_.last = last;
    while (first < last) {
      task_.first = first;
      found_->count = 0;
      first = kernels().find_walls(task_, *found_);
      for (std::uint32_t n = 0; n < found_->count; ++n) recall(n);
      kernels().push_walls(task_, *found_);
      for (std::uint32_t n = 0; n < found_->count; ++n) apply(n);
      if (found_->count > 0) sum_up(sums_[wall_]);
    }
  }

  void set_wall(const WallPart& part, std::uint32_t number, const Numbers& numbers) {
    task_.wall = part.shape;
    task_.origin = part.origin;
    task_.number = number;
    task_.numbers = reinterpret_cast<const double*>(&numbers);
    wall_ = part.wall;
  }
  WallSums sums() { return std::move(sums_); }

  // Returns the touches sorted by particle, then in the order of the walls.
  std::vector<Touched> touched() {
    std::stable_sort(all_.begin(), all_.end(), [](const Touched& a, const Touched& b) { return a.index < b.index; });
    return std::move(all_);
  }

 private:
  std::uint32_t index_of(std::uint32_t n) const { return placed_.cells->order()[found_->place[n]]; }

  void recall(std::uint32_t n) {
    const std::span<const Touch> known = side_.store->touches(index_of(n));
    const auto touch = std::find_if(known.begin(), known.end(), [&](const Touch& one) {
      return one.law == law_ && one.id == found_->number[n] && one.step + 1 == now_;
    });
    for (std::size_t c = 0; c < 3; ++c) {
      found_->slid[c][n] = touch == known.end() ? 0 : touch->slid[c];
      found_->rolled[c][n] = touch == known.end() ? 0 : touch->rolled[c];
    }
  }

  void sum_up(WallSum& sum) const {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::uint32_t n = 0; n < found_->count; ++n) {
        sum.force[c].add(found_->force[c][n]);
        sum.torque[c].add(found_->torque[c][n]);
      }
    }
  }

  void apply(std::uint32_t n) {
    GrainPush& push = placed_.out[found_->place[n]];
    for (std::size_t c = 0; c < 3; ++c) {
      push.velocity[c] += found_->change[c][n];
      push.spin[c] += found_->change[3 + c][n];
    }
    Touch touch{found_->number[n], law_, now_, {}, {}};
    for (std::size_t c = 0; c < 3; ++c) {
      touch.slid[c] = found_->slid[c][n];
      touch.rolled[c] = found_->rolled[c][n];
    }
    all_.push_back({index_of(n), touch});
  }

  const Side& side_;
  const std::uint32_t now_;  // sub-step
  const PlacedGrains& placed_;
  WallTask task_;
  std::uint32_t law_;
  std::unique_ptr<WallTouches> found_;
  std::vector<Touched> all_;
  std::uint32_t wall_ = 0;
  WallSums sums_;
};

// Writes touches with walls to the store. A particle that touches no wall any more keeps its old touches until the
// frame's last sub-step; their outdated step number makes them void.
void write_down(const std::vector<Touched>& touched, particles::Store& store) {
  std::vector<Touch> touches;
  for (std::size_t k = 0; k < touched.size();) {
    const std::uint32_t index = touched[k].index, law = touched[k].touch.law;
    touches.clear();
    for (const Touch& touch : store.touches(index)) {
      if (touch.law != law) touches.push_back(touch);
    }
    for (; k < touched.size() && touched[k].index == index; ++k) touches.push_back(touched[k].touch);
    store.set_touches(index, touches);
  }
}

}  // namespace

WallSums touch_walls(const Side& side, const SubStep& step, const PlacedGrains& placed, threads::Pool& pool) {
  const actions::Action& action = *side.action;
  const std::vector<WallPart> parts = parts_of(action);
  if (parts.empty()) return {};
  std::vector<Numbers> numbers;
  for (const actions::WallNumbers& wall : actions::grains_of(action)->walls)
    numbers.push_back(numbers_for(actions::numbers_of<actions::numbers::contact>(action), wall));
  const std::vector<std::uint32_t>& order = placed.cells->order();
  WallTask task;
  task.start = step.start;
  task.end = step.end;
  task.grains = placed.grains;
  task.order = order.data();
  task.own = static_cast<std::uint32_t>(side.store->size());
  task.chosen = side.chosen != nullptr ? side.chosen->data() : nullptr;
  task.dt = step.dt;
  std::vector<std::vector<Touched>> touched(order.size() / pool.items(kRange) + 1);
  std::vector<WallSums> sums(touched.size());
  threads::over_ranges(pool, order.size(), kRange, [&](std::size_t first, std::size_t last) {
    const simd::FloatMode mode;
    Holding range(side, step.number, placed, task);
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
      range.set_wall(parts[p], p, numbers[parts[p].wall]);
      range.hold(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last));
    }
    touched[first / pool.items(kRange)] = range.touched();
    sums[first / pool.items(kRange)] = range.sums();
  });
  for (const std::vector<Touched>& range : touched) write_down(range, *side.store);
  WallSums all;
  for (const WallSums& range : sums) {
    for (const auto& [wall, sum] : range) all[wall] += sum;
  }
  return all;
}

}  // namespace motes::interactions
