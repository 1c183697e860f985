// A region of space as a plain value (API: motes.shapes).
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/vectors.h"
#include "meshes/mesh_form.h"

namespace motes::shapes {

enum class Kind : std::uint8_t {
#define MOTES_SHAPE(kind, ...) kind,
#include "shapes/list.inc"
};

inline constexpr int kKinds = 0
#define MOTES_SHAPE(...) +1  // NOLINT(bugprone-macro-parentheses): a summand
#include "shapes/list.inc"
    ;

/// Where a mesh is: its rotation is a unit quaternion w, i, j, k.
struct MeshPlace {
  float position[3], rotation[4];
};

/// One struct per kind of shape, whose fields are its numbers, in metres, in the order of the constructor's arguments:
/// shape.as<numbers::disc>().radius.
namespace numbers {
struct point {
  float position[3];
};
struct line {
  float p0[3], p1[3];
};
struct rectangle {
  float origin[3], u[3], v[3];
};
struct disc {
  float center[3], normal[3], radius, inner_radius;
};
struct plane {
  float point[3], normal[3];
};
struct box {
  float low[3], high[3];
};
struct sphere {
  float center[3], radius, inner_radius;
};
struct triangle {
  float p0[3], p1[3], p2[3];
};
struct cylinder {
  float p0[3], p1[3], radius, inner_radius;
};
struct cone {
  float apex[3], base[3], radius, inner_radius;
};
struct axial {  // a cylinder or a cone, whose apex is the start
  float start[3], end[3], radius, inner_radius;
};
struct blob {
  float center[3], sigma;
};
struct united {};  // its parts: see unite()
struct mesh {
  MeshPlace end, start;  // of the frame
  float solid;  // samples are from the inside
  float resolution;  // cells of its grid along the longest side
};
}  // namespace numbers

template <class Numbers>
inline constexpr int kCountOf =
    static_cast<int>(sizeof(Numbers) / sizeof(float));  // NOLINT(bugprone-sizeof-expression): without numbers 1 / 4, 0

/// The largest count of numbers that a shape has.
inline constexpr int kNumbers = std::max({
#define MOTES_SHAPE(kind, ...) kCountOf<numbers::kind>,
#include "shapes/list.inc"
});

/// A shape: its kind and its numbers.
struct Shape {
  Kind kind = Kind::point;
  float number[kNumbers] = {};

  /// Returns the numbers by name. Always inline, so that a kernel never links a copy that was compiled for another
  /// instruction set.
  template <class Numbers>
  [[gnu::always_inline]] Numbers as() const {
    Numbers numbers;
    __builtin_memcpy(&numbers, number, sizeof numbers);
    return numbers;
  }
  template <class Numbers>
  void set(const Numbers& numbers) {
    __builtin_memcpy(number, &numbers, sizeof numbers);
  }

  // A union's parts, none of them a union, as plain pointers: kernels call nothing from the standard library.
  const Shape* part = nullptr;
  int parts = 0;
  float upto = 1;  // of a part: a number in 0..1 selects the first part whose `upto` is above it
  std::shared_ptr<const std::vector<Shape>> owner = {};

  // Of a mesh: the key of its content, and its form in this process; null if the process keeps no such mesh.
  std::uint64_t mesh = 0;
  const meshes::MeshForm* form = nullptr;
  // Of a mesh: the key of the mesh that it was deformed from, or its own. Of one that deforms during the frame: the key
  // of its content at the frame's start, and the way from there; otherwise 0 and null.
  std::uint64_t origin = 0, before = 0;
  const meshes::Deformation* deformation = nullptr;

  /// Compares kind, numbers, parts and meshes.
  bool operator==(const Shape& other) const;
};

/// Returns whether a mesh has different places at the start and at the end of the frame. Always inline: as() says why.
[[gnu::always_inline]] inline bool changes_place(const Shape& mesh) {
  bool changes = false;
  for (int i = 0; i < kCountOf<MeshPlace>; ++i) changes |= mesh.number[i] != mesh.number[kCountOf<MeshPlace> + i];
  return changes;
}

/// Returns the union of the shapes, in order; a union among them is replaced by its parts. Its measure is the sum of
/// the parts' measures, where m, m^2 and m^3 count alike. To sample it, a part is picked with a probability
/// proportional to its measure, or with equal probability if all measures are 0 or one is infinite. Where parts
/// overlap, points count once for each part. Throws std::invalid_argument if there is no shape or more than kMostParts.
Shape unite(const std::vector<Shape>& shapes);
inline constexpr std::size_t kMostParts = 65536;

/// A part of a union as bytes: its kind and numbers. Everything else follows from them.
struct UnionPart {
  Kind kind = Kind::point;
  float number[kNumbers] = {};
  std::uint64_t mesh = 0;
};

template <class Visitor>
constexpr void fields(Visitor& visit, UnionPart& part) {
  visit(part.kind, part.number, part.mesh);
}

std::vector<UnionPart> parts_of(const Shape& shape);

/// Completes a shape that was read: a union gets its parts, a mesh its form in this process. Throws std::runtime_error
/// if the parts cannot form a union.
void set_parts(Shape& shape, const std::vector<UnionPart>& parts);

template <class Visitor>
void fields(Visitor& visit, Shape& shape) {
  visit(shape.kind, shape.number, shape.mesh);
  if (shape.kind == Kind::mesh) visit(shape.origin, shape.before);
  std::vector<UnionPart> parts;
  if (shape.kind == Kind::united) {
    if constexpr (!Visitor::kReads) parts = parts_of(shape);
    visit(parts);
  }
  if constexpr (Visitor::kReads) set_parts(shape, parts);
}

/// Throws std::invalid_argument, naming the argument, if a number is not finite or the shape is degenerate.
void check(const Shape& shape);

/// Like check(), for a shape that must have an inside: a mesh, also one in a union, must be closed.
void check_region(const Shape& shape);

/// Like check(), but a mesh need not have an area, since it is only drawn.
void check_placed(const Shape& shape);

/// Returns a mesh of this key with these numbers (see mesh.h), made from the mesh `origin` and deforming from the mesh
/// `before`, or 0. Throws as deform_from().
Shape mesh_shape(std::uint64_t key, const float (&number)[kNumbers], std::uint64_t origin = 0,
                 std::uint64_t before = 0);

/// Makes a mesh deform during the frame from the content and pose that `before` has at the end of its frame. Throws
/// std::invalid_argument if the two are not closed or have different triangles.
void deform_from(Shape& mesh, const Shape& before);

/// Returns the keys of the shape's meshes.
std::vector<std::uint64_t> meshes_of(const Shape& shape);

/// Returns the length, area or volume in metres to the power of the shape's dimension; 0 for a point, infinite for a
/// plane and a blob. Of a mesh: the area, or the volume if samples are from the inside. A disc, cylinder, cone or
/// sphere whose two radii are equal is a curve or a surface, and is measured as one.
double measure(const Shape& shape);

/// Returns how many numbers a shape of this kind has.
int count(Kind kind);

/// Returns the name of the Python class.
std::string name(Kind kind);

/// Returns whether samples of a mesh are from the inside.
bool drawn_inside(const Shape& mesh);

/// Returns whether a particle can bounce off shapes of this kind. True for unions, whatever their parts.
bool has_surface(Kind kind);

}  // namespace motes::shapes
