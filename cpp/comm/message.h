// A message between two ranks: a header that is checked, then bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "particles/bytes.h"

namespace motes::comm {

/// The conversations of a frame. One MPI tag each.
enum class Phase : std::uint8_t { begin, report, verdict, exchange, records, gather, particles };
const char* name(Phase phase);

struct Header {
  std::uint32_t magic = 0x73746f6d;  // "mots"
  Phase phase = Phase::begin;
  std::uint8_t failed = 0;           // the sender's compute failed: the payload is empty
  std::uint16_t reserved = 0;
  std::uint64_t frame = 0;
  std::uint64_t count = 0;           // particles in the payload
  std::uint64_t payload_bytes = 0;
};
static_assert(sizeof(Header) == 32);

class Message {
 public:
  /// An empty one to be filled: bytes() holds the header's room already.
  Message() { bytes_.put(Header{}); }
  /// One that has arrived. Throws std::runtime_error where the bytes hold no header.
  explicit Message(particles::Bytes bytes) : bytes_(std::move(bytes)) { header(); }

  particles::Bytes& bytes() { return bytes_; }
  Header header() const {
    particles::Reader reader(bytes_.view());
    return reader.get<Header>();
  }
  void set_header(Header header) {
    header.payload_bytes = bytes_.size() - sizeof(Header);
    bytes_.set(0, header);
  }
  std::span<const std::byte> payload() const { return bytes_.view().subspan(sizeof(Header)); }
  particles::Reader reader() const { return particles::Reader(payload()); }

 private:
  particles::Bytes bytes_;
};

}  // namespace motes::comm
