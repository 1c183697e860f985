// One calculator's share of a snapshot: the particles of all systems as they lie in memory, plane by plane. On disk a
// part is a file in the safetensors format, which others read with a library or a few lines of NumPy; in the memory of
// another rank the same planes stand behind the same description, without that file's head.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "particles/store.h"
#include "threads/pool.h"

namespace motes::snapshots {

/// What the values of a plane are.
enum class Plane : std::uint8_t { ids, component, uniform, touch_counts, touches };

/// A stretch of a part's planes: one value per particle or, where all share it, the value of an attribute; of touches,
/// as many as their counts say.
struct SavedPlane {
  std::int32_t system = 0;
  Plane kind = Plane::ids;
  std::string attribute;  // of components and uniform values
  std::int32_t component = 0;
  std::int32_t width = 1;    // of the attribute
  std::uint64_t offset = 0;  // bytes from the first plane on
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;     // on disk
};

template <class Visitor>
constexpr void fields(Visitor& visit, SavedPlane& plane) {
  visit(plane.system, plane.kind, plane.attribute, plane.component, plane.width, plane.offset, plane.bytes, plane.crc);
}

struct SavedSystem {
  std::string name;
  std::uint64_t rows = 0;  // particles
};

template <class Visitor>
constexpr void fields(Visitor& visit, SavedSystem& system) {
  visit(system.name, system.rows);
}

struct Description {
  std::uint64_t frame = 0;  // the next one to run
  std::int32_t part = 0;    // the calculator
  std::vector<SavedSystem> systems;
  std::vector<SavedPlane> planes;
  base::Bytes more;    // what else belongs to this calculator
};

template <class Visitor>
constexpr void fields(Visitor& visit, Description& description) {
  visit(description.frame, description.part, description.systems, description.planes, description.more);
}

/// Describes the particles of all systems, whose names the description has already, and appends their planes to `out`.
void copy(const std::vector<const particles::Store*>& stores, Description& description, base::Bytes& out,
          threads::Pool& pool);

/// Appends particles first .. last - 1 of a system to a store. Throws std::runtime_error where the planes are not those
/// of the store's schema.
void append(const Description& description, std::span<const std::byte> planes, std::size_t system, std::uint64_t first,
            std::uint64_t last, particles::Store& store, threads::Pool& pool);

/// What a file begins with; the planes follow it. Sets their checksums.
base::Bytes head(Description& description, std::span<const std::byte> planes);

/// A file as it lies in memory.
struct Opened {
  Description description;
  std::span<const std::byte> planes;
};

/// Throws std::runtime_error, saying what is wrong, where the bytes are no part or not whole. `sums`: planes are
/// compared with their checksums, too.
Opened open(std::span<const std::byte> file, bool sums);

}  // namespace motes::snapshots
