// The frame: the paper's Algorithm 1, told once for all roles. Every rank calls the same functions in the same order;
// each does its roles' part. One file a phase holds both ends of that phase's conversation.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "comm/communicator.h"
#include "frame/log.h"
#include "frame/report.h"
#include "frame/system.h"
#include "image/canvas.h"
#include "image/records.h"
#include "recording/record.h"
#include "roles/cast.h"

namespace motes::frame {

/// All ranks agreed that one of them failed, or that their scripts differ; every rank throws this, but the one whose
/// compute failed throws its original exception.
class Agreed : public std::runtime_error {
 public:
  Agreed(Verdict verdict, std::uint64_t frame, std::string role, const std::string& text)
      : std::runtime_error(text), verdict_(std::move(verdict)), frame_(frame), role_(std::move(role)) {}
  const Verdict& verdict() const { return verdict_; }
  const std::string& role() const { return role_; }  // of verdict().failed_rank
  std::uint64_t frame() const { return frame_; }

 private:
  Verdict verdict_;
  std::uint64_t frame_;
  std::string role_;
};

struct Options {
  std::uint64_t seed = 0;
  double dt = 1.0 / 24;  // seconds a frame
  int substeps = 1;
  bool digest = false;   // fingerprint the particles of every frame for the log
  std::string log;       // directory, or empty
  std::vector<std::string> hosts;  // one a rank
};

class Engine {
 public:
  Engine(std::unique_ptr<comm::Communicator> communicator, roles::Cast cast, Options options);

  int rank() const { return comm_->rank(); }
  const roles::Cast& cast() const { return cast_; }
  std::uint64_t frame() const { return frame_; }
  bool draws() const { return rank() == cast_.image_generator; }
  bool manages() const { return rank() == cast_.manager; }
  int calculator() const { return cast_.calculator_of(rank()); }

  /// Defines a system; its index is the same on all ranks that make the same calls.
  int add_system(recording::SystemDefinition definition);
  System& system(int index) { return *systems_[static_cast<std::size_t>(index)]; }
  int system_count() const { return static_cast<int>(systems_.size()); }

  /// Adds to this frame's list.
  void record(int system, recording::Item item);

  /// This rank's particles as they are where the script stands: runs what was recorded so far. Communicates nothing:
  /// each calculator makes the newborn of its own domain.
  particles::Store& local(int system);
  /// The script may have moved particles of this rank.
  void touched(int system) { this->system(system).moved = true; }

  /// How the script's callbacks are called: with a system, the callback's number and the first particle it concerns.
  void on_callback(std::function<void(int system, int callback, std::size_t begin)> call) {
    callback_ = std::move(call);
  }

  /// Collective. The first and the last word of a run: all ranks are here, with the same systems and seed.
  void start();
  void finish();

  /// Collective. Ends the frame: create, act, move, agree, exchange; with a view the picture too.
  void run_frame(const std::optional<image::View>& view);

  /// The picture of the last frame, on the image generator: height * width * 3 bytes of sRGB, moved out.
  std::vector<std::uint8_t> take_pixels() { return std::move(pixels_); }

  /// Whether frames keep the light that linear() returns: linear RGB, height * width * 3, of the last frame.
  bool keeps_linear() const { return keep_linear_; }
  void keep_linear(bool keep) { keep_linear_ = keep; }
  std::vector<float> linear() const { return canvas_.linear(); }

  /// Collective. Fingerprints of all systems' particles where the script stands.
  std::vector<particles::Digest> digest();

  /// Collective. All particles of a system on rank 0, or on every rank; null elsewhere. Not sorted.
  std::unique_ptr<particles::Store> gather(int system, bool to_all);

  /// Seconds of this rank's phases in the last frame.
  const PhaseTimes& times() const { return times_; }
  /// Manager: the last frame about which all is known, for progress and logs.
  const std::optional<FrameRow>& last_row() const { return last_row_; }
  /// The image generator tells the log about its picture.
  void set_image_sha256(const std::string& hex) { tail_.image_sha256 = hex; }

 private:
  using Stores = std::vector<particles::Store>;

