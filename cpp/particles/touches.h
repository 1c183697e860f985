// What particles remember of those that they touch: how far the surfaces at each touch have slid and rolled, which is
// what holds grains by friction (interactions/contact.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motes::particles {

/// Marks the law of a touch with a wall, so that a wall's number is no particle's id.
inline constexpr std::uint32_t kWall = 1u << 31;

/// One touch, as one of the two sees it.
struct Touch {
  std::uint64_t id;    // of the other, or the number of a wall's face
  std::uint32_t law;   // which law of the list it is of, from 0 on, and which part of its state; or kWall: law_part
  std::uint32_t step;  // the sub-step in which it was last felt, from 1 on
  float slid[3];       // contact: metres: how far the other's surface has slid along this one's
  float rolled[3];     // contact: metres: how far this one has rolled on the other; both see the same

  bool operator==(const Touch&) const = default;
};

/// Laws that remember more than six numbers of a pair have several touches of it, one for each six.
constexpr std::uint32_t law_part(std::uint32_t law, std::uint32_t part) { return part << 24 | law; }
constexpr std::uint32_t law_of(const Touch& touch) { return touch.law & 0xffffffu; }
constexpr std::uint32_t part_of(const Touch& touch) { return touch.law >> 24 & 0x7f; }
/// Tells whether a law has left it of a pair of particles.
constexpr bool is_of_pair(const Touch& touch, std::uint32_t law) {
  return law_of(touch) == law && (touch.law & kWall) == 0;
}

/// The touches of many particles, one after another in memory. Rows say where they are: they can be moved and copied
/// within a store as numbers can.
class TouchMemory {
 public:
  struct Row {
    std::uint32_t first = 0, count = 0, room = 0;
  };

  std::span<const Touch> of(const Row& row) const { return {all_.data() + row.first, row.count}; }

  /// Writes down a row's touches. Where it has no room for them, it gets some at the end.
  void set(Row& row, std::span<const Touch> touches);

  /// Frees what no row uses any more, once that is more than half.
  void tidy(std::span<Row> rows);

  std::size_t bytes() const { return all_.capacity() * sizeof(Touch); }

 private:
  std::vector<Touch> all_;
};

}  // namespace motes::particles
