// What ranks tell each other about a frame: their reports to the manager, and its verdict to all. Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "balance/cuts.h"
#include "frame/render_order.h"
#include "image/scene.h"
#include "particles/bytes.h"
#include "particles/digest.h"
#include "recording/spawn.h"

namespace motes::frame {

/// Seconds that a rank spent in each phase of a frame.
struct PhaseTimes {
  double create = 0;    // births made, dealt, received
  double act = 0;       // the recorded list, fused
  double report = 0;    // report and verdict, with the wait for the slowest
  double exchange = 0;  // particles to their owners
  double balance = 0;   // cuts moved
  double render = 0;    // the picture: the three below, and waits for what others do for it
  double project = 0;   // particles to records, on their way
  double draw = 0;      // records to pixels
  double assemble = 0;  // tiles of all ranks to one picture
  double wait = 0;      // of all these: waiting for messages
  double frame = 0;     // the whole frame, the script's own part included
};

template <class Visitor>
constexpr void fields(Visitor& visit, PhaseTimes& times) {
  visit(times.create, times.act, times.report, times.exchange, times.balance, times.render, times.project, times.draw,
        times.assemble, times.wait, times.frame);
}

/// An item of a list: of which system, and how many calls of the script came before it in the list; -1 where it is not
/// known.
struct ItemPlace {
  std::int32_t system = -1;
  std::int32_t item = -1;
};

template <class Visitor>
constexpr void fields(Visitor& visit, ItemPlace& place) {
  visit(place.system, place.item);
}

/// Why a rank could not compute its part.
struct Failure {
  enum class Kind : std::uint8_t { none, compute, mismatch };
  Kind kind = Kind::none;
  std::string action;  // what it was doing
  std::string text;
  ItemPlace place{};  // the item that it was doing it for

