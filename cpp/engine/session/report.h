// Plain structs that ranks exchange about a frame: reports to the manager, and its verdict.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "balance/cells.h"
#include "balance/cuts.h"
#include "base/bytes.h"
#include "comm/ledger.h"
#include "engine/session/drawings.h"
#include "interactions/wall_sums.h"
#include "particles/digest.h"
#include "recording/spawn.h"

namespace motes::engine {

/// Seconds that a rank spent in each phase of a frame.
struct PhaseTimes {
  double create = 0;    // create, deal and receive births
  double act = 0;       // run the recorded list
  double report = 0;    // report and verdict, including the wait for the slowest rank
  double exchange = 0;  // send particles to their owners
  double balance = 0;   // move cuts
  double render = 0;    // the picture: project, draw, assemble, and waits for other ranks
  double project = 0;   // turn particles into records and send them
  double draw = 0;      // draw records
  double assemble = 0;  // assemble the tiles of all ranks
  double wait = 0;      // the part of all phases spent waiting for messages
  double frame = 0;     // from the end of the last frame to the end of this one, including the script
};

template <class Visitor>
constexpr void fields(Visitor& visit, PhaseTimes& times) {
  visit(times.create, times.act, times.report, times.exchange, times.balance, times.render, times.project, times.draw,
        times.assemble, times.wait, times.frame);
}

/// The place of an item: its system, and the number of script calls before it in the system's list; -1: unknown.
struct ItemPlace {
  std::int32_t system = -1;
  std::int32_t item = -1;
};

template <class Visitor>
constexpr void fields(Visitor& visit, ItemPlace& place) {
  visit(place.system, place.item);
}

/// Why a rank failed.
struct Failure {
  enum class Kind : std::uint8_t { none, compute, mismatch };
  Kind kind = Kind::none;
  std::string action;  // what the rank was doing
  std::string text;
  ItemPlace place{};  // the list item it was running

  bool failed() const { return kind != Kind::none; }
};

template <class Visitor>
constexpr void fields(Visitor& visit, Failure& failure) {
  visit(failure.kind, failure.action, failure.text, failure.place);
}

/// The number of migrants to one domain.
struct Sent {
  std::int32_t domain = 0;
  std::uint64_t count = 0;
};

/// Counts of one system on one calculator in a frame.
struct Tally {
  std::uint64_t at_start = 0;
  std::uint64_t created = 0;
  std::uint64_t killed = 0;
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t bytes_sent = 0;
  double compute_s = 0;
};

/// Statistics of one system's pair interactions on one calculator in a frame. Interactions between two systems count
/// for the first.
struct InteractionStats {
  std::uint64_t pairs = 0;   // pairs within reach, counted once for each of the two particles
  std::uint64_t ghosts = 0;  // sent to other calculators
  std::uint64_t bytes = 0;   // bytes sent in interactions: ghosts and migrants
  std::uint64_t moved_in = 0, moved_out = 0;  // migrants in interactions
  std::uint32_t interactions = 0;
  std::uint32_t most_in_a_cell = 0;
  float interact_s = 0, wait_s = 0;  // seconds in interactions, waits included; seconds of those waits
  float overlap_99 = 0;          // see interactions/overlap.h
  std::uint16_t substeps = 0;    // fewest substeps per frame with which no spring of `contact` is softened
  std::uint16_t neighbour_ranks = 0;  // maximum number of calculators that an interaction sent messages to
};

template <class Visitor>
constexpr void fields(Visitor& visit, InteractionStats& interaction) {
  visit(interaction.pairs, interaction.ghosts, interaction.bytes, interaction.moved_in, interaction.moved_out,
        interaction.interactions, interaction.most_in_a_cell, interaction.interact_s, interaction.wait_s,
        interaction.overlap_99, interaction.substeps, interaction.neighbour_ranks);
}

/// Maxima over calculators of those statistics of a system's interactions that can cause a warning.
struct Strain {
  std::uint32_t most_in_a_cell = 0;
  float overlap_99 = 0;
  std::uint32_t substeps = 0;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Strain& strain) {
  visit(strain.most_in_a_cell, strain.overlap_99, strain.substeps);
}

/// A particle that has children at the end of this frame, as sent to the calculator that owns the children.
struct Parent {
  std::int32_t system = 0;   // the parent's system
  std::int32_t rule = 0;     // index among that system's spawn rules
  std::uint64_t first = 0;   // index of its first child among the frame's children in their system
  recording::Event event;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Parent& parent) {
  visit(parent.system, parent.rule, parent.first, parent.event);
}

/// One system on all calculators of a subtree, after its list has run and before the exchange.
struct SystemReport {
  std::uint64_t particles = 0;  // particles, migrants included
  Strain strain;
  particles::Digest digest;
  std::uint64_t oldest = UINT64_MAX;  // the lowest live id, if the birth history needs it
  std::vector<std::vector<recording::Event>> events;  // one list per spawn rule, sorted by id
};

template <class Visitor>
constexpr void fields(Visitor& visit, SystemReport& system) {
  visit(system.particles, system.strain, system.digest, system.oldest, system.events);
}

/// One system on one calculator, as the policy and the log need it. A rank holds fewer than 2^32 particles.
struct CalculatorLoad {
  std::uint32_t at_start = 0, created = 0, killed = 0, stayed = 0, sent = 0;
  std::uint32_t received = 0;  // added by the rank at which the senders' reports meet the receiver's
  double compute_s = 0;
  double speed = 0, error = 0;  // as in balance::Load
};

template <class Visitor>
constexpr void fields(Visitor& visit, CalculatorLoad& load) {
  visit(load.at_start, load.created, load.killed, load.stayed, load.sent, load.received, load.compute_s, load.speed,
        load.error);
}

/// The number of a system's migrants between two calculators.
struct Flow {
  std::uint32_t from = 0, to = 0;  // calculators
  std::uint32_t system = 0;        // index within the round
  std::uint32_t count = 0;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Flow& flow) {
  visit(flow.from, flow.to, flow.system, flow.count);
}

/// Seconds per particle that a calculator has needed so far for work that depends on the balancer.
struct Handling {
  struct Work {
    double particles = 0, seconds = 0;

