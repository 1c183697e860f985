// Balancing policies as values, including those written in Python, and where to cut, for replays and tests.
#include "balance/cells.h"
#include "balance/cuts.h"
#include "balance/named.h"
#include "base/invalid_argument.h"
#include "bindings/bindings.h"

namespace motes::bindings {
namespace {

using namespace balance;
using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using CountArray = py::array_t<std::uint64_t, py::array::c_style | py::array::forcecast>;
using OrderTuple = std::tuple<std::int32_t, std::int32_t, std::uint64_t>;

template <class T, class Array>
std::span<const T> span_of(const Array& array) {
  if (array.ndim() != 1)
    throw base::InvalidArgument("arrays", "have the shape (n,)", std::to_string(array.ndim()) + "-d");
  return {array.data(), static_cast<std::size_t>(array.size())};
}

template <class T>
py::array_t<T> array_of(std::vector<T> values) {
  const auto size = static_cast<py::ssize_t>(values.size());
  return owned_array(std::move(values), {size});
}

// A policy written in Python: a callable from table to plan. Only the manager calls it.
class Scripted : public Policy {
 public:
  Scripted(std::string name, py::function decide)
      : name_(std::move(name)), decide_(new py::function(std::move(decide)), [](py::function* f) {
          const py::gil_scoped_acquire gil;  // any thread may destroy the last copy
          delete f;
        }) {}

  const char* kind() const override { return "Balancer"; }
  std::string name() const override { return name_; }
  bool scripted() const override { return true; }
  Plan plan(const LoadTable& table) const override {
    const py::gil_scoped_acquire gil;
    return (*decide_)(table).cast<Plan>();
  }

