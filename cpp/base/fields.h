// Descriptions of a struct's fields. One description both writes the fields as bytes and reads them back. It stands
// next to the struct and lists the fields in the order of their declaration:
//
//   template <class Visitor>
//   constexpr void fields(Visitor& visit, Sent& sent) {
//     visit(sent.domain, sent.count);
//   }
//
// A field is a number, an enumeration, a bool, a string, Bytes, an array, a vector, an optional, a variant or another
// struct with such a description. Padding is never written. Reading reuses the memory of the value that it fills, and
// checks what it reads: element counts against the bytes that are left, enumerators, bools, alternatives.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/bytes.h"
#include "base/enumerators.h"

namespace motes::base {

/// Visits fields to add up the smallest number of bytes that they take.
class FieldSizes {
 public:
  static constexpr bool kReads = false;

  template <class... T>
  constexpr void operator()(T&... values) {
    (one(values), ...);
  }
  constexpr std::size_t bytes() const { return bytes_; }
  /// Whether all values of these bytes are valid, so that reading needs no checks.
  constexpr bool any_value() const { return any_value_; }

 private:
  template <class T>
  constexpr void one(T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      bytes_ += sizeof(T);
      any_value_ = any_value_ && !std::is_enum_v<T> && !std::is_same_v<T, bool>;
    } else if constexpr (std::is_array_v<T>) {
      for (auto& element : value) one(element);
    } else {
      fields(*this, value);
    }
  }
  template <class T, std::size_t kCount>
  constexpr void one(std::array<T, kCount>& value) {
    for (T& element : value) one(element);
  }
  void one(std::string&) { bytes_ += sizeof(std::uint32_t); }
  void one(Bytes&) { bytes_ += sizeof(std::uint64_t); }
  template <class T>
  void one(std::vector<T>&) {
    bytes_ += sizeof(std::uint64_t);
  }
  template <class T>
  void one(std::optional<T>&) {
    bytes_ += sizeof(bool);
  }
  template <class... T>
  void one(std::variant<T...>&) {
    bytes_ += sizeof(std::uint8_t);
  }

  std::size_t bytes_ = 0;
  bool any_value_ = true;
};

template <class T>
constexpr FieldSizes field_sizes() {
  FieldSizes visit;
  T value{};
  visit(value);
  return visit;
}

/// Returns the smallest number of bytes that a value takes, never 0.
template <class T>
std::size_t least_bytes() {
  if constexpr (std::is_trivially_copyable_v<T>) {
    return std::max<std::size_t>(field_sizes<T>().bytes(), 1);
  } else {
    static const std::size_t kLeast = std::max<std::size_t>(field_sizes<T>().bytes(), 1);
    return kLeast;
  }
}

/// Returns whether the bytes of the fields are those of the struct, without padding, and need no checks. Such values,
/// and lists of them, are copied whole.
template <class T>
consteval bool copied_whole() {
  if constexpr (std::is_trivially_copyable_v<T> && !std::is_array_v<T>) {
    return field_sizes<T>().any_value() && field_sizes<T>().bytes() == sizeof(T);
  } else {
    return false;
  }
}

/// Visits fields to write them. See write_fields().
class FieldWriter {
 public:
  static constexpr bool kReads = false;

  explicit FieldWriter(Bytes& out) : out_(out) {}

  template <class... T>
  void operator()(T&... values) {
    (one(values), ...);
  }

 private:
  template <class T>
  void one(T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T> || copied_whole<T>()) {
      out_.put_raw(&value, sizeof value);
    } else if constexpr (std::is_array_v<T>) {
      elements(std::data(value), std::size(value));
    } else {
      fields(*this, value);
    }
  }
  template <class T, std::size_t kCount>
  void one(std::array<T, kCount>& value) {
    elements(value.data(), kCount);
  }
  void one(std::string& text) { out_.put_text(text); }
  void one(Bytes& bytes) {
    out_.put(static_cast<std::uint64_t>(bytes.size()));
    out_.put_raw(bytes.data(), bytes.size());
  }
  template <class T>
  void one(std::vector<T>& list) {
    out_.put(static_cast<std::uint64_t>(list.size()));
    elements(list.data(), list.size());
  }
  template <class T>
  void one(std::optional<T>& value) {
    out_.put(value.has_value());
    if (value) one(*value);
  }
  template <class... T>
  void one(std::variant<T...>& value) {
    out_.put(static_cast<std::uint8_t>(value.index()));
    std::visit([&](auto& held) { one(held); }, value);
  }
  template <class T>
  void elements(T* first, std::size_t count) {
    if constexpr (copied_whole<T>()) {
      out_.put_raw(first, count * sizeof(T));
    } else {
      for (std::size_t i = 0; i < count; ++i) one(first[i]);
    }
  }

  Bytes& out_;
};

