// How many enumerators an enumeration has, from the compiler: what must be checked when a number becomes one of them.
#pragma once

#include <string_view>
#include <type_traits>

namespace motes::particles {

/// Whether an enumerator has this value. GCC and Clang print the name of one that exists, and a cast, "(Type)7", where
/// there is none.
template <auto kValue>
consteval bool is_enumerator() {
  constexpr std::string_view kBefore = "kValue = ";
  const std::string_view text = __PRETTY_FUNCTION__;
  return text[text.rfind(kBefore) + kBefore.size()] != '(';
}

/// The enumerators 0, 1, 2, ... of a type, which must not belong to an unnamed namespace.
template <class Enum, int kFrom = 0>
consteval int enumerators() {
  static_assert(std::is_enum_v<Enum>);
  if constexpr (is_enumerator<static_cast<Enum>(kFrom)>()) {
    return enumerators<Enum, kFrom + 1>();
  } else {
    static_assert(kFrom > 0, "no enumerators from 0 on: in an unnamed namespace?");
    return kFrom;
  }
}

}  // namespace motes::particles
