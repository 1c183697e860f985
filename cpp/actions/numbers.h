// The kinds of actions and the named numbers that each records, both generated from list.inc.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

namespace motes::actions {

enum class Kind : std::uint8_t {
#define MOTES_ACTION(name, ...) name,
#define MOTES_INTERACTION MOTES_ACTION
#include "actions/list.inc"
#undef MOTES_INTERACTION
#undef MOTES_ACTION
};

inline constexpr int kKinds = 0
#define MOTES_ACTION(name, ...) +1  // NOLINT(bugprone-macro-parentheses): a summand
#define MOTES_INTERACTION MOTES_ACTION
#include "actions/list.inc"
#undef MOTES_INTERACTION
#undef MOTES_ACTION
    ;

/// One number of an action, or a vector of them: its name in the Python API and the values that it may have.
struct Number {
  enum class Rule : std::uint8_t { none, whole, axis, not_below_last };
  const char* name;
  double low;
  double high;
  int count = 1;
  Rule rule = Rule::none;  // axis: not all zero; not_below_last: at least the number before it
};

/// The rules of list.inc: which values a number may have.
namespace rules {
inline constexpr double kAny = 1e15;  // float32 can still square it
inline constexpr double kInf = std::numeric_limits<double>::infinity();

constexpr Number within(const char* name, double low, double high) { return {name, low, high}; }
constexpr Number any(const char* name) { return {name, -kAny, kAny}; }
constexpr Number positive(const char* name, int count = 1) { return {name, 0, kAny, count}; }
constexpr Number limit(const char* name) { return {name, 0, kInf}; }
constexpr Number not_below(const char* name) { return {name, 0, kInf, 1, Number::Rule::not_below_last}; }
constexpr Number part(const char* name) { return {name, 0, 1}; }
constexpr Number whole(const char* name, double low, double high) { return {name, low, high, 1, Number::Rule::whole}; }
constexpr Number vector(const char* name) { return {name, -kAny, kAny, 3}; }
constexpr Number axis(const char* name) { return {name, -kAny, kAny, 3, Number::Rule::axis}; }
}  // namespace rules

// Expands MOTES_NUMBER(rule, name, ...) for each element of (rule, name, ...) (rule, name, ...) ...: two macros call
// each other.
#define MOTES_EACH_NUMBER(list) MOTES_NUMBERS_END(MOTES_NUMBERS_1 list)
#define MOTES_NUMBERS_1(...) MOTES_NUMBER(__VA_ARGS__) MOTES_NUMBERS_2
#define MOTES_NUMBERS_2(...) MOTES_NUMBER(__VA_ARGS__) MOTES_NUMBERS_1
#define MOTES_NUMBERS_END(...) MOTES_NUMBERS_ENDED(__VA_ARGS__)
#define MOTES_NUMBERS_ENDED(...) __VA_ARGS__##_END
#define MOTES_NUMBERS_1_END
#define MOTES_NUMBERS_2_END

template <class T, int count>
struct Components {
  using Type = T[count];
};
template <class T>
struct Components<T, 1> {
  using Type = T;
};

/// One struct per kind of action, whose fields are its numbers: `numbers::wind` has `velocity[3]` and `drag`. They are
/// recorded as doubles and read by kernels as floats.
namespace numbers {
using rules::kAny;
using rules::kInf;
#define MOTES_NUMBER(rule, name, ...) \
  typename Components<T, rules::rule(#name __VA_OPT__(, ) __VA_ARGS__).count>::Type name{};
#define MOTES_ACTION(action, given, ...)        \
  template <class T = double>                   \
  struct action {                               \
    static constexpr Kind kKind = Kind::action; \
    MOTES_EACH_NUMBER(given)                    \
  };
#define MOTES_INTERACTION(action, family, ...) MOTES_ACTION(action, __VA_ARGS__)
#include "actions/list.inc"
#undef MOTES_INTERACTION
#undef MOTES_ACTION
#undef MOTES_NUMBER
}  // namespace numbers

/// Returns the numbers recorded at `from` as a struct of T. Always inline, so that a kernel never links a copy that was
/// compiled for another instruction set.
template <template <class> class Numbers, class T = float>
[[gnu::always_inline]] inline Numbers<T> read_numbers(const double* from) {
  T values[sizeof(Numbers<T>) / sizeof(T)];
  for (T& value : values) value = static_cast<T>(*from++);
  return __builtin_bit_cast(Numbers<T>, values);
}

}  // namespace motes::actions
