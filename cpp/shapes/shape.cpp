#include "shapes/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "base/invalid_argument.h"
#include "base/vectors.h"
#include "meshes/deformation.h"
#include "meshes/distance_field.h"
#include "meshes/form.h"

namespace motes::shapes {

Vector vector_at(const Shape& s, int first) { return {s.number[first], s.number[first + 1], s.number[first + 2]}; }

namespace {

struct Facts {
  const char* name;
  int numbers;
  bool surface;
};
constexpr std::array<Facts, kKinds> kFacts = {{
#define MOTES_SHAPE(kind, Name, numbers, surface) {#Name, numbers, surface},
#include "shapes/list.inc"
}};

const Facts& facts(Kind kind) { return kFacts[static_cast<std::size_t>(kind)]; }

// Returns whether a vector is long and short enough for a direction: kernels divide by the square of its length in
// float32, which must be a normal number.
bool direction(const Vector& a) {
  const double square = length(a) * length(a);
  return square > 1e-30 && square < 1e30;
}

[[noreturn]] void refuse(const Shape& s, const std::string& argument, const std::string& rule,
                         const std::string& got = "") {
  throw base::InvalidArgument(argument, rule, got, name(s.kind));
}

void check_radii(const Shape& s, float radius, float inner) {
  if (!(radius > 0)) refuse(s, "radius", "be > 0", std::to_string(radius));
  if (!(inner >= 0 && inner <= radius)) {
    refuse(s, "inner_radius", "be 0..radius", std::to_string(inner));
  }
}

// Returns the measure of a cylinder or cone. A cone has a third of the cylinder's volume; its side is half the product
// of slant and circumference.
double shell_measure(const Shape& s) {
  const double height = length(vector_at(s, 3) - vector_at(s, 0));
  const double radius = s.number[6], inner = s.number[7];
  if (radius != inner) {
    const double volume = std::numbers::pi * (radius * radius - inner * inner) * height;
    return s.kind == Kind::cone ? volume / 3 : volume;
  }
  if (s.kind == Kind::cylinder) return 2 * std::numbers::pi * radius * height;
  return std::numbers::pi * radius * std::sqrt(height * height + radius * radius);
}

constexpr int kRotation = 3, kBefore = 7, kSolid = 14, kResolution = 15;  // indices of a mesh's numbers

bool is_rotation(const float* q) {
  double square = 0;
  for (int i = 0; i < 4; ++i) square += double{q[i]} * q[i];
  return std::fabs(square - 1) < 1e-3;
}

void check_numbers(const Shape& s) {
  for (int i = 0; i < count(s.kind); ++i) {
    if (!(std::fabs(s.number[i]) <= 1e12f)) {
      refuse(s, "every number", "be finite and within 1e12", std::to_string(s.number[i]));
    }
  }
}

void check_placed_mesh(const Shape& s) {
  const float resolution = s.number[kResolution];
  if (!(resolution >= meshes::kLeastResolution && resolution <= meshes::kMostResolution) ||
      std::trunc(resolution) != resolution) {
    refuse(s, "resolution",
           "be a whole number in " + std::to_string(meshes::kLeastResolution) + ".." +
               std::to_string(meshes::kMostResolution),
           std::to_string(resolution));
  }
  if (!is_rotation(s.number + kRotation) || !is_rotation(s.number + kBefore + kRotation)) {
    refuse(s, "a rotation", "be a quaternion of length 1");
  }
  if (s.number[kSolid] != 0 && s.number[kSolid] != 1) refuse(s, "solid", "be 0 or 1");
  if (s.form == nullptr) refuse(s, "mesh", "be one that this process keeps");
}

void check_mesh(const Shape& s) {
  check_placed_mesh(s);
  if (s.form->triangles == 0) refuse(s, "triangles", "have an area, and a density above 0 if one is given");
  if (s.number[kSolid] != 0) meshes::need_inside(*s.form);
}

bool moves(const Shape& s) {
  return s.kind == Kind::mesh && (s.before != 0 || !std::equal(s.number, s.number + kBefore, s.number + kBefore));
}

// Sets what a mesh points to, which is not part of a shape's bytes.
void find_form(Shape& s) {
  if (s.kind != Kind::mesh) return;
  const auto form_of = [&](std::uint64_t key) {
    return meshes::form_of(key, static_cast<int>(s.number[kResolution]), s.number[kSolid] != 0);
  };
  s.form = form_of(s.mesh);
  const meshes::MeshForm* before = s.before == 0 ? nullptr : form_of(s.before);
  s.deformation = before == nullptr || s.form == nullptr ? nullptr : meshes::deformation_of(*before, *s.form);
}

double add_measure(double sum, const Shape& s) { return sum + measure(s); }

void share_out(std::vector<Shape>& parts) {
  const double total = std::accumulate(parts.begin(), parts.end(), 0.0, add_measure);
  const bool by_measure = total > 0 && std::isfinite(total);
  double sum = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    sum += by_measure ? measure(parts[i]) : 1;
    parts[i].upto = static_cast<float>(sum / (by_measure ? total : static_cast<double>(parts.size())));
  }
  parts.back().upto = 1;  // whatever the rounding of the sum, every number in [0, 1) selects a part
}

}  // namespace

