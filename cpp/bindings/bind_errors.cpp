// C++ exceptions as the errors of motes.errors.
#include "base/invalid_argument.h"
#include "bindings/bindings.h"
#include "engine/engine.h"
#include "engine/recovery/loss.h"

namespace motes::bindings {
namespace {

void raise(const py::object& error) { PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr()); }

py::object errors(const char* name) { return py::module_::import("motes.errors").attr(name); }

void raise_agreed(const engine::Agreed& error) {
  const engine::Verdict& verdict = error.verdict();
  py::dict keywords;
  keywords["frame"] = error.frame();
  keywords["speaker"] = verdict.failed_rank;
  if (verdict.failure.kind == engine::Failure::Kind::mismatch) {
    keywords["ranks"] = py::tuple(py::cast(verdict.ranks));
    const py::object make = py::module_::import("motes._run.script_lines").attr("mismatch_error");
    raise(make(error.what(), **keywords));
    return;
  }
  keywords["rank"] = verdict.failed_rank;
  keywords["action"] = verdict.failure.action;
  keywords["role"] = error.role();
  keywords["place"] = std::pair(verdict.failure.place.system, verdict.failure.place.item);
  const py::object make = py::module_::import("motes._run.script_lines").attr("rank_error");
  raise(make(verdict.failure.text, **keywords));
}

}  // namespace

void bind_errors(py::module_&) {
  // Only for exceptions thrown by this module: those of other pybind11 modules are not translated here.
  py::register_local_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const engine::Agreed& error) {
      raise_agreed(error);
    } catch (const engine::ItemFailure& error) {
      std::rethrow_exception(error.original());  // for the other translators
    } catch (const base::InvalidArgument& error) {
      raise(errors("argument_error")(error.what(), error.argument(), error.value(), error.allowed()));
    } catch (const std::invalid_argument& error) {
      raise(errors("argument_error")(error.what()));
    } catch (const jsonl::LogError& error) {
      raise(errors("LogError")(error.what()));
    } catch (const engine::Unrecoverable& error) {
      const py::object made = errors("MotesError")(error.what());
      made.attr("lost") = true;
      raise(made);
    } catch (const comm::CommError& error) {
      raise(errors("MotesError")(error.what()));
    } catch (const threads::NoThread& error) {
      raise(errors("MotesError")(error.what()));
    }
  });
}

}  // namespace motes::bindings
