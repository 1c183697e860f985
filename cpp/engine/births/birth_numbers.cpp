#include "engine/births/birth_numbers.h"

#include <array>
#include <cstring>
#include <stdexcept>

namespace motes::engine {

using base::Reader;
using comm::Message;

namespace {

// Reads the births of one group from a message, after the group's number.
std::span<const std::byte> births_in(Reader& in) { return in.take(in.get<std::uint32_t>() * sizeof(Due)); }

using DigitCounts = std::array<std::uint32_t, roles::Ring::kDigits>;

// Finds the message for each birth and counts them. The ring is passed by value so that it can stay in registers.
DigitCounts digits_of(std::span<const Due> births, const roles::Ring ring, int step, std::uint8_t* digits) {
  DigitCounts counts{};
  for (std::size_t i = 0; i < births.size(); ++i) {
    const auto digit = static_cast<std::uint8_t>(ring.digit(static_cast<int>(births[i].owner), step));
    digits[i] = digit;
    ++counts[digit];
  }
  return counts;
}

// Appends room for `count` births of a group to a message and returns its address.
std::byte* make_room(std::uint32_t group, std::uint32_t count, Message& message) {
  base::Bytes& bytes = message.bytes();
  bytes.reserve(bytes.size() + sizeof group + sizeof count + count * sizeof(Due));
  bytes.put(group);
  bytes.put(count);
  comm::Header header = message.header();
  header.count += count;
  message.set_header(header);
  return bytes.extend(count * sizeof(Due));
}

}  // namespace

std::vector<Message> split(std::span<const BirthNumbers> groups, const roles::Ring& ring, int step) {
  std::vector<Message> messages(1 + ring.ahead(step).size());
  std::vector<std::uint8_t> digits;
  for (const BirthNumbers& group : groups) {
    const std::span<const Due> births = group.births;
    digits.resize(births.size());
    const DigitCounts counts = digits_of(births, ring, step, digits.data());
    std::array<std::byte*, roles::Ring::kDigits> next{};
    for (std::size_t m = 0; m < messages.size(); ++m) {
      if (counts[m] > 0) next[m] = make_room(group.group, counts[m], messages[m]);
    }
    for (std::size_t i = 0; i < births.size(); ++i) {
      std::byte*& at = next[digits[i]];
      std::memcpy(at, &births[i], sizeof(Due));
      at += sizeof(Due);
    }
  }
  return messages;
}

std::uint64_t join(std::span<const Message> messages, std::span<BirthNumbers> groups) {
  std::uint64_t count = 0;
  for (const Message& message : messages) {
    for (Reader in = message.reader(); !in.done();) {
      const auto group = in.get<std::uint32_t>();
      if (group >= groups.size()) throw std::runtime_error("a message has births of a group that is not in the round");
      const auto bytes = births_in(in);
      std::vector<Due>& births = groups[group].births;
      const std::size_t before = births.size();
      births.resize(before + bytes.size() / sizeof(Due));
      std::memcpy(births.data() + before, bytes.data(), bytes.size());
      count += births.size() - before;
    }
  }
  return count;
}

void take(Reader& in, std::uint32_t group, std::uint64_t count, std::vector<std::uint32_t>& numbers) {
  while (!in.done()) {
    Reader ahead = in;
    if (ahead.get<std::uint32_t>() != group) return;
    in = ahead;
    const auto bytes = births_in(in);
    const std::size_t before = numbers.size();
    numbers.resize(before + bytes.size() / sizeof(Due));
    for (std::size_t i = before; i < numbers.size(); ++i) {
      Due due;
      std::memcpy(&due, bytes.data() + (i - before) * sizeof due, sizeof due);
      if (due.number >= count) throw std::runtime_error("a message has a birth that is not in its group");
      numbers[i] = due.number;
    }
  }
}

}  // namespace motes::engine
