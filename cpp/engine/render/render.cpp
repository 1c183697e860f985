#include "engine/render/render.h"

#include <stdexcept>

#include "engine/render/draw_work.h"
#include "engine/render/render_bloom.h"
#include "engine/render/render_costs.h"
#include "engine/render/render_project.h"
#include "engine/render/render_shadows.h"
#include "engine/render/render_tiles.h"

namespace motes::engine {
namespace {

using Path = image::View::Path;

std::size_t bytes_of(const image::View& view) {
  return std::size_t{3} * static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
}

// Image generator: receives the calculators' records, and adds their number to `records`.
std::vector<comm::Message> receive_all(Rank& rank, double& records) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "wait for records");
  std::vector<comm::Message> messages;
  for (const int from : rank.session.cast().calculators) {
    if (from == rank.session.rank()) continue;
    messages.push_back(rank.session.comm().expect(from, comm::Phase::records, rank.session.stamp()));
    // A frame that lacks a calculator's part must not reach the script: end the run with that calculator's failure.
    if (messages.back().header().failed != 0) give_up_for(rank, messages.back());
    const auto count = static_cast<double>(messages.back().header().count);
    rank.machine.charge(rank.machine.costs().collect * count);
    records += count;
  }
  return messages;
}

// Path gather: the image generator draws the whole picture.
void draw_all(Rank& rank, const image::View& view, Painter& painter) {
  double records = static_cast<double>(painter.drawing.records);  // this rank's
  const std::vector<comm::Message> messages = receive_all(rank, records);
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::draw, "draw");
  draw_work(rank, view, [&] {
    Drawing& drawing = painter.drawing;
    drawing.counts.assign(static_cast<std::size_t>(image::Grid{view.width, view.height}.tiles()), 0);
    if (rank.session.calculates()) drawing.counts = painter.counts;
    painter.canvas.begin(view, view.linear, *rank.pool, painter.shadows.get());
    for (const image::Records& own : painter.records) painter.canvas.add(own.bytes());
    const auto add = [&](std::span<const std::byte> bytes) {
      painter.canvas.add(bytes);
      image::RecordsView(bytes).add_counts(drawing.counts);
    };
    for (const comm::Message& message : messages) {
      base::Reader in = message.reader();
      take_records(in, add);
      if (!in.done()) throw std::runtime_error("a message has data after its sender's records");
    }
    painter.pixels = painter.canvas.finish();
    rank.machine.charge(rank.machine.costs().draw * records);
    const double passes = render_costs::passes(view) + render_costs::spreading(view);
    rank.machine.charge_once(rank.machine.costs().picture * passes);
  });
}

// Sets up the picture's shared memory before other ranks look for it.
void share_memory(Rank& rank, const image::View& view, Painter& painter) {
  const image::Grid grid{view.width, view.height};
  const std::size_t bytes = view.linear ? image::PictureLight::bytes(grid) : bytes_of(view);
  painter.shared.interact(rank, bytes, painter.plan);
  if (!rank.session.draws()) return;
  std::shared_ptr<std::uint8_t[]> memory = painter.shared.open(bytes, rank.session.stamp());
  draw_work(rank, view, [&] {
    if (view.linear) {
      painter.whole.begin(grid, std::move(memory));
    } else if (memory) {
      painter.pixels = {std::move(memory), bytes};
    }
  });
}

// Prepares for drawing tiles on the paths tiles and composite: the scene, the picture's memory, this rank's records.
void open_tiles(Rank& rank, const image::View& view, Painter& painter) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::draw, "open tiles");
  draw_work(rank, view, [&] {
    painter.scene.prepare(view, static_cast<std::size_t>(rank.pool->threads()), painter.shadows.get());
    painter.workers.begin(painter.scene, rank.pool->threads());
    painter.pieces.begin(view, painter.slots);
    if (view.bloom > 0) open_bloom(rank, view, painter);
    for (const image::Records& own : painter.records) painter.pieces.add(own.bytes());
    if (!rank.session.draws()) return;
    painter.pixels.resize(bytes_of(view));
    painter.layers.begin(view);
  });
}

// Announces all expected messages, so they can arrive while this rank projects or draws.
void await_all(Rank& rank, const image::View& view, const Painter& painter) {
  Session& session = rank.session;
  if (painter.plan.draws(session.rank())) {
    for (const int from : session.cast().calculators) session.comm().await(from, comm::Phase::records);
  }
  if (painter.plan.path == Path::gather) return;
  if (view.bloom > 0) await_glow(rank, painter);
  if (session.draws()) await_tiles(rank, view, painter);
}

}  // namespace

std::vector<float> Painter::linear() const {
  if (!light_kept) throw std::logic_error("the last picture's light was not kept: its view does not request it");
  return plan.path == Path::gather ? canvas.linear() : whole.linear();
}

const std::vector<float>& Painter::layer(std::uint8_t bit) const {
  return (plan.path == Path::gather ? canvas.layers() : layers).layer(bit);
}

void render(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter) {
  painter.drawing = {};
  painter.light_kept = false;
  if (!script.record.view) return;
  const Session& session = rank.session;
  const image::View& view = *script.record.view;
  if (!painter.plan.covers(image::Grid{view.width, view.height}.tiles(), session.size())) {
    throw std::logic_error("the plan belongs to a different picture");  // on all ranks, which share the plan
  }
  painter.drawing.width = view.width;
  painter.drawing.height = view.height;
  painter.drawing.path = painter.plan.path;
  painter.drawing.order = painter.plan.order;
  painter.merged.reset();
  if (painter.plan.path == Path::composite) painter.merged = merged_blend(view, script.record.sprites);
  painter.slots = slots_of(painter.plan.order, {view.width, view.height});
  if (painter.plan.path != Path::gather) share_memory(rank, view, painter);
  await_all(rank, view, painter);
  gather_shadows(rank, script, calculator, painter);
  if (session.calculates()) project(rank, script, calculator, painter);
  if (painter.plan.path == Path::gather) {
    if (session.calculates()) send_records(rank, painter);
    if (session.draws()) draw_all(rank, view, painter);
  } else {
    open_tiles(rank, view, painter);
    if (session.calculates()) send_records(rank, painter);
    draw_tiles(rank, view, painter);
    if (view.bloom > 0) {
      spread_glow(rank, view, painter);
      show_tiles(rank, view, painter);
    }
    if (session.draws()) assemble(rank, view, painter);
  }
  painter.light_kept = view.linear && session.draws() && !session.failed();
}

}  // namespace motes::engine
