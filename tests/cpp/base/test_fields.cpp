// Structs as bytes from one description of their fields: no padding, memory reused, damage detected.
#include "base/fields.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "engine/session/report.h"
#include "image/buffer.h"
#include "recording/record.h"
#include "support/check.h"

namespace motes::test_fields {
using base::Bytes;
using base::read_fields;
using base::Reader;
using base::write_fields;

namespace sample {

enum class Colour : std::int16_t { red, green, blue };

struct Nothing {
  bool operator==(const Nothing&) const = default;
};
template <class Visitor>
constexpr void fields(Visitor&, Nothing&) {}

// Has padding behind a list of numbers.
struct Listed {
  std::uint64_t first = 0;
  float numbers[17] = {};
};

template <class Visitor>
constexpr void fields(Visitor& visit, Listed& listed) {
  visit(listed.first, listed.numbers);
}

// Has padding after the first and the last field.
struct Padded {
  std::uint8_t small = 0;
  double large = 0;
  std::int32_t last = 0;

  bool operator==(const Padded&) const = default;
};
template <class Visitor>
constexpr void fields(Visitor& visit, Padded& padded) {
  visit(padded.small, padded.large, padded.last);
}

struct Everything {
  bool yes = false;
  Colour colour = Colour::red;
  std::string text;
  std::array<float, 3> three{};
  Padded two[2];
  std::vector<std::vector<Padded>> lists;
  std::optional<std::string> maybe;
  std::variant<Nothing, Padded, std::string> one_of;

  bool operator==(const Everything&) const = default;
};
template <class Visitor>
constexpr void fields(Visitor& visit, Everything& all) {
  visit(all.yes, all.colour, all.text, all.three, all.two, all.lists, all.maybe, all.one_of);
}

}  // namespace sample

namespace {

using sample::Colour;
using sample::Everything;
using sample::Padded;

static_assert(base::enumerators<Colour>() == 3);
static_assert(base::enumerators<recording::Verb>() == 13);
static_assert(base::enumerators<engine::Request::Kind>() == 4);
static_assert(base::enumerators<actions::Kind>() == actions::kKinds);
static_assert(base::enumerators<shapes::Kind>() == shapes::kKinds);

static_assert(base::copied_whole<engine::PhaseTimes>() && base::copied_whole<recording::Event>());
static_assert(!base::copied_whole<engine::OwnedParent>() && !base::copied_whole<balance::Gift>(), "padding");
static_assert(!base::copied_whole<engine::Request>(), "an enumeration is checked");

Everything everything() {
  Everything all;
  all.yes = true;
  all.colour = Colour::blue;
  all.text = "snow";
  all.three = {1, 2, 3};
  all.two[1] = {7, 0.5, -1};
  all.lists = {{{1, 2, 3}, {4, 5, 6}}, {}, {{7, 8, 9}}};
  all.maybe = "there";
  all.one_of = Padded{3, 4, 5};
  return all;
}

template <class T>
Bytes bytes_of(const T& value) {
  Bytes bytes;
  write_fields(value, bytes);
  return bytes;
}

template <class T>
T value_of(const Bytes& bytes, T over = {}) {
  Reader in(bytes.view());
  read_fields(in, over);
  CHECK(in.done());
  return over;
}

// Returns the bytes of a list of one value whose memory, including padding, held something else before.
template <class T, class Set>
std::string bytes_over(int filler, const Set& set) {
  std::vector<T> list(1);
  std::memset(static_cast<void*>(list.data()), filler, sizeof(T));
  set(list[0]);
  const Bytes bytes = bytes_of(list);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class T, class Set>
bool padding_shows(const Set& set) {
  return bytes_over<T>(0x00, set) != bytes_over<T>(0xaa, set);
}

}  // namespace

TEST(fields_survive_their_bytes) {
  const Everything all = everything();
  const Bytes bytes = bytes_of(all);
  CHECK(value_of<Everything>(bytes) == all);
  CHECK(value_of(bytes, all) == all);
  CHECK(value_of(bytes_of(Everything{}), all) == Everything{});  // overwrites a value with more content
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    Reader part(bytes.view().first(length));
    Everything other;
    CHECK_THROWS(read_fields(part, other), std::runtime_error);
  }
}

TEST(fields_write_no_padding) {
  CHECK(bytes_of(Padded{}).size() == 1 + 8 + 4);
  CHECK(!padding_shows<Padded>([](Padded& p) { p.small = 1, p.large = 2, p.last = 3; }));
  CHECK(!padding_shows<engine::OwnedParent>([](engine::OwnedParent& owned) {
    owned.owner = 1;
    owned.parent = {1, 2, 3, {4, {5, 6, 7}, {8, 9, 10}}};
  }));
  CHECK(!padding_shows<balance::Gift>([](balance::Gift& gift) { gift.cut = 1, gift.count = 2; }));
  CHECK(!padding_shows<sample::Listed>([](sample::Listed& listed) {
    listed.first = 1;
    std::fill_n(listed.numbers, std::size(listed.numbers), 1.0f);
  }));
  CHECK(bytes_of(std::vector<sample::Listed>(3)).size() == 8 + 3 * (8 + 4 * 17));
}

TEST(fields_are_read_into_memory_that_is_there) {
  Everything all = everything();
  const Bytes bytes = bytes_of(all);
  const auto* lists = all.lists.data();
  const auto* list = all.lists[0].data();
  all = value_of(bytes, std::move(all));
  CHECK(all.lists.data() == lists && all.lists[0].data() == list);
  all.text.assign(100, 'x');
  const auto* text = all.text.data();
  Reader in(bytes.view());
  read_fields(in, all);
  CHECK(all.text == "snow" && all.text.data() == text);
}

TEST(fields_find_damage) {
  const auto refused = [](auto value, std::size_t at, std::uint8_t byte) {
    Bytes bytes = bytes_of(value);
    bytes.set(at, byte);
    Reader in(bytes.view());
    CHECK_THROWS(read_fields(in, value), std::runtime_error);
  };
  Everything all;
  const std::size_t size = bytes_of(all).size();
  refused(all, 0, 2);         // neither false nor true
  refused(all, 1, 3);         // no such colour
  refused(all, 2, 0x80);      // nor one below 0
  refused(all, size - 2, 2);  // neither present nor absent
  refused(all, size - 1, 3);  // no such alternative
  refused(recording::Record{}, 0, base::enumerators<recording::Verb>());
  engine::Inquiry inquiry;
  inquiry.requests.resize(1);
  refused(inquiry, 8 + 4, base::enumerators<engine::Request::Kind>());
}

TEST(fields_that_end_too_early_are_refused) {
  const Everything all;
  const Bytes whole = bytes_of(all);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    Everything read;
    Reader in(whole.view().first(size));
    CHECK_THROWS(read_fields(in, read), std::runtime_error);
  }
}

