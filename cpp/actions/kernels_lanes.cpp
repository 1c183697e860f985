// Compiled once for each instruction set: the table of kernels. A new action adds one line.
#include "actions/avoid.h"
#include "actions/births.h"
#include "actions/bounce.h"
#include "actions/damping.h"
#include "actions/evaluate.h"
#include "actions/explosion.h"
#include "actions/gravity.h"
#include "actions/jet.h"
#include "actions/kernels.h"
#include "actions/kill.h"
#include "actions/move.h"
#include "actions/orbit.h"
#include "actions/over_life.h"
#include "actions/random_velocity.h"
#include "actions/restore.h"
#include "actions/speed_clamp.h"
#include "actions/target.h"
#include "actions/vortex.h"
#include "actions/wind.h"

namespace motes::MOTES_ISA {
namespace {

void contains(const shapes::Shape& shape, const float* const* position, std::size_t count, std::uint8_t* inside) {
  visit(shape, [&](const auto& lanes) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < count; i += kLanes) {
      const Mask mask = lanes.contains({load(position[0] + i), load(position[1] + i), load(position[2] + i)});
      for (std::size_t k = 0; k < kLanes && i + k < count; ++k) inside[i + k] = mask[k] != 0;
    }
  });
}

void collect(const actions::Block& b, const float* axis, float low, float high, std::uint32_t base, std::uint32_t* dead,
             std::size_t& dead_count, std::uint32_t* left, std::size_t& left_count) {
  for (std::size_t i = 0; i < b.count; i += kLanes) {
    const Mask killed = load_mask(b.dead + i);
    Mask away = Mask{};
    if (axis != nullptr) {
      const Floats x = load(axis + i);
      away = ~((x >= low) & (x < high));
    }
    if (!any(killed | away)) continue;
    for (std::size_t k = 0; k < kLanes && i + k < b.count; ++k) {
      const auto index = static_cast<std::uint32_t>(base + i + k);
      if (killed[k] != 0) {
        dead[dead_count++] = index;
      } else if (away[k] != 0) {
        left[left_count++] = index;
      }
    }
  }
}

}  // namespace

extern const actions::Kernels action_kernels;
const actions::Kernels action_kernels = {
    {
        gravity,
        damping,
        random_acceleration,
        random_velocity,
        bounce,
        sink,
        kill_old,
        kill_expired,
        move,
        set,
        avoid,
        explosion,
        jet,
        orbit_point,
        orbit_line,
        vortex,
        random_displacement,
        random_rotational_velocity,
        rotational_damping,
        sink_velocity,
        speed_clamp,
        target_color,
        target_size,
        target_velocity,
        target_rotational_velocity,
        restore,
        copy_vertex_b,
        wind,
        color_over_life,
        alpha_over_life,
        size_over_life,
    },
    evaluate,
    draw,
    jitter,
    contains,
    collect,
};

}  // namespace motes::MOTES_ISA
