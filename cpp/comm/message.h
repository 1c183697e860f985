// A message between two ranks: a header that is checked, then bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/bytes.h"

namespace motes::comm {

/// The phases of a frame's conversations. Each has its own MPI tag, so messages of different phases cannot be mixed up.
enum class Phase : std::uint8_t {
  begin,
  report,
  verdict,
  exchange,
  records,
  tiles,
  gather,
  plan,
  loads,
  proposals,
  births,
  log,
  sums,
  totals,
  all_reduce,
  interaction,
  notes,
  replicas,  // copies of particles, in case their rank is lost
  recovery,  // after the loss of a rank
  memory,    // where the image generator's pictures are in shared memory
  glow,      // light of tiles, sent to all other ranks for bloom
  shadows    // shadows of particles
};
inline constexpr int kPhases = 22;
/// Returns the phase's name; for kPhases "leave", a wait for own messages to leave.
const char* name(Phase phase);

/// The place of a message in the run, by which a rank that is a step ahead or behind is detected at once. This removes
/// the hazard in section 3.2 of the paper: a calculator sends twice before another has sent once.
struct Stamp {
  std::uint64_t frame = 0;
  std::uint32_t turn = 0;  // conversations so far; one frame may have several

  bool operator==(const Stamp&) const = default;
};

struct Header {
  std::uint32_t magic = 0x73746f6d;  // "mots"
  std::uint32_t turn = 0;
  std::uint64_t frame = 0;
  std::uint64_t count = 0;           // particles in the payload
  std::uint64_t payload_bytes = 0;
  Phase phase = Phase::begin;
  std::uint8_t failed = 0;           // the sender's compute failed; the payload is void
  std::uint16_t chain_high = 0;      // see chain_s(); fills the padding, so all sent bytes are set
  std::uint32_t chain_low = 0;

  /// Returns the length of the sender's chain of work (Ledger::chain_s), s; 0 if unknown. Stored in steps of 10 ns.
  double chain_s() const { return 1e-8 * (static_cast<double>(chain_high) * 0x1p32 + static_cast<double>(chain_low)); }
  void set_chain_s(double seconds) {
    const auto steps = static_cast<std::uint64_t>(1e8 * seconds);
    chain_high = static_cast<std::uint16_t>(steps >> 32);
    chain_low = static_cast<std::uint32_t>(steps);
  }
};
static_assert(sizeof(Header) == 40);

class Message {
 public:
  /// Makes an empty message to fill: bytes() already has space for the header.
  Message() { bytes_.put(Header{}); }
  /// Takes a message that has arrived. Throws std::runtime_error if the bytes hold no header.
  explicit Message(base::Bytes bytes) : bytes_(std::move(bytes)) { header(); }

  base::Bytes& bytes() { return bytes_; }
  const base::Bytes& bytes() const { return bytes_; }
  Header header() const {
    base::Reader reader(bytes_.view());
    return reader.get<Header>();
  }
  void set_header(Header header) {
    header.payload_bytes = bytes_.size() - sizeof(Header);
    bytes_.set(0, header);
  }
  Message copy() const {
    base::Bytes same;
    same.put_raw(bytes_.data(), bytes_.size());
    return Message(std::move(same));
  }
  std::span<const std::byte> payload() const { return bytes_.view().subspan(sizeof(Header)); }
  base::Reader reader() const { return base::Reader(payload()); }

 private:
  base::Bytes bytes_;
};

/// Returns the length of a message, header included, from its first bytes. Throws std::runtime_error if it is not one
/// of motes.
std::size_t whole_length(std::span<const std::byte> beginning);

}  // namespace motes::comm
