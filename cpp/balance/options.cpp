#include "balance/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/invalid_argument.h"

namespace motes::balance {
namespace {

std::string text_of(const Value& value) {
  if (const auto* truth = std::get_if<bool>(&value)) return *truth ? "True" : "False";
  if (const auto* count = std::get_if<std::uint64_t>(&value)) return std::to_string(*count);
  if (const auto* number = std::get_if<double>(&value)) return shown(*number);
  if (const auto* text = std::get_if<std::string>(&value)) return "'" + *text + "'";
  return shown(std::get<std::vector<double>>(value));
}

// Sets an option. Returns what is allowed if the value is not, else null.
struct Setter {
  const Value& value;

  const char* operator()(const NumberOption& option) const {
    double number = std::numeric_limits<double>::quiet_NaN();
    if (const auto* given = std::get_if<double>(&value)) number = *given;
    if (const auto* given = std::get_if<std::uint64_t>(&value)) number = static_cast<double>(*given);
    const char* const allowed = option.most == 1 ? "0..1" : "a number >= 0";
    if (!std::isfinite(number) || number < 0 || number > option.most) return allowed;
    *option.value = number;
    return nullptr;
  }
  const char* operator()(const CountOption& option) const {
    const auto* given = std::get_if<std::uint64_t>(&value);
    if (given == nullptr) return "a whole number >= 0";
    *option.value = *given;
    return nullptr;
  }
  const char* operator()(const FlagOption& option) const {
    const auto* given = std::get_if<bool>(&value);
    if (given == nullptr) return "True or False";
    *option.value = *given;
    return nullptr;
  }
  const char* operator()(const PowersOption& option) const {
    const auto* given = std::get_if<std::vector<double>>(&value);
    const char* const allowed = option.required ? "a list of finite numbers >= 0, one per calculator, not all 0"
                                                : "a list of finite numbers > 0, one per calculator";
    if (given == nullptr || (option.required && given->empty())) return allowed;
    const auto fits = [&](double power) { return std::isfinite(power) && (option.required ? power >= 0 : power > 0); };
    if (!std::all_of(given->begin(), given->end(), fits)) return allowed;
    const auto above = [](double power) { return power > 0; };
    if (option.required && std::none_of(given->begin(), given->end(), above)) return allowed;
    *option.value = *given;
    return nullptr;
  }
  const char* operator()(const OverOption& option) const {
    const auto* given = std::get_if<std::string>(&value);
    if (given == nullptr || (*given != "system" && *given != "all")) return R"("system" or "all")";
    *option.all = *given == "all";
    return nullptr;
  }
};

}  // namespace

void set(const Option& option, const Value& value, const std::string& owner) {
  const char* const allowed = std::visit(Setter{value}, option.of);
  if (allowed == nullptr) return;
  throw base::InvalidArgument(option.name, std::string("be ") + allowed, text_of(value), owner);
}

Value value_of(const Option& option) {
  struct Getter {
    Value operator()(const NumberOption& o) const { return *o.value; }
    Value operator()(const CountOption& o) const { return *o.value; }
    Value operator()(const FlagOption& o) const { return *o.value; }
    Value operator()(const PowersOption& o) const { return *o.value; }
    Value operator()(const OverOption& o) const { return std::string(*o.all ? "all" : "system"); }
  };
  return std::visit(Getter{}, option.of);
}

std::string shown(const Option& option) {
  const std::string start = std::string(option.name) + "=";
  if (const auto* powers = std::get_if<PowersOption>(&option.of); powers != nullptr && powers->value->empty())
    return "";
  if (const auto* flag = std::get_if<FlagOption>(&option.of); flag != nullptr && *flag->value) return "";
  if (const auto* over = std::get_if<OverOption>(&option.of)) return *over->all ? start + "\"all\"" : "";
  return start + text_of(value_of(option));
}

std::string shown(double number) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, number + 0.0).ptr};  // no -0
}

std::string shown(const std::vector<double>& numbers) {
  std::string text = "[";
  for (const double number : numbers) {
    if (text.size() > 1) text += ", ";
    text += shown(number);
  }
  return text + "]";
}

}  // namespace motes::balance
