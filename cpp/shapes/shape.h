// A region of space as a plain value (API: motes.shapes).
#pragma once

#include <cstdint>
#include <string>

namespace motes::shapes {

enum class Kind : std::uint8_t { point, line, rectangle, disc, plane, box, sphere };
inline constexpr int kKinds = 7;

/// Most numbers that one shape needs (a rectangle's three vectors).
inline constexpr int kNumbers = 9;

/// The kind and its numbers, in metres, in the order of the constructor's arguments:
///   point p | line p0 p1 | rectangle origin u v | disc center normal radius inner_radius | plane point normal
///   | box low high | sphere center radius inner_radius
struct Shape {
  Kind kind = Kind::point;
  float number[kNumbers] = {};

  bool operator==(const Shape&) const = default;
};

/// Throws std::invalid_argument, naming the argument, where a number is not finite or the shape is degenerate.
void check(const Shape& shape);

/// Length, area or volume in metres to the power of the shape's dimension; 0 for a point, infinite for a plane.
double measure(const Shape& shape);

/// How many numbers a shape of this kind has.
int count(Kind kind);

/// The name of the Python class.
std::string name(Kind kind);

}  // namespace motes::shapes
