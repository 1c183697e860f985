#include "bindings/bindings.h"
#include "image/bench.h"
#include "recording/bench.h"

namespace motes::bindings {

void bind_bench(py::module_& m) {
  m.def(
      "act_bench",
      [](const std::string& scene, std::size_t particles, int steps) {
        recording::ActBench b;
        {
          const py::gil_scoped_release release;
          b = recording::act_bench(scene, particles, steps);
        }
        py::dict d;
        d["updates_per_s"] = b.updates_per_s;
        d["memory_limit_updates_per_s"] = b.memory_limit_updates_per_s;
        d["ratio"] = b.ratio;
        d["bytes_per_particle"] = b.bytes_per_particle;
        return d;
      },
      py::arg("scene"), py::arg("particles"), py::arg("steps"));
  m.def(
      "leaver_bench",
      [](std::size_t particles, int bins, int steps) {
        recording::LeaverBench b;
        {
          const py::gil_scoped_release release;
          b = recording::leaver_bench(particles, bins, steps);
        }
        py::dict d;
        d["none_s"] = b.none;
        d["fused_s"] = b.fused;
        d["scanned_s"] = b.scanned;
        d["binned_s"] = b.binned;
        return d;
      },
      py::arg("particles"), py::arg("bins"), py::arg("steps"));
}

}  // namespace motes::bindings