  // frame.cpp
  bool in_frame() const { return record_.verb == recording::Verb::render || record_.verb == recording::Verb::step; }
  void begin_frame(recording::Verb verb, const std::optional<image::View>& view, const std::string& argument);
  void end_frame();
  comm::Stamp stamp() const { return {frame_, turn_}; }
  template <class Work>
  void work(const std::string& action, const Work& compute);
  void converse(recording::Verb verb, const std::string& argument);

  // create.cpp: manager -> all
  void create();
  struct Hand {  // newborn particles for one calculator
    particles::Bytes bytes;
    std::uint64_t count = 0;
  };
  void deal();
  static void deal_out(const System& system, const particles::Store& newborn, std::vector<Hand>& hands);
  comm::Message receive_births();
  void make_births(System& system, const std::vector<BirthGroup>& groups, Stores& newborn);
  void fit(System& system, const Stores& newborn) const;
  static particles::Store make_children(System& system);

  // act.cpp: calculators
  void act(const comm::Message& births);
  void act_on_all(particles::Reader& births, std::uint64_t expected);
  static void take_cuts(System& system, particles::Reader& in);
  void act_on(System& system, const std::vector<BirthGroup>& groups, particles::Reader& births);
  void run_list(System& system, const std::vector<BirthGroup>& groups, std::size_t children,
                const std::function<void(std::size_t)>& append);
  recording::Slice slice_of(const System& system) const;
  void run_pieces(System& system, const std::vector<Piece>& pieces, std::size_t begin, std::size_t entry,
                  int first_substep);
  void call_back(System& system, int number, std::size_t begin);
  static void drop_dead(recording::Outcome& outcome);
  static void note_events(System& system, const std::vector<const recording::Spawn*>& rules,
                          const std::vector<std::uint32_t>& newborn);
  void pack_leavers(System& system, std::size_t index);

  // agree.cpp: all -> manager -> all
  void agree();
  Report own_report();
  void judge();
  void collect_offspring(std::vector<Report>& reports, Verdict& verdict);
  Verdict compare(std::vector<Report>& reports) const;
  Verdict mismatch(std::vector<Report>& reports) const;
  void obey(Verdict verdict);

  // exchange.cpp: calculators <-> calculators
  void exchange();

  // render.cpp: calculators -> image generator
  void render();
  void send_sprites();
  void draw();

  // rows.cpp: the manager's account
  void note_frame(const std::vector<Report>& reports, const Verdict& verdict);
  void note_imbalance(const std::vector<Report>& reports, FrameRow& row) const;
  void note_loads(const std::vector<Report>& reports, std::size_t system, FrameRow& row) const;
  void note_tails(const std::vector<Report>& reports);

  std::function<void(int system, int callback, std::size_t begin)> callback_;
  std::unique_ptr<comm::Communicator> comm_;
  roles::Cast cast_;
  Options options_;
  std::vector<std::unique_ptr<System>> systems_;
  std::uint64_t frame_ = 0;
  std::uint32_t turn_ = 0;  // conversations so far

  recording::Record record_;
  particles::Bytes record_bytes_;
  std::vector<std::vector<BirthGroup>> groups_;  // one a system
  Failure failure_;
  bool broken_ = false;  // all agreed on a failure: particles are half-way through a frame
  std::exception_ptr own_exception_;
  std::vector<comm::Message> leaving_;            // one a calculator
  std::vector<std::vector<Sent>> sent_;           // one a system
  std::vector<particles::Digest> digests_;        // one a system: this rank's, then the agreed ones
  std::vector<std::uint64_t> exchange_bytes_;     // one a system
  Verdict verdict_;
  image::Projector projector_;
  image::Records records_;
  image::Canvas canvas_;
  bool keep_linear_ = false;
  std::vector<std::uint8_t> pixels_;

  PhaseTimes times_;
  double frame_start_s_ = 0;
  double waited_before_s_ = 0;
  Tail tail_;
  std::unique_ptr<Log> log_;
  std::optional<FrameRow> open_row_;   // waits for the tails
  std::optional<FrameRow> last_row_;
};

}  // namespace motes::frame
