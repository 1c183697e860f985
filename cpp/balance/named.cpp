#include "balance/named.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "balance/diffusive.h"
#include "balance/pairwise.h"
#include "balance/prefix_cuts.h"
#include "balance/proportional.h"
#include "balance/static.h"

namespace motes::balance {
namespace {

// A call such as Pairwise(threshold=0.1), split into its parts.
class Call {
 public:
  explicit Call(const std::string& text) : text_(text) {
    const std::size_t open = std::min(text.find('('), text.size());
    name_ = trimmed(text.substr(0, open));
    if (open == text.size()) return;
    const std::size_t close = text.rfind(')');
    if (close == std::string::npos || close < open || !trimmed(text.substr(close + 1)).empty())
      refuse("a ) is missing at the end");
    for (const std::string& argument : parts(text.substr(open + 1, close - open - 1))) {
      const std::size_t equals = argument.find('=');
      if (equals == std::string::npos) refuse("options must have the form name=value");
      options_[trimmed(argument.substr(0, equals))] = trimmed(argument.substr(equals + 1));
    }
  }

  const std::string& name() const { return name_; }

  double number(const std::string& option, double otherwise, double most = INFINITY) {
    const std::string value = take(option);
    return value.empty() ? otherwise : read(option, value, most);
  }

  std::uint64_t count(const std::string& option, std::uint64_t otherwise) {
    const std::string value = take(option);
    if (value.empty()) return otherwise;
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc() || end != value.data() + value.size()) refuse(option + " must be a whole number >= 0");
    return number;
  }

  bool flag(const std::string& option, bool otherwise) {
    const std::string value = take(option);
    if (!value.empty() && value != "True" && value != "False") refuse(option + " must be True or False, got " + value);
    return value.empty() ? otherwise : value == "True";
  }

  std::vector<double> numbers(const std::string& option) {
    const std::string value = take(option);
    if (value.empty()) return {};
    if (value.size() < 2 || value.front() != '[' || value.back() != ']') refuse(option + " must be [number, ...]");
    std::vector<double> all;
    for (const std::string& part : parts(value.substr(1, value.size() - 2)))
      all.push_back(read(option, part, INFINITY));
    return all;
  }

  bool over_all() {
    const std::string value = take("over");
    if (value.empty() || value == R"("system")" || value == "'system'") return false;
    if (value != R"("all")" && value != "'all'") refuse(R"(over must be "system" or "all")");
    return true;
  }

  void done() const {
    if (!options_.empty()) refuse("unknown option " + options_.begin()->first);
  }

  [[noreturn]] void refuse(const std::string& why) const {
    throw std::invalid_argument("balancer '" + text_ + "': " + why);
  }

 private:
  static std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(' ');
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(' ') - first + 1);
  }

  // Splits at the commas outside brackets.
  static std::vector<std::string> parts(const std::string& text) {
    std::vector<std::string> all;
    std::string part;
    int depth = 0;
    for (const char c : text) {
      depth += c == '[' ? 1 : c == ']' ? -1 : 0;
      if (c != ',' || depth > 0) {
        part += c;
      } else {
        all.push_back(trimmed(part));
        part.clear();
      }
    }
    if (!trimmed(part).empty()) all.push_back(trimmed(part));
    return all;
  }

  std::string take(const std::string& option) {
    const auto found = options_.find(option);
    if (found == options_.end()) return "";
    std::string value = found->second;
    if (value.empty()) refuse(option + " has no value");
    options_.erase(found);
    return value;
  }

  double read(const std::string& option, const std::string& value, double most) const {
    double number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    const bool whole = error == std::errc() && end == value.data() + value.size();
    if (!whole || !std::isfinite(number) || number < 0 || number > most) {
      refuse(option + " must be " + (most == 1 ? "0..1" : "a number >= 0") + ", got " + value);
    }
    return number;
  }

  std::string text_;
  std::string name_;
  std::map<std::string, std::string> options_;
};

std::shared_ptr<Policy> policy_of(Call& call) {
  const std::uint64_t least = call.name() == "Static" ? 0 : call.count("min_particles", Policy::kMinParticles);
  if (call.name() == "Static") return std::make_shared<Static>();
  if (call.name() == "Pairwise") {
    return std::make_shared<Pairwise>(call.number("threshold", Pairwise::kThreshold, 1), least, call.numbers("powers"));
  }
  if (call.name() == "Diffusive") {
    const double threshold = call.number("threshold", Diffusive::kThreshold, 1);
    const double rate = call.number("rate", Diffusive::kRate, 1);
    return std::make_shared<Diffusive>(threshold, rate, least, call.flag("manager", true));
  }
  const std::vector<double> powers = call.numbers("powers");
  if (call.name() == "PrefixCuts") {
    return std::make_shared<PrefixCuts>(call.number("threshold", PrefixCuts::kThreshold), powers, least);
  }
  if (call.name() != "Proportional") {
    call.refuse("must be Static, Pairwise, Diffusive, PrefixCuts or Proportional, with options in brackets");
  }
  if (powers.empty()) call.refuse("powers must be given: [number, ...], one per calculator");
  return std::make_shared<Proportional>(powers, call.number("threshold", Proportional::kThreshold), least);
}

}  // namespace

PolicyPtr policy_named(const std::string& name) {
  Call call(name);
  std::shared_ptr<Policy> policy = policy_of(call);
  if (call.name() != "Static") {
    if (call.name() != "Proportional") policy->speeds.smoothing = call.number("smoothing", SpeedOptions{}.smoothing, 1);
    policy->over_all = call.over_all();
  }
  call.done();
  return policy;
}

}  // namespace motes::balance
