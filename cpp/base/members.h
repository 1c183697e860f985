// Structs that describe their members once, by name. From this description come their bytes (see fields.h) and the
// arguments that scripts give:
//
//   struct RibbonSprite {
//     float width = 0;
//     float length = 0;
//
//     static constexpr std::tuple kMembers{base::Member{"width", &RibbonSprite::width},
//                                          base::Member{"length", &RibbonSprite::length}};
//   };
//
// A description that leaves out a member does not compile.
#pragma once

#include <cstddef>
#include <tuple>

namespace motes::base {

/// A member of a struct, and the name by which scripts give it; "": scripts do not.
template <class Owner, class T>
struct Member {
  const char* name;
  T Owner::* at;
};

template <class Owner, class T>
Member(const char*, T Owner::*) -> Member<Owner, T>;

/// Converts to the type of any member.
struct AnyMember {
  template <class T>
  constexpr operator T() const;  // NOLINT(google-explicit-constructor): never called
};

/// Returns how many members an aggregate has. None may be a C array.
template <class T, class... Before>
consteval std::size_t members() {
  if constexpr (requires { T{Before{}..., AnyMember{}}; }) {
    return members<T, Before..., AnyMember>();
  } else {
    return sizeof...(Before);
  }
}

/// A struct that describes its members.
template <class T>
concept Described = requires { T::kMembers; };

/// Calls visit(name, member) for each member, in the order of their description.
template <Described T, class Visit>
constexpr void for_each_member(T& value, const Visit& visit) {
  static_assert(std::tuple_size_v<decltype(T::kMembers)> == members<T>(), "kMembers leaves out a member");
  std::apply([&](const auto&... member) { (visit(member.name, value.*member.at), ...); }, T::kMembers);
}

/// The members as fields: see fields.h.
template <class Visitor, Described T>
constexpr void fields(Visitor& visit, T& value) {
  for_each_member(value, [&](const char*, auto& member) { visit(member); });
}

}  // namespace motes::base
