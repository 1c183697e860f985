#include "interactions/walls.h"

#include <algorithm>
#include <memory>

#include "interactions/extent.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using particles::Touch;

// Adds a wall, or each part of a union as a separate wall.
void add_wall(const shapes::Shape& shape, std::vector<const shapes::Shape*>& walls) {
  if (shape.parts == 0) return walls.push_back(&shape);
  for (int i = 0; i < shape.parts; ++i) walls.push_back(shape.part + i);
}

std::vector<const shapes::Shape*> walls_of(const actions::Action& action) {
  const auto count = static_cast<std::size_t>(actions::numbers_of<actions::numbers::contact>(action).walls);
  std::vector<const shapes::Shape*> walls;
  for (std::size_t i = 0; i < count; ++i) add_wall(action.shapes[i], walls);
  return walls;
}

// A touch in this sub-step, and the index of its particle.
struct Touched {
  std::uint32_t index;
  Touch touch;
};

class Holding {
 public:
  Holding(const Side& side, const PlacedParticles& placed, WallTask task)
      : side_(side), placed_(placed), task_(task), law_(side.law | particles::kWall),
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
    }
  }

  void set_wall(const shapes::Shape& wall, std::uint32_t number) {
    task_.wall = &wall;
    task_.number = number;
  }

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
      return one.law == law_ && one.id == found_->number[n] && one.step + 1 == side_.now;
    });
    for (std::size_t c = 0; c < 3; ++c) {
      found_->slid[c][n] = touch == known.end() ? 0 : touch->slid[c];
      found_->rolled[c][n] = touch == known.end() ? 0 : touch->rolled[c];
    }
  }

  void apply(std::uint32_t n) {
    for (std::size_t c = 0; c < 6; ++c) placed_.out[c][found_->place[n]] += found_->change[c][n];
    Touch touch{found_->number[n], law_, side_.now, {}, {}};
    for (std::size_t c = 0; c < 3; ++c) {
      touch.slid[c] = found_->slid[c][n];
      touch.rolled[c] = found_->rolled[c][n];
    }
    all_.push_back({index_of(n), touch});
  }

  const Side& side_;
  const PlacedParticles& placed_;
  WallTask task_;
  std::uint32_t law_;
  std::unique_ptr<WallTouches> found_;
  std::vector<Touched> all_;
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

void touch_walls(const actions::Action& action, const Side& side, float dt, const PlacedParticles& placed,
                 threads::Pool& pool) {
  const std::vector<const shapes::Shape*> walls = walls_of(action);
  if (walls.empty()) return;
  const std::vector<std::uint32_t>& order = placed.cells->order();
  WallTask task;
  task.start = side.start;
  task.end = side.end;
  task.column = placed.column;
  task.order = order.data();
  task.own = static_cast<std::uint32_t>(side.store->size());
  task.chosen = side.chosen != nullptr ? side.chosen->data() : nullptr;
  task.numbers = action.numbers.data();
  task.dt = dt;
  std::vector<std::vector<Touched>> touched(order.size() / pool.items(kRange) + 1);
  threads::over_ranges(pool, order.size(), kRange, [&](std::size_t first, std::size_t last) {
    const simd::FloatMode mode;
    Holding range(side, placed, task);
    for (std::uint32_t w = 0; w < walls.size(); ++w) {
      range.set_wall(*walls[w], w);
      range.hold(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last));
    }
    touched[first / pool.items(kRange)] = range.touched();
  });
  for (const std::vector<Touched>& range : touched) write_down(range, *side.store);
}

}  // namespace motes::interactions
