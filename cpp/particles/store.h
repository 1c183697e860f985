// The particles of one system on one rank.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "particles/blocks.h"
#include "particles/bytes.h"
#include "particles/schema.h"

namespace motes::particles {

/// Structure of arrays: one plane of floats for each component of each attribute, one of 64-bit ids. An attribute
/// whose particles all have one value has no planes until something writes it. The order of particles means nothing.
class Store {
 public:
  explicit Store(const Schema& schema);

  const Schema& schema() const { return *schema_; }
  std::size_t size() const { return size_; }

  /// True where all particles share the attribute's value and no memory holds it.
  bool uniform(int attribute) const { return columns_[index(attribute)].planes == nullptr; }
  std::array<float, 3> uniform_value(int attribute) const { return columns_[index(attribute)].value; }

  /// The plane of a component (0..2) for reading, or null where the attribute is uniform.
  const float* plane(int attribute, int component) const;

  /// The same for writing: gives a uniform attribute its memory first.
  float* writable_plane(int attribute, int component);

  /// Distance in floats between the planes of an attribute.
  std::size_t plane_stride() const { return capacity_; }

  const std::uint64_t* ids() const { return ids_.get(); }
  std::uint64_t* ids() { return ids_.get(); }

  /// Keeps a plane's memory alive for as long as the result lives, whatever becomes of the store.
  std::shared_ptr<float[]> planes(int attribute) const { return columns_[index(attribute)].planes; }
  std::shared_ptr<std::uint64_t[]> shared_ids() const { return ids_; }

  /// Moves planes and ids that others still hold (planes(), shared_ids()) to fresh memory: what they hold is a copy
  /// then, and writing to it changes no particle. Planes that nobody else holds stay where they are.
  void part_from_holders();

  /// Room for this many particles. Existing ones stay; views of planes are void.
  void reserve(std::size_t capacity);

  /// Room for so many more, with some to spare where they are few. Throws std::length_error where the store would have
  /// more than 2^32 - 1: indices of particles are 32-bit numbers.
  void make_room(std::size_t count);

  /// Adds `count` particles with undefined ids and with the last uniform or undefined values; returns the first index.
  std::size_t grow(std::size_t count);

  /// Sets a uniform attribute's value. Only for stores that are being filled: throws std::logic_error otherwise.
  void set_uniform(int attribute, std::array<float, 3> value);

  /// Gives every particle the value of one attribute in another of the same width.
  void copy_attribute(int from, int to);

  /// Removes the particles at these indices (ascending, no duplicate): the last ones move into the holes.
  void remove(std::span<const std::uint32_t> indices);
  void clear() { size_ = 0; }

  /// Puts the particle at from[i] to place i, for all: `from` names each index once. Planes stay where they are.
  void permute(std::span<const std::uint32_t> from);

  /// Appends the particles at `indices` of this store to a message, in that order.
  void pack(std::span<const std::uint32_t> indices, Bytes& out) const;

  /// The most bytes that pack() appends for so many.
  std::size_t packed_bytes(std::size_t count) const;

  /// Appends what pack() wrote. Throws std::runtime_error where the bytes do not fit the schema.
  void unpack(Reader& in);

  /// Bytes of memory that the planes and ids take.
  std::size_t memory_bytes() const;

 private:
  struct Column {
    std::shared_ptr<float[]> planes;  // null: uniform
    std::array<float, 3> value{};
  };

  static std::size_t index(int attribute) { return static_cast<std::size_t>(attribute); }
  int width(int attribute) const { return (*schema_)[attribute].width; }
  void materialize(int attribute);
  /// Takes over a uniform value that newcomers bring: true where it is (or becomes) the value of all.
  bool adopt_uniform(int attribute, std::array<float, 3> value, std::size_t before);

  const Schema* schema_;
  std::vector<Column> columns_;
  std::shared_ptr<std::uint64_t[]> ids_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

/// Memory for `count` values, aligned to a cache line; large ones ask for huge pages.
template <class T>
std::shared_ptr<T[]> allocate_plane(std::size_t count);

}  // namespace motes::particles
