#include "lab/bench/bench_scene.h"

#include <time.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace motes::bench {

using namespace recording;

using actions::Action;
using actions::make;
namespace numbers = actions::numbers;
using particles::Store;
using shapes::Shape;

double cpu_now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Action> paper_list(const std::string& scene) {
  const Shape gust{shapes::Kind::box, {-2, -1, -2, 2, 1, 2}};
  const Shape ground{shapes::Kind::plane, {0, 0, 0, 0, 1, 0}};
  // random acceleration, collide with an object, eliminate old ones, move; the fountain has gravity too
  std::vector<Action> list = {make(numbers::random_acceleration<>{}, {gust}),
                              make(numbers::bounce<>{.restitution = 0.1, .friction = 0.5, .exact_hit = 1}, {ground}),
                              make(numbers::kill_old<>{.age_limit = 1e6}), make(numbers::move<>{.rotational = 1})};
  if (scene == "fountain") list.insert(list.begin(), make(numbers::gravity<>{.acceleration = {0, -9.81, 0}}));
  if (scene != "snow" && scene != "fountain") {
    throw std::invalid_argument("scene must be snow or fountain, got '" + scene + "'");
  }
  return list;
}

Burst full_air(std::size_t particles) {
  Burst burst;
  burst.count = particles;
  burst.shape = {shapes::Kind::box, {-50, 0, -50, 50, 50, 50}};
  const shapes::Shape velocities{shapes::Kind::box, {-1, -2, -1, 1, -1, 1}};
  burst.state.push_back({particles::velocity, actions::distributions::InShape{velocities}});
  return burst;
}

void touch(Store& store, std::uint64_t reads, std::uint64_t writes) {
  std::vector<const float*> read;
  std::vector<float*> written;
  for (int a = 0; a < store.schema().size(); ++a) {
    for (int c = 0; c < store.schema()[a].width; ++c) {
      if ((writes >> a & 1u) != 0) {
        written.push_back(store.writable_plane(a, c));
      } else if ((reads >> a & 1u) != 0 && !store.uniform(a)) {
        read.push_back(store.plane(a, c));
      }
    }
  }
  const auto n = static_cast<std::ptrdiff_t>(store.size());
  std::uint32_t seen = 0;
  for (std::ptrdiff_t at = 0; at < n; at += 4096) {
    const std::ptrdiff_t end = std::min<std::ptrdiff_t>(at + 4096, n);
    for (float* plane : written) {
      for (std::ptrdiff_t i = at; i < end; ++i) {
        std::uint32_t bits;
        std::memcpy(&bits, plane + i, 4);
        bits ^= 1u;
        std::memcpy(plane + i, &bits, 4);
      }
    }
    for (const float* plane : read) {
      for (std::ptrdiff_t i = at; i < end; ++i) {
        std::uint32_t bits;
        std::memcpy(&bits, plane + i, 4);
        seen |= bits;
      }
    }
  }
  asm volatile("" : : "r"(seen));  // keeps the compiler from removing the loads
}

}  // namespace motes::bench
