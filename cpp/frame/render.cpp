#include "frame/render.h"

#include "frame/drawn.h"

namespace motes::frame {
namespace {

void send_records(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter) {
  Conversation& talk = rank.talk;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "project");
  const double start = rank.machine.compute_seconds();
  comm::Message message;
  std::uint64_t projected = 0;
  talk.work("render", [&] {
    for (std::size_t i = 0; i < script.systems.size(); ++i) {
      const particles::Store& store = calculator.populations[i]->store;
      painter.projector.project(drawn(store), script.systems[i]->sprite, *script.record.view, painter.records,
                                projection(script, i));
      const auto bytes = painter.records.bytes();
      message.bytes().put(static_cast<std::uint64_t>(bytes.size()));
      message.bytes().put_raw(bytes.data(), bytes.size());
      projected += store.size();
    }
    if (!talk.draws()) rank.machine.charge(rank.machine.costs().record * static_cast<double>(projected));
  });
  rank.machine.slow_down(start);
  if (talk.failed()) {
    message = comm::Message();
    message.bytes().put_text(talk.failure().action);
    message.bytes().put_text(talk.failure().text);
  }
  talk.comm().post(talk.cast().image_generator, comm::Phase::records, talk.stamp(), std::move(message), projected,
                   talk.failed());
  if (rank.settings.blocking) talk.comm().flush();
}

// No frame without a calculator's part may reach the script: here the run is over, for the reason that it gives.
[[noreturn]] void report_failure(Rank& rank, int from, const comm::Message& message) {
  particles::Reader in = message.reader();
  Verdict verdict;
  verdict.failed_rank = from;
  verdict.failure = {Failure::Kind::compute, in.get_text(), in.get_text()};
  rank.talk.give_up(std::move(verdict));
}

// What all calculators sent, and how many particles it stands for.
std::vector<comm::Message> receive_records(Rank& rank, double& particles) {
  std::vector<comm::Message> messages;
  for (const int from : rank.talk.cast().calculators) {
    messages.push_back(rank.talk.comm().expect(from, comm::Phase::records, rank.talk.stamp()));
    if (messages.back().header().failed != 0 && from != rank.talk.rank()) report_failure(rank, from, messages.back());
    const auto count = static_cast<double>(messages.back().header().count);
    if (from != rank.talk.rank()) rank.machine.charge(rank.machine.costs().collect * count);
    particles += count;
  }
  return messages;
}

void draw(Rank& rank, const Script& script, Painter& painter) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "draw");
  double particles = 0;
  const std::vector<comm::Message> messages = receive_records(rank, particles);
  rank.talk.work("render", [&] {
    painter.canvas.begin(*script.record.view, script.record.view->linear);
    for (const comm::Message& message : messages) {
      for (particles::Reader in = message.reader(); !in.done();) painter.canvas.add(in.take(in.get<std::uint64_t>()));
    }
    painter.pixels = painter.canvas.finish();
    rank.machine.charge(rank.machine.costs().draw * particles);
    rank.machine.charge_once(rank.machine.costs().picture);
  });
}

}  // namespace

void render(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter) {
  if (!script.record.view) return;
  if (rank.talk.calculates()) send_records(rank, script, calculator, painter);
  if (rank.talk.draws()) draw(rank, script, painter);
}

}  // namespace motes::frame