/// Visits fields to fill them. See read_fields().
class FieldReader {
 public:
  static constexpr bool kReads = true;

  explicit FieldReader(Reader& in) : in_(in) {}

  template <class... T>
  void operator()(T&... values) {
    (one(values), ...);
  }

 private:
  static void require(bool right, const char* what) {
    if (!right) throw std::runtime_error(what);
  }

  template <class T>
  void one(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      const auto number = in_.get<std::uint8_t>();
      require(number <= 1, "damaged bytes: a bool that is neither 0 nor 1");
      value = number == 1;
    } else if constexpr (std::is_enum_v<T>) {
      const auto number = in_.get<std::underlying_type_t<T>>();
      require(number >= 0 && static_cast<std::uint64_t>(number) < enumerators<T>(),
              "damaged bytes: an enumerator that does not exist");
      value = static_cast<T>(number);
    } else if constexpr (std::is_arithmetic_v<T> || copied_whole<T>()) {
      std::memcpy(&value, in_.take(sizeof value).data(), sizeof value);
    } else if constexpr (std::is_array_v<T>) {
      elements(std::data(value), std::size(value));
    } else {
      fields(*this, value);
    }
  }
  template <class T, std::size_t kCount>
  void one(std::array<T, kCount>& value) {
    elements(value.data(), kCount);
  }
  void one(std::string& text) {
    const auto bytes = in_.take(in_.get<std::uint32_t>());
    text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  void one(Bytes& value) {
    const auto bytes = in_.take(in_.get<std::uint64_t>());
    value.clear();
    value.put_raw(bytes.data(), bytes.size());
  }
  template <class T>
  void one(std::vector<T>& list) {
    const auto count = in_.get<std::uint64_t>();
    require(count <= in_.left() / least_bytes<T>(), "damaged bytes: a list that is longer than the remaining bytes");
    list.resize(count);
    elements(list.data(), count);
  }
  template <class T>
  void one(std::optional<T>& value) {
    bool there = false;
    one(there);
    if (!there) return value.reset();
    if (!value) value.emplace();
    one(*value);
  }
  template <class... T>
  void one(std::variant<T...>& value) {
    const auto index = in_.get<std::uint8_t>();
    require(index < sizeof...(T), "damaged bytes: an alternative that does not exist");
    if (index != value.index()) emplace(value, index, std::index_sequence_for<T...>{});
    std::visit([&](auto& held) { one(held); }, value);
  }
  template <class Variant, std::size_t... kIndex>
  static void emplace(Variant& value, std::size_t index, std::index_sequence<kIndex...>) {
    ((kIndex == index ? void(value.template emplace<kIndex>()) : void()), ...);
  }
  template <class T>
  void elements(T* first, std::size_t count) {
    if constexpr (copied_whole<T>()) {
      const auto bytes = in_.take(count * sizeof(T));
      if (count != 0) std::memcpy(first, bytes.data(), bytes.size());
    } else {
      for (std::size_t i = 0; i < count; ++i) one(first[i]);
    }
  }

  Reader& in_;
};

/// Appends the fields of a value.
template <class T>
void write_fields(const T& value, Bytes& out) {
  FieldWriter{out}(const_cast<T&>(value));  // a writer changes nothing
}

/// Fills a value, reusing its memory. Throws std::runtime_error if the bytes end too early or do not form such a value.
template <class T>
void read_fields(Reader& in, T& value) {
  FieldReader{in}(value);
}

}  // namespace motes::base
