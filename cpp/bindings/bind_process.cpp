// What the process itself does when a rank fails: the crash report and the end of the process.
#include "bindings/bindings.h"
#include "comm/last_words.h"
#include "comm/watchdog.h"

namespace motes::bindings {

void bind_process(py::module_& m) {
  m.def("name_crashes", &comm::name_crashes, py::arg("mark"));
  m.def("set_place", &comm::set_place, py::arg("place"));
  m.def("end_process_after", &comm::end_process_after, py::arg("seconds"), py::arg("code"));
}

}  // namespace motes::bindings