TEST(a_list_longer_than_its_bytes_is_refused_before_memory_is_asked_for) {
  for (const std::uint64_t count : {std::uint64_t{5}, std::uint64_t{1} << 40, UINT64_MAX, UINT64_MAX / 13 + 2}) {
    Bytes bytes = bytes_of(std::vector<Padded>(4));
    bytes.set(0, count);
    Reader in(bytes.view());
    std::vector<Padded> list;
    CHECK_THROWS(read_fields(in, list), std::runtime_error);
    CHECK(list.capacity() == 0);
  }
}

// These tests are about the state of objects that were moved from.
// NOLINTBEGIN(bugprone-use-after-move)
TEST(what_bytes_are_moved_from_is_empty) {
  Bytes first;
  first.put_text("a text");
  Bytes second = std::move(first);
  CHECK(first.empty() && second.size() == 10);
  first.put_text("another");  // in new memory
  CHECK(first.size() == 11 && second.size() == 10);
  second = std::move(first);
  CHECK(first.empty() && second.size() == 11);
  first.resize(5);
  std::memset(first.data(), 1, 5);
  CHECK(first.size() == 5 && Reader(second.view()).get_text() == "another");
}

TEST(what_a_buffer_is_moved_from_is_empty) {
  image::Buffer first;
  first.resize(100);
  std::memset(first.data(), 7, 100);
  image::Buffer second = std::move(first);
  CHECK(first.size() == 0 && second.size() == 100);
  first.resize(50);
  std::memset(first.data(), 8, 50);
  CHECK(second.data()[49] == std::byte{7});
  second = std::move(first);
  CHECK(first.size() == 0 && second.size() == 50 && second.data()[49] == std::byte{8});
  first.resize(10);
  std::memset(first.data(), 9, 10);
  CHECK(second.data()[0] == std::byte{8});
}
// NOLINTEND(bugprone-use-after-move)

}  // namespace motes::test_fields
