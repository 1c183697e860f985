// What the process itself does when a rank fails or is asked to stop: crash report, signals, exit.
#include "bindings/bindings.h"
#include "comm/last_words.h"
#include "comm/stop_signals.h"
#include "comm/watchdog.h"

namespace motes::bindings {

void bind_process(py::module_& m) {
  m.def("name_crashes", &comm::name_crashes, py::arg("mark"), py::arg("lost_line"));
  m.def("set_place", &comm::set_place, py::arg("place"));
  m.def("end_process_after", &comm::end_process_after, py::arg("seconds"), py::arg("code"));
  m.def("note_stop_signals", &comm::note_stop_signals, py::arg("signals"), py::arg("same_s"), py::arg("speaks"));
  m.def("stop_signal", &comm::stop_signal);
  m.def("forget_stop_signal", &comm::forget_stop_signal);
  m.def("release_stop_signals", &comm::release_stop_signals);
  m.def("end_with_code", &comm::end_with_code, py::arg("code"));
}

}  // namespace motes::bindings
