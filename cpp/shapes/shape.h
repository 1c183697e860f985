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

/// The most numbers that one shape has.
inline constexpr int kNumbers = std::max({
#define MOTES_SHAPE(kind, Name, numbers, surface) numbers,
#include "shapes/list.inc"
});

/// The kind and its numbers, in metres, in the order of the constructor's arguments: see list.inc.
struct Shape {
  Kind kind = Kind::point;
  float number[kNumbers] = {};

  // A union's parts, none of them a union, as plain pointers: kernels call nothing from the standard library.
  const Shape* part = nullptr;
  int parts = 0;
  float upto = 1;  // of a part: a number in 0..1 selects the first part whose `upto` is above it
  std::shared_ptr<const std::vector<Shape>> owner = {};

  // Of a mesh: the key of its content, and what this process has made of it; null where it keeps no such mesh.
  std::uint64_t mesh = 0;
  const meshes::MeshForm* form = nullptr;

  /// Same kind, numbers, parts and mesh.
  bool operator==(const Shape& other) const;
};

/// Return three of the shape's numbers, from number `first` on.
Vector vector_at(const Shape& shape, int first);

/// The union of the shapes, in order; a union among them is replaced by its parts. Its measure is the sum of the parts'
/// measures, where m, m^2 and m^3 count alike. To sample it, a part is picked with a probability proportional to its
/// measure, or with equal probability where all measures are 0 or one is infinite. Where parts overlap, points count
/// once for each part. Throws std::invalid_argument where there is no shape, or more than kMostParts.
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

/// Gives its parts to a shape that was read: none unless it is a union; to a mesh, what this process has made of it.
/// Throws std::runtime_error where these parts cannot form a union.
void set_parts(Shape& shape, const std::vector<UnionPart>& parts);

template <class Visitor>
void fields(Visitor& visit, Shape& shape) {
  visit(shape.kind, shape.number, shape.mesh);
  std::vector<UnionPart> parts;
  if (shape.kind == Kind::united) {
    if constexpr (!Visitor::kReads) parts = parts_of(shape);
    visit(parts);
  }
  if constexpr (Visitor::kReads) set_parts(shape, parts);
}

/// Throws std::invalid_argument, naming the argument, where a number is not finite or the shape is degenerate.
void check(const Shape& shape);

/// The same for a shape that must know what is inside it: a mesh, or one in a union, must be closed.
void check_region(const Shape& shape);

/// The same for a mesh that is only drawn: it need not have an area. For other shapes as check().
void check_placed(const Shape& shape);

/// A mesh of this key with these numbers: see mesh.h.
Shape mesh_shape(std::uint64_t key, const float (&number)[kNumbers]);

/// The keys of the meshes that the shape has.
std::vector<std::uint64_t> meshes_of(const Shape& shape);

/// Length, area or volume in metres to the power of the shape's dimension; 0 for a point, infinite for a plane and a
/// blob. Of a mesh: the area, or the volume where samples are from the inside. A disc, cylinder, cone or sphere whose
/// two radii are equal is a curve or a surface, and is measured as one.
double measure(const Shape& shape);

/// How many numbers a shape of this kind has.
int count(Kind kind);

/// The name of the Python class.
std::string name(Kind kind);

/// Whether points are drawn from the inside of a mesh.
bool drawn_inside(const Shape& mesh);

/// Whether a particle can bounce off the shape; for a union, whether it can bounce off its parts.
bool has_surface(Kind kind);

}  // namespace motes::shapes
