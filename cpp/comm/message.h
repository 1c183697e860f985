// A message between two ranks: a header that is checked, then bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/bytes.h"

namespace motes::comm {

/// The conversations of a frame. Messages of different phases do not overtake each other's order: one MPI tag each.
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
  replicas,  // of particles, kept for the loss of their rank
  recovery,  // after such a loss
  memory,    // where the image generator's pictures are
  glow,      // light of tiles on its way to all others
  shadows    // of particles, where those who draw are no calculators
};
inline constexpr int kPhases = 22;
/// Returns the phase's name; beyond the last: "leave", for messages that are to leave.
const char* name(Phase phase);

/// Where in the run a message belongs: a rank that is a step ahead or behind is found out at once. This answers the
/// paper's hazard of a calculator that sends twice before another has sent once (3.2).
struct Stamp {
  std::uint64_t frame = 0;
  std::uint32_t turn = 0;  // conversations so far: several may fall into one frame

  bool operator==(const Stamp&) const = default;
};

struct Header {
  std::uint32_t magic = 0x73746f6d;  // "mots"
  std::uint32_t turn = 0;
  std::uint64_t frame = 0;
  std::uint64_t count = 0;           // particles in the payload
  std::uint64_t payload_bytes = 0;
  Phase phase = Phase::begin;
  std::uint8_t failed = 0;           // the sender's compute failed: the payload says nothing
  std::uint16_t chain_high = 0;      // see chain_s(); no padding: all bytes that are sent are set
  std::uint32_t chain_low = 0;

  /// Where the sender's chain of work stood (Ledger::chain_s), seconds; 0 if unknown. Kept in steps of 10 ns.
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
  /// An empty one to be filled: bytes() holds the header's room already.
  Message() { bytes_.put(Header{}); }
  /// One that has arrived. Throws std::runtime_error where the bytes hold no header.
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

/// The length of a message, header included, of which the beginning has arrived. Throws std::runtime_error where that
/// is no message of ours.
std::size_t whole_length(std::span<const std::byte> beginning);

}  // namespace motes::comm
