#include "engine/session/stopwatch.h"

#include <utility>

#include "comm/clock.h"

namespace motes::engine {

Stopwatch::Phase::Phase(Stopwatch& watch, double PhaseTimes::* seconds, const char* phase, std::string system)
    : watch_(watch), seconds_(seconds), phase_(phase), system_(std::move(system)), start_(comm::wall_seconds()),
      cpu_start_(watch.spans_ ? comm::cpu_seconds() : 0) {}

Stopwatch::Phase::~Phase() {
  const double end = comm::wall_seconds();
  watch_.now_.*seconds_ += end - start_;
  if (!watch_.spans_ || !watch_.in_frame_) return;
  watch_.spans_->add(watch_.frame_, phase_, system_, start_, end, comm::cpu_seconds() - cpu_start_);
}

void Stopwatch::start() { frame_start_s_ = comm::wall_seconds(); }

void Stopwatch::begin(std::uint64_t frame, bool in_frame, double waited_s) {
  now_ = {};
  frame_ = frame;
  in_frame_ = in_frame;
  waited_before_s_ = waited_s;
}

void Stopwatch::end(double waited_s) {
  const double now = comm::wall_seconds();
  now_.wait = waited_s - waited_before_s_;
  now_.frame = now - frame_start_s_;
  now_.render += now_.project + now_.draw + now_.assemble;
  frame_start_s_ = now;
  last_ = now_;
}

void Stopwatch::keep_spans(const std::string& directory, int rank, double zero, std::uint64_t first_frame) {
  spans_ = std::make_unique<Spans>(directory, rank, zero, first_frame);
}

void Stopwatch::note_messages(const std::string& system, double start) {
  if (spans_ && in_frame_) spans_->add(frame_, "messages", system, start, comm::wall_seconds(), std::nullopt);
}

void Stopwatch::write_spans() {
  if (spans_) spans_->write();
}

}  // namespace motes::engine
