// What calculators send to the image generator: the visible particles of one system as screen-space records.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "image/buffer.h"
#include "image/grid.h"
#include "image/project_lanes.h"
#include "image/scene.h"
#include "particles/bytes.h"

namespace motes::image {

/// A message. Little-endian, without pointers: it can be sent, kept or written to a file as it is.
///   header  magic u32, sprite kind u8, sprite pixels u8, with_depth u8, zero u8, width u16, height u16,
///           first u32, tiles u32, batches u32, records u64: it holds tiles first .. first + tiles - 1
///   batch   offsets u32[tiles + 1], then offsets[tiles] records: those of tile first + t are offsets[t] ..
///           offsets[t+1]-1
///   record  x i16, y i16 (see Grid::sub_bits), r g b alpha u8; with_depth: bits of the positive float view depth u32
/// A record appears in every tile that its footprint touches. Batches keep the sorting inside the second-level cache;
/// their order, and the order of records within a tile, has no meaning.
class Records {
 public:
  std::span<const std::byte> bytes() const { return {buffer_.data(), buffer_.size()}; }
  bool empty() const { return buffer_.size() == 0; }

 private:
  friend class Projector;
  Buffer buffer_;
};

/// Projects and culls particles. Keeps its working memory from frame to frame.
class Projector {
 public:
  explicit Projector(const ProjectLanes& lanes = project_lanes()) : lanes_(&lanes) {}

  /// Replaces the content of `records` by the records of `particles`, reusing its memory. Records have a depth where
  /// the view has objects. Particles that are not finite, nearer than the camera's `near`, outside the image or without
  /// light are left out. Throws std::invalid_argument where view or sprite is not valid, or a position plane is
  /// missing.
  void project(const Drawn& particles, const Sprite& sprite, const View& view, Records& records);

 private:
  void append_batch(const ProjectTask& task, std::size_t first, std::size_t last, bool with_depth, int tiles,
                    Records& records);

  const ProjectLanes* lanes_;
  BufferOf<std::uint32_t> projected_;
  std::vector<std::uint32_t> cursor_;
};

/// Records in memory owned by someone else, with any alignment.
class RecordsView {
 public:
  struct Batch {
    const std::byte* offsets;
    const std::byte* records;
  };
  struct Piece {
    const std::byte* records;
    std::size_t count;
  };

  /// Throws std::runtime_error where the bytes are not a whole, consistent message.
  explicit RecordsView(std::span<const std::byte> bytes);

  const Sprite& sprite() const { return sprite_; }
  const Grid& grid() const { return grid_; }
  bool with_depth() const { return with_depth_; }
  std::size_t record_bytes() const { return with_depth_ ? 12 : 8; }

  /// Records in all batches; a particle on a tile's edge counts once per tile.
  std::size_t count() const { return count_; }
  /// The same in tiles first .. end - 1, which must be in the message.
  std::size_t count(int first, int end) const;

  /// Appends a message of tiles first .. end - 1 alone. Throws std::invalid_argument where they are not in this one.
  void append_part(int first, int end, particles::Bytes& out) const;

  const std::vector<Batch>& batches() const { return batches_; }
  /// Empty where the tile is not in the message.
  Piece piece(const Batch& batch, int tile) const;

 private:
  Batch take_batch(std::span<const std::byte>& rest);

  Sprite sprite_;
  Grid grid_;
  const std::byte* header_ = nullptr;
  int first_ = 0, tiles_ = 0;
  bool with_depth_ = false;
  std::size_t count_ = 0;
  std::vector<Batch> batches_;
};

}  // namespace motes::image