  bool failed() const { return kind != Kind::none; }
};

template <class Visitor>
constexpr void fields(Visitor& visit, Failure& failure) {
  visit(failure.kind, failure.action, failure.text, failure.place);
}

/// Particles on their way to one domain.
struct Sent {
  std::int32_t domain = 0;
  std::uint64_t count = 0;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Sent& sent) {
  visit(sent.domain, sent.count);
}

/// What happened to one system on one calculator in a frame.
struct Tally {
  std::uint64_t at_start = 0;
  std::uint64_t created = 0;
  std::uint64_t killed = 0;
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t bytes_sent = 0;
  double compute_s = 0;
};

/// A particle that has children at the end of this frame, for the calculator that they belong to.
struct Parent {
  std::int32_t system = 0;   // the parent's
  std::int32_t rule = 0;     // its number among that system's spawn rules
  std::uint64_t first = 0;   // number of its first child among all of the frame, in the children's system
  recording::Event event;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Parent& parent) {
  visit(parent.system, parent.rule, parent.first, parent.event);
}

/// One system on one calculator: after its list ran, before the exchange.
struct SystemReport {
  std::uint64_t at_start = 0;
  std::uint64_t created = 0;
  std::uint64_t killed = 0;
  std::uint64_t kept = 0;
  double compute_s = 0;
  std::vector<Sent> sent;
  particles::Digest digest;
  std::uint64_t oldest = UINT64_MAX;  // the lowest id, where the birth history asks for it
  std::vector<std::vector<recording::Event>> events;  // one list per spawn rule
};

template <class Visitor>
constexpr void fields(Visitor& visit, SystemReport& system) {
  visit(system.at_start, system.created, system.killed, system.kept, system.compute_s, system.sent, system.digest,
        system.oldest, system.events);
}

/// Where a calculator's particles of one system are, for the log.
inline constexpr int kQuantiles = 16;
struct Density {
  std::uint64_t particles = 0;
  float quantiles[kQuantiles + 1] = {};  // metres along the system's axis
};

template <class Visitor>
constexpr void fields(Visitor& visit, Density& density) {
  visit(density.particles, density.quantiles);
}

/// What a rank did for a frame's picture.
struct Drawing {
  std::int32_t width = 0, height = 0;  // pixels; 0: the frame had no picture
  image::View::Path path = image::View::Path::gather;
  std::uint64_t records = 0;  // of its own particles
  std::uint64_t sent = 0;     // those that went to other ranks, as they are or drawn
  std::uint64_t bytes = 0;    // sent to other ranks
  std::uint32_t active = 0;   // tiles that its own particles touch
  TileOrder order = TileOrder::rows;
  std::uint32_t first = 0;            // the first slot that it drew
  std::vector<std::uint32_t> counts;  // records in each slot that it drew
};

template <class Visitor>
constexpr void fields(Visitor& visit, Drawing& drawing) {
  visit(drawing.width, drawing.height, drawing.path, drawing.records, drawing.sent, drawing.bytes, drawing.active,
        drawing.order, drawing.first, drawing.counts);
}

/// What became known too late for the report of its own frame: it is sent with the next one.
struct Tail {
  bool valid = false;
  std::uint64_t frame = 0;
  PhaseTimes times;
  std::vector<std::uint64_t> bytes_sent;  // exchange, one per system
  std::vector<Density> density;           // one per system, where there is a log
  std::vector<particles::Digest> children;  // born at the frame's end; one per system, where the log has digests
  Drawing drawing;
  std::string image_sha256;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Tail& tail) {
  visit(tail.valid, tail.frame, tail.times, tail.bytes_sent, tail.density, tail.children, tail.drawing,
        tail.image_sha256);
}

struct Report {
  Failure failure;
  particles::Bytes record;  // the sender's recorded list, where it differs from the manager's
  std::vector<SystemReport> systems;
  Tail tail;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Report& report) {
  visit(report.failure, report.record, report.systems, report.tail);
}

/// What a calculator is asked for before cuts move: this many particles at most for a neighbour, or where all of
/// its particles are.
struct Request {
  enum class Kind : std::uint32_t { give_left, give_right, histogram };
  std::int32_t system = 0;
  Kind kind = Kind::histogram;
  std::uint64_t count = 0;  // particles, or bins of the histogram
};

template <class Visitor>
constexpr void fields(Visitor& visit, Request& request) {
  visit(request.system, request.kind, request.count);
}

/// The answer.
struct Proposal {
  Request request;
  balance::Gift gift;
  balance::Histogram histogram;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Proposal& proposal) {
  visit(proposal.request, proposal.gift, proposal.histogram);
}

struct Verdict {
  Failure failure;
  std::int32_t failed_rank = -1;
  std::vector<std::int32_t> ranks;      // kind mismatch: those whose lists differ from most
  std::vector<std::uint64_t> alive;     // one per system, over all ranks
  std::vector<particles::Digest> digests;
  std::vector<std::uint64_t>
      spawned;   // one per system: children at the end of this frame, before the capacity limits them
  std::vector<std::uint64_t> oldest;    // one per system: the lowest id on any rank, where the birth history asks
};

template <class Visitor>
constexpr void fields(Visitor& visit, Verdict& verdict) {
  visit(verdict.failure, verdict.failed_rank, verdict.ranks, verdict.alive, verdict.digests, verdict.spawned,
        verdict.oldest);
}

/// What the verdict says to one rank alone.
struct Orders {
  std::vector<std::int32_t> sources;  // ranks that will send it particles
  std::vector<Parent> parents;        // whose children belong to it

  void clear() {
    sources.clear();
    parents.clear();
  }
};

template <class Visitor>
constexpr void fields(Visitor& visit, Orders& orders) {
  visit(orders.sources, orders.parents);
}

/// What the manager planned in a round, for all ranks.
struct Planned {
  Failure failure;    // the balancer's: all give up
  bool asks = false;  // some calculator has an inquiry: all say what they propose
};

template <class Visitor>
constexpr void fields(Visitor& visit, Planned& planned) {
  visit(planned.failure, planned.asks);
}

/// What the plan asks of one calculator, before cuts move.
struct Inquiry {
  std::vector<Request> requests;
  std::vector<std::int32_t> partners;  // neighbouring calculators to compare loads with, ascending

  bool empty() const { return requests.empty() && partners.empty(); }
};

template <class Visitor>
constexpr void fields(Visitor& visit, Inquiry& inquiry) {
  visit(inquiry.requests, inquiry.partners);
}

void write(const Report& report, particles::Bytes& out);
/// Reads over an earlier report, and reuses its memory.
void read(particles::Reader& in, Report& report);
void write(const Verdict& verdict, particles::Bytes& out);
Verdict read_verdict(particles::Reader& in);
void write(const Orders& orders, particles::Bytes& out);
Orders read_orders(particles::Reader& in);
void write(const Planned& planned, particles::Bytes& out);
Planned read_planned(particles::Reader& in);
void write(const Inquiry& inquiry, particles::Bytes& out);
Inquiry read_inquiry(particles::Reader& in);
void write(const Proposal& proposal, particles::Bytes& out);
Proposal read_proposal(particles::Reader& in);

}  // namespace motes::frame
