// The only file that includes pybind11. One bind_* function per subject.
#pragma once

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "expressions/expression.h"
#include "particles/store.h"

namespace motes::engine {
class RecoveringEngine;
}

namespace motes::bindings {

namespace py = pybind11;

using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Instructions: operation, index, value.
using Steps = std::vector<std::tuple<std::string, int, double>>;
expressions::Expression expression(const Steps& steps);

void bind_errors(py::module_& m);
void bind_shapes(py::module_& m);
void bind_recording(py::module_& m);
void bind_image(py::module_& m);
void bind_balance(py::module_& m);
void bind_engine(py::module_& m);
void bind_process(py::module_& m);
void bind_snapshots(py::module_& m);
void bind_saving(py::class_<engine::RecoveringEngine>& engine);
void bind_losses(py::class_<engine::RecoveringEngine>& engine);

// The laboratory (cpp/lab), in builds with MOTES_LAB.
void bind_bench(py::module_& lab);
void bind_soak(py::module_& lab);

/// Guards a function of the engine that touches no Python object: other Python threads run meanwhile.
using Release = py::call_guard<py::gil_scoped_release>;

/// Returns what `work` returns. Other Python threads may run meanwhile, so it must touch no Python object.
template <class Work>
auto released(const Work& work) {
  const py::gil_scoped_release release;
  return work();
}

/// Returns an array over the memory of a moved vector, or of another owner of values, without a copy.
template <class Values>
auto owned_array(Values values, const std::vector<py::ssize_t>& shape) {
  auto* held = new Values(std::move(values));
  const py::capsule owner(held, [](void* p) { delete static_cast<Values*>(p); });
  return py::array_t<std::remove_cvref_t<decltype(*held->data())>>(shape, held->data(), owner);
}

/// Returns a writable view of an attribute's planes for the particles begin .. end - 1, (n,) or (n, 3). The view keeps
/// the memory alive, but the store may move its particles elsewhere.
py::array column_view(particles::Store& store, int attribute, std::size_t begin, std::size_t end);
py::array id_copy(const particles::Store& store, std::size_t begin, std::size_t end);

/// Copies a column; a uniform attribute gets no memory of its own.
py::array column_copy(const particles::Store& store, int attribute);

/// Copies attributes and, last, ids of the first `count` particles.
py::list column_copies(const particles::Store& store, const std::vector<int>& attributes, std::size_t count,
                       threads::Pool& pool);

/// Copies rows of an array, (n, 3) or (n,) of 4 or 8 bytes each, into one of the same form: row k is row order[k].
/// Throws std::out_of_range for a row that does not exist.
void take_rows(const py::array& rows, const py::array_t<std::int64_t>& order, py::array& into);

/// Rows of numbers for a column of particles, float32 or float64 in C order: (n,) or (n, 3).
struct Rows {
  int attribute;
  py::array values;
};

/// Fills an empty store with `count` particles. Columns with a single row hold for all of them. `numbered`: ids depend
/// only on positions; otherwise they are undefined. Returns the first attribute with a value that is not finite as a
/// float32, or -1.
int fill(particles::Store& store, std::size_t count, const std::vector<Rows>& columns, bool numbered,
         threads::Pool& pool);

/// Returns, for each attribute of the schema, whether any of the first `count` particles has a value other than the
/// initial one.
std::vector<bool> used_attributes(const particles::Store& store, std::size_t count);

}  // namespace motes::bindings
