// A region of space as a plain value (API: motes.shapes).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace motes::shapes {

/// The numbers are written into recorded scenes: new kinds stand at the end.
enum class Kind : std::uint8_t {
  point,
  line,
  rectangle,
  disc,
  plane,
  box,
  sphere,
  triangle,
  cylinder,
  cone,
  blob,
  united
};
inline constexpr int kKinds = 12;

/// Most numbers that one shape needs (three vectors).
inline constexpr int kNumbers = 9;

/// The kind and its numbers, in metres, in the order of the constructor's arguments:
///   point p | line p0 p1 | rectangle origin u v | disc center normal radius inner_radius | plane point normal
///   | box low high | sphere center radius inner_radius | triangle p0 p1 p2 | cylinder p0 p1 radius inner_radius
///   | cone apex base radius inner_radius | blob center sigma | united (none: see unite())
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

}  // namespace motes::shapes
