// Checkpoints: the state that all ranks share as bytes, and parts to disk and back.
#include "base/crc32c.h"
#include "bindings/bindings.h"
#include "engine/recovering_engine.h"
#include "snapshots/file.h"

namespace motes::bindings {
namespace {

using Engine = engine::RecoveringEngine;
using snapshots::PartFile;

py::bytes as_bytes(const base::Bytes& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

std::span<const std::byte> span_of(const py::bytes& bytes) {
  const std::string_view text = bytes;
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

std::vector<std::pair<std::string, std::uint64_t>> rows_of(const PartFile& part) {
  std::vector<std::pair<std::string, std::uint64_t>> rows;
  for (const snapshots::SavedSystem& system : part.description().systems) rows.emplace_back(system.name, system.rows);
  return rows;
}

engine::Sample sample_of(const PartFile& part, std::size_t system, std::size_t most) {
  engine::Sample sample;
  engine::take_sample(part.description(), part.planes(), system, most, sample);
  return sample;
}

// Returns whether a part is being written, the newest frame whose part is on disk, and the error of the last one.
std::tuple<bool, std::optional<std::uint64_t>, std::string> outcome_of(const Engine& engine) {
  const snapshots::Writer::Outcome outcome = engine.part_writer().outcome();
  return {engine.part_writer().busy(), outcome.written, outcome.error};
}

}  // namespace

void bind_snapshots(py::module_& m) {
  m.def("crc32c", [](const py::bytes& bytes) { return base::crc32c(span_of(bytes)); });
  py::class_<PartFile>(m, "PartFile")
      .def(py::init<const std::string&, bool>(), py::arg("path"), py::arg("sums"), Release())
      .def_property_readonly("frame", [](const PartFile& part) { return part.description().frame; })
      .def_property_readonly("part", [](const PartFile& part) { return part.description().part; })
      .def_property_readonly("rows", &rows_of)
      .def("sample", &sample_of, py::arg("system"), py::arg("most"));
}

void bind_saving(py::class_<Engine>& engine) {
  engine.def("shared_state", [](const Engine& e) { return as_bytes(e.shared_state()); })
      .def("save_part", &Engine::save_part, py::arg("path"), Release())
      .def("part_outcome", &outcome_of)
      .def(
          "wait_for_part", [](Engine& e) { e.part_writer().wait(); }, Release())
      .def(
          "restore_state",
          [](Engine& e, const py::bytes& state, const std::vector<engine::Sample>& samples) {
            e.restore_state(span_of(state), samples);
          },
          py::arg("state"), py::arg("samples"))
      .def(
          "restore_rows",
          [](Engine& e, const PartFile& part, std::size_t system, std::uint64_t first, std::uint64_t last) {
            e.restore_rows(part.description(), part.planes(), system, first, last);
          },
          py::arg("part"), py::arg("system"), py::arg("first"), py::arg("last"), Release())
      .def(
          "restore_speeds", [](Engine& e, const PartFile& part) { e.restore_speeds(part.description()); },
          py::arg("part"));
}

}  // namespace motes::bindings
