// Ties between particles: who is tied to whom, by ids, and how long each tie is at rest. Known to all ranks.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "base/bytes.h"

namespace motes::interactions {

/// What a tie resists: being longer or shorter (stretch), being askew (shear), being bent. Each has its compliance.
enum class TieKind : std::uint8_t { stretch, shear, bend };

struct Ties {
  std::vector<std::uint64_t> ends;       // ids: two for each tie
  std::vector<float> lengths;            // m
  std::vector<std::uint8_t> kinds;       // TieKind
  std::vector<std::uint64_t> pinned;     // ids of those that ties do not move
  std::vector<std::uint64_t> tethered;   // ids: of each tether
  std::vector<std::uint32_t> pins;       // of each tether: who holds it, an index of `pinned`
  std::vector<float> tethers;            // m: the length of each

  bool operator==(const Ties&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Ties& ties) {
  visit(ties.ends, ties.lengths, ties.kinds, ties.pinned, ties.tethered, ties.pins, ties.tethers);
}

/// The name of ties: equal content has an equal key. 0 names none.
using TiesKey = std::uint64_t;

/// Throws std::invalid_argument, naming the argument, its value and what is allowed.
void check(const Ties& ties);

/// One end of a tie, seen from the other.
struct Bond {
  std::uint32_t partner = 0;  // a row
  float length = 0;           // m
  TieKind kind = TieKind::stretch;
};

struct Tether {
  std::uint32_t pin = 0;  // index of Ties::pinned
  float length = 0;       // m
};

/// Ties by particle: rows in the order of ids, and the bonds of each in the order of their partners.
class Bonds {
 public:
  explicit Bonds(const Ties& ties);

  static constexpr std::uint32_t kNone = UINT32_MAX;

  std::size_t rows() const { return ids_.size(); }
  std::uint64_t id(std::size_t row) const { return ids_[row]; }
  /// The row of a particle, or kNone.
  std::uint32_t row_of(std::uint64_t id) const;

  std::size_t first(std::size_t row) const { return first_[row]; }  // the next row's first ends it
  const Bond& bond(std::size_t i) const { return bonds_[i]; }
  std::size_t first_tether(std::size_t row) const { return first_tether_[row]; }
  const Tether& tether(std::size_t i) const { return tethers_[i]; }

  /// The pin that a row is, or kNone.
  std::uint32_t pin(std::size_t row) const { return pin_[row]; }
  std::size_t pins() const { return pins_; }

  /// The most bonds of one particle.
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

/// Checks the ties and keeps them until the process ends. Thread-safe, as are the following.
TiesKey keep(Ties ties);

/// Throw std::invalid_argument where this process keeps no such ties.
std::shared_ptr<const Ties> ties(TiesKey key);
std::shared_ptr<const Bonds> bonds(TiesKey key);

/// The lowest id of a particle that has bonds of both, if there is one. Found once for each two; throws as the above.
std::optional<std::uint64_t> shared_particle(TiesKey one, TiesKey other);

/// For files, as meshes/assets.h.
void write_ties(const std::set<TiesKey>& keys, base::Bytes& out);
void read_ties(base::Reader& in);

}  // namespace motes::interactions