    void add(std::size_t count, double took_s) {
      particles += static_cast<double>(count);
      seconds += took_s;
    }
    float each_s() const { return particles > 0 ? static_cast<float>(seconds / particles) : kUnknown; }
  };
  static constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

  Work pack;    // migrants that leave
  Work unpack;  // migrants that arrive
  Work search;  // looking for a cut, or making a histogram
  float bytes = kUnknown;  // of a migrant in a message
};

inline constexpr int kQuantiles = 16;
/// Ways of particles in a frame are logged as this many quantiles, at 1/16, 3/16, ... 15/16.
inline constexpr int kWays = 8;
/// Where a calculator's particles of one system are, for the log.
struct Density {
  std::uint64_t particles = 0;
  // Positions along the axes that are cut, in their order, in metres. For domains cut by id or along a curve: the
  // coordinates that are cut instead.
  float quantiles[3 * (kQuantiles + 1)] = {};
};

/// A tail: results that came too late for the report of their frame and are sent with the next one.
struct Tail {
  bool valid = false;
  std::uint64_t frame = 0;
  PhaseTimes times;                  // the longest of each phase
  double ended_s = 0;                // the latest end of the frame, each rank by its own clock (comm::Spent)
  std::uint64_t exchanged_bytes = 0;  // bytes exchanged, including those in interactions
  std::uint64_t moved = 0;           // particles that migrated in interactions
  std::vector<particles::Digest> children;  // one per system: born at the frame's end; empty unless digests are logged
  Drawings drawings;
  std::string image_sha256;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Tail& tail) {
  visit(tail.valid, tail.frame, tail.times, tail.ended_s, tail.exchanged_bytes, tail.moved, tail.children,
        tail.drawings, tail.image_sha256);
}

/// Results of one system on one calculator that only the log needs; sent with the next frame.
struct CalculatorTail {
  std::uint64_t bytes_sent = 0;  // exchange and interactions
  std::uint64_t particles = 0;  // see Density
  float quantiles[3 * (kQuantiles + 1)] = {};
  float exchange_s = 0, wait_s = 0, image_s = 0, project_s = 0;
  float pack_s = 0, unpack_s = 0, search_s = 0;  // per particle; NaN, like the next two: unknown
  double migrant_bytes = 0;
  std::array<float, kWays> ways{};  // metres along the first cut axis
  InteractionStats interaction;
};

template <class Visitor>
constexpr void fields(Visitor& visit, CalculatorTail& tail) {
  visit(tail.bytes_sent, tail.particles, tail.quantiles, tail.exchange_s, tail.wait_s, tail.image_s, tail.project_s,
        tail.pack_s, tail.unpack_s, tail.search_s, tail.migrant_bytes, tail.ways, tail.interaction);
}

/// What a rank spent the time of a frame on, for the log.
struct RankTimes {
  std::int32_t rank = 0;
  comm::Spent spent;
};

/// A rank whose list differs from the manager's, and that list.
struct Dissent {
  std::int32_t rank = 0;
  base::Bytes record;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Dissent& dissent) {
  visit(dissent.rank, dissent.record);
}

/// Forces on the walls of a system's contacts: by the contact's index in the system's list and the wall's number in the
/// contact.
using WallForces = std::map<std::pair<std::uint32_t, std::uint32_t>, interactions::WallSum>;

/// The forces of one system's particles on one wall, in all sub-steps of a frame.
struct WallForce {
  std::uint32_t system = 0, item = 0, wall = 0;
  interactions::WallSum sum;
};

template <class Visitor>
constexpr void fields(Visitor& visit, WallForce& force) {
  visit(force.system, force.item, force.wall, force.sum);
}

/// A cut's position from the next frame on, and the number of particles it moves (> 0: from left to right).
struct NewCut {
  std::uint32_t system = 0;
  std::uint32_t cut = 0;  // between calculators `cut` and `cut` + 1
  float at = 0;  // metres
  std::int64_t given = 0;
};

template <class Visitor>
constexpr void fields(Visitor& visit, NewCut& cut) {
  visit(cut.system, cut.cut, cut.at, cut.given);
}

/// A cut that two neighbours moved without the manager, as reported by the donor.
struct Decision {
  NewCut cut;
  std::int64_t ordered = 0;  // particles to give, with the sign of `cut.given`
};

template <class Visitor>
constexpr void fields(Visitor& visit, Decision& decision) {
  visit(decision.cut, decision.ordered);
}

/// The report of a subtree: sums, and what the manager needs from each rank. The calculators' loads follow it in the
/// message and are forwarded unread. If a rank failed, only the failures are valid.
struct Report {
  Failure failure;
  std::int32_t failed_rank = -1;  // the lowest rank that failed
  std::uint8_t stop = 0;  // highest number of a signal that asked a rank to stop, or 0
  std::uint64_t unsaved_from = UINT64_MAX;  // the first frame whose picture is not yet in a file
  std::string orders;  // viewers' orders, from the image generator, for all ranks
  std::vector<Dissent> dissents;
  std::vector<SystemReport> systems;  // systems of the round; empty if no rank calculates
  std::vector<Flow> flows;  // flows to calculators elsewhere in the tree
  std::vector<Decision> decisions;  // decisions of neighbours without the manager, for all ranks
  std::vector<WallForce> walls;  // ordered by system, item and wall
  Tail tail;