std::string name(Kind kind) { return facts(kind).name; }
int count(Kind kind) { return facts(kind).numbers; }
bool drawn_inside(const Shape& mesh) { return mesh.number[kSolid] != 0; }

bool has_surface(Kind kind) { return facts(kind).surface; }

void check(const Shape& s) {
  check_numbers(s);
  switch (s.kind) {
    case Kind::rectangle:
      if (!direction(cross(vector_at(s, 3), vector_at(s, 6)))) refuse(s, "u and v", "span an area");
      break;
    case Kind::disc:
      if (!direction(vector_at(s, 3))) refuse(s, "normal", "not be zero");
      check_radii(s, s.number[6], s.number[7]);
      break;
    case Kind::plane:
      if (!direction(vector_at(s, 3))) refuse(s, "normal", "not be zero");
      break;
    case Kind::box:
      for (int i = 0; i < 3; ++i) {
        if (s.number[i] > s.number[i + 3]) {
          refuse(s, "low", "not be above high", std::to_string(s.number[i]) + " > " + std::to_string(s.number[i + 3]));
        }
      }
      break;
    case Kind::sphere: check_radii(s, s.number[3], s.number[4]); break;
    case Kind::triangle:
      if (!direction(cross(vector_at(s, 3) - vector_at(s, 0), vector_at(s, 6) - vector_at(s, 0))))
        refuse(s, "p0, p1 and p2", "span an area");
      break;
    case Kind::cylinder:
      if (!direction(vector_at(s, 3) - vector_at(s, 0))) refuse(s, "p0 and p1", "differ");
      check_radii(s, s.number[6], s.number[7]);
      break;
    case Kind::cone:
      if (!direction(vector_at(s, 3) - vector_at(s, 0))) refuse(s, "apex and base", "differ");
      check_radii(s, s.number[6], s.number[7]);
      break;
    case Kind::blob:
      if (!(s.number[3] > 0)) refuse(s, "sigma", "be > 0", std::to_string(s.number[3]));
      break;
    case Kind::united:
      if (s.parts == 0) refuse(s, "shapes", "not be empty");
      for (int i = 0; i < s.parts; ++i) {
        check(s.part[i]);
        if (moves(s.part[i])) refuse(s, "shapes", "not include a mesh that moves: it cannot be part of a union");
      }
      break;
    case Kind::mesh: check_mesh(s); break;
    case Kind::point:
    case Kind::line: break;
  }
}

void check_region(const Shape& s) {
  check(s);
  for (int i = 0; i < s.parts; ++i) check_region(s.part[i]);
  if (s.kind == Kind::mesh) meshes::need_inside(*s.form);
}

void check_placed(const Shape& s) {
  if (s.kind != Kind::mesh) return check(s);
  check_numbers(s);
  check_placed_mesh(s);
}

Shape mesh_shape(std::uint64_t key, const float (&number)[kNumbers], std::uint64_t origin, std::uint64_t before) {
  Shape s;
  s.kind = Kind::mesh;
  std::copy_n(number, kNumbers, s.number);
  s.mesh = key;
  s.origin = origin;
  s.before = before;
  find_form(s);
  return s;
}

void deform_from(Shape& mesh, const Shape& before) {
  mesh.before = before.mesh;
  std::copy_n(before.number, kBefore, mesh.number + kBefore);
  double same_way = 0;
  for (int i = kRotation; i < kBefore; ++i) same_way += double{mesh.number[i]} * mesh.number[kBefore + i];
  if (same_way < 0) {  // interpolate the shorter way
    for (int i = kRotation; i < kBefore; ++i) mesh.number[kBefore + i] = -mesh.number[kBefore + i];
  }
  find_form(mesh);
}

