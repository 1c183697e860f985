// The manager's state: each system's coming cuts, the loads they follow from, the ranks' reports, and the account of
// the frame.
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

/// Cuts of one system: what they follow from, and what they will be.
struct Balancing {
  bool untold = false;  // the other ranks do not know the cuts yet
  std::optional<domains::Domains> next;  // domains from the next frame's births on
  std::vector<balance::Load> loads;  // after the exchange of this frame, one per calculator
  balance::Plan plan;  // what this frame's loads call for
  std::uint64_t evaluations = 0;  // how often cuts were looked at
  std::vector<balance::Histogram> histograms;  // one per calculator, where all are asked for one
  std::vector<std::vector<balance::Cell>> cells;  // one list per calculator, for bricks
};

/// The manager's open questions of a round, until it needs the new cuts.
struct Asked {
  comm::Stamp stamp;
  std::vector<std::size_t> systems;
};

/// A parent, and the calculator that its children belong to; -1 where each child's id decides.
struct PlacedParent {
  int calculator;
  int into;  // the children's system
  std::uint32_t count;
  std::uint64_t first_id;  // id of the first child
  Parent parent;
};

/// Messages of calculators for the log that are still to arrive, after all reports.
struct AwaitedTails {
  comm::Stamp stamp;
  std::vector<CalculatorTail> own;  // the manager's own tails, if it calculates
  comm::Spent own_spent;
};

struct Manager {
  std::vector<Balancing> systems;
  Account account;
  Alarms alarms;
  std::vector<std::string> remarks;  // warnings that the script has not heard yet
  std::map<std::pair<std::size_t, std::int32_t>, BalanceRow> rows;  // by system and cut, until cuts are known
  std::vector<Asked> asked;  // questions whose answers are on their way
  std::vector<PlacedParent> parents;  // parents with events in this frame
  RenderLoad picture;  // what the last pictures took
  std::vector<Judged> judged;  // rounds of this conversation that are not in the account yet
  std::optional<AwaitedTails> tails;  // tails that are not in the account yet
};

/// Writes a warning to the log, and keeps it for the script.
void say(Alarm&& alarm, std::uint64_t frame, Manager& manager);

/// Returns how many of a parent's children are born if the capacity has room for `children` in the whole frame.
std::uint64_t children_of(std::uint64_t first, std::uint32_t count, std::uint64_t children);

/// Manager, once all rounds are judged: what each parent's children add to which system on which calculator.
void note_children(const Script& script, const Manager& manager,
                   const std::function<void(std::size_t into, int calculator, std::uint64_t count)>& note);

}  // namespace motes::engine
