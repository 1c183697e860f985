// The columns of a system's particles.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "particles/periods.h"

namespace motes::particles {

/// Indices of the built-in attributes in every schema (paper 3.1.2 and API: System.configure).
enum Builtin : int {
#define MOTES_ATTRIBUTE(name, ...) name,
#include "particles/attributes.inc"
  builtin_count
};

inline constexpr float kForever = std::numeric_limits<float>::infinity();

/// The numbers of one attribute of a particle. The first ones count, as many as the attribute's width.
using Value = std::array<float, 4>;

struct BuiltinAttribute {
  const char* name;
  int width;                        // 1, 3 or 4
  Value initial{};
};

inline constexpr std::array<BuiltinAttribute, builtin_count> kBuiltins = {{
#define MOTES_ATTRIBUTE(name, width, ...) {#name, width, {__VA_ARGS__}},
#include "particles/attributes.inc"
}};

/// Returns the position of a built-in attribute's first component among the components of every schema.
consteval int first_component(Builtin attribute) {
  int components = 0;
  for (int before = 0; before < attribute; ++before) components += kBuiltins[static_cast<std::size_t>(before)].width;
  return components;
}

/// The `*_b` attributes are targets that particles can return to. They start as copies of position, velocity and up,
/// and take memory only in systems that use them; in other systems they read as zero.
inline constexpr std::array<std::pair<Builtin, Builtin>, 3> kCopies = {
    {{position_b, position}, {velocity_b, velocity}, {up_b, up}}};

/// A named column of 1, 3 or 4 floats per particle.
struct Attribute {
  std::string name;
  int width = 1;
  Value initial{};                    // value of newborn particles unless the script configures another
  int first_component = 0;            // its position among all components of the schema

  bool operator==(const Attribute&) const = default;
};

/// The attribute that counts, in periodic space, how often a particle has crossed the ends of each axis.
inline constexpr const char* kCrossings = "crossings";

/// The attributes of one system (the built-in ones, then the user's) and the periods of its space.
class Schema {
 public:
  Schema();

  /// Adds a user attribute and returns its index. Throws std::invalid_argument for a name that is taken, empty or not
  /// an identifier, for a width other than 1 or 3, and for more than 64 attributes.
  int add(const std::string& name, int width, Value initial);

  /// Makes space periodic. Throws std::invalid_argument for an empty interval, or without an attribute kCrossings of
  /// three numbers.
  void set_periods(const Periods& periods);
  const Periods& periods() const { return periods_; }
  /// Returns the index of kCrossings; -1 if no axis is periodic.
  int crossings() const { return crossings_; }

  const std::vector<Attribute>& attributes() const { return attributes_; }
  const Attribute& operator[](int index) const { return attributes_[static_cast<std::size_t>(index)]; }
  int size() const { return static_cast<int>(attributes_.size()); }
  int components() const { return components_; }

  /// Returns the attribute's index, or -1.
  int find(std::string_view name) const;

  /// Returns the attribute that a component belongs to.
  int attribute_of(int component) const;

  bool operator==(const Schema&) const = default;

 private:
  std::vector<Attribute> attributes_;
  int components_ = 0;
  Periods periods_;
  int crossings_ = -1;
};

}  // namespace motes::particles
