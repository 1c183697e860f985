// Load balancing as a pure function: loads and cuts in, orders out. No messages, no clock; the same code plans a run
// and replays its log.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "balance/load.h"
#include "balance/options.h"
#include "domains/axes.h"

namespace motes::balance {

/// Everything that a policy may know.
struct LoadTable {
  std::uint64_t frame = 0;
  std::uint64_t evaluation = 0;  // number of earlier evaluations for this system
  std::string system;  // its name, or "all" for the sum over systems
  std::vector<Load> loads;  // one per calculator, in the order of the domains
  std::vector<float> cuts;  // loads.size() - 1, in the order of the domains
  domains::Axes axes{};  // the axes that domains cut; orders need domains in a row
};

/// Particles to move from one domain to its left or right neighbour.
struct Order {
  std::int32_t from = 0;
  std::int32_t to = 0;  // from - 1 or from + 1
  std::uint64_t count = 0;

  bool operator==(const Order&) const = default;
};

/// A policy's decision: orders between neighbours, or every calculator's share of all particles. Nothing moves if both
/// are empty.
struct Plan {
  std::vector<Order> orders;
  std::vector<double> shares;  // one per calculator; any sum above 0
  /// The cost of a particle on each calculator; shares are then shares of cost. Empty: all cost the same.
  std::vector<double> costs;
  std::vector<std::int32_t> evaluated;  // cuts that were examined, for the log; cut i is between i and i + 1

  bool empty() const { return orders.empty() && shares.empty(); }
};

/// A balancing policy. Implementations keep no state: the same table always gives the same plan.
class Policy {
 public:
  Policy() = default;
  virtual ~Policy() = default;
  Policy(const Policy&) = delete;  // options point to members
  Policy& operator=(const Policy&) = delete;

  /// The name of the class, in C++, in Python and in logs.
  virtual const char* kind() const = 0;

  /// The policy's options in the order in which they are shown. Members hold the defaults until they are set.
  virtual Options options() { return {}; }

  /// Returns the call as a script writes it, for logs and errors: "Pairwise(threshold=0.1, min_particles=64,
  /// smoothing=0.5)".
  virtual std::string name() const;

  virtual Plan plan(const LoadTable& table) const = 0;

  /// Throws std::invalid_argument if the policy cannot work with this many calculators.
  virtual void check(std::size_t) const {}

  /// Whether cuts may move.
  virtual bool moves() const { return true; }

  /// Whether neighbours decide themselves what moves over their common cut. `between` is then called on both sides with
  /// the same loads.
  virtual bool decentralised() const { return false; }
  virtual Order between(std::int32_t left, const Load& left_load, const Load& right_load) const;

  /// Whether neighbours compare their loads in every frame; the manager then plans nothing.
  virtual bool unmanaged() const { return false; }

  /// Whether a function of the script makes the plan.
  virtual bool scripted() const { return false; }

  SpeedOptions speeds;
  bool over_all = false;  // balance the sum over systems, not each one

 protected:
  /// Options that several policies have.
  Option smoothing() { return {"smoothing", NumberOption{&speeds.smoothing, 1}}; }
  Option over() { return {"over", OverOption{&over_all}}; }
};

/// Makes a plan legal for this table: orders over the same cut are netted and sorted by cut, no donor gives more than
/// it has (both sides together), shares sum to 1, and the plan is empty if there are no particles or no cuts. Throws
/// std::invalid_argument naming policy and frame for an invalid plan: a wrong number of shares or costs, a negative or
/// non-finite number, no share above 0, orders between calculators that are not neighbours or whose domains are not
/// slabs, both orders and shares.
Plan legal(Plan plan, const LoadTable& table, const std::string& policy);

/// Converts a plan for the sum over systems to one for a system that holds `mine` of the particles of `all`: orders are
/// scaled in proportion, shares stay as they are.
Plan part_of(const Plan& plan, const std::vector<Load>& mine, const std::vector<Load>& all);

using PolicyPtr = std::shared_ptr<const Policy>;

}  // namespace motes::balance
