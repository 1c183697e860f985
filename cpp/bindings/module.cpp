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
  motes::bindings::bind_bench(m);
  motes::bindings::bind_soak(m);
}
