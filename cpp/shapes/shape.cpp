#include "shapes/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
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

namespace {

struct Facts {
  const char* name;
  int numbers;
  bool surface;
};
constexpr std::array<Facts, kKinds> kFacts = {{
#define MOTES_SHAPE(kind, Name, surface) {#Name, kCountOf<numbers::kind>, surface},
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

// Returns whether it is a quaternion of length 1.
bool is_rotation(const float (&q)[4]) {
  double square = 0;
  for (const float component : q) square += double{component} * component;
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
  const auto mesh = s.as<numbers::mesh>();
  if (!(mesh.resolution >= meshes::kLeastResolution && mesh.resolution <= meshes::kMostResolution) ||
      std::trunc(mesh.resolution) != mesh.resolution) {
    refuse(s, "resolution",
           "be a whole number in " + std::to_string(meshes::kLeastResolution) + ".." +
               std::to_string(meshes::kMostResolution),
           std::to_string(mesh.resolution));
  }
  if (!is_rotation(mesh.end.rotation) || !is_rotation(mesh.start.rotation)) {
    refuse(s, "a rotation", "be a quaternion of length 1");
  }
  if (mesh.solid != 0 && mesh.solid != 1) refuse(s, "solid", "be 0 or 1");
  if (s.form == nullptr) refuse(s, "mesh", "be one that this process keeps");
}

bool moves(const Shape& s) { return s.kind == Kind::mesh && (s.before != 0 || changes_place(s)); }

// Sets what a mesh points to, which is not part of a shape's bytes.
void find_form(Shape& s) {
  if (s.kind != Kind::mesh) return;
  const auto form_of = [&](std::uint64_t key) {
    return meshes::form_of(key, static_cast<int>(s.as<numbers::mesh>().resolution), drawn_inside(s));
  };
  s.form = form_of(s.mesh);
  const meshes::MeshForm* before = s.before == 0 ? nullptr : form_of(s.before);
  s.deformation = before == nullptr || s.form == nullptr ? nullptr : meshes::deformation_of(*before, *s.form);
}

// --- checks per kind, by its numbers

void check(const Shape&, const numbers::point&) {}
void check(const Shape&, const numbers::line&) {}

void check(const Shape& s, const numbers::rectangle& rectangle) {
  if (!direction(cross(vector_of(rectangle.u), vector_of(rectangle.v)))) refuse(s, "u and v", "span an area");
}

void check(const Shape& s, const numbers::disc& disc) {
  if (!direction(vector_of(disc.normal))) refuse(s, "normal", "not be zero");
  check_radii(s, disc.radius, disc.inner_radius);
}

void check(const Shape& s, const numbers::plane& plane) {
  if (!direction(vector_of(plane.normal))) refuse(s, "normal", "not be zero");
}

void check(const Shape& s, const numbers::box& box) {
  for (int i = 0; i < 3; ++i) {
    if (box.low[i] <= box.high[i]) continue;
    refuse(s, "low", "not be above high", std::to_string(box.low[i]) + " > " + std::to_string(box.high[i]));
  }
}

void check(const Shape& s, const numbers::sphere& sphere) { check_radii(s, sphere.radius, sphere.inner_radius); }

// Returns the cross product of two sides, which is as long as twice the area.
Vector span_of(const numbers::triangle& triangle) {
  const Vector p0 = vector_of(triangle.p0);
  return cross(vector_of(triangle.p1) - p0, vector_of(triangle.p2) - p0);
}

void check(const Shape& s, const numbers::triangle& triangle) {
  if (!direction(span_of(triangle))) refuse(s, "p0, p1 and p2", "span an area");
}

void check(const Shape& s, const numbers::cylinder& cylinder) {
  if (!direction(vector_of(cylinder.p1) - vector_of(cylinder.p0))) refuse(s, "p0 and p1", "differ");
  check_radii(s, cylinder.radius, cylinder.inner_radius);
}

void check(const Shape& s, const numbers::cone& cone) {
  if (!direction(vector_of(cone.base) - vector_of(cone.apex))) refuse(s, "apex and base", "differ");
  check_radii(s, cone.radius, cone.inner_radius);
}

void check(const Shape& s, const numbers::blob& blob) {
  if (!(blob.sigma > 0)) refuse(s, "sigma", "be > 0", std::to_string(blob.sigma));
}

void check(const Shape& s, const numbers::united&) {
  if (s.parts == 0) refuse(s, "shapes", "not be empty");
  for (int i = 0; i < s.parts; ++i) {
    shapes::check(s.part[i]);
    if (moves(s.part[i])) refuse(s, "shapes", "not include a mesh that moves: it cannot be part of a union");
  }
}

void check(const Shape& s, const numbers::mesh& mesh) {
  check_placed_mesh(s);
  if (s.form->triangles == 0) refuse(s, "triangles", "have an area, and a density above 0 if one is given");
  if (mesh.solid != 0) meshes::need_inside(*s.form);
}

// --- measures per kind

double add_measure(double sum, const Shape& s) { return sum + measure(s); }

double measure(const Shape&, const numbers::point&) { return 0; }
double measure(const Shape&, const numbers::line& line) { return length(vector_of(line.p1) - vector_of(line.p0)); }
double measure(const Shape&, const numbers::rectangle& rectangle) {
  return length(cross(vector_of(rectangle.u), vector_of(rectangle.v)));
}
double measure(const Shape&, const numbers::disc& disc) {
  const double radius = disc.radius, inner = disc.inner_radius;
  return radius == inner ? 2 * std::numbers::pi * radius : std::numbers::pi * (radius * radius - inner * inner);
}
double measure(const Shape&, const numbers::plane&) { return kInfinity; }
double measure(const Shape&, const numbers::box& box) {
  const Vector size = vector_of(box.high) - vector_of(box.low);
  return size[0] * size[1] * size[2];
}
double measure(const Shape&, const numbers::sphere& sphere) {
  const double radius = sphere.radius, inner = sphere.inner_radius;
  if (radius == inner) return 4 * std::numbers::pi * radius * radius;
  return 4.0 / 3.0 * std::numbers::pi * (radius * radius * radius - inner * inner * inner);
}
double measure(const Shape&, const numbers::triangle& triangle) { return length(span_of(triangle)) / 2; }
double measure(const Shape&, const numbers::cylinder& cylinder) {
  const double height = length(vector_of(cylinder.p1) - vector_of(cylinder.p0));
  const double radius = cylinder.radius, inner = cylinder.inner_radius;
  if (radius == inner) return 2 * std::numbers::pi * radius * height;
  return std::numbers::pi * (radius * radius - inner * inner) * height;
}
// A cone has a third of the cylinder's volume; its side is half the product of slant and circumference.
double measure(const Shape&, const numbers::cone& cone) {
  const double height = length(vector_of(cone.base) - vector_of(cone.apex));
  const double radius = cone.radius, inner = cone.inner_radius;
  if (radius == inner) return std::numbers::pi * radius * std::sqrt(height * height + radius * radius);
  return std::numbers::pi * (radius * radius - inner * inner) * height / 3;
}
double measure(const Shape&, const numbers::blob&) { return kInfinity; }
double measure(const Shape& s, const numbers::united&) {
  return std::accumulate(s.part, s.part + s.parts, 0.0, add_measure);
}
double measure(const Shape& s, const numbers::mesh& mesh) {
  if (s.form == nullptr) return 0;
  return mesh.solid != 0 ? s.form->volume : s.form->area;
}

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
bool drawn_inside(const Shape& mesh) { return mesh.as<numbers::mesh>().solid != 0; }

bool has_surface(Kind kind) { return facts(kind).surface; }

void check(const Shape& s) {
  check_numbers(s);
  switch (s.kind) {
#define MOTES_SHAPE(kind, ...) \
  case Kind::kind: return check(s, s.as<numbers::kind>());
#include "shapes/list.inc"
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
  auto placed = mesh.as<numbers::mesh>();
  placed.start = before.as<numbers::mesh>().end;
  double same_way = 0;
  for (int i = 0; i < 4; ++i) same_way += double{placed.end.rotation[i]} * placed.start.rotation[i];
  if (same_way < 0) {  // interpolate the shorter way
    for (float& component : placed.start.rotation) component = -component;
  }
  mesh.set(placed);
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
  switch (s.kind) {
#define MOTES_SHAPE(kind, ...) \
  case Kind::kind: return measure(s, s.as<numbers::kind>());
#include "shapes/list.inc"
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
