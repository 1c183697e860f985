// Counts and names the enumerators of an enumeration at compile time.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "base/invalid_argument.h"

namespace motes::base {

/// Returns the value as GCC and Clang print it: Type::name, or (Type)7 if there is no such enumerator.
template <auto kValue>
consteval std::string_view printed() {
  constexpr std::string_view kBefore = "kValue = ";
  std::string_view text = __PRETTY_FUNCTION__;
  text.remove_prefix(text.find(kBefore) + kBefore.size());
  return text.substr(0, text.find_first_of(";]"));
}

/// Returns the number of enumerators 0, 1, 2, ... of a type. The type must not be in an unnamed namespace.
template <class Enum, int kFrom = 0>
consteval int enumerators() {
  static_assert(std::is_enum_v<Enum>);
  if constexpr (printed<static_cast<Enum>(kFrom)>()[0] != '(') {
    return enumerators<Enum, kFrom + 1>();
  } else {
    static_assert(kFrom > 0, "no enumerators from 0 on: in an unnamed namespace?");
    return kFrom;
  }
}

/// The names of all enumerators, in order.
template <class Enum>
inline constexpr auto kNames = []<std::size_t... kAt>(std::index_sequence<kAt...>) {
  const auto last_part = [](std::string_view text) { return text.substr(text.rfind(':') + 1); };
  return std::array{last_part(printed<static_cast<Enum>(kAt)>())...};
}(std::make_index_sequence<static_cast<std::size_t>(enumerators<Enum>())>{});

/// Returns the name of an existing enumerator.
template <class Enum>
constexpr std::string_view name_of(Enum value) {
  return kNames<Enum>[static_cast<std::size_t>(value)];
}

/// Returns all names, for errors: "a, b or c".
template <class Enum>
std::string names_of() {
  std::string all;
  for (std::size_t i = 0; i < kNames<Enum>.size(); ++i) {
    if (i > 0) all.append(i + 1 < kNames<Enum>.size() ? ", " : " or ");
    all.append(kNames<Enum>[i]);
  }
  return all;
}

/// Returns the enumerator with this name. Throws InvalidArgument naming the argument if there is none.
template <class Enum>
Enum enumerator(const std::string& argument, std::string_view name) {
  const auto found = std::find(kNames<Enum>.begin(), kNames<Enum>.end(), name);
  if (found == kNames<Enum>.end()) {
    throw InvalidArgument(argument, "be " + names_of<Enum>(), "'" + std::string(name) + "'");
  }
  return static_cast<Enum>(found - kNames<Enum>.begin());
}

}  // namespace motes::base
