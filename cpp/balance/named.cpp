#include "balance/named.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "balance/all_policies.h"  // all policy_*.h of this folder; written by CMake, so a new one needs no line here
#include "base/invalid_argument.h"

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
      options_[trimmed(argument.substr(0, equals))] = value(trimmed(argument.substr(equals + 1)));
    }
  }

  const std::string& name() const { return name_; }
  const std::map<std::string, Value>& options() const { return options_; }

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

  template <class Number>
  static bool read(const std::string& text, Number& number) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size();
  }

  // Parses True, "text", 64, 0.5 or [1, 2.5], as Python writes them.
  Value value(const std::string& text) const {
    if (text == "True" || text == "False") return text == "True";
    if (text.size() >= 2 && text.front() == text.back() && (text.front() == '"' || text.front() == '\''))
      return text.substr(1, text.size() - 2);
    std::uint64_t count = 0;
    if (read(text, count)) return count;
    double number = 0;
    if (read(text, number)) return number;
    if (text.size() < 2 || text.front() != '[' || text.back() != ']') refuse("'" + text + "' is not a value");
    std::vector<double> numbers;
    for (const std::string& part : parts(text.substr(1, text.size() - 2))) {
      if (!read(part, numbers.emplace_back())) refuse("'" + part + "' is not a number");
    }
    return numbers;
  }

  std::string text_;
  std::string name_;
  std::map<std::string, Value> options_;
};

bool has(const Options& options, const std::string& name) {
  return std::any_of(options.begin(), options.end(), [&](const Option& option) { return name == option.name; });
}

}  // namespace

const std::vector<std::string>& policy_names() {
  static const std::vector<std::string> all = {
#define MOTES_POLICY(kind) #kind,
#include "balance/policies.inc"
#undef MOTES_POLICY
  };
  return all;
}

std::shared_ptr<Policy> policy_made(const std::string& kind) {
#define MOTES_POLICY(name) \
  if (kind == #name) return std::make_shared<name>();
#include "balance/policies.inc"
#undef MOTES_POLICY
  std::string names;
  for (const std::string& name : policy_names()) names += (names.empty() ? "" : ", ") + name;
  throw base::InvalidArgument("balancer", "be one of " + names + ", with options in parentheses", "'" + kind + "'");
}

std::shared_ptr<Policy> policy_made(const std::string& kind, const std::map<std::string, Value>& options) {
  std::shared_ptr<Policy> policy = policy_made(kind);
  const Options known = policy->options();
  for (const auto& [name, value] : options) {
    if (!has(known, name)) throw std::invalid_argument(kind + ": unknown option " + name);
  }
  for (const Option& option : known) {
    const auto given = options.find(option.name);
    const auto* powers = std::get_if<PowersOption>(&option.of);
    if (given != options.end()) set(option, given->second, kind);
    if (given == options.end() && powers != nullptr && powers->required) set(option, std::vector<double>(), kind);
  }
  return policy;
}

std::shared_ptr<Policy> policy_named(const std::string& text) {
  const Call call(text);
  return policy_made(call.name(), call.options());
}

}  // namespace motes::balance
