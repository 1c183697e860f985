#include "frame/birth_batch.h"

#include <cstring>
#include <stdexcept>
#include <utility>

#include "frame/places.h"

namespace motes::frame {

using comm::Message;
using particles::Reader;

BirthBatch::BirthBatch(std::uint32_t number, particles::Store newborn, const domains::Domains& domains)
    : group(number), store(std::move(newborn)), owners(store.size()) {
  domains.owners_of(places_of(store), owners.data());
}

std::vector<Message> split(std::span<const BirthBatch> batches, const roles::Ring& ring, int step) {
  std::vector<Message> messages(1 + ring.ahead(step).size());
  std::vector<std::uint8_t> digits;
  std::vector<std::uint32_t> sorted;
  for (const BirthBatch& batch : batches) {
    const auto count = static_cast<std::uint32_t>(batch.owners.size());
    std::vector<std::uint32_t> ends(messages.size() + 1, 0);  // of each message's particles among the sorted
    digits.resize(count);
    sorted.resize(count);
    for (std::uint32_t p = 0; p < count; ++p) {
      digits[p] = static_cast<std::uint8_t>(ring.digit(static_cast<int>(batch.owners[p]), step));
      ++ends.at(digits[p] + 1u);
    }
    for (std::size_t m = 0; m < messages.size(); ++m) ends[m + 1] += ends[m];
    for (std::uint32_t p = 0; p < count; ++p) sorted[ends[digits[p]]++] = p;
    std::uint32_t first = 0;
    for (std::size_t m = 0; m < messages.size(); first = ends[m++]) {
      const std::span<const std::uint32_t> chosen(sorted.data() + first, ends[m] - first);
      if (chosen.empty()) continue;
      particles::Bytes& out = messages[m].bytes();
      out.reserve(out.size() + sizeof batch.group + batch.store.packed_bytes(chosen.size()) +
                  chosen.size() * sizeof(std::uint32_t));
      out.put(batch.group);
      batch.store.pack(chosen, out);
      std::byte* owners = out.extend(chosen.size() * sizeof(std::uint32_t));
      for (std::size_t i = 0; i < chosen.size(); ++i) std::memcpy(owners + 4 * i, &batch.owners[chosen[i]], 4);
      comm::Header header = messages[m].header();
      header.count += chosen.size();
      messages[m].set_header(header);
    }
  }
  return messages;
}

std::uint64_t join(std::span<const Message> messages, std::span<BirthBatch> batches) {
  std::uint64_t count = 0;
  for (const Message& message : messages) {
    for (Reader in = message.reader(); !in.done();) {
      const auto group = in.get<std::uint32_t>();
      if (group >= batches.size()) throw std::runtime_error("births of a group that is not in the round");
      BirthBatch& batch = batches[group];
      batch.store.unpack(in);
      const std::size_t before = batch.owners.size();
      batch.owners.resize(batch.store.size());
      const auto owners = in.take((batch.owners.size() - before) * sizeof(std::uint32_t));
      std::memcpy(batch.owners.data() + before, owners.data(), owners.size());
      count += batch.owners.size() - before;
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