  bool failed() const { return failure.failed() || !dissents.empty(); }
};

template <class Visitor>
constexpr void fields(Visitor& visit, Report& report) {
  visit(report.failure, report.failed_rank, report.stop, report.unsaved_from, report.orders, report.dissents,
        report.systems, report.flows, report.decisions, report.walls, report.tail);
}

/// Merges the reports of two subtrees. Throws std::runtime_error if they are about different systems.
void join(Report& into, Report&& other);

/// A request to a calculator before cuts move: a cut that gives at most `count` particles to a neighbour, or a
/// histogram of its particles along an axis or in boxes.
struct Request {
  enum class Kind : std::uint32_t { give_left, give_right, histogram, cells };
  std::int32_t system = 0;
  Kind kind = Kind::histogram;
  std::uint64_t count = 0;  // particles, bins of the histogram, or cells
};

template <class Visitor>
constexpr void fields(Visitor& visit, Request& request) {
  visit(request.system, request.kind, request.count);
}

/// The answer to a Request.
struct Proposal {
  Request request;
  balance::Gift gift;
  balance::Histogram histogram;
  std::vector<balance::Cell> cells;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Proposal& proposal) {
  visit(proposal.request, proposal.gift, proposal.histogram, proposal.cells);
}

struct Verdict {
  Failure failure;
  std::int32_t failed_rank = -1;
  std::uint8_t stop = 0;  // highest signal in the reports: all ranks stop after this frame
  std::uint64_t unsaved_from = UINT64_MAX;
  std::string orders;  // viewers' orders: all ranks apply them before the next frame
  std::vector<std::int32_t> ranks;  // Kind::mismatch: ranks whose lists differ from the majority's
  std::vector<std::uint64_t> alive;  // one per system, over all ranks
  std::vector<particles::Digest> digests;
  std::vector<std::uint64_t> spawned;  // one per system: children of this frame, before the capacity limits them
  std::vector<std::uint64_t> oldest;  // one per system: lowest live id on any rank, if the birth history needs it
  std::vector<NewCut> cuts;  // as donors reported them
  std::vector<WallForce> walls;  // ordered by system, item and wall
};

template <class Visitor>
constexpr void fields(Visitor& visit, Verdict& verdict) {
  visit(verdict.failure, verdict.failed_rank, verdict.stop, verdict.unsaved_from, verdict.orders, verdict.ranks,
        verdict.alive, verdict.digests, verdict.spawned, verdict.oldest, verdict.cuts, verdict.walls);
}

/// Says that one calculator will send particles to another.
struct Transfer {
  std::uint32_t to = 0, from = 0;

