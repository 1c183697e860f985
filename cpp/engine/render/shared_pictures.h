// Memory of pictures in which the ranks of the image generator's host draw their tiles: no message holds those pixels,
// and nobody copies them.
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

/// A few pictures, used in turn: pixels, or sums of light where the picture is shown as a whole (see
/// image::PictureLight). One that somebody still holds, such as the script, is not drawn into again.
class SharedPictures {
 public:
  /// More than a script holds that looks at one frame after the other.
  static constexpr std::size_t kPictures = 4;
  /// Bytes of a picture above which its tiles travel in messages: there may be no room for several such pictures.
  static constexpr std::size_t kLargest = std::size_t{1} << 29;

  /// The image generator tells those that draw for the first time where the memory is: this makes room for pictures of
  /// so many bytes. All ranks call it with the same size and plan, before they draw; a rank that draws for the first
  /// time waits for the image generator.
  void interact(Rank& rank, std::size_t bytes, const RenderPlan& plan);

  /// Image generator: memory for a picture, which the others then find. Null where there is none that nobody uses.
  std::shared_ptr<std::uint8_t[]> open(std::size_t bytes, comm::Stamp stamp);
  /// Image generator: whether others may have found the memory of this picture.
  bool opened(comm::Stamp stamp) const { return opened_ == sign_of(stamp); }
  /// The others: the memory of this picture; null where it has none, or the image generator has not opened it yet.
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
  std::vector<bool> met_;  // by rank: has been told of this memory
  std::shared_ptr<comm::SharedMemory> memory_;  // signs, then pictures
  std::shared_ptr<Uses> uses_;
  std::uint64_t opened_ = 0;
};

}  // namespace motes::engine
