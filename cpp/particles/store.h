// The particles of one system on one rank.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "particles/blocks.h"
#include "particles/ids.h"
#include "particles/plane_memory.h"
#include "particles/schema.h"
#include "particles/touches.h"
#include "threads/pool.h"

namespace motes::particles {

/// Structure of arrays: one plane of floats per component of each attribute, and one plane of each half of the ids. An
/// attribute with the same value for all particles has no planes until something writes to it, and upper halves of ids
/// have none until one is not 0. The order of particles has no meaning. Touches, if there are any, move with their
/// particles.
class Store {
 public:
  explicit Store(const Schema& schema);  // must outlive the store
  explicit Store(const Schema&& schema) = delete;

  const Schema& schema() const { return *schema_; }
  std::size_t size() const { return size_; }

  /// Returns whether all particles share one value of the attribute, without a plane for it.
  bool uniform(int attribute) const { return columns_[index(attribute)].planes == nullptr; }
  Value uniform_value(int attribute) const { return columns_[index(attribute)].value; }

  /// Returns the plane of a component (0..3) for reading; null if the attribute is uniform.
  const float* plane(int attribute, int component) const;

  /// Returns the value of one particle. Loops over many should use the plane.
  float value(int attribute, int component, std::size_t i) const {
    const Column& column = columns_[index(attribute)];
    return column.planes ? column.planes.get()[index(component) * capacity_ + i] : column.value[index(component)];
  }

  /// Returns the plane for writing; allocates the planes of a uniform attribute first.
  float* writable_plane(int attribute, int component);

  /// Returns the distance in floats between the planes of an attribute.
  std::size_t plane_stride() const { return capacity_; }

  Ids ids() const { return {lower_ids_.get(), upper_ids_.get()}; }
  void set_id(std::size_t i, std::uint64_t id) { set_ids(i, {&id, 1}); }
  /// Sets the ids of the particles from `first` on.
  void set_ids(std::size_t first, std::span<const std::uint64_t> ids);

  /// Returns whether any particle has ever had a touch.
  bool remembers() const { return touches_ != nullptr; }
  /// Returns a particle's touches, valid until the next call of set_touches().
  std::span<const Touch> touches(std::size_t i) const {
    return touches_ ? memory_of_touches_.of(touches_.get()[i]) : std::span<const Touch>{};
  }
  void set_touches(std::size_t i, std::span<const Touch> touches);

  /// Returns an attribute's planes. They stay alive as long as the result, whatever happens to the store.
  std::shared_ptr<float[]> planes(int attribute) const { return columns_[index(attribute)].planes; }

  /// Moves planes that others still hold (planes()) to fresh memory: the others then hold a copy, and writing to it
  /// changes no particle. Other planes stay where they are.
  void part_from_holders();

  /// Reserves room for this many particles. Existing ones are kept; views of planes become invalid.
  void reserve(std::size_t capacity);

  /// Reserves room for `count` more particles. If that needs more capacity, it grows by half at least. Throws
  /// std::length_error if the store would hold more than 2^32 - 1 particles: indices are 32-bit.
  void make_room(std::size_t count);

  /// Adds `count` particles with undefined ids; their values are the uniform ones or undefined. Returns the first
  /// index.
  std::size_t grow(std::size_t count);

  /// Sets a uniform attribute's value. Only for empty stores: throws std::logic_error otherwise.
  void set_uniform(int attribute, Value value);

  /// Gives all particles the attribute's initial value, without a plane for it.
  void forget(int attribute) { columns_[index(attribute)] = {nullptr, (*schema_)[attribute].initial}; }

  /// Copies one attribute of every particle to another attribute of the same width.
  void copy_attribute(int from, int to);

  /// Removes the particles at these indices (ascending, no duplicates): the last particles move into the holes.
  void remove(std::span<const std::uint32_t> indices, threads::Pool& pool = threads::alone());
  void clear() { size_ = 0; }

  /// Swaps pairs of particles. Valid until the store moves or gets other planes.
  class Swapper;

  /// Moves the particle at from[i] to index i, for every i: `from` holds each index once. Planes stay where they are.
  void permute(std::span<const std::uint32_t> from, threads::Pool& pool = threads::alone());

  /// Appends the particles at `indices` of this store to a message, in that order.
  void pack(std::span<const std::uint32_t> indices, base::Bytes& out, threads::Pool& pool = threads::alone()) const;

  /// Returns the most bytes that pack() appends for this many particles, without their touches.
  std::size_t packed_bytes(std::size_t count) const;

  /// Appends the particles that pack() wrote. Throws std::runtime_error if the bytes do not fit the schema.
  void unpack(base::Reader& in, threads::Pool& pool = threads::alone());

  /// Appends all particles of another store of the same schema.
  void append(const Store& from);

  /// Appends the particles at `indices` of another store of the same schema.
  void append(const Store& from, const std::vector<std::uint32_t>& indices, threads::Pool& pool = threads::alone());

  /// Returns the bytes of memory that planes, ids and touches take.
  std::size_t memory_bytes() const;

 private:
  struct Column {
    std::shared_ptr<float[]> planes;  // null: uniform
    Value value{};
  };

  using TouchRow = TouchMemory::Row;

  // A plane of floats, of halves of ids, or of rows of touches.
  struct Plane {
    float* values;
    std::uint32_t* ids = nullptr;
    TouchRow* touches = nullptr;

    template <class Visitor>
    void visit(const Visitor& visitor) const {
      ids != nullptr ? visitor(ids) : touches != nullptr ? visitor(touches) : visitor(values);
    }
  };

  static std::size_t index(int number) { return static_cast<std::size_t>(number); }
  int width(int attribute) const { return (*schema_)[attribute].width; }
  void materialize(int attribute);
  std::size_t bytes_of_planes(std::size_t capacity) const;
  std::vector<Plane> planes_and_rows() const;
  std::uint32_t* writable_upper_ids();
  void pack_touches(std::span<const std::uint32_t> indices, base::Bytes& out) const;
  void unpack_touches(base::Reader& in, std::size_t first);
  /// For particles from `first` on, which have just been added: set one value for all, or make planes to write to.
  void set_added(int attribute, Value value, std::size_t first);
  void open_added(int attribute, std::size_t first);

  const Schema* schema_;
  std::vector<Column> columns_;
  std::shared_ptr<std::uint32_t[]> lower_ids_;
  std::shared_ptr<std::uint32_t[]> upper_ids_;  // null: all are 0
  std::shared_ptr<TouchRow[]> touches_;  // null: no particle has had a touch
  TouchMemory memory_of_touches_;
  PlaneMemory memory_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

class Store::Swapper {
 public:
  explicit Swapper(const Store& store) : planes_(store.planes_and_rows()) {}
  void swap(std::size_t one, std::size_t other) const {
    for (const Plane& plane : planes_) {
      plane.visit([&](auto* values) { std::swap(values[one], values[other]); });
    }
  }

 private:
  std::vector<Plane> planes_;
};

}  // namespace motes::particles
