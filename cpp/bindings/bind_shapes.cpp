#include <algorithm>
#include <cmath>
#include <numeric>

#include "actions/kernels.h"
#include "bindings/bindings.h"
#include "particles/streams.h"
#include "simd/float_mode.h"
#include "simd/isa.h"

namespace motes::bindings {
namespace {

using shapes::Shape;

Shape make_shape(const std::string& kind, const std::vector<double>& numbers) {
  for (int k = 0; k < shapes::kKinds; ++k) {
    if (shapes::name(static_cast<shapes::Kind>(k)) != kind) continue;
    Shape shape;
    shape.kind = static_cast<shapes::Kind>(k);
    if (static_cast<int>(numbers.size()) != shapes::count(shape.kind)) {
      throw std::invalid_argument(kind + " needs " + std::to_string(shapes::count(shape.kind)) + " numbers");
    }
    const simd::FloatMode mode;  // keeps denormal numbers
    for (std::size_t i = 0; i < numbers.size(); ++i) shape.number[i] = static_cast<float>(numbers[i]);
    shapes::check(shape);
    return shape;
  }
  throw std::invalid_argument("no shape is called '" + kind + "'");
}

Shape make_mesh(std::uint64_t mesh, const std::vector<double>& given, std::uint64_t origin, std::uint64_t before) {
  float numbers[shapes::kNumbers] = {};
  if (given.size() != static_cast<std::size_t>(shapes::count(shapes::Kind::mesh))) {
    throw std::invalid_argument("Mesh needs " + std::to_string(shapes::count(shapes::Kind::mesh)) + " numbers");
  }
  std::copy(given.begin(), given.end(), numbers);
  const Shape shape = shapes::mesh_shape(mesh, numbers, origin, before);
  shapes::drawn_inside(shape) ? shapes::check(shape) : shapes::check_placed(shape);
  return shape;
}

// Returns points as three planes with room for whole vectors.
std::vector<std::vector<float>> planes_of(const FloatArray& points) {
  const auto n = static_cast<std::size_t>(points.shape(0));
  std::vector<std::vector<float>> planes(3, std::vector<float>(n + particles::kPadding, 0.0f));
  const auto view = points.unchecked<2>();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < 3; ++c) planes[c][i] = view(static_cast<py::ssize_t>(i), static_cast<py::ssize_t>(c));
  }
  return planes;
}

py::array contains(const Shape& shape, const FloatArray& points) {
  const simd::FloatMode mode;  // as in actions
  shapes::check_region(shape);
  const auto n = static_cast<std::size_t>(points.shape(0));
  const auto planes = planes_of(points);
  const float* position[3] = {planes[0].data(), planes[1].data(), planes[2].data()};
  std::vector<std::uint8_t> inside(n);
  actions::kernels().contains(shape, position, n, inside.data());
  return owned_array(std::move(inside), {static_cast<py::ssize_t>(n)}).view("?");
}

py::array sample(const Shape& shape, std::size_t n, std::uint64_t seed) {
  const simd::FloatMode mode;
  shapes::check(shape);
  std::vector<std::uint64_t> numbers(n + particles::kPadding);
  std::iota(numbers.begin(), numbers.end(), std::uint64_t{0});
  const particles::IdList ids(numbers);
  std::vector<std::vector<float>> planes(3, std::vector<float>(n + particles::kPadding));
  float* into[3] = {planes[0].data(), planes[1].data(), planes[2].data()};
  const actions::distributions::InShape d{shape};
  particles::DrawKeys draws;
  const particles::Key key = particles::system_key(seed, 0);
  actions::kernels().draw(d, nullptr, {0, 0, particles::user_sample, key, 0, &draws}, ids, n, into, 3);
  std::vector<float> rows(3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t c = 0; c < 3; ++c) rows[3 * i + c] = planes[c][i];
  }
  return owned_array(std::move(rows), {static_cast<py::ssize_t>(n), 3});
}

}  // namespace

void bind_shapes(py::module_& m) {
  py::class_<Shape>(m, "Shape")
      .def(py::init(&make_shape), py::arg("kind"), py::arg("numbers"))
      .def_static("mesh", &make_mesh, py::arg("mesh"), py::arg("numbers"), py::arg("origin") = 0, py::arg("before") = 0)
      .def_static("united", &shapes::unite, py::arg("shapes"))
      .def_property_readonly("parts", [](const Shape& s) { return std::vector<Shape>(s.part, s.part + s.parts); })
      .def_property_readonly("kind", [](const Shape& s) { return shapes::name(s.kind); })
      .def_property_readonly(
          "numbers", [](const Shape& s) { return std::vector<float>(s.number, s.number + shapes::count(s.kind)); })
      .def("measure", [](const Shape& s) { return shapes::measure(s); })
      .def("contains", &contains, py::arg("points"))
      .def("sample", &sample, py::arg("n"), py::arg("seed"))
      .def("__eq__", [](const Shape& a, const Shape& b) { return a == b; });
  m.def("simd", [] { return std::string(simd::name(simd::isa())); });
}

}  // namespace motes::bindings
