// One calculator's part of a snapshot: the particles of all systems as in memory, plane by plane. On disk, a part is a
// file in the safetensors format, which a library or a few lines of NumPy can read. In another rank's memory, it is the
// same description and planes without the file's head.
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

/// The kind of values in a plane.
enum class Plane : std::uint8_t { ids, component, uniform, touch_counts, touches };

/// One plane of a part: one value per particle or, if all share it, the value of an attribute; of touches, as many as
/// their counts tell.
struct SavedPlane {
  std::int32_t system = 0;
  Plane kind = Plane::ids;
  std::string attribute;  // for components and uniform values
  std::int32_t component = 0;
  std::int32_t width = 1;  // width of the attribute
  std::uint64_t offset = 0;  // bytes from the start of the first plane
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;  // only on disk
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
  std::uint64_t frame = 0;  // the next frame to run
  std::int32_t part = 0;  // number of the calculator
  std::vector<SavedSystem> systems;
  std::vector<SavedPlane> planes;
  base::Bytes more;  // other data of this calculator
};

template <class Visitor>
constexpr void fields(Visitor& visit, Description& description) {
  visit(description.frame, description.part, description.systems, description.planes, description.more);
}

/// Describes the particles of all systems and appends their planes to `out`. The description must already have the
/// systems' names.
void copy(const std::vector<const particles::Store*>& stores, Description& description, base::Bytes& out,
          threads::Pool& pool);

/// Appends particles first .. last - 1 of a system to a store. Throws std::runtime_error if the planes do not match the
/// store's schema.
void append(const Description& description, std::span<const std::byte> planes, std::size_t system, std::uint64_t first,
            std::uint64_t last, particles::Store& store, threads::Pool& pool);

/// Returns the beginning of a file, which the planes follow. Sets their checksums in the description.
base::Bytes head(Description& description, std::span<const std::byte> planes);

/// A part's file in memory.
struct Opened {
  Description description;
  std::span<const std::byte> planes;
};

/// Reads a part's file in memory. Throws std::runtime_error, saying what is wrong, if the bytes are not a part or not
/// whole. `sums`: also compares the planes with their checksums.
Opened open(std::span<const std::byte> file, bool sums);

}  // namespace motes::snapshots
