#include "engine/session/stopwatch.h"

#include <utility>

#include "comm/clock.h"

namespace motes::engine {
namespace {

comm::Activity activity_of(double PhaseTimes::* seconds) {
  if (seconds == &PhaseTimes::create) return comm::Activity::births;
  if (seconds == &PhaseTimes::act) return comm::Activity::act;
  for (const auto picture : {&PhaseTimes::render, &PhaseTimes::project, &PhaseTimes::draw, &PhaseTimes::assemble}) {
    if (seconds == picture) return comm::Activity::picture;
  }
  return comm::Activity::talk;
}

}  // namespace

Stopwatch::Phase::Phase(Stopwatch& watch, double PhaseTimes::* seconds, const char* phase, std::string system)
    : watch_(watch), seconds_(seconds), phase_(phase), system_(std::move(system)),
      turn_(watch.ledger_, activity_of(seconds)), start_(comm::wall_seconds()),
      cpu_start_(watch.spans_ ? comm::cpu_seconds() : 0) {}

Stopwatch::Phase::~Phase() {
  const double end = comm::wall_seconds();
  watch_.now_.*seconds_ += end - start_;
  if (!watch_.spans_ || !watch_.in_frame_) return;
  watch_.spans_->add(watch_.frame_, phase_, system_, start_, end, comm::cpu_seconds() - cpu_start_);
}

void Stopwatch::begin(std::uint64_t frame, bool in_frame, double waited_s) {
  now_ = {};
  frame_ = frame;
  in_frame_ = in_frame;
  waited_before_s_ = waited_s;
}

void Stopwatch::end(double waited_s) {
  now_.wait = waited_s - waited_before_s_;
  now_.render += now_.project + now_.draw + now_.assemble;
  spent_ = ledger_.take();
  now_.frame = spent_.wall_s;
  last_ = now_;
}

void Stopwatch::keep_spans(const std::string& directory, int rank, double zero, std::uint64_t first_frame) {
  spans_ = std::make_unique<Spans>(directory, rank, zero, first_frame);
  ledger_.on_wait([this](const comm::Waited& wait, double start, double end) {
    spans_->add_wait(frame_, comm::name(static_cast<comm::Phase>(wait.phase)), wait.sender, start, end);
  });
}

void Stopwatch::note_messages(const std::string& system, double start) {
  if (spans_ && in_frame_) spans_->add(frame_, "messages", system, start, comm::wall_seconds(), std::nullopt);
}

void Stopwatch::write_spans() {
  if (spans_) spans_->write();
}

}  // namespace motes::engine
