#include "engine/session/report.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "base/fields.h"

namespace motes::engine {

using base::Bytes;
using base::Reader;

namespace {

template <class T>
T read_new(Reader& in) {
  T value;
  base::read_fields(in, value);
  return value;
}

template <class T>
void append(std::vector<T>& to, std::vector<T>&& more) {
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

void join(std::vector<recording::Event>& into, const std::vector<recording::Event>& other) {
  const auto middle = static_cast<std::ptrdiff_t>(into.size());
  into.insert(into.end(), other.begin(), other.end());
  std::inplace_merge(into.begin(), into.begin() + middle, into.end(),
                     [](const recording::Event& a, const recording::Event& b) { return a.id < b.id; });
}

// Merges two ordered lists, and adds up the forces on the same wall.
void join(std::vector<WallForce>& into, const std::vector<WallForce>& other) {
  const auto before = [](const WallForce& a, const WallForce& b) {
    return std::tie(a.system, a.item, a.wall) < std::tie(b.system, b.item, b.wall);
  };
  std::vector<WallForce> all;
  std::merge(into.begin(), into.end(), other.begin(), other.end(), std::back_inserter(all), before);
  into.clear();
  for (const WallForce& force : all) {
    if (into.empty() || before(into.back(), force)) {
      into.push_back(force);
    } else {
      into.back().sum += force.sum;
    }
  }
}

void join(SystemReport& into, const SystemReport& other) {
  into.particles += other.particles;
  into.strain.most_in_a_cell = std::max(into.strain.most_in_a_cell, other.strain.most_in_a_cell);
  into.strain.overlap_99 = std::max(into.strain.overlap_99, other.strain.overlap_99);
  into.strain.substeps = std::max(into.strain.substeps, other.strain.substeps);
  into.digest += other.digest;
  into.oldest = std::min(into.oldest, other.oldest);
  into.events.resize(std::max(into.events.size(), other.events.size()));
  for (std::size_t rule = 0; rule < other.events.size(); ++rule) join(into.events[rule], other.events[rule]);
}

void join(PhaseTimes& into, const PhaseTimes& other) {
  for (const auto seconds : {&PhaseTimes::create, &PhaseTimes::act, &PhaseTimes::report, &PhaseTimes::exchange,
                             &PhaseTimes::balance, &PhaseTimes::render, &PhaseTimes::project, &PhaseTimes::draw,
                             &PhaseTimes::assemble, &PhaseTimes::wait, &PhaseTimes::frame}) {
    into.*seconds = std::max(into.*seconds, other.*seconds);
  }
}

void join(Drawings& into, Drawings&& other) {
  if (into.width == 0) {
    into.width = other.width;
    into.height = other.height;
    into.path = other.path;
    into.order = other.order;
  }
  into.records += other.records;
  into.record_bytes += other.record_bytes;
  into.sent += other.sent;
  into.bytes += other.bytes;
  into.assemble_s += other.assemble_s;  // nonzero on one rank only
  append(into.active, std::move(other.active));
  append(into.tiles, std::move(other.tiles));
  into.sighted.resize(std::max(into.sighted.size(), other.sighted.size()));
  for (std::size_t i = 0; i < other.sighted.size(); ++i) into.sighted[i] = std::max(into.sighted[i], other.sighted[i]);
}

void join(Tail& into, Tail&& other) {
  if (into.valid != other.valid || into.frame != other.frame) {
    throw std::runtime_error("reports are about different frames");
  }
  join(into.times, other.times);
  into.ended_s = std::max(into.ended_s, other.ended_s);
  into.exchanged_bytes += other.exchanged_bytes;
  into.moved += other.moved;
  into.children.resize(std::max(into.children.size(), other.children.size()));
  for (std::size_t i = 0; i < other.children.size(); ++i) into.children[i] += other.children[i];
  join(into.drawings, std::move(other.drawings));
  if (into.image_sha256.empty()) into.image_sha256 = std::move(other.image_sha256);
}

}  // namespace

Drawings drawings_of(Drawing drawing, int rank, bool calculates) {
  Drawings one{drawing.width,
               drawing.height,
               drawing.path,
               drawing.order,
               drawing.records,
               drawing.record_bytes,
               drawing.sent,
               drawing.bytes,
               drawing.assemble_s,
               {},
               {},
               std::move(drawing.sighted)};
  if (drawing.width == 0) return one;
  if (calculates) one.active.push_back(drawing.active);
  if (!drawing.counts.empty()) {
    one.tiles.push_back({drawing.first, std::move(drawing.counts), rank, static_cast<float>(drawing.draw_s)});
  }
  return one;
}

void join(Report& into, Report&& other) {
  const bool failed = into.failed() || other.failed();
  append(into.dissents, std::move(other.dissents));
  into.stop = std::max(into.stop, other.stop);
  into.unsaved_from = std::min(into.unsaved_from, other.unsaved_from);
  into.orders += other.orders;  // nonempty on one rank only
  if (other.failure.failed() && (!into.failure.failed() || other.failed_rank < into.failed_rank)) {
    into.failure = std::move(other.failure);
    into.failed_rank = other.failed_rank;
  }
  if (failed) return;
  if (into.systems.empty()) into.systems.resize(other.systems.size());
  if (!other.systems.empty() && into.systems.size() != other.systems.size()) {
    throw std::runtime_error("reports are about different systems");
  }
  for (std::size_t i = 0; i < other.systems.size(); ++i) join(into.systems[i], other.systems[i]);
  append(into.flows, std::move(other.flows));
  append(into.decisions, std::move(other.decisions));
  join(into.walls, other.walls);
  join(into.tail, std::move(other.tail));
}

void write(const Report& report, Bytes& out) { base::write_fields(report, out); }
void write(const Judgement& judgement, Bytes& out) { base::write_fields(judgement, out); }
void write(const Planned& planned, Bytes& out) { base::write_fields(planned, out); }
void write(const Inquiry& inquiry, Bytes& out) { base::write_fields(inquiry, out); }
void write(const Proposal& proposal, Bytes& out) { base::write_fields(proposal, out); }

Report read_report(Reader& in) { return read_new<Report>(in); }
Judgement read_judgement(Reader& in) { return read_new<Judgement>(in); }
Planned read_planned(Reader& in) { return read_new<Planned>(in); }
Inquiry read_inquiry(Reader& in) { return read_new<Inquiry>(in); }
Proposal read_proposal(Reader& in) { return read_new<Proposal>(in); }

}  // namespace motes::engine
