#include "bindings/bindings.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "The engine of motes. Scripts use the package motes, which adds defaults, types and documentation.";
  motes::bindings::bind_errors(m);
  motes::bindings::bind_shapes(m);
  motes::bindings::bind_recording(m);
  motes::bindings::bind_image(m);
  motes::bindings::bind_balance(m);
  motes::bindings::bind_snapshots(m);
  motes::bindings::bind_engine(m);
  motes::bindings::bind_process(m);
#ifdef MOTES_LAB
  auto lab = m.def_submodule("lab", "Benchmarks of the engine, and simulated disasters, for the package motes_lab.");
  motes::bindings::bind_bench(lab);
  motes::bindings::bind_soak(lab);
#endif
}
