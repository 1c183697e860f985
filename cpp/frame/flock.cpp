#include "frame/flock.h"

#include <cstring>
#include <stdexcept>
#include <utility>

namespace motes::frame {

using comm::Message;
using particles::Reader;

Flock::Flock(std::uint32_t number, particles::Store newborn, const domains::Domains& domains, int axis)
    : group(number), store(std::move(newborn)), owners(store.size()) {
  domains.owners_of({store.plane(particles::position, axis), store.size()}, owners.data());
}

std::vector<Message> split(std::span<const Flock> flocks, const roles::Ring& ring, int step) {
  std::vector<Message> messages(1 + ring.ahead(step).size());
  std::vector<std::uint8_t> digits;
  std::vector<std::uint32_t> sorted;
  for (const Flock& flock : flocks) {
    const auto count = static_cast<std::uint32_t>(flock.owners.size());
    std::vector<std::uint32_t> ends(messages.size() + 1, 0);  // of each message's particles among the sorted
    digits.resize(count);
    sorted.resize(count);
    for (std::uint32_t p = 0; p < count; ++p) {
      digits[p] = static_cast<std::uint8_t>(ring.digit(static_cast<int>(flock.owners[p]), step));
      ++ends.at(digits[p] + 1u);
    }
    for (std::size_t m = 0; m < messages.size(); ++m) ends[m + 1] += ends[m];
    for (std::uint32_t p = 0; p < count; ++p) sorted[ends[digits[p]]++] = p;
    std::uint32_t first = 0;
    for (std::size_t m = 0; m < messages.size(); first = ends[m++]) {
      const std::span<const std::uint32_t> chosen(sorted.data() + first, ends[m] - first);
      if (chosen.empty()) continue;
      particles::Bytes& out = messages[m].bytes();
      out.reserve(out.size() + sizeof flock.group + flock.store.packed_bytes(chosen.size()) +
                  chosen.size() * sizeof(std::uint32_t));
      out.put(flock.group);
      flock.store.pack(chosen, out);
      std::byte* owners = out.extend(chosen.size() * sizeof(std::uint32_t));
      for (std::size_t i = 0; i < chosen.size(); ++i) std::memcpy(owners + 4 * i, &flock.owners[chosen[i]], 4);
      comm::Header header = messages[m].header();
      header.count += chosen.size();
      messages[m].set_header(header);
    }
  }
  return messages;
}

std::uint64_t join(std::span<const Message> messages, std::span<Flock> flocks) {
  std::uint64_t count = 0;
  for (const Message& message : messages) {
    for (Reader in = message.reader(); !in.done();) {
      const auto group = in.get<std::uint32_t>();
      if (group >= flocks.size()) throw std::runtime_error("births of a group that is not in the round");
      Flock& flock = flocks[group];
      flock.store.unpack(in);
      const std::size_t before = flock.owners.size();
      flock.owners.resize(flock.store.size());
      const auto owners = in.take((flock.owners.size() - before) * sizeof(std::uint32_t));
      std::memcpy(flock.owners.data() + before, owners.data(), owners.size());
      count += flock.owners.size() - before;
    }
  }
  return count;
}

void take(Reader& in, std::uint32_t group, particles::Store& store) {
  while (!in.done()) {
    Reader ahead = in;
    if (ahead.get<std::uint32_t>() != group) return;
    in = ahead;
    const std::size_t before = store.size();
    store.unpack(in);
    in.take((store.size() - before) * sizeof(std::uint32_t));  // whose they are: this calculator's
  }
}

}  // namespace motes::frame
