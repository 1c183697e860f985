// Contact history: how far the surfaces at each touch have slid and rolled, from which friction is computed
// (interactions/laws/law_contact.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace motes::particles {

/// Marks the law of a touch with a wall, so a wall's number is not taken for a particle's id.
inline constexpr std::uint32_t kWall = 1u << 31;

/// A touch, as one of the two particles remembers it.
struct Touch {
  std::uint64_t id;    // id of the other particle, or number of a wall's face
  std::uint32_t law;   // number of its law, from 0, with a part of its state (law_part) or kWall
  std::uint32_t step;  // sub-step of the last touch, from 1
  // A law that a script defines keeps six numbers of the pair's state in these.
  float slid[3];       // how far the other's surface has slid along this one's, m
  float rolled[3];     // how far this one has rolled on the other, m; the same for both

  bool operator==(const Touch&) const = default;
};

/// Returns a touch's `law` for a part of its state. A law with more than six numbers per pair has several touches per
/// pair, one for every six numbers.
constexpr std::uint32_t law_part(std::uint32_t law, std::uint32_t part) { return part << 24 | law; }
constexpr std::uint32_t law_of(const Touch& touch) { return touch.law & 0xffffffu; }
constexpr std::uint32_t part_of(const Touch& touch) { return touch.law >> 24 & 0x7f; }
/// Returns whether the touch is between two particles, and belongs to this law.
constexpr bool is_of_pair(const Touch& touch, std::uint32_t law) {
  return law_of(touch) == law && (touch.law & kWall) == 0;
}

/// The touches of many particles, one after another in memory. A Row tells where the touches of one particle are; it
/// can be moved and copied within a store like a number.
class TouchMemory {
 public:
  struct Row {
    std::uint32_t first = 0, count = 0, room = 0;
  };

  std::span<const Touch> of(const Row& row) const { return {all_.data() + row.first, row.count}; }

  /// Replaces a row's touches; a row without room for them moves to the end.
  void set(Row& row, std::span<const Touch> touches);

  /// Compacts the memory if rows use less than half of it.
  void tidy(std::span<Row> rows);

  std::size_t bytes() const { return all_.capacity() * sizeof(Touch); }

 private:
  std::vector<Touch> all_;
};

}  // namespace motes::particles
