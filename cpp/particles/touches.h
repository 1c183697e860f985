// What particles remember of those that they touch: how far the surfaces at each touch have slid and rolled, which is
// what holds grains by friction (interactions/contact.h).
#pragma once

#include <cstdint>

namespace motes::particles {

/// One touch, as one of the two sees it.
struct Touch {
  std::uint64_t id;  // of the other
  float slid[3];     // metres: how far the other's surface has slid along this one's
  float rolled[3];   // metres: how far this one has rolled on the other; both see the same

  bool operator==(const Touch&) const = default;
};

/// The touches of a particle. Spheres of one size have at most twelve.
struct Touches {
  static constexpr std::uint32_t kMost = 12;

  std::uint32_t count = 0;
  std::uint32_t step = 0;  // the sub-step in which they were written down, from 1 on; 0: never
  Touch touch[kMost];

  bool operator==(const Touches& other) const {
    bool same = count == other.count && step == other.step;
    for (std::uint32_t k = 0; same && k < count; ++k) same = touch[k] == other.touch[k];
    return same;
  }
};

}  // namespace motes::particles
