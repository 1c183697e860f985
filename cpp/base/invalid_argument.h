// The error for a value that a function does not accept, with the parts from which Python makes an ArgumentError.
#pragma once

#include <stdexcept>
#include <string>

namespace motes::base {

/// Its message is "argument must rule, got value", after "owner: " if there is an owner.
class InvalidArgument : public std::invalid_argument {
 public:
  /// `rule`: what the argument must do, such as "be 1..64" or "have a surface"; `value`: as text, empty if it would not
  /// help; `owner`: what the argument belongs to, such as an action.
  InvalidArgument(const std::string& argument, const std::string& rule, const std::string& value = "",
                  const std::string& owner = "")
      : std::invalid_argument((owner.empty() ? "" : owner + ": ") + argument + " must " + rule +
                              (value.empty() ? "" : ", got " + value)),
        argument_(argument), rule_(rule), value_(value) {}

  const std::string& argument() const { return argument_; }
  const std::string& value() const { return value_; }
  /// The rule, without a leading "be ".
  std::string allowed() const { return rule_.starts_with("be ") ? rule_.substr(3) : rule_; }

 private:
  std::string argument_, rule_, value_;
};

}  // namespace motes::base
