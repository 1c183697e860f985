// What an attribute of newborn particles is drawn from (API: System.configure).
#pragma once

#include <variant>

#include "shapes/shape.h"

namespace motes::actions {

namespace distributions {

/// The same value for all.
struct Value {
  float number[4] = {};

  bool operator==(const Value&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Value& value) {
  visit(value.number);
}

/// Three numbers: a point in a shape.
struct InShape {
  shapes::Shape shape;

  bool operator==(const InShape&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, InShape& in) {
  visit(in.shape);
}

/// Uniform between two ends, for each component.
struct Uniform {
  float low[3] = {}, high[3] = {};
  bool alike = false;  // one draw for all components, if scalars were given for a vector

  bool operator==(const Uniform&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Uniform& uniform) {
  visit(uniform.low, uniform.high, uniform.alike);
}

/// Normal, for each component.
struct Normal {
  float mean[3] = {}, sigma[3] = {};
  bool alike = false;  // as Uniform's

  bool operator==(const Normal&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Normal& normal) {
  visit(normal.mean, normal.sigma, normal.alike);
}

/// Uniformly distributed orientations.
struct AnyRotation {
  bool operator==(const AnyRotation&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, AnyRotation&) {
  visit();
}

/// The normal of the mesh on which the particle is born, at its place.
struct AlongNormal {
  float length = 0;

  bool operator==(const AlongNormal&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, AlongNormal& along) {
  visit(along.length);
}

/// The colour of the mesh on which the particle is born, at its place.
struct SurfaceColor {
  bool operator==(const SurfaceColor&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, SurfaceColor&) {
  visit();
}

}  // namespace distributions

using Distribution =
    std::variant<distributions::Value, distributions::InShape, distributions::Uniform, distributions::Normal,
                 distributions::AnyRotation, distributions::AlongNormal, distributions::SurfaceColor>;

/// Returns whether the draws that placed a particle on a mesh also draw this.
inline bool of_surface(const Distribution& distribution) {
  return std::holds_alternative<distributions::AlongNormal>(distribution) ||
         std::holds_alternative<distributions::SurfaceColor>(distribution);
}

}  // namespace motes::actions
