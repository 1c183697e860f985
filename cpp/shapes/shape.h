// A region of space as a plain value (API: motes.shapes).
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace motes::shapes {

enum class Kind : std::uint8_t {
#define MOTES_SHAPE(kind, ...) kind,
#include "shapes/list.inc"
};

inline constexpr int kKinds = 0
#define MOTES_SHAPE(...) +1  // NOLINT(bugprone-macro-parentheses): a summand
#include "shapes/list.inc"
    ;

/// Most numbers that one shape has.
inline constexpr int kNumbers = std::max({
#define MOTES_SHAPE(kind, Name, numbers, surface) numbers,
#include "shapes/list.inc"
});

/// The kind and its numbers, in metres, in the order of the constructor's arguments: see list.inc.
struct Shape {
  Kind kind = Kind::point;
  float number[kNumbers] = {};

  // A union's parts, none of them a union, as plain pointers: kernels call nothing of the standard library.
  const Shape* part = nullptr;
  int parts = 0;
  float upto = 1;  // of a part: a number in 0..1 below this, and not below that of the part before, picks it
  std::shared_ptr<const std::vector<Shape>> owner = {};

  /// Equal kind, numbers and parts.
  bool operator==(const Shape& other) const;
};

/// The union of the shapes, in order; a union among them counts as its parts. Its measure is the sum of theirs, and it
/// is drawn from a part that is picked by measure, where m, m^2 and m^3 count alike; by equal chances where all
/// measures are 0 or one is infinite. Where parts overlap, points there count for each. Throws std::invalid_argument
/// where there is no shape, or more than kMostParts.
Shape unite(const std::vector<Shape>& shapes);
inline constexpr std::size_t kMostParts = 65536;

/// A part of a union as bytes: its kind and numbers. All else follows from them.
struct Part {
  Kind kind = Kind::point;
  float number[kNumbers] = {};
};

template <class Visitor>
constexpr void fields(Visitor& visit, Part& part) {
  visit(part.kind, part.number);
}

std::vector<Part> parts_of(const Shape& shape);

/// Gives a shape that was read its parts: none unless it is a union. Throws std::runtime_error where a union cannot
/// have them.
void set_parts(Shape& shape, const std::vector<Part>& parts);

template <class Visitor>
void fields(Visitor& visit, Shape& shape) {
  visit(shape.kind, shape.number);
  std::vector<Part> parts;
  if (shape.kind == Kind::united) {
    if constexpr (!Visitor::kReads) parts = parts_of(shape);
    visit(parts);
  }
  if constexpr (Visitor::kReads) set_parts(shape, parts);
}

/// Throws std::invalid_argument, naming the argument, where a number is not finite or the shape is degenerate.
void check(const Shape& shape);

/// Length, area or volume in metres to the power of the shape's dimension; 0 for a point, infinite for a plane and a
/// blob. A disc, cylinder, cone or sphere whose two radii are equal is a curve or surface, and measured as such.
double measure(const Shape& shape);

/// How many numbers a shape of this kind has.
int count(Kind kind);

/// The name of the Python class.
std::string name(Kind kind);

/// Whether the shape has something that a particle can bounce off; a union has what its parts have.
bool has_surface(Kind kind);

}  // namespace motes::shapes
