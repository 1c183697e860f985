#include "shapes/shape.h"

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace motes::shapes {
namespace {

constexpr double kPi = 3.14159265358979323846;

struct Facts {
  const char* name;
  int count;
};
constexpr Facts kFacts[kKinds] = {{"Point", 3}, {"Line", 6}, {"Rectangle", 9}, {"Disc", 8},
                                  {"Plane", 6}, {"Box", 6},  {"Sphere", 5}};

using Vector = std::array<double, 3>;

Vector vector_at(const Shape& s, int first) { return {s.number[first], s.number[first + 1], s.number[first + 2]}; }
Vector cross(Vector a, Vector b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(Vector a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

// What the kernels divide by is the float square of a length: it must be a normal number.
bool direction(Vector a) {
  const double square = length(a) * length(a);
  return square > 1e-30 && square < 1e30;
}

[[noreturn]] void refuse(const Shape& s, const std::string& what) {
  throw std::invalid_argument(name(s.kind) + ": " + what);
}

void check_radii(const Shape& s, float radius, float inner) {
  if (!(radius > 0)) refuse(s, "radius must be > 0, got " + std::to_string(radius));
  if (!(inner >= 0 && inner <= radius)) {
    refuse(s, "inner_radius must be 0..radius, got " + std::to_string(inner));
  }
}

}  // namespace

std::string name(Kind kind) { return kFacts[static_cast<int>(kind)].name; }
int count(Kind kind) { return kFacts[static_cast<int>(kind)].count; }

void check(const Shape& s) {
  for (int i = 0; i < count(s.kind); ++i) {
    if (!(std::fabs(s.number[i]) <= 1e15f)) {
      refuse(s, "every number must be finite and within 1e15, got " + std::to_string(s.number[i]));
    }
  }
  switch (s.kind) {
    case Kind::rectangle:
      if (!direction(cross(vector_at(s, 3), vector_at(s, 6)))) refuse(s, "u and v must span an area");
      break;
    case Kind::disc:
      if (!direction(vector_at(s, 3))) refuse(s, "normal must not be zero");
      check_radii(s, s.number[6], s.number[7]);
      break;
    case Kind::plane:
      if (!direction(vector_at(s, 3))) refuse(s, "normal must not be zero");
      break;
    case Kind::box:
      for (int i = 0; i < 3; ++i) {
        if (s.number[i] > s.number[i + 3]) {
          refuse(s, "low must not be above high, got " + std::to_string(s.number[i]) + " > " +
                        std::to_string(s.number[i + 3]));
        }
      }
      break;
    case Kind::sphere: check_radii(s, s.number[3], s.number[4]); break;
    case Kind::point:
    case Kind::line: break;
  }
}

double measure(const Shape& s) {
  const auto n = [&](int i) { return static_cast<double>(s.number[i]); };
  switch (s.kind) {
    case Kind::point: return 0;
    case Kind::line: return length({n(3) - n(0), n(4) - n(1), n(5) - n(2)});
    case Kind::rectangle: return length(cross(vector_at(s, 3), vector_at(s, 6)));
    case Kind::disc: return kPi * (n(6) * n(6) - n(7) * n(7));
    case Kind::plane: return std::numeric_limits<double>::infinity();
    case Kind::box: return (n(3) - n(0)) * (n(4) - n(1)) * (n(5) - n(2));
    case Kind::sphere: return 4.0 / 3.0 * kPi * (n(3) * n(3) * n(3) - n(4) * n(4) * n(4));
  }
  return 0;
}

}  // namespace motes::shapes
