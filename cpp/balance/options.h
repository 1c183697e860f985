// The options of a policy. Each is described once, next to the member that holds it and its default; logs, command
// lines, scenes and Python all use this description.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace motes::balance {

/// A number in 0..most.
struct NumberOption {
  double* value;
  double most = std::numeric_limits<double>::infinity();
};
/// A whole number >= 0.
struct CountOption {
  std::uint64_t* value;
};
struct FlagOption {
  bool* value;
};
/// The powers of machines, one per calculator. If required, they are >= 0 and not all 0; otherwise above 0, or empty to
/// measure them.
struct PowersOption {
  std::vector<double>* value;
  bool required = false;
};
/// "system" or "all".
struct OverOption {
  bool* all;
};

struct Option {
  const char* name;
  std::variant<NumberOption, CountOption, FlagOption, PowersOption, OverOption> of;
};
using Options = std::vector<Option>;

/// The values that options accept.
using Value = std::variant<bool, std::uint64_t, double, std::string, std::vector<double>>;

/// Sets an option. Throws base::InvalidArgument naming the option and its `owner` if the value is not allowed.
void set(const Option& option, const Value& value, const std::string& owner);

/// Returns the option's value.
Value value_of(const Option& option);

/// Returns the option as Python writes it: "threshold=0.1". Empty for a flag, a choice or powers with the default
/// value.
std::string shown(const Option& option);

/// Returns the fewest digits that read back as this number; -0 gives 0.
std::string shown(double number);
std::string shown(const std::vector<double>& numbers);

}  // namespace motes::balance