std::vector<std::uint64_t> meshes_of(const Shape& shape) {
  std::vector<std::uint64_t> keys;
  if (shape.kind == Kind::mesh) keys.push_back(shape.mesh);
  if (shape.before != 0) keys.push_back(shape.before);
  for (int i = 0; i < shape.parts; ++i) {
    if (shape.part[i].kind == Kind::mesh) keys.push_back(shape.part[i].mesh);
  }
  return keys;
}

double measure(const Shape& s) {
  const auto n = [&](int i) { return static_cast<double>(s.number[i]); };
  switch (s.kind) {
    case Kind::point: return 0;
    case Kind::line: return length({n(3) - n(0), n(4) - n(1), n(5) - n(2)});
    case Kind::rectangle: return length(cross(vector_at(s, 3), vector_at(s, 6)));
    case Kind::disc: return n(6) == n(7) ? 2 * std::numbers::pi * n(6) : std::numbers::pi * (n(6) * n(6) - n(7) * n(7));
    case Kind::plane: return std::numeric_limits<double>::infinity();
    case Kind::box: return (n(3) - n(0)) * (n(4) - n(1)) * (n(5) - n(2));
    case Kind::sphere:
      if (n(3) == n(4)) return 4 * std::numbers::pi * n(3) * n(3);
      return 4.0 / 3.0 * std::numbers::pi * (n(3) * n(3) * n(3) - n(4) * n(4) * n(4));
    case Kind::triangle: return length(cross(vector_at(s, 3) - vector_at(s, 0), vector_at(s, 6) - vector_at(s, 0))) / 2;
    case Kind::cylinder:
    case Kind::cone: return shell_measure(s);
    case Kind::blob: return std::numeric_limits<double>::infinity();
    case Kind::mesh:
      if (s.form == nullptr) return 0;
      return n(kSolid) != 0 ? s.form->volume : s.form->area;
    case Kind::united: return std::accumulate(s.part, s.part + s.parts, 0.0, add_measure);
  }
  return 0;
}

bool Shape::operator==(const Shape& other) const {
  return kind == other.kind && mesh == other.mesh && origin == other.origin && before == other.before &&
         std::equal(number, number + kNumbers, other.number) &&
         std::equal(part, part + parts, other.part, other.part + other.parts);
}

Shape unite(const std::vector<Shape>& shapes) {
  auto parts = std::make_shared<std::vector<Shape>>();
  for (const Shape& shape : shapes) {
    if (shape.kind == Kind::united) {
      parts->insert(parts->end(), shape.part, shape.part + shape.parts);
    } else {
      parts->push_back(shape);
    }
  }
  if (parts->empty() || parts->size() > kMostParts) {
    throw base::InvalidArgument("there", "be 1.." + std::to_string(kMostParts) + " shapes",
                                std::to_string(parts->size()), "Union");
  }
  share_out(*parts);
  Shape whole;
  whole.kind = Kind::united;
  whole.part = parts->data();
  whole.parts = static_cast<int>(parts->size());
  whole.owner = std::move(parts);
  return whole;
}

std::vector<UnionPart> parts_of(const Shape& shape) {
  std::vector<UnionPart> parts(static_cast<std::size_t>(shape.parts));
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i].kind = shape.part[i].kind;
    std::copy_n(shape.part[i].number, kNumbers, parts[i].number);
    parts[i].mesh = shape.part[i].mesh;
  }
  return parts;
}

void set_parts(Shape& shape, const std::vector<UnionPart>& parts) {
  Shape whole;
  whole.kind = shape.kind;
  std::copy_n(shape.number, kNumbers, whole.number);
  whole.mesh = shape.mesh;
  whole.origin = shape.origin;
  whole.before = shape.before;
  find_form(whole);
  if (shape.kind == Kind::united) {
    std::vector<Shape> list(parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].kind == Kind::united) throw std::runtime_error("damaged bytes: a union inside a union");
      list[i].kind = parts[i].kind;
      std::copy_n(parts[i].number, kNumbers, list[i].number);
      list[i].mesh = parts[i].mesh;
      find_form(list[i]);
    }
    if (list.empty() || list.size() > kMostParts) {
      throw std::runtime_error("damaged bytes: a union of " + std::to_string(list.size()) + " shapes");
    }
    whole = unite(list);
  }
  shape = std::move(whole);
}

}  // namespace motes::shapes
