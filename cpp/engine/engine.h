// The engine: the frame of the paper's Algorithm 1, told once for all roles. Every rank calls the same functions in the
// same order; each does its roles' part. The phases are functions over the parts that they use, one file per phase,
// with both ends of that phase's conversation.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/act/read.h"
#include "engine/parts/parts.h"
#include "engine/parts/snapshot.h"
#include "engine/recovery/loss.h"
#include "engine/recovery/replicas.h"
#include "engine/recovery/standing.h"
#include "engine/sums/sums.h"
#include "program/sums.h"
#include "snapshots/writer.h"

namespace motes::engine {

class Engine {
 public:
  Engine(std::unique_ptr<comm::Communicator> communicator, roles::Cast cast, Settings settings);

  /// Returns this rank's conversation: its rank, roles and the frame being recorded.
  const Session& session() const { return parts_->rank.session; }
  /// The threads of this rank.
  threads::Pool& pool() const { return *parts_->rank.pool; }
  std::uint64_t frame() const { return parts_->rank.session.frame; }
  /// The signal that asked some rank to stop before it had reported on the last frame, the same on all ranks; or 0.
  int stop_asked() const { return parts_->rank.session.stop; }
  /// Seconds of this rank's phases in the last frame.
  const PhaseTimes& times() const { return parts_->rank.watch.last(); }

  /// Defines a system; its index is the same on all ranks that make the same calls.
  int add_system(recording::SystemDefinition definition);
  System& system(int index) { return *parts_->script.systems[static_cast<std::size_t>(index)]; }
  /// Throws std::invalid_argument where the system's particles cannot be drawn so.
  void set_sprite(int index, const image::Sprite& sprite);
  int system_count() const { return static_cast<int>(parts_->script.systems.size()); }

  /// Adds to this frame's list. Throws std::invalid_argument for what the system cannot take.
  void record(int system, recording::Item item);
  /// Adds an action between the particles of two systems: it stands at this place in both of their lists.
  void record_interaction(int first, int second, actions::Action action);

  /// Returns System::next_birth.
  std::pair<std::uint64_t, std::uint64_t> next_birth(int system);

  /// This rank's particles as they are where the script stands: runs what was recorded so far. Communicates nothing.
  /// Throws what that fails with: it cannot run again from its middle, so all ranks hear of it in what they say next.
  ParticlesView local(int system);
  /// Returns what the last local() showed.
  ParticlesView seen(int system) { return engine::seen(population(system)); }
  /// The script writes what the last local() saw, where that is a preview: see read.h.
  void keep_preview(int system);
  /// The script may have moved particles of this rank.
  void touched(int system);
  void on_callback(std::function<void(const Call&)> call) { parts_->calculator.callback = std::move(call); }

  /// Collective. The start and the end of a run: all ranks are here, with the same systems and seed.
  void start();
  void finish();
  /// Collective, between two frames: returns where no rank has failed in the frames so far, also not behind the point
  /// at which all agreed on the last one; with the log's rows of all of them on the disk, which otherwise lag up to two
  /// frames behind. Each rank first does `first`, which brings to the disk what it writes beside the log. Where ranks
  /// are lost meanwhile, those that are left do it again before they return.
  void secure(const std::function<void()>& first = {});

  /// Collective, between two frames: what each rank says, by rank, on every rank. `say` is asked again where ranks are
  /// lost meanwhile, also on a rank that has heard the answers before: these must not depend on which time it was. It
  /// is kept until the next call.
  std::vector<std::string> tell(const std::function<std::string()>& say);

  /// Collective. Ends the frame; with a view it has a picture. All ranks agree on `argument`.
  void run_frame(const std::optional<image::View>& view, const std::string& argument = "");
  /// Collective, between two frames. Another picture of the particles as they are, which changes nothing else.
  void redraw(const image::View& view, const std::string& argument = "");

  /// Image generator: what viewers ask for, as text; asked once in each frame, and in hear_orders().
  void on_orders(std::function<std::string()> orders);
  /// Returns viewers' orders of the last frame or hear_orders(), the same on all ranks.
  const std::string& orders() const { return parts_->rank.session.orders; }
  /// Collective, between two frames. Brings orders and signals to all ranks, as a frame does.
  void hear_orders(const std::string& argument = "");

  Painter& painter() { return parts_->painter; }
  /// The image generator tells the log about its picture.
  void set_image_sha256(const std::string& hex) { parts_->calculator.tail.image_sha256 = hex; }
  /// Manager: warnings of the last frames; they are not told again.
  std::vector<std::string> take_remarks() { return std::exchange(parts_->manager.remarks, {}); }
  /// Manager: the last frame about which all is known, for progress and logs.
  const std::optional<FrameRow>& last_row() const { return parts_->manager.account.last_row(); }

  /// Keeps each frame's list from now on. Without `compute` it makes no pictures, and on a single rank computes no
  /// particles before catch_up(). Call before start(), on all ranks.
  void keep_lists(bool compute);
  /// The recorded lists of the frames since then, as bytes.
  const std::vector<base::Bytes>& kept_lists() const { return kept_.lists; }
  /// Computes what was only kept so far: particles, counts and cuts are then those of an ordinary run. Reading calls
  /// it.
  void catch_up();

