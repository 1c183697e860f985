// The manager's state: each system's loads and next cuts, the ranks' reports, and the account of the frame.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "balance/cells.h"
#include "balance/cuts.h"
#include "balance/policy.h"
#include "domains/domains.h"
#include "engine/log/account.h"
#include "engine/log/alarms.h"
#include "engine/render/render_plan.h"
#include "engine/session/report.h"
#include "engine/session/reports.h"
#include "engine/state/script.h"

namespace motes::engine {

/// The balancing of one system: its loads and its next cuts.
struct Balancing {
  bool untold = false;  // the cuts have not been sent to the other ranks yet
  std::optional<domains::Domains> next;  // domains from the next frame's births on
  std::vector<balance::Load> loads;  // after the exchange of this frame, one per calculator
  balance::Plan plan;  // from this frame's loads
  std::uint64_t evaluations = 0;  // how often the policy has evaluated the cuts
  std::vector<balance::Histogram> histograms;  // one per calculator, if the plan needs them
  std::vector<std::vector<balance::Cell>> cells;  // one list per calculator, for bricks
};

/// Requests to calculators in a round whose answers the manager has not read yet.
struct PendingAnswers {
  comm::Stamp stamp;
  std::vector<std::size_t> systems;
};

/// A parent, and the calculator that owns its children; -1: each child's id determines its owner.
struct PlacedParent {
  int calculator;
  int into;  // the children's system
  std::uint32_t count;
  std::uint64_t first_id;  // id of the first child
  Parent parent;
};

/// Tails for the log that other ranks send after all reports, not yet received.
struct AwaitedTails {
  comm::Stamp stamp;
  std::vector<CalculatorTail> own;  // the manager's tails, if it calculates
  comm::Spent own_spent;
};

struct Manager {
  std::vector<Balancing> systems;
  Account account;
  Alarms alarms;
  std::vector<std::string> remarks;  // warnings that the script has not received yet
  std::map<std::pair<std::size_t, std::int32_t>, BalanceRow> rows;  // by system and cut, until the cuts are known
  std::vector<PendingAnswers> pending;  // requests whose answers are pending
  std::vector<PlacedParent> parents;  // parents with events in this frame
  RenderLoad picture;  // times of the last pictures
  std::vector<Judged> judged;  // rounds of this conversation that are not in the account yet
  std::optional<AwaitedTails> tails;  // tails that are not in the account yet
};

/// Writes a warning to the log and keeps it for the script.
void say(Alarm&& alarm, std::uint64_t frame, Manager& manager);

/// Returns how many of a parent's children are born if the capacity allows `children` in the whole frame. `first`:
/// index of the parent's first child among the frame's.
std::uint64_t children_of(std::uint64_t first, std::uint32_t count, std::uint64_t children);

/// Manager, once all rounds are judged: calls `note` with the number of each parent's children, their system and their
/// calculator.
void note_children(const Script& script, const Manager& manager,
                   const std::function<void(std::size_t into, int calculator, std::uint64_t count)>& note);

}  // namespace motes::engine
