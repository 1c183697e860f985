// The options of a policy. Each is described once, beside the member that holds it and its default: from that follow how
// a policy is shown in logs, read from a command line or a scene, and made and checked in Python.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace motes::balance {

/// 0 .. most.
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
/// The powers of machines, one per calculator. Required: >= 0, and not all 0. Else above 0, or none: they are measured.
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

/// What an option may be given.
using Value = std::variant<bool, std::uint64_t, double, std::string, std::vector<double>>;

/// Throws base::InvalidArgument, naming the option and its `owner`, where the value is not allowed.
void set(const Option& option, const Value& value, const std::string& owner);

/// The option's value.
Value value_of(const Option& option);

/// As Python writes it: "threshold=0.1"; empty where it is a flag, a choice or powers, and has its default.
std::string shown(const Option& option);

/// The fewest digits that read back as this number; -0 gives 0.
std::string shown(double number);
std::string shown(const std::vector<double>& numbers);

}  // namespace motes::balance