  /// Survives losses of ranks from now on: keeps replicas of all particles before every `every`-th frame. A collective
  /// call that a loss interrupts is repeated on the remaining ranks, in the world as it was; if that is impossible, it
  /// throws Unrecoverable on all of them. Call after start(), on all ranks, where the communicator survives losses.
  void survive_losses(std::uint64_t every, Bystander bystander);
  /// Collective, behind restore_rows() on all ranks: replicas from here on. Throws RankLost where a rank is lost before
  /// all have theirs.
  void copy_restored();
  /// The image generator: pictures of the frames from here on are in no file yet. UINT64_MAX: none.
  void set_unsaved_from(std::uint64_t frame) { parts_->rank.session.unsaved_from = frame; }
  /// Returns how often ranks were lost so far.
  std::uint32_t losses() const { return replicas_.losses; }

  /// Between two frames: what all ranks know of the world, equal on all of them.
  base::Bytes shared_state() const;
  /// This calculator's particles: the planes are appended to `out`.
  snapshots::Description copy_part(base::Bytes& out) const {
    return engine::copy_part(parts_->rank, parts_->script, parts_->calculator, out);
  }
  /// Copies this calculator's particles, and writes them to a file while frames go on; waits for the part before. Other
  /// ranks have no part.
  void save_part(const std::string& path);
  snapshots::Writer& part_writer() { return writer_; }
  const snapshots::Writer& part_writer() const { return writer_; }

  /// The world goes on from such a state: see engine/parts/snapshot.h. Before its first frame, equal on all ranks.
  void restore_state(std::span<const std::byte> state, const std::vector<Sample>& samples);
  // NOLINTNEXTLINE(readability-make-member-function-const): particles change
  void restore_rows(const snapshots::Description& description, std::span<const std::byte> planes, std::size_t system,
                    std::uint64_t first, std::uint64_t last) {
    engine::restore_rows(parts_->rank, parts_->calculator, description, planes, system, first, last);
  }
  // NOLINTNEXTLINE(readability-make-member-function-const): speeds do
  void restore_speeds(const snapshots::Description& description) {
    engine::restore_speeds(parts_->calculator, description);
  }

  /// Collective. Fingerprints of all systems' particles where the script stands.
  std::vector<particles::Digest> digest();

  /// Collective. All particles of a system on rank 0, or on every rank; null elsewhere. Not sorted.
  std::unique_ptr<particles::Store> gather(int system, bool to_all);

  /// Collective. What a sum over all particles of a system comes to where the script stands, on every rank. `verb`:
  /// total, histogram or tally. Throws std::invalid_argument for what the system cannot sum.
  program::Totals sum(int system, recording::Verb verb, const program::Sum& what);

  /// Collective. What each rank has to tell before particles are written to files: what `prepare` returns, which may
  /// fail. Where it reads particles, what was recorded so far runs first. All ranks agree on `what`.
  Notes prepare_write(const std::string& what, bool reads, const std::function<Note()>& prepare);

 private:
  // Lists that are kept for a scene file.
  struct Kept {
    bool on = false;
    bool pictures = true;  // frames are drawn
    bool only = false;  // keep lists without computing
    std::vector<base::Bytes> lists;

    void keep(Script& script);
  };

  // A collective call that ended on this rank; it is repeated if it did not end on others.
  struct Ended {
    std::uint64_t count = 0;  // number of calls so far, this one included
    bool frame = false;  // the call is a frame, whose list is kept
    std::function<void()> again;  // another call, if it can be made again
    std::vector<std::size_t> before, after;  // lengths of the lists
  };

  // The call that a loss interrupted.
  struct Interrupted {
    std::vector<std::unique_ptr<System>> systems;
    std::function<void(const Call&)> callback;
    std::uint64_t unsaved_from = UINT64_MAX;
    Announced announced;
    std::string refusal;
  };

  void start_now();
  void finish_now();
  void secure_now(const std::function<void()>& first);
  std::vector<std::string> tell_now(const std::function<std::string()>& say);
  void run_frame_now(const std::optional<image::View>& view, const std::string& argument);
  void redraw_now(const image::View& view, const std::string& argument);
  void hear_orders_now(const std::string& argument);
  std::vector<particles::Digest> digest_now();
  std::unique_ptr<particles::Store> gather_now(int system, bool to_all);
  program::Totals sum_now(int system, recording::Verb verb, const program::Sum& what);
  Notes prepare_write_now(const std::string& what, bool reads, const std::function<Note()>& prepare);

  /// Runs what was recorded so far; nothing where this rank has failed, in that or before.
  std::optional<ParticlesView> try_read(int system);
  template <class Compute>
  void look_at(int system, const Compute& compute);
  Population& population(int system) { return *parts_->calculator.populations[static_cast<std::size_t>(system)]; }

  // recover.cpp
  template <class Now>
  auto surviving(const Now& now, bool frame, std::function<void()> again = {});
  std::vector<std::size_t> lengths() const;
  void recover();
  void regroup();
  void bring_lists_back();
  Standing standing() const;
  void start_again(const Generation& from);
  void go_back(const WayBack& way);
  void run_again(const WayBack& way, bool ahead);
  void replay_frame(const KeptList& list, const WayBack& way);
  void record_items(const std::vector<std::size_t>& from, const std::vector<std::size_t>& to);

  std::unique_ptr<Parts> parts_;
  Kept kept_;
  snapshots::Writer writer_;

  Replicas replicas_;
  Bystander bystander_;
  Ended last_;
  std::vector<std::size_t> before_;  // lengths of the lists when the current call began
  std::uint64_t frame_before_ = 0;  // and where it stands
  bool wrote_ = false;  // the script wrote to particles in the frame under way
  bool recovering_ = false;
  std::unique_ptr<Interrupted> interrupted_;
  std::optional<Announced> announced_;  // announced by ranks that made the current call already
  Loss loss_;
  double zero_ = 0;  // zero of timelines
};

}  // namespace motes::engine
