// The engine: the frame of the paper's Algorithm 1, told once for all roles. Every rank calls the same functions in the
// same order; each does its roles' part. The phases are functions over the parts that they use, one file per phase,
// with both ends of that phase's conversation.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frame/parts.h"
#include "frame/read.h"
#include "recording/sums.h"

namespace motes::frame {

class Engine {
 public:
  Engine(std::unique_ptr<comm::Communicator> communicator, roles::Cast cast, Settings settings);

  /// Who this rank is, what it plays, and which frame is being recorded.
  const Conversation& talk() const { return parts_.rank.talk; }
  std::uint64_t frame() const { return parts_.rank.talk.frame; }
  /// Seconds of this rank's phases in the last frame.
  const PhaseTimes& times() const { return parts_.rank.watch.last(); }

  /// Defines a system; its index is the same on all ranks that make the same calls.
  int add_system(recording::SystemDefinition definition);
  System& system(int index) { return *parts_.script.systems[static_cast<std::size_t>(index)]; }
  int system_count() const { return static_cast<int>(parts_.script.systems.size()); }

  /// Adds to this frame's list. Throws std::invalid_argument for what the system cannot take.
  void record(int system, recording::Item item);
  /// Adds an action between the particles of two systems: it stands at this place in both of their lists.
  void record_meeting(int first, int second, actions::Action action);

  /// See System::next_birth.
  std::pair<std::uint64_t, std::uint64_t> next_birth(int system) const;

  /// This rank's particles as they are where the script stands: runs what was recorded so far. Communicates nothing.
  Seen local(int system);
  /// What the last local() saw.
  Seen seen(int system) { return frame::seen(population(system)); }
  /// The script writes what the last local() saw, where that is a preview: see read.h.
  void keep_preview(int system) { frame::keep_preview(parts_.rank, parts_.script, parts_.calculator, system); }
  /// The script may have moved particles of this rank.
  void touched(int system) { population(system).moved = true; }
  void on_callback(std::function<void(const Call&)> call) { parts_.calculator.callback = std::move(call); }

  /// Collective. The start and the end of a run: all ranks are here, with the same systems and seed.
  void start();
  void finish();

  /// Collective. Ends the frame; with a view it has a picture.
  void run_frame(const std::optional<image::View>& view);
  Painter& painter() { return parts_.painter; }
  /// The image generator tells the log about its picture.
  void set_image_sha256(const std::string& hex) { parts_.calculator.tail.image_sha256 = hex; }
  /// Manager: warnings of the last frames; they are not told again.
  std::vector<std::string> take_remarks() { return std::exchange(parts_.manager.remarks, {}); }
  /// Manager: the last frame about which all is known, for progress and logs.
  const std::optional<FrameRow>& last_row() const { return parts_.manager.account.last_row(); }

  /// From now on, until the end, the engine keeps each frame's list. Without `compute` it makes no pictures, and on a
  /// single rank it computes no particles before catch_up(). To be called before start(), on all ranks.
  void keep_lists(bool compute);
  /// The recorded lists of the frames since then, as bytes.
  const std::vector<particles::Bytes>& kept_lists() const { return kept_.lists; }
  /// Computes what was only kept so far: particles, counts and cuts are then those of an ordinary run. Reading calls
  /// it.
  void catch_up();

  /// Collective. Fingerprints of all systems' particles where the script stands.
  std::vector<particles::Digest> digest();

  /// Collective. All particles of a system on rank 0, or on every rank; null elsewhere. Not sorted.
  std::unique_ptr<particles::Store> gather(int system, bool to_all);

  /// Collective. What a sum over all particles of a system comes to where the script stands, on every rank. `verb`:
  /// total, histogram or tally. Throws std::invalid_argument for what the system cannot sum.
  recording::Totals sum(int system, recording::Verb verb, const recording::Sum& what);

 private:
  // Lists that are kept for a scene file.
  struct Kept {
    bool on = false;
    bool pictures = true;  // frames are drawn
    bool only = false;  // nothing is computed
    std::vector<particles::Bytes> lists;

    void keep(Script& script);
  };

  template <class Compute>
  void look_at(int system, const Compute& compute);
  Population& population(int system) { return *parts_.calculator.populations[static_cast<std::size_t>(system)]; }

  Parts parts_;
  Kept kept_;
};

}  // namespace motes::frame
