// Where a particle belongs: the slices of space along one axis, one per calculator, for one system (paper 3.1.4).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace motes::domains {

/// Half the width of the paper's infinite space, in metres.
inline constexpr float kInfinite = 1048576.0f;  // 2^20

/// How a system's space is divided at the start (API: World.space).
struct Space {
  enum class Kind : unsigned char { finite, infinite, fit };
  Kind kind = Kind::infinite;
  double low = 0;   // metres, kind finite
  double high = 0;

  bool operator==(const Space&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Space& space) {
  visit(space.kind, space.low, space.high);
}

/// The n domains of one system: n - 1 ascending cuts. Domain i holds cuts[i-1] <= x < cuts[i]; the first and the last
/// extend to infinity. Particles whose coordinate is NaN belong to the last.
class Domains {
 public:
  /// One domain that holds everything.
  Domains() = default;
  /// Throws std::invalid_argument where the cuts do not ascend or one of them is NaN.
  explicit Domains(std::vector<float> cuts);

  int count() const { return static_cast<int>(cuts_.size()) + 1; }
  const std::vector<float>& cuts() const { return cuts_; }

  /// The single rule of ownership: create, exchange and donate all use it.
  int owner_of(float x) const {
    std::uint32_t owner = 0;
    owners_of({&x, 1}, &owner);
    return static_cast<int>(owner);
  }
  /// The same for many particles.
  void owners_of(std::span<const float> x, std::uint32_t* owners) const;

  float low(int domain) const;   // -infinity for the first
  float high(int domain) const;  // infinity for the last

  bool operator==(const Domains&) const = default;

 private:
  std::vector<float> cuts_;
};

/// n equal slices of [low, high].
Domains equal_slices(double low, double high, int count);

/// The cuts that put equally many of these coordinates (in any order) into each of n domains.
Domains quantiles(std::span<const float> coordinates, int count);

}  // namespace motes::domains
