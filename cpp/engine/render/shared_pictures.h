// Shared memory for pictures, into which ranks on the image generator's host draw their tiles without messages or
// copies.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "comm/message.h"
#include "comm/shared_memory.h"
#include "engine/render/render_plan.h"
#include "engine/session/rank.h"

namespace motes::engine {

/// A few pictures, used in turn: pixels, or sums of light if the picture is tone-mapped as a whole (see
/// image::PictureLight). A picture that is still held, for example by the script, is not drawn into again.
class SharedPictures {
 public:
  /// More pictures than a script holds that handles one frame after the other.
  static constexpr std::size_t kPictures = 4;
  /// Maximum bytes of a picture; tiles of larger ones are sent in messages, since several might not fit into memory.
  static constexpr std::size_t kLargest = std::size_t{1} << 29;

  /// Makes room for pictures of `bytes` bytes, and sends the memory's address to ranks that draw for the first time;
  /// these wait for it. All ranks call it with the same size and plan before they draw.
  void interact(Rank& rank, std::size_t bytes, const RenderPlan& plan);

  /// Image generator: returns memory for a picture, which other ranks can then find; null if no picture is free.
  std::shared_ptr<std::uint8_t[]> open(std::size_t bytes, comm::Stamp stamp);
  /// Image generator: tells whether other ranks may have found the memory of this picture.
  bool opened(comm::Stamp stamp) const { return opened_ == sign_of(stamp); }
  /// Other ranks: returns the memory of this picture; null if it has none or the image generator has not opened it yet.
  std::uint8_t* find(comm::Stamp stamp);

 private:
  // Returns the number that marks a picture's memory with its stamp; 0 marks none.
  static std::uint64_t sign_of(comm::Stamp stamp) { return ((stamp.frame << 32) | stamp.turn) + 1; }

  // The image generator's record of a picture's memory.
  struct Use {
    std::atomic<bool> taken{false};
    std::uint64_t forks = 0;  // forks of this process when the picture was taken
  };
  using Uses = std::array<Use, kPictures>;

  std::size_t memory_bytes() const;
  std::uint8_t* pixels(std::size_t picture);
  std::atomic_ref<std::uint64_t> sign(std::size_t picture);
  void tell(Rank& rank, int to);
  void hear(Rank& rank);

  std::size_t bytes_ = 0;  // bytes of the largest picture so far, the same on all ranks
  std::vector<bool> met_;  // by rank: has received the memory's address
  std::shared_ptr<comm::SharedMemory> memory_;  // signs, then pictures
  std::shared_ptr<Uses> uses_;
  std::uint64_t opened_ = 0;
};

}  // namespace motes::engine