  bool operator==(const Transfer&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Transfer& transfer) {
  visit(transfer.to, transfer.from);
}

/// A parent, and the calculator that owns its children.
struct OwnedParent {
  std::uint32_t owner = 0;
  Parent parent;
};

template <class Visitor>
constexpr void fields(Visitor& visit, OwnedParent& owned) {
  visit(owned.owner, owned.parent);
}

/// The verdict for a subtree: the part for all ranks, and the parts for single ranks.
struct Judgement {
  Verdict verdict;
  std::vector<Transfer> transfers;
  std::vector<OwnedParent> parents;  // those of one owner are ordered by system, rule and id
};

template <class Visitor>
constexpr void fields(Visitor& visit, Judgement& judgement) {
  visit(judgement.verdict, judgement.transfers, judgement.parents);
}

/// The part of the verdict for one rank.
struct Orders {
  std::vector<std::int32_t> senders;  // ranks that will send it particles
  std::vector<Parent> parents;  // parents whose children this calculator owns
};

/// The manager's plan of a round, for all ranks.
struct Planned {
  Failure failure;  // if the balancer failed: all ranks give up
  bool asks = false;  // some calculator has an inquiry: all calculators send proposals
};

template <class Visitor>
constexpr void fields(Visitor& visit, Planned& planned) {
  visit(planned.failure, planned.asks);
}

/// The manager's requests to one calculator before cuts move.
struct Inquiry {
  std::vector<Request> requests;
  std::vector<std::int32_t> partners;  // neighbouring calculators to compare loads with, ascending

  bool empty() const { return requests.empty() && partners.empty(); }
};

template <class Visitor>
constexpr void fields(Visitor& visit, Inquiry& inquiry) {
  visit(inquiry.requests, inquiry.partners);
}

void write(const Report& report, base::Bytes& out);
Report read_report(base::Reader& in);
void write(const Judgement& judgement, base::Bytes& out);
Judgement read_judgement(base::Reader& in);
void write(const Planned& planned, base::Bytes& out);
Planned read_planned(base::Reader& in);
void write(const Inquiry& inquiry, base::Bytes& out);
Inquiry read_inquiry(base::Reader& in);
void write(const Proposal& proposal, base::Bytes& out);
Proposal read_proposal(base::Reader& in);

}  // namespace motes::engine
