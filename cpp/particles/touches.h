// Contact history: how far the surfaces at each touch have slid and rolled, which is what holds grains by friction
// (interactions/laws/law_contact.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motes::particles {

/// Marks the law of a touch with a wall, so that a wall's number is no particle's id.
inline constexpr std::uint32_t kWall = 1u << 31;

/// A touch, as one of the two particles sees it.
struct Touch {
  std::uint64_t id;    // of the other, or the number of a wall's face
  std::uint32_t law;   // the place of its law in the list, from 0 on, and a part of its state (law_part); or kWall
  std::uint32_t step;  // the sub-step in which it was last felt, from 1 on
  float slid[3];       // contact: metres: how far the other's surface has slid along this one's
  float rolled[3];     // contact: metres: how far this one has rolled on the other; both see the same

  bool operator==(const Touch&) const = default;
};

/// A law that remembers more than six numbers per pair keeps several touches of it, one for each six numbers.
constexpr std::uint32_t law_part(std::uint32_t law, std::uint32_t part) { return part << 24 | law; }
constexpr std::uint32_t law_of(const Touch& touch) { return touch.law & 0xffffffu; }
constexpr std::uint32_t part_of(const Touch& touch) { return touch.law >> 24 & 0x7f; }
/// Returns whether the touch is between two particles, and belongs to this law.
constexpr bool is_of_pair(const Touch& touch, std::uint32_t law) {
  return law_of(touch) == law && (touch.law & kWall) == 0;
}

/// The touches of many particles, one after another in memory. A Row says where those of one particle are, and can be
/// moved and copied within a store like a number.
class TouchMemory {
 public:
  struct Row {
    std::uint32_t first = 0, count = 0, room = 0;
  };

  std::span<const Touch> of(const Row& row) const { return {all_.data() + row.first, row.count}; }

  /// Replaces a row's touches; a row without room for them moves to the end.
  void set(Row& row, std::span<const Touch> touches);

  /// Compacts the memory, once rows use less than half of it.
  void tidy(std::span<Row> rows);

  std::size_t bytes() const { return all_.capacity() * sizeof(Touch); }

 private:
  std::vector<Touch> all_;
};

}  // namespace motes::particles
