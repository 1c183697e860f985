// What calculators send to the ranks that draw: the visible particles of one system as screen-space records.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "image/buffer.h"
#include "image/grid.h"
#include "image/layout.h"
#include "image/scene.h"

namespace motes::image {

/// The head of a message of records. Little-endian, without pointers: a message can be sent, kept or written to a file
/// as it is. After the head:
///   sprite  the fields of painted(), and zeros: `sprite_bytes` in all
///   batch   offsets u32[slots + 1], then offsets[slots] records: those of slot first_slot + s are offsets[s] ..
///           offsets[s + 1] - 1
///   record  see Layout; followed by three floats if with_velocity
/// A record appears in every tile that its footprint touches. Batches keep the sorting inside the second-level cache.
/// The order of batches, and of records within a slot, does not matter.
struct RecordsHead {
  static constexpr std::size_t kAligned = 8;           // sprite_bytes are a multiple of this
  static constexpr std::uint32_t kMagic = 0x3653544d;  // "MTS6"

  std::uint32_t magic = kMagic;
  std::uint32_t system = 0;
  std::uint32_t sprite_bytes = 0;
  std::uint8_t layout = 0;
  std::uint8_t with_velocity = 0;
  std::uint8_t colored = 1;       // 0: records carry no colour; all have `color`
  std::uint8_t most_alpha = 255;  // upper bound on the alpha of records
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::uint32_t first_slot = 0;
  std::uint32_t slots = 0;
  std::uint32_t batches = 0;
  std::uint32_t color = 0;  // r | g << 8 | b << 16 | alpha << 24
  std::uint64_t records = 0;
};
static_assert(sizeof(RecordsHead) == 48);

/// A message that a Projector fills. Slots are tiles in the order given to the projector.
class Records {
 public:
  std::span<const std::byte> bytes() const { return {buffer_.data(), buffer_.size()}; }
  bool empty() const { return buffer_.size() == 0; }

 private:
  friend class Projector;

  RecordsHead head_;
  Buffer buffer_;
};

/// A view of a message of records, with any alignment.
class RecordsView {
 public:
  struct Batch {
    const std::byte* offsets;
    const std::byte* records;
  };
  struct RecordRun {
    const std::byte* records;
    std::size_t count;
  };

  /// Throws std::runtime_error if the bytes are not a whole, consistent message.
  explicit RecordsView(std::span<const std::byte> bytes);

  const Sprite& sprite() const { return sprite_; }
  int system() const { return static_cast<int>(head_.system); }
  const Grid& grid() const { return grid_; }
  Layout layout() const { return static_cast<Layout>(head_.layout); }
  bool with_depth() const { return has_depth(layout()); }
  /// Returns whether each record has its own colour; if not, all have color().
  bool colored() const { return head_.colored != 0; }
  std::uint32_t color() const { return head_.color; }
  bool with_velocity() const { return head_.with_velocity != 0; }
  /// Returns an upper bound on the alpha of records, 0..255.
  std::uint8_t most_alpha() const { return head_.most_alpha; }
  /// Returns the bytes from one record to the next.
  std::size_t record_bytes() const {
    return image::record_bytes(layout(), colored()) + (with_velocity() ? kVelocityBytes : 0);
  }

  /// Returns the number of records in all batches; a particle on a tile's edge counts once per tile.
  std::size_t count() const { return count_; }
  /// Returns the number of records in slots first .. end - 1, which must be in the message.
  std::size_t count(int first, int end) const;

  /// Adds the number of records in each slot to `counts`, which has one number per slot of the view.
  void add_counts(std::span<std::uint32_t> counts) const;

  /// Appends a message of only slots first .. end - 1. Throws std::invalid_argument if they are not in this one.
  void append_part(int first, int end, base::Bytes& out) const;

  const std::vector<Batch>& batches() const { return batches_; }

  /// Returns the records in a slot, which is the tile of that number unless the projector was given another order.
  /// Empty if the message is a part without this slot.
  RecordRun piece(const Batch& batch, int slot) const;

 private:
  void check_head() const;
  void take_sprite(std::span<const std::byte>& rest);
  Batch take_batch(std::span<const std::byte>& rest);

  RecordsHead head_;
  std::span<const std::byte> sprite_bytes_;
  Sprite sprite_;
  Grid grid_;
  std::size_t count_ = 0;
  std::vector<Batch> batches_;
};

}  // namespace motes::image
