// The engine: the frame of the paper's Algorithm 1, for all roles. Every rank calls the same functions in the same
// order, and each does the part of its roles. The phases are functions over the parts that they use; each file holds
// both ends of its phase's conversation. recovering_engine.h adds what survives the loss of ranks.
#pragma once

#include <array>
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
#include "engine/sums/sums.h"
#include "program/sums.h"
#include "snapshots/writer.h"
#include "surfaces/skin.h"

namespace motes::engine {

/// RecoveringEngine overrides the virtual functions.
class Engine {
 public:
  Engine(std::unique_ptr<comm::Communicator> communicator, roles::Cast cast, Settings settings);
  virtual ~Engine() = default;

  /// Returns this rank's session, with its rank, its roles and the frame being recorded.
  const Session& session() const { return parts_->rank.session; }
  /// Returns this rank's thread pool.
  threads::Pool& pool() const { return *parts_->rank.pool; }
  std::uint64_t frame() const { return parts_->rank.session.frame; }
  /// Returns the signal that asked a rank to stop before its report on the last frame, or 0. The same on all ranks.
  int stop_asked() const { return parts_->rank.session.stop; }
  /// Returns the seconds of this rank's phases in the last frame.
  const PhaseTimes& times() const { return parts_->rank.watch.last(); }

  /// Defines a system; its index is the same on all ranks that make the same calls.
  int add_system(recording::SystemDefinition definition);
  System& system(int index) { return *parts_->script.systems[static_cast<std::size_t>(index)]; }
  /// Sets how a system's particles are drawn. Throws std::invalid_argument if they cannot be drawn that way.
  void set_sprite(int index, const image::Sprite& sprite);
  int system_count() const { return static_cast<int>(parts_->script.systems.size()); }

  /// Appends an item to this frame's list. Throws std::invalid_argument if the item is not valid for the system.
  void record(int system, recording::Item item);
  /// Appends an action between the particles of two systems to both of their lists.
  /// `counterpart`: what the second list gets if its particles take part in another way; null: the same action, without
  /// its shapes and condition.
  void record_interaction(int first, int second, actions::Action action, const actions::Action* counterpart = nullptr);

  /// Returns the mean force and torque on a wall of the last frame: see force_on(). Does not communicate.
  std::optional<std::array<double, 6>> wall_force(const shapes::Shape& wall);

  /// Returns System::next_birth.
  std::pair<std::uint64_t, std::uint64_t> next_birth(int system);

  /// Runs what was recorded so far, and returns this rank's particles as they are then. Does not communicate. Throws
  /// any failure of that run; a run cannot be repeated from its middle, so all ranks learn of the failure in the next
  /// conversation.
  ParticlesView local(int system);
  /// Returns the result of the last local().
  ParticlesView seen(int system) { return engine::seen(population(system)); }
  /// Keeps the script's writes to the result of the last local() if that is a preview: see read.h.
  virtual void keep_preview(int system);
  /// Notes that the script may have moved particles of this rank.
  void touched(int system);
  void on_callback(std::function<void(const Call&)> call) { parts_->calculator.callback = std::move(call); }

  /// Begins (start) and ends (finish) a run, with the same systems and seed on all ranks. Collective.
  void start();
  virtual void finish();
  /// Waits until the log's rows of all frames so far are on disk; without it, they lag up to two frames behind. Throws
  /// on all ranks if one has failed, even if that was after the last verdict. Each rank first calls `first`, which
  /// flushes its other files to disk. Collective, between two frames.
  virtual void secure(const std::function<void()>& first = {});

  /// Returns the result of `say` on every rank, by rank. Collective, between two frames.
  virtual std::vector<std::string> tell(const std::function<std::string()>& say);

  /// Sets the camera of a frame that ends without a picture, so that the next picture's streaks begin there. Call just
  /// before run_frame(), equally on all ranks.
  void pass_camera(const image::Camera& camera) { parts_->script.passing = camera; }
  /// Runs the recorded list and ends the frame; with a view, draws a picture. `argument` must be the same on all ranks.
  /// Collective.
  virtual void run_frame(const std::optional<image::View>& view, const std::string& argument = "");
  /// Draws another picture of the particles; changes nothing else. Collective, between two frames.
  virtual void redraw(const image::View& view, const std::string& argument = "");

  /// Image generator: sets the function that returns viewers' orders as text; called once per frame and in
  /// hear_orders().
  virtual void on_orders(std::function<std::string()> orders) { parts_->rank.settings.orders = std::move(orders); }
  /// Returns viewers' orders from the last frame or hear_orders(); the same on all ranks.
  const std::string& orders() const { return parts_->rank.session.orders; }
  /// Sends orders and signals to all ranks, as a frame does. Collective, between two frames.
  virtual void hear_orders(const std::string& argument = "");

