#include "engine/session/spans.h"

#include <cstdio>

namespace motes::engine {
namespace {

std::string path_of(const std::string& directory, int rank) {
  char name[32];
  std::snprintf(name, sizeof name, "/spans.r%04d.jsonl", rank);
  return directory + name;
}

}  // namespace

Spans::Spans(const std::string& directory, int rank, double zero, std::uint64_t first_frame)
    : table_(path_of(directory, rank), 256, first_frame), zero_(zero) {}

void Spans::add(std::uint64_t frame, const char* phase, const std::string& system, double start, double end,
                std::optional<double> cpu_s) {
  jsonl::JsonlRow row;
  row.field("frame", frame).field("phase", std::string(phase)).field("system", system);
  row.field("start_s", start - zero_).field("end_s", end - zero_);
  if (cpu_s) {
    row.field("cpu_s", *cpu_s);
  } else {
    row.null("cpu_s");
  }
  table_.add(row);
}

void Spans::add_wait(std::uint64_t frame, const char* phase, int rank, double start, double end) {
  jsonl::JsonlRow row;
  row.field("frame", frame).field("phase", std::string("wait")).field("system", std::string());
  row.field("start_s", start - zero_).field("end_s", end - zero_).null("cpu_s");
  row.field("waited_for", rank).field("message", std::string(phase));
  table_.add(row);
}

}  // namespace motes::engine
