// The loss of ranks: what the core then calls on the script's side.
#include "bindings/bindings.h"
#include "engine/recovering_engine.h"

namespace motes::bindings {
namespace {

using Engine = engine::RecoveringEngine;
using engine::Loss;

// Holds an object that may be destroyed on any thread, without the GIL.
std::shared_ptr<py::object> held(py::object object) {
  return {new py::object(std::move(object)), [](py::object* dropped) {
            const py::gil_scoped_acquire gil;
            delete dropped;
          }};
}

py::tuple cast_of(const roles::Cast& cast) {
  return py::make_tuple(cast.manager, cast.image_generator, cast.calculators);
}

py::dict facts_of(const Loss& loss) {
  py::dict d;
  d["survivors"] = loss.survivors;
  d["lost"] = loss.lost;
  d["roles"] = cast_of(loss.now);
  d["comm"] = loss.handle;
  return d;
}

void survive_losses(Engine& engine, std::uint64_t every, py::object script) {
  const auto side = held(std::move(script));
  engine::Bystander bystander;
  bystander.watch = engine.session().comm().watch();
  bystander.regroup = [side](const Loss& loss) {
    const py::gil_scoped_acquire gil;
    const py::object answer = side->attr("regroup")(facts_of(loss));
    if (answer.is_none()) throw comm::RankLost(-1);  // another rank was lost meanwhile
    return answer.cast<std::string>();
  };
  bystander.unsaved_from = [side](const Loss&) {
    const py::gil_scoped_acquire gil;
    const py::object frame = side->attr("unsaved_from")();
    return frame.is_none() ? UINT64_MAX : frame.cast<std::uint64_t>();
  };
  bystander.resumed = [side](std::uint64_t frame) {
    const py::gil_scoped_acquire gil;
    side->attr("resumed")(frame);
  };
  bystander.redrawn = [side](std::uint64_t frame, const image::View& view) {
    const py::gil_scoped_acquire gil;
    side->attr("redrawn")(frame, view);
  };
  const py::gil_scoped_release release;
  engine.survive_losses(every, std::move(bystander));
}

}  // namespace

void bind_losses(py::class_<engine::RecoveringEngine>& engine) {
  engine.def("survive_losses", &survive_losses, py::arg("every"), py::arg("script"))
      .def("copy_restored", &Engine::copy_restored, Release())
      .def(
          "set_unsaved_from",
          [](Engine& e, std::optional<std::uint64_t> frame) { e.set_unsaved_from(frame.value_or(UINT64_MAX)); },
          py::arg("frame"))
      .def_property_readonly("losses", &Engine::losses);
}

}  // namespace motes::bindings
