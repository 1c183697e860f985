// Disasters and damaged files for `motes soak`.
#include "bindings/bindings.h"
#include "lab/soak/disasters.h"
#include "lab/soak/files.h"

namespace motes::bindings {

void bind_soak(py::module_& m) {
  m.def(
      "disaster",
      [](std::uint64_t seed) {
        const soak::Disaster happened = released([&] { return soak::disaster(seed); });
        constexpr const char* kKinds[] = {"orders", "losses", "restarts"};
        py::dict d;
        d["kind"] = kKinds[static_cast<std::size_t>(happened.kind)];
        d["ranks"] = happened.ranks;
        d["died"] = happened.died;
        d["survived"] = happened.survived;
        d["reported"] = happened.reported;
        d["broken"] = happened.broken;
        return d;
      },
      py::arg("seed"), "Run one disaster on simulated ranks; `broken`: the promise that was broken, or an empty text.");
  m.def(
      "damaged_file",
      [](std::uint64_t seed, const std::string& directory) {
        const soak::DamagedFile file = released([&] { return soak::damaged_file(seed, directory); });
        constexpr const char* kKinds[] = {"scenes", "parts", "states", "tables"};
        py::dict d;
        d["kind"] = kKinds[static_cast<std::size_t>(file.kind)];
        d["read"] = file.read;
        d["broken"] = file.broken;
        return d;
      },
      py::arg("seed"), py::arg("directory"),
      "Damage a file and try to read it; `broken`: what went wrong, or an empty text.");
}

}  // namespace motes::bindings