  Painter& painter() { return parts_->painter; }
  /// Image generator: sets the checksum of its picture for the log.
  void set_image_sha256(const std::string& hex) { parts_->calculator.tail.image_sha256 = hex; }
  /// Manager: returns the warnings since the last call.
  std::vector<std::string> take_remarks() { return std::exchange(parts_->manager.remarks, {}); }
  /// Manager: returns the row of the last complete frame, for progress and logs.
  const std::optional<FrameRow>& last_row() const { return parts_->manager.account.last_row(); }

  /// Keeps each frame's list from now on. Without `compute`, frames have no pictures, and a single rank computes no
  /// particles before catch_up(). Call before start(), on all ranks.
  void keep_lists(bool compute);
  /// Returns the lists kept since keep_lists(), as bytes.
  const std::vector<base::Bytes>& kept_lists() const { return kept_.lists; }
  /// Computes the frames whose lists were only kept so far; particles, counts and cuts are then those of an ordinary
  /// run. Called by all functions that read particles.
  void catch_up();

  /// Image generator: sets the first frame whose picture is not yet in a file; UINT64_MAX: none.
  void set_unsaved_from(std::uint64_t frame) { parts_->rank.session.unsaved_from = frame; }
  /// Counts this rank's time outside of frames as work on checkpoints, or as the script's again.
  void set_saving(bool saves) {
    parts_->rank.watch.ledger().turn_to(saves ? comm::Activity::checkpoint : comm::Activity::script);
  }

  /// Returns the state that all ranks share, as bytes. Call between two frames.
  base::Bytes shared_state() const;
  /// Describes this calculator's particles and appends their planes to `out`.
  snapshots::Description copy_part(base::Bytes& out) const {
    return engine::copy_part(parts_->rank, parts_->script, parts_->calculator, out);
  }
  /// Copies this calculator's particles and writes them to a file in the background, after the previous file is
  /// complete. No effect on other ranks.
  void save_part(const std::string& path);
  snapshots::Writer& part_writer() { return writer_; }
  const snapshots::Writer& part_writer() const { return writer_; }

  /// Restores a shared state: see engine/parts/snapshot.h. Call before the first frame, with the same state on all
  /// ranks.
  void restore_state(std::span<const std::byte> state, const std::vector<Sample>& samples);
  // NOLINTNEXTLINE(readability-make-member-function-const): particles change
  void restore_rows(const snapshots::Description& description, std::span<const std::byte> planes, std::size_t system,
                    std::uint64_t first, std::uint64_t last) {
    engine::restore_rows(parts_->rank, parts_->calculator, description, planes, system, first, last);
  }
  // NOLINTNEXTLINE(readability-make-member-function-const): speeds change
  void restore_speeds(const snapshots::Description& description) {
    engine::restore_speeds(parts_->calculator, description);
  }

  /// Returns digests of all systems' particles after the items recorded so far. Collective.
  virtual std::vector<particles::Digest> digest();

  /// Returns all particles of a system on rank 0, or on every rank; null elsewhere. Not sorted. Collective.
  virtual std::unique_ptr<particles::Store> gather(int system, bool to_all);

  /// Returns a sum over all particles of a system after the items recorded so far, on every rank. `verb`: total,
  /// histogram or tally. Throws std::invalid_argument if the sum is not valid for the system. Collective.
  virtual program::Totals sum(int system, recording::Verb verb, const program::Sum& what);

  /// Returns the surface of a system's particles after the items recorded so far, on every rank. Throws
  /// std::invalid_argument if the measure is not valid. Collective.
  virtual surfaces::Skin surface(int system, const surfaces::Measure& measure);

  /// Returns the notes of all ranks before particles are written to files. `prepare` returns this rank's note and may
  /// fail. `reads`: it reads particles, so what was recorded so far runs first. `what` must be the same on all ranks.
  /// Collective.
  virtual Notes prepare_write(const std::string& what, bool reads, const std::function<Note()>& prepare);

 protected:
  // Lists kept for a scene file.
  struct Kept {
    bool on = false;
    bool pictures = true;  // frames are drawn
    bool only = false;  // keep lists without computing
    std::vector<base::Bytes> lists;

    void keep(Script& script);
  };

  /// Counts time in a collective call, outside of its phases, as such, unless the script is saving a checkpoint.
  comm::ActivityScope between_phases();

  std::unique_ptr<Parts> parts_;
  Kept kept_;

 private:
  /// Runs what was recorded so far; returns nothing if this rank has failed, in this or earlier work.
  std::optional<ParticlesView> try_read(int system);
  template <class Compute>
  void look_at(int system, const Compute& compute);
  Population& population(int system) { return *parts_->calculator.populations[static_cast<std::size_t>(system)]; }

  snapshots::Writer writer_;
  double zero_ = 0;  // zero of timelines, in wall seconds
};

}  // namespace motes::engine
