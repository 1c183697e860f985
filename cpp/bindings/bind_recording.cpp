#include <optional>

#include "actions/kernels.h"
#include "base/enumerators.h"
#include "base/fields.h"
#include "base/invalid_argument.h"
#include "bindings/bindings.h"
#include "interactions/ties.h"
#include "meshes/assets.h"
#include "program/sums.h"
#include "recording/births.h"
#include "recording/record.h"
#include "simd/float_mode.h"

PYBIND11_MAKE_OPAQUE(motes::actions::Distribution)  // a class of its own, not one of its alternatives

namespace motes::bindings {
namespace {

using actions::Action;
using actions::Distribution;
using State = std::vector<std::pair<int, Distribution>>;

namespace distributions = actions::distributions;

template <std::size_t N>
void set(float (&numbers)[N], const std::vector<double>& values) {
  const simd::FloatMode mode;  // keeps denormal numbers
  for (std::size_t i = 0; i < values.size() && i < N; ++i) numbers[i] = static_cast<float>(values[i]);
}

distributions::Value value_of(const std::vector<double>& numbers) {
  distributions::Value value;
  set(value.number, numbers);
  return value;
}

// Returns a distribution that has two numbers per component.
template <class Kind>
Distribution of_pairs(float (Kind::*first)[3], float (Kind::*second)[3], const std::vector<double>& firsts,
                      const std::vector<double>& seconds, bool alike) {
  Kind kind;
  set(kind.*first, firsts);
  set(kind.*second, seconds);
  kind.alike = alike;
  return kind;
}

// Writes a distribution with its meshes, which another process may not have.
py::bytes bytes_of(const Distribution& distribution) {
  base::Bytes bytes;
  const auto* in = std::get_if<distributions::InShape>(&distribution);
  const std::vector<meshes::AssetKey> meshes =
      in == nullptr ? std::vector<meshes::AssetKey>() : shapes::meshes_of(in->shape);
  meshes::write_assets({meshes.begin(), meshes.end()}, bytes);
  base::write_fields(distribution, bytes);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Distribution from_bytes(const py::bytes& text) {
  const std::string_view view = text;
  base::Reader in({reinterpret_cast<const std::byte*>(view.data()), view.size()});
  meshes::read_assets(in);
  Distribution distribution;
  base::read_fields(in, distribution);
  return distribution;
}

std::vector<recording::Given> given(const State& state) {
  std::vector<recording::Given> all;
  for (const auto& [attribute, distribution] : state) all.push_back({attribute, distribution});
  return all;
}

recording::Source make_source(const shapes::Shape& shape, double rate, std::vector<double> integral, double scale,
                              const std::optional<shapes::Shape>& before, bool jitter, const State& state,
                              std::uint64_t number) {
  recording::Source source{shape, {}, rate, std::move(integral), scale, number, jitter, given(state)};
  if (before) source.before = {*before};
  return source;
}

recording::Burst make_burst(const shapes::Shape& shape, std::uint64_t count, const State& state) {
  return {shape, count, given(state)};
}

recording::Emit make_emit(std::uint64_t count, const std::vector<std::pair<int, FloatArray>>& columns,
                          const State& state) {
  recording::Emit emit{count, {}, given(state)};
  for (const auto& [attribute, values] : columns) {
    emit.columns.push_back({attribute, {values.data(), values.data() + values.size()}});
  }
  return emit;
}

// Returns the given numbers in their recorded order; a ramp's as they are.
std::vector<double> numbers_of(actions::Kind kind, const py::dict& given) {
  const actions::Facts& facts = actions::facts(kind);
  const auto of = [&](const char* name) {
    PyObject* const value = PyDict_GetItemString(given.ptr(), name);
    if (value == nullptr) throw base::InvalidArgument(name, "be given", "", actions::call_of(kind));
    return py::reinterpret_borrow<py::object>(value);
  };
  if (facts.ramp > 0) return of("ramp").cast<std::vector<double>>();
  std::vector<double> numbers;
  for (const actions::Number& number : facts.numbers) {
    const py::object value = of(number.name);
    if (number.count == 1) {
      numbers.push_back(value.cast<double>());
      continue;
    }
    const auto values = value.cast<std::vector<double>>();
    if (values.size() != static_cast<std::size_t>(number.count)) {
      throw base::InvalidArgument(number.name, "be " + std::to_string(number.count) + " numbers", "",
                                  actions::call_of(kind));
    }
    numbers.insert(numbers.end(), values.begin(), values.end());
  }
  if (given.size() != facts.numbers.size())
    throw base::InvalidArgument("numbers", "match the action's number of parameters", std::to_string(given.size()),
                                actions::call_of(kind));
  return numbers;
}

using UnionPart = std::tuple<std::string, int, int>;

Action make_action(const std::string& name, const py::dict& numbers, std::vector<shapes::Shape> shapes,
                   const Steps& where, int target, const std::vector<Steps>& values, std::uint64_t ties,
                   actions::TableKey table, const std::vector<UnionPart>& leaves, const std::vector<UnionPart>& results,
                   const std::vector<std::array<double, 4>>& walls) {
  Action action;
  action.kind = actions::kind_of(name);
  action.numbers = numbers_of(action.kind, numbers);
  action.shapes = std::move(shapes);
  action.where = expression(where);
  action.specifics = actions::specifics_of(action.kind);
  const auto refuse = [&](const char* field, bool given) {
    if (given) throw base::InvalidArgument(field, "not be given", "", actions::call_of(action.kind));
  };
  std::visit(  // each kind takes the fields that it has
      [&](auto& part) {
        if constexpr (!requires { part.table; } && !requires { part.clump; }) refuse("table", table != 0);
        if constexpr (!requires { part.values; }) refuse("values", !values.empty());
        if constexpr (!requires { part.leaves; }) refuse("leaves", !leaves.empty());
        if constexpr (!requires { part.results; }) refuse("results", !results.empty());
        if constexpr (!requires { part.walls; }) refuse("walls", !walls.empty());
        if constexpr (requires { part.attribute; }) part.attribute = target;
        if constexpr (requires { part.ties; }) part.ties = ties;
        if constexpr (requires { part.table; }) part.table = table;
        if constexpr (requires { part.clump; }) part.clump = table;
        if constexpr (requires { part.values; }) {
          for (const Steps& value : values) part.values.push_back(expression(value));
        }
        if constexpr (requires { part.leaves; }) {
          for (const auto& [of, attribute, component] : leaves)
            part.leaves.push_back({base::enumerator<actions::Leaf::Of>("leaf", of), attribute, component});
        }
        if constexpr (requires { part.results; }) {
          for (const auto& [how, attribute, component] : results)
            part.results.push_back({base::enumerator<actions::Result::How>("result", how), attribute, component});
        }
        if constexpr (requires { part.walls; }) {
          for (const auto& [stiffness, restitution, friction, rolling_friction] : walls)
            part.walls.push_back({stiffness, restitution, friction, rolling_friction});
        }
      },
      action.specifics);
  actions::check(action);
  return action;
}

recording::Spawn make_spawn(int into, const std::string& on, std::uint32_t count, double inherit_velocity,
                            const State& state, const Steps& where, std::vector<shapes::Shape> shapes) {
  recording::Spawn spawn;
  spawn.into = into;
  spawn.on = base::enumerator<recording::Spawn::On>("on", on);
  spawn.count = count;
  spawn.inherit_velocity = inherit_velocity;
  spawn.state = given(state);
  spawn.where = expression(where);
  spawn.shapes = std::move(shapes);
  return spawn;
}

recording::Callback make_callback(const std::string& name, int number, const Steps& where,
                                  std::vector<shapes::Shape> shapes) {
  return {name, number, expression(where), std::move(shapes)};
}

using Dimensions = std::vector<std::tuple<Steps, std::vector<double>, bool>>;

program::Sum make_sum(const Dimensions& dimensions, const std::vector<Steps>& weights, const Steps& where,
                      std::vector<shapes::Shape> shapes, double time) {
  program::Sum sum;
  for (const auto& [value, edges, closed] : dimensions) sum.dimensions.push_back({expression(value), edges, closed});
  for (const Steps& weight : weights) sum.weights.push_back(expression(weight));
  sum.where = expression(where);
  sum.shapes = std::move(shapes);
  sum.time = time;
  return sum;
}

void bind_tables(py::module_& m) {
  m.def(
      "keep_table",
      [](const FloatArray& values, const std::array<std::int32_t, 3>& size) {
        const auto entries = static_cast<py::ssize_t>(size[0]) * size[1] * size[2];
        const auto width = static_cast<std::int32_t>(entries > 0 ? values.size() / entries : 0);
        return actions::keep({size, width, {values.data(), values.data() + values.size()}});
      },
      py::arg("values"), py::arg("size"));
}

void bind_ties(py::module_& m) {
  using Ids = py::array_t<std::uint64_t, py::array::c_style | py::array::forcecast>;
  using Kinds = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;
  using Pins = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;
  m.def(
      "keep_ties",
      [](const Ids& ends, const FloatArray& lengths, const Kinds& kinds, const Ids& pinned, const Ids& tethered,
         const Pins& pins, const FloatArray& tethers) {
        const auto values = [](const auto& array) { return std::vector(array.data(), array.data() + array.size()); };
        return interactions::keep({values(ends), values(lengths), values(kinds), values(pinned), values(tethered),
                                   values(pins), values(tethers)});
      },
      py::arg("ends"), py::arg("lengths"), py::arg("kinds"), py::arg("pinned"), py::arg("tethered"), py::arg("pins"),
      py::arg("tethers"));
}

}  // namespace

expressions::Expression expression(const Steps& steps) {
  expressions::Expression made;
  for (const auto& [name, index, value] : steps) {
    made.push_back({base::enumerator<expressions::Op>("operation", name), index, static_cast<float>(value)});
  }
  return made;
}

namespace {

// Evaluates a checked expression of arrays with the kernels of actions, a block at a time.
py::array evaluate(const Steps& steps, const std::vector<FloatArray>& columns) {
  const expressions::Expression code = expression(steps);
  if (expressions::check(code, static_cast<int>(columns.size()), 0) != expressions::Type::number)
    throw std::invalid_argument("the expression must give numbers");
  if (expressions::names_ids(code)) throw std::invalid_argument("the expression must not read ids: arrays have none");
  const auto count = columns.empty() ? py::ssize_t{0} : columns.front().size();
  for (const FloatArray& column : columns) {
    if (column.size() != count) throw std::invalid_argument("all arrays must have the same size");
  }
  py::array_t<float> result(count);
  const auto size = static_cast<std::size_t>(count);
  const simd::FloatMode mode;  // as in actions
  std::vector<float> scratch(actions::kScratch), given(columns.size() * actions::kPlane);
  std::vector<float*> planes;
  for (std::size_t c = 0; c < columns.size(); ++c) planes.push_back(given.data() + c * actions::kPlane);
  for (std::size_t at = 0; at < size; at += particles::kBlock) {
    const std::size_t here = std::min(size - at, std::size_t{particles::kBlock});
    for (std::size_t c = 0; c < columns.size(); ++c) std::copy_n(columns[c].data() + at, here, planes[c]);
    const actions::Block block{here, planes.data(), {}, nullptr};
    actions::kernels().evaluate(code.data(), code.size(), nullptr, block, 0, scratch.data());
    std::copy_n(scratch.data(), here, result.mutable_data() + at);
  }
  return result;
}

}  // namespace

void bind_recording(py::module_& m) {
  m.def("evaluate", &evaluate, py::arg("steps"), py::arg("columns"));
  bind_ties(m);
  bind_tables(m);
  py::class_<Action>(m, "Action")
      .def(py::init(&make_action), py::arg("name"), py::arg("numbers"), py::arg("shapes"), py::arg("where") = Steps{},
           py::arg("target") = -1, py::arg("values") = std::vector<Steps>{}, py::arg("ties") = 0, py::arg("table") = 0,
           py::arg("leaves") = std::vector<UnionPart>{}, py::arg("results") = std::vector<UnionPart>{},
           py::arg("walls") = std::vector<std::array<double, 4>>{})
      .def_property_readonly("name", [](const Action& a) { return actions::call_of(a.kind); })
      .def_readonly("numbers", &Action::numbers)
      .def("__eq__", [](const Action& a, const Action& b) { return a == b; });
  py::class_<Distribution>(m, "Distribution")
      .def_static("value", [](const std::vector<double>& v) -> Distribution { return value_of(v); })
      .def_static("shape", [](const shapes::Shape& shape) -> Distribution { return distributions::InShape{shape}; })
      .def_static(
          "uniform",
          [](const std::vector<double>& lo, const std::vector<double>& hi, bool alike) {
            return of_pairs(&distributions::Uniform::low, &distributions::Uniform::high, lo, hi, alike);
          },
          py::arg("lo"), py::arg("hi"), py::arg("alike") = false)
      .def_static(
          "normal",
          [](const std::vector<double>& mean, const std::vector<double>& sigma, bool alike) {
            return of_pairs(&distributions::Normal::mean, &distributions::Normal::sigma, mean, sigma, alike);
          },
          py::arg("mean"), py::arg("sigma"), py::arg("alike") = false)
      .def_static("rotation", []() -> Distribution { return distributions::AnyRotation{}; })
      .def_static(
          "along_normal",
          [](double length) -> Distribution { return distributions::AlongNormal{static_cast<float>(length)}; },
          py::arg("length"))
      .def_static("surface_color", []() -> Distribution { return distributions::SurfaceColor{}; })
      .def("to_bytes", &bytes_of)
      .def_static("from_bytes", &from_bytes);
  py::class_<recording::Source>(m, "Source")
      .def(py::init(&make_source), py::arg("shape"), py::kw_only(), py::arg("rate"), py::arg("integral"),
           py::arg("scale"), py::arg("before"), py::arg("jitter"), py::arg("state"), py::arg("number"));
  py::class_<recording::Burst>(m, "Burst")
      .def(py::init(&make_burst), py::arg("shape"), py::kw_only(), py::arg("count"), py::arg("state"));
  py::class_<recording::Emit>(m, "Emit").def(py::init(&make_emit), py::kw_only(), py::arg("count"), py::arg("columns"),
                                             py::arg("state"));
  py::class_<recording::Spawn>(m, "Spawn")
      .def(py::init(&make_spawn), py::arg("into"), py::arg("on"), py::arg("count"), py::arg("inherit_velocity"),
           py::arg("state"), py::arg("where"), py::arg("shapes"));
  py::class_<recording::Callback>(m, "Callback")
      .def(py::init(&make_callback), py::arg("name"), py::arg("number"), py::arg("where"), py::arg("shapes"));
  py::class_<program::Sum>(m, "Sum").def(py::init(&make_sum), py::arg("dimensions"), py::arg("weights"),
                                         py::arg("where"), py::arg("shapes"), py::arg("time"));
  m.attr("noise_fields") = expressions::kFields;
  m.attr("most_bins") = program::kMostBins;
  m.def("action_names", [] {
    std::vector<std::string> names;
    for (int k = 0; k < actions::kKinds; ++k) names.emplace_back(actions::facts(static_cast<actions::Kind>(k)).name);
    return names;
  });
}

}  // namespace motes::bindings
