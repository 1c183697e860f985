#include "balance/policy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/invalid_argument.h"

namespace motes::balance {
namespace {

constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();

std::uint64_t saturated_sum(std::uint64_t a, std::uint64_t b) { return a > kMost - b ? kMost : a + b; }

// floor(count * part / whole) for part <= whole.
std::uint64_t portion(std::uint64_t count, std::uint64_t part, std::uint64_t whole) {
  using Wide = unsigned __int128;
  return whole == 0 ? 0 : static_cast<std::uint64_t>(static_cast<Wide>(count) * part / whole);
}

// "Even(), frame 7: shares must be ..., got ..."
[[noreturn]] void refuse(const std::string& policy, const LoadTable& table, const std::string& argument,
                         const std::string& allowed, const std::string& got) {
  throw base::InvalidArgument(argument, "be " + allowed, got, policy + ", frame " + std::to_string(table.frame));
}

void check_numbers(const std::vector<double>& numbers, const char* what, const LoadTable& table,
                   const std::string& policy) {
  const std::size_t calculators = table.loads.size();
  if (numbers.size() != calculators) {
    refuse(policy, table, what, std::to_string(calculators) + " numbers, one per calculator",
           std::to_string(numbers.size()));
  }
  bool any = false;
  for (const double number : numbers) {
    if (!std::isfinite(number) || number < 0) refuse(policy, table, what, "finite and >= 0", shown(number));
    any = any || number > 0;
  }
  if (!any) refuse(policy, table, what, "above 0 for at least one calculator", "0 for all");
}

// Scales the numbers to a sum of 1, without overflow on the way.
void normalise(std::vector<double>& shares) {
  const double largest = *std::max_element(shares.begin(), shares.end());
  double sum = 0;
  for (double& share : shares) sum += share /= largest;
  for (double& share : shares) share /= sum;
}

// The particles that move over one cut, to the right and to the left.
struct CutFlow {
  std::uint64_t right = 0;
  std::uint64_t left = 0;
};

std::vector<CutFlow> crossings(const Plan& plan, const LoadTable& table, const std::string& policy) {
  const auto calculators = static_cast<std::int64_t>(table.loads.size());
  std::vector<CutFlow> cuts(table.loads.empty() ? 0 : table.loads.size() - 1);
  for (const Order& order : plan.orders) {
    const bool exist = std::min(order.from, order.to) >= 0 && std::max(order.from, order.to) < calculators;
    if (!exist || std::abs(static_cast<std::int64_t>(order.from) - order.to) != 1) {
      refuse(policy, table, "orders", "between neighbours among calculators 0.." + std::to_string(calculators - 1),
             std::to_string(order.from) + " to " + std::to_string(order.to));
    }
    CutFlow& cut = cuts[static_cast<std::size_t>(std::min(order.from, order.to))];
    std::uint64_t& count = order.to > order.from ? cut.right : cut.left;
    count = saturated_sum(count, order.count);
  }
  for (CutFlow& cut : cuts) {
    const std::uint64_t both = std::min(cut.left, cut.right);
    cut.left -= both;
    cut.right -= both;
  }
  return cuts;
}

// Limits orders so that no donor gives more than it has; both neighbours then get proportionally less.
void limit(std::vector<CutFlow>& cuts, const std::vector<Load>& loads) {
  for (std::size_t c = 0; c < loads.size(); ++c) {
    std::uint64_t none = 0;
    std::uint64_t& left = c > 0 ? cuts[c - 1].left : none;
    std::uint64_t& right = c < cuts.size() ? cuts[c].right : none;
    const std::uint64_t has = loads[c].particles;
    if (saturated_sum(left, right) <= has) continue;
    if (left > kMost / 2 || right > kMost / 2) {  // the sum below would overflow
      left /= 2;
      right /= 2;
    }
    const std::uint64_t both = left + right;
    left = portion(has, left, both);
    right = std::min(portion(has, right, both), has - left);
  }
}

}  // namespace

std::string Policy::name() const {
  std::string text;
  for (const Option& option : const_cast<Policy&>(*this).options()) {  // only read here
    const std::string one = shown(option);
    if (!one.empty()) text += (text.empty() ? "" : ", ") + one;
  }
  return std::string(kind()) + "(" + text + ")";
}

Order Policy::between(std::int32_t left, const Load&, const Load&) const { return {left, left + 1, 0}; }

Plan legal(Plan plan, const LoadTable& table, const std::string& policy) {
  if (!plan.shares.empty() && !plan.orders.empty()) {
    refuse(policy, table, "a plan", "orders or shares", "both");
  }
  if (!plan.orders.empty() && !table.axes.row()) {
    refuse(policy, table, "a plan", "shares where domains are not slabs", "orders (axis " + name_of(table.axes) + ")");
  }
  if (!plan.shares.empty()) check_numbers(plan.shares, "shares", table, policy);
  if (!plan.costs.empty()) check_numbers(plan.costs, "costs", table, policy);
  std::vector<CutFlow> cuts = crossings(plan, table, policy);
  limit(cuts, table.loads);
  plan.orders.clear();
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const auto left = static_cast<std::int32_t>(i);
    if (cuts[i].right > 0) plan.orders.push_back({left, left + 1, cuts[i].right});
    if (cuts[i].left > 0) plan.orders.push_back({left + 1, left, cuts[i].left});
  }
  const bool any = std::any_of(table.loads.begin(), table.loads.end(), [](const Load& l) { return l.particles > 0; });
  if (!any || cuts.empty()) plan.shares.clear();
  if (plan.shares.empty()) {
    plan.costs.clear();
  } else {
    normalise(plan.shares);
  }
  return plan;
}

Plan part_of(const Plan& plan, const std::vector<Load>& mine, const std::vector<Load>& all) {
  Plan part = plan;
  for (Order& order : part.orders) {
    const auto donor = static_cast<std::size_t>(order.from);
    order.count = std::min(mine[donor].particles, portion(order.count, mine[donor].particles, all[donor].particles));
  }
  std::erase_if(part.orders, [](const Order& order) { return order.count == 0; });
  return part;
}

}  // namespace motes::balance
