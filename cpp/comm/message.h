// A message between two ranks: a header that is checked, then bytes.
#pragma once

#include <algorithm>
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

/// What kept a rank from sending a message earlier, seconds: first a wait that `rank` caused, then its own work.
struct Delay {
  std::int32_t rank = -1;  // -1: it had not waited, or for several ranks
  double waited_s = 0;
  double busy_s = 0;
};

struct Header {
  std::uint32_t magic = 0x73746f6d;  // "mots"
  std::uint32_t turn = 0;
  std::uint64_t frame = 0;
  std::uint64_t payload_bytes = 0;
  std::uint32_t count = 0;           // particles in the payload: a rank holds fewer than 2^32
  std::int32_t delay_rank = -1;      // see delay()
  std::uint32_t delay_waited = 0, delay_busy = 0;
  Phase phase = Phase::begin;
  std::uint8_t failed = 0;           // the sender's compute failed; the payload is void
  std::uint16_t chain_high = 0;      // see chain_s(); fills the padding, so all sent bytes are set
  std::uint32_t chain_low = 0;

  /// Returns what kept the sender from sending earlier. Stored in steps of 100 ns, up to seven minutes.
  Delay delay() const { return {delay_rank, 1e-7 * delay_waited, 1e-7 * delay_busy}; }
  void set_delay(const Delay& delay) {
    const auto steps = [](double seconds) { return static_cast<std::uint32_t>(std::clamp(1e7 * seconds, 0.0, 4e9)); };
    delay_rank = delay.rank;
    delay_waited = steps(delay.waited_s);
    delay_busy = steps(delay.busy_s);
  }

  /// Returns the length of the sender's chain of work (Ledger::chain_s), s; 0 if unknown. Stored in steps of 10 ns.
  double chain_s() const { return 1e-8 * (static_cast<double>(chain_high) * 0x1p32 + static_cast<double>(chain_low)); }
  void set_chain_s(double seconds) {
    const auto steps = static_cast<std::uint64_t>(1e8 * seconds);
    chain_high = static_cast<std::uint16_t>(steps >> 32);
    chain_low = static_cast<std::uint32_t>(steps);
  }
};
static_assert(sizeof(Header) == 48);

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
