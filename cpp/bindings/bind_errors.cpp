// C++ exceptions as the errors of motes.errors.
#include "bindings/bindings.h"
#include "frame/engine.h"

namespace motes::bindings {
namespace {

void raise(const char* name, const py::tuple& args, const py::dict& keywords) {
  const py::object type = py::module_::import("motes.errors").attr(name);
  PyErr_SetObject(type.ptr(), type(*args, **keywords).ptr());
}

void raise_agreed(const frame::Agreed& error) {
  const frame::Verdict& verdict = error.verdict();
  py::dict keywords;
  keywords["frame"] = error.frame();
  keywords["speaker"] = verdict.failed_rank;
  if (verdict.failure.kind == frame::Failure::Kind::mismatch) {
    keywords["ranks"] = py::tuple(py::cast(verdict.ranks));
    raise("ScriptMismatch", py::make_tuple(error.what()), keywords);
    return;
  }
  keywords["rank"] = verdict.failed_rank;
  keywords["action"] = verdict.failure.action;
  keywords["role"] = error.role();
  raise("RankError", py::make_tuple(verdict.failure.text), keywords);
}

}  // namespace

void bind_errors(py::module_&) {
  // Of exceptions that this module throws alone: those of other modules of pybind11 are not ours.
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const frame::Agreed& error) {
      raise_agreed(error);
    } catch (const std::invalid_argument& error) {
      const py::object made = py::module_::import("motes.errors").attr("argument_error")(error.what());
      PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(made.ptr())), made.ptr());
    } catch (const comm::CommError& error) {
      raise("MotesError", py::make_tuple(error.what()), {});
    }
  });
}

}  // namespace motes::bindings
