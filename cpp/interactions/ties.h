// Ties between particles: pairs of ids and rest lengths, known to all ranks.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "base/bytes.h"

namespace motes::interactions {

/// What a tie resists: stretching, shearing or bending. Each kind has its own compliance.
enum class TieKind : std::uint8_t { stretch, shear, bend };

struct Ties {
  std::vector<std::uint64_t> ends;       // two ids per tie
  std::vector<float> lengths;            // m
  std::vector<std::uint8_t> kinds;       // TieKind
  std::vector<std::uint64_t> pinned;     // ids of particles that ties do not move
  std::vector<std::uint64_t> tethered;   // ids, one per tether
  std::vector<std::uint32_t> pins;       // index in `pinned`, one per tether
  std::vector<float> tethers;            // length of each tether, m

  bool operator==(const Ties&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Ties& ties) {
  visit(ties.ends, ties.lengths, ties.kinds, ties.pinned, ties.tethered, ties.pins, ties.tethers);
}

/// A key of ties: a hash of their content, never 0.
using TiesKey = std::uint64_t;

/// Throws std::invalid_argument that names the argument, its value and what is allowed.
void check(const Ties& ties);

/// A tie as one of its ends sees it.
struct Bond {
  std::uint32_t partner = 0;  // a row
  float length = 0;           // m
  TieKind kind = TieKind::stretch;
};

struct Tether {
  std::uint32_t pin = 0;  // index of Ties::pinned
  float length = 0;       // m
};

/// Ties by particle: rows in the order of ids; the bonds of a row in the order of partners.
class Bonds {
 public:
  explicit Bonds(const Ties& ties);

  static constexpr std::uint32_t kNone = UINT32_MAX;

  std::size_t rows() const { return ids_.size(); }
  std::uint64_t id(std::size_t row) const { return ids_[row]; }
  /// Returns the row of a particle, or kNone.
  std::uint32_t row_of(std::uint64_t id) const;

  std::size_t first(std::size_t row) const { return first_[row]; }  // the next row's first() is its end
  const Bond& bond(std::size_t i) const { return bonds_[i]; }
  std::size_t first_tether(std::size_t row) const { return first_tether_[row]; }
  const Tether& tether(std::size_t i) const { return tethers_[i]; }

  /// Returns the index of a row in Ties::pinned, or kNone.
  std::uint32_t pin(std::size_t row) const { return pin_[row]; }
  std::size_t pins() const { return pins_; }

  /// Returns the largest number of bonds of one particle.
  std::size_t most() const { return most_; }

 private:
  std::vector<std::uint64_t> ids_;
  std::vector<std::uint32_t> first_, first_tether_;
  std::vector<Bond> bonds_;
  std::vector<Tether> tethers_;
  std::vector<std::uint32_t> pin_;
  std::size_t pins_ = 0;
  std::size_t most_ = 0;
};

/// Checks the ties and keeps them until the process ends. Thread-safe.
TiesKey keep(Ties ties);

/// Return kept ties; throw std::invalid_argument if there are none with this key. Thread-safe.
std::shared_ptr<const Ties> ties(TiesKey key);
std::shared_ptr<const Bonds> bonds(TiesKey key);

/// Returns the lowest id of a particle that has bonds in both, if any; cached per pair. Throws std::invalid_argument
/// for unknown keys. Thread-safe.
std::optional<std::uint64_t> shared_particle(TiesKey one, TiesKey other);

/// Write ties to a scene file; read ties from one and keep them.
void write_ties(const std::set<TiesKey>& keys, base::Bytes& out);
void read_ties(base::Reader& in);

}  // namespace motes::interactions