 private:
  std::string name_;
  std::shared_ptr<py::function> decide_;
};

const char* kind_of(const Option& option) {
  struct Kinds {
    const char* operator()(const NumberOption&) const { return "number"; }
    const char* operator()(const CountOption&) const { return "count"; }
    const char* operator()(const FlagOption&) const { return "flag"; }
    const char* operator()(const PowersOption& o) const { return o.required ? "shares" : "powers"; }
    const char* operator()(const OverOption&) const { return "over"; }
  };
  return std::visit(Kinds{}, option.of);
}

// Name, kind, default, and the maximum of a number.
using OptionTuple = std::tuple<std::string, std::string, Value, double>;

std::vector<OptionTuple> options_of(const std::string& kind) {
  std::vector<OptionTuple> all;
  const std::shared_ptr<Policy> policy = policy_made(kind);
  for (const Option& option : policy->options()) {
    const auto* number = std::get_if<NumberOption>(&option.of);
    all.emplace_back(option.name, kind_of(option), value_of(option), number != nullptr ? number->most : INFINITY);
  }
  return all;
}

std::shared_ptr<Policy> scripted(std::string name, py::function decide, double smoothing, bool over_all) {
  auto policy = std::make_shared<Scripted>(std::move(name), std::move(decide));
  policy->speeds.smoothing = smoothing;
  policy->over_all = over_all;
  return policy;
}

LoadTable make_table(std::uint64_t frame, std::uint64_t evaluation, const std::string& system,
                     const CountArray& particles, const DoubleArray& seconds, const DoubleArray& speed,
                     const FloatArray& cuts, const DoubleArray& errors, const std::string& axes) {
  const auto n = span_of<std::uint64_t>(particles);
  const auto s = span_of<double>(seconds);
  const auto v = span_of<double>(speed);
  const auto c = span_of<float>(cuts);
  const auto e = span_of<double>(errors);
  if (s.size() != n.size() || (!e.empty() && e.size() != n.size()) || v.size() != n.size() ||
      c.size() + 1 != std::max<std::size_t>(n.size(), 1)) {
    throw base::InvalidArgument("particles, seconds, speed and error", "be one per calculator, and cuts one fewer",
                                std::to_string(n.size()) + " particles, " + std::to_string(c.size()) + " cuts");
  }
  LoadTable table{frame, evaluation, system, {}, {c.begin(), c.end()}};
  table.axes = domains::axes_of(axes);
  for (std::size_t i = 0; i < n.size(); ++i) table.loads.push_back({n[i], s[i], v[i], e.empty() ? 0 : e[i]});
  return table;
}

template <class T>
py::array_t<T> column(const LoadTable& table, T Load::* member) {
  std::vector<T> values;
  for (const Load& load : table.loads) values.push_back(load.*member);
  return array_of(std::move(values));
}

std::vector<OrderTuple> tuples(const Plan& plan) {
  std::vector<OrderTuple> orders;
  for (const Order& order : plan.orders) orders.emplace_back(order.from, order.to, order.count);
  return orders;
}

Plan make_plan(const std::vector<OrderTuple>& orders, std::vector<double> shares, std::vector<double> costs) {
  Plan plan;
  for (const auto& [from, to, count] : orders) plan.orders.push_back({from, to, count});
  plan.shares = std::move(shares);
  plan.costs = std::move(costs);
  return plan;
}

std::vector<float> cuts_from(const std::vector<std::pair<FloatArray, CountArray>>& histograms, const DoubleArray& costs,
                             const DoubleArray& shares, const FloatArray& before) {
  std::vector<Histogram> all;
  for (const auto& [edges, counts] : histograms) {
    const auto e = span_of<float>(edges);
    const auto c = span_of<std::uint64_t>(counts);
    all.push_back({{e.begin(), e.end()}, {c.begin(), c.end()}});
  }
  return prefix_cuts(all, span_of<double>(costs), span_of<double>(shares), span_of<float>(before));
}

domains::Domains tree_of(const std::vector<int>& axes, const FloatArray& cuts) {
  const auto at = span_of<float>(cuts);
  if (at.size() != axes.size()) throw base::InvalidArgument("axes and cuts", "have the same length");
  std::vector<domains::Cut> tree;
  for (std::size_t i = 0; i < axes.size(); ++i) tree.push_back({axes[i], at[i]});
  return domains::Domains::of(tree);
}

// Cells of one calculator: their lower and upper corners (n, 3), and particle counts (n,).
using CellArrays = std::tuple<FloatArray, FloatArray, CountArray>;

std::vector<Cell> cells_of(const CellArrays& arrays) {
  const auto& [low, high, count] = arrays;
  const auto n = span_of<std::uint64_t>(count);
  for (const FloatArray& ends : {low, high}) {
    const bool fits = ends.ndim() == 2 && ends.shape(0) == count.size() && ends.shape(1) == 3;
    if (!fits)
      throw base::InvalidArgument("corners of cells", "have the shape (n, 3), where n is the number of counts");
  }
  std::vector<Cell> cells(n.size());
  for (std::size_t i = 0; i < n.size(); ++i) {
    std::copy_n(low.data() + 3 * i, 3, cells[i].low.begin());
    std::copy_n(high.data() + 3 * i, 3, cells[i].high.begin());
    cells[i].count = n[i];
  }
  return cells;
}

std::vector<float> cuts_of_tree(const std::vector<CellArrays>& calculators, const DoubleArray& costs,
                                const DoubleArray& shares, const std::vector<int>& axes, const FloatArray& before) {
  std::vector<std::vector<Cell>> all;
  for (const CellArrays& arrays : calculators) all.push_back(cells_of(arrays));
  return tree_cuts(all, span_of<double>(costs), span_of<double>(shares), tree_of(axes, before)).cuts();
}

void bind_values(py::module_& m) {
  py::class_<LoadTable>(m, "BalanceTable")
      .def(py::init(&make_table), py::arg("frame"), py::arg("evaluation"), py::arg("system"), py::arg("particles"),
           py::arg("seconds"), py::arg("speed"), py::arg("cuts"),
           py::arg("error") = py::tuple(),  // an array would load NumPy with this module
           py::arg("axes") = "x")
      .def_readonly("frame", &LoadTable::frame)
      .def_readonly("evaluation", &LoadTable::evaluation)
      .def_readonly("system", &LoadTable::system)
      .def_property_readonly("particles", [](const LoadTable& t) { return column(t, &Load::particles); })
      .def_property_readonly("seconds", [](const LoadTable& t) { return column(t, &Load::seconds); })
      .def_property_readonly("speed", [](const LoadTable& t) { return column(t, &Load::speed); })
      .def_property_readonly("error", [](const LoadTable& t) { return column(t, &Load::error); })
      .def_property_readonly("complete_speed", [](const LoadTable& t) { return array_of(complete(t.loads)); })
      .def_property_readonly("cuts", [](const LoadTable& t) { return array_of(t.cuts); })
      .def_property_readonly("bricks", [](const LoadTable& t) { return t.axes.bricks(); })
      .def_property_readonly("imbalance", [](const LoadTable& t) { return imbalance(t.loads); });
  py::class_<Plan>(m, "BalancePlan")
      .def(py::init(&make_plan), py::arg("orders"), py::arg("shares"), py::arg("costs"))
      .def_property_readonly("orders", &tuples)
      .def_property_readonly("shares", [](const Plan& p) { return array_of(p.shares); })
      .def_property_readonly("costs", [](const Plan& p) { return array_of(p.costs); })
      .def_property_readonly("evaluated", [](const Plan& p) { return array_of(p.evaluated); });
  m.def(
      "sum_of_tables",
      [](const std::vector<LoadTable>& systems) {
        if (systems.empty()) throw base::InvalidArgument("systems", "have at least one table");
        std::vector<std::vector<Load>> loads;
        LoadTable sum = systems.front();
        for (const LoadTable& table : systems) {
          loads.push_back(table.loads);
          if (!table.axes.row()) sum.axes = table.axes;  // orders must be possible in all systems
        }
        sum.system = "all";
        sum.loads = sum_of(loads);
        return sum;
      },
      py::arg("systems"));
  m.def("legal_plan", &legal, py::arg("plan"), py::arg("table"), py::arg("policy"));
  m.def(
      "plan_part",
      [](const Plan& plan, const LoadTable& mine, const LoadTable& all) {
        return part_of(plan, mine.loads, all.loads);
      },
      py::arg("plan"), py::arg("mine"), py::arg("all"));
}

void bind_policies(py::module_& m) {
  py::class_<Speeds>(m, "Speeds")
      .def("add", &Speeds::add, py::arg("calculator"), py::arg("particles"), py::arg("seconds"), py::arg("newborn") = 0)
      .def("of", &Speeds::of, py::arg("calculator"))
      .def("error", &Speeds::error, py::arg("calculator"));
  py::class_<Policy, std::shared_ptr<Policy>>(m, "Policy")
      .def_property_readonly("name", &Policy::name)
      .def_property_readonly("moves", &Policy::moves)
      .def_property_readonly("decentralised", &Policy::decentralised)
      .def_property_readonly("unmanaged", &Policy::unmanaged)
      .def_readonly("over_all", &Policy::over_all)
      .def_property_readonly("smoothing", [](const Policy& p) { return p.speeds.smoothing; })
      .def("check", &Policy::check, py::arg("calculators"))
      .def("plan", &Policy::plan, py::arg("table"))
      .def(
          "speeds", [](const Policy& p, int calculators) { return Speeds(calculators, p.speeds); },
          py::arg("calculators"));
  m.def("policy_named", &policy_named, py::arg("call"));
  m.def("policy_names", &policy_names);
  m.def("policy_options", &options_of, py::arg("kind"));
  m.def("make_policy", py::overload_cast<const std::string&, const std::map<std::string, Value>&>(&policy_made),
        py::arg("kind"), py::arg("options"));
  m.def("scripted_policy", &scripted, py::arg("name"), py::arg("decide"), py::arg("smoothing"), py::arg("over_all"));
}

void bind_cuts(py::module_& m) {
  const auto gift = [](Gift (*give)(std::span<const float>, std::uint64_t, float, float)) {
    return [give](const FloatArray& coordinates, std::uint64_t wanted, float low, float high) {
      const Gift g = give(span_of<float>(coordinates), wanted, low, high);
      return std::pair(g.cut, g.count);
    };
  };
  m.def("give_left", gift(&give_left), py::arg("coordinates"), py::arg("wanted"), py::arg("low"), py::arg("high"));
  m.def("give_right", gift(&give_right), py::arg("coordinates"), py::arg("wanted"), py::arg("low"), py::arg("high"));
  m.def(
      "histogram",
      [](const FloatArray& coordinates, int bins) {
        Histogram h = histogram(span_of<float>(coordinates), bins);
        return std::pair(array_of(std::move(h.edges)), array_of(std::move(h.counts)));
      },
      py::arg("coordinates"), py::arg("bins"));
  m.def(
      "quantiles",
      [](const FloatArray& coordinates, int count) { return array_of(quantiles(span_of<float>(coordinates), count)); },
      py::arg("coordinates"), py::arg("count"));
  m.def(
      "prefix_cuts",
      [](const std::vector<std::pair<FloatArray, CountArray>>& histograms, const DoubleArray& costs,
         const DoubleArray& shares,
         const FloatArray& before) { return array_of(cuts_from(histograms, costs, shares, before)); },
      py::arg("histograms"), py::arg("costs"), py::arg("shares"), py::arg("before"));
  m.def(
      "tree_cuts",
      [](const std::vector<CellArrays>& cells, const DoubleArray& costs, const DoubleArray& shares,
         const std::vector<int>& axes,
         const FloatArray& before) { return array_of(cuts_of_tree(cells, costs, shares, axes, before)); },
      py::arg("cells"), py::arg("costs"), py::arg("shares"), py::arg("axes"), py::arg("before"));
}

}  // namespace

void bind_balance(py::module_& m) {
  bind_values(m);
  bind_policies(m);
  bind_cuts(m);
}

}  // namespace motes::bindings
