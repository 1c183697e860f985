// The frame: the paper's Algorithm 1, told once for all roles. Every rank calls the same functions in the same order;
// each does its roles' part. One file a phase holds both ends of that phase's conversation.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "balance/policy.h"
#include "comm/communicator.h"
#include "frame/costs.h"
#include "frame/flock.h"
#include "frame/log.h"
#include "frame/relay.h"
#include "frame/report.h"
#include "frame/round.h"
#include "frame/spans.h"
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

/// Who makes newborn particles: the manager, which deals them out (paper 3.2.1), or each calculator a part of them.
enum class Births : std::uint8_t { manager, calculators };

struct Options {
  std::uint64_t seed = 0;
  double dt = 1.0 / 24;  // seconds a frame
  int substeps = 1;
  bool digest = false;   // fingerprint the particles of every frame for the log
  std::string log;       // directory, or empty
  std::vector<std::string> hosts;  // one a rank
  balance::PolicyPtr policy;       // null: cuts stay
  Combine combine = Combine::together;
  bool wall_clock = false;  // what compute seconds are: processor time of this thread, or wall time
  double speed = 1;         // 0..1: this rank spends as much time as a machine of this part of its speed would
  bool spans = false;       // write a timeline of each rank to the log
  Births births = Births::manager;
  int fan_out = 8;          // to so many ranks at most one passes the manager's words on
  bool blocking = false;    // calculators wait until the image generator has taken their particles (paper)
  Costs costs;              // of work on a simulated machine
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

  /// One call of a function of the script: of particles `begin`.. of a system or, where a condition stands, of those
  /// at the indices `chosen`.
  struct Call {
    int system;
    int callback;  // its number
    std::size_t begin;
    const std::vector<std::uint32_t>* chosen;
  };
  void on_callback(std::function<void(const Call&)> call) { callback_ = std::move(call); }

  /// Collective. The first and the last word of a run: all ranks are here, with the same systems and seed.
  void start();
  void finish();

  /// Collective. Ends the frame: create, act, move, agree, exchange; with a view the picture too.
  void run_frame(const std::optional<image::View>& view);

  /// From now on, until the end, the engine keeps each frame's list. Without `compute` it makes no pictures, and on a
  /// single rank it computes no particles before catch_up(). To be called before start(), on all ranks.
  void keep_lists(bool compute);
  /// The recorded lists of the frames since then, as bytes.
  const std::vector<particles::Bytes>& kept_lists() const { return kept_; }
  /// Computes what was only kept so far: particles, counts and cuts are then those of an ordinary run. Reading calls
  /// it.
  void catch_up();

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
  const PhaseTimes& times() const { return last_times_; }
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
  void split();
  void talk();
  void open(std::size_t round);
  void settle(Round& round);
  void close(Round& round);
  void keep_list();  // keep.cpp
  comm::Stamp stamp() const { return {frame_, turn_}; }
  comm::Stamp stamp(const Round& round) const { return {frame_, round.turn}; }
  std::string name_of(const Round& round) const;
  template <class Work>
  void work(const std::string& action, const Work& compute);
  void converse(recording::Verb verb, const std::string& argument);

  // work.h: what a phase took, for times and spans
  class Timed {
   public:
    Timed(Engine& engine, double& seconds, const char* phase, std::string system = "");
    ~Timed();
    Timed(const Timed&) = delete;
    Timed& operator=(const Timed&) = delete;

   private:
    Engine& engine_;
    double& seconds_;
    const char* phase_;
    std::string system_;
    double start_;
  };
  double compute_seconds() const;
  void slow_down(double since) const;
  void charge(double nanoseconds) const;

  // create.cpp: manager -> all
  void count_births();
  struct Newborn {  // what a calculator got of a round's births
    Heard heard;                             // the manager's message
    particles::Reader dealt{{}};             // children, and births where the manager makes them
    bool shared = false;                     // the calculators made them:
    std::vector<comm::Message> shares;       // from several, each with packs of groups in their order
    std::vector<particles::Reader> readers;  // of the shares
    std::uint32_t group = 0;                 // the next to be taken
    std::uint64_t count = 0;                 // particles in all of it
  };
  void deal(const Round& round);
  void deal_groups(std::size_t system, std::vector<Part>& hands);
  static void put_cuts(System& system, particles::Bytes& out);
  void deal_out(const System& system, const particles::Store& newborn, std::vector<Part>& hands) const;
  Newborn receive_births(std::size_t round);
  using Use = std::function<void(particles::Store&&)>;
  void make_births(const System& system, const BirthGroup& group, std::uint64_t first, std::uint64_t last,
                   const Use& use) const;
  void fit(System& system, const std::vector<BirthGroup>& groups, const Stores& children) const;
  bool bears_its_own() const;
  void bear(System& system, const BirthGroup& group) const;
  static void take_births(System& system, const BirthGroup& group, Newborn& newborn);
  static particles::Store make_children(System& system);

  // share.cpp: calculators <-> calculators
  bool shares_births(const Round& round) const;
  void share_births(const Round& round, Newborn& newborn);
  std::vector<Flock> make_share(const Round& round) const;
  std::vector<Flock> between_steps(const Round& round, const std::vector<comm::Message>& messages) const;
  std::vector<comm::Message> pass_on(const Round& round, const roles::Ring& ring, int step,
                                     std::vector<comm::Message> messages);
  static void take_shares(System& system, Newborn& newborn);

  // act.cpp: calculators
  void act(Round& round, Newborn& newborn);
  void act_on_all(Round& round, Newborn& newborn);
  static void take_cuts(System& system, particles::Reader& in);
  void act_on(System& system, const std::vector<BirthGroup>& groups, Newborn& newborn);
  void run_list(System& system, const std::vector<BirthGroup>& groups, std::size_t children,
                const std::function<void(const BirthGroup&)>& append);
  void charge_list(const System& system) const;
  recording::Slice slice_of(const System& system) const;
  void run_pieces(System& system, const std::vector<Piece>& pieces, std::size_t begin, std::size_t entry,
                  int first_substep);
  void order();
  static void order(System& system, std::size_t first);
  void call_back(System& system, const recording::Callback& callback, std::size_t begin);
  static void drop_dead(recording::Outcome& outcome);
  static void note_events(System& system, const std::vector<const recording::Spawn*>& rules,
                          const std::vector<std::uint32_t>& newborn);
  void pack_leavers(Round& round, std::size_t index);

  // agree.cpp: all -> manager -> all
  void report(Round& round);
  Report own_report(const Round& round);
  void judge(Round& round);
  void sum_up(const Round& round, const std::vector<Report>& reports, Verdict& verdict,
              std::vector<Orders>& orders) const;
  void collect_offspring(const Round& round, std::vector<Report>& reports, Verdict& verdict);
  Verdict compare(std::vector<Report>& reports) const;
  Verdict mismatch(std::vector<Report>& reports) const;
  void obey(Round& round, Verdict verdict, Orders orders);

  // exchange.cpp: calculators <-> calculators
  void send_leavers(Round& round);
  void receive_strangers(Round& round);

  // balance.cpp: calculators -> manager, or calculators <-> calculators -> manager, where the verdict asks for it
  bool balances() const;
  std::vector<std::size_t> systems_to_balance(const Round& round) const;
  void plan(const Round& round, std::vector<Orders>& orders);  // one a calculator
  void ask(std::size_t system, const balance::Plan& plan, std::vector<Orders>& orders);
  void balance(Round& round);
  static void bring_together(const balance::Plan& plan, std::vector<Orders>& orders);
  std::vector<Request> decide_with_neighbours(const Round& round);
  std::vector<Request> requests_between(int me, int other, const std::vector<balance::Load>& own,
                                        const std::vector<balance::Load>& theirs,
                                        const std::vector<std::size_t>& systems) const;
  Proposal propose(const Request& request);
  void take_all_proposals();
  void take_proposals(const Asked& asked);
  void take_proposal(int calculator, const Proposal& proposal);
  void move_cuts(const std::vector<std::size_t>& systems);
  void write_balance_rows();
  BalanceRow& row_of(std::size_t system, std::int32_t cut);
  balance::Load own_load(const System& system) const;
  void note_density();

  // render.cpp: calculators -> image generator
  void render();
  void send_sprites();
  void draw();

  // rows.cpp: the manager's account
  void note_round(const Round& round, const std::vector<Report>& reports, const Verdict& verdict);
  void note_imbalance();
  void note_loads(const std::vector<Report>& reports, std::size_t system, std::size_t first);
  void note_tails(const std::vector<Report>& reports);
  void write_rows();
  void note_tail(int rank, const Tail& tail, FrameRow& row);

  std::function<void(const Call&)> callback_;
  std::unique_ptr<comm::Communicator> comm_;
  roles::Cast cast_;
  Relay relay_;
  Options options_;
  std::vector<std::unique_ptr<System>> systems_;
  std::uint64_t frame_ = 0;
  std::uint32_t turn_ = 0;  // rounds of conversation so far
  std::vector<Round> rounds_;

  recording::Record record_;
  particles::Bytes record_bytes_;
  std::vector<std::vector<BirthGroup>> groups_;  // one a system
  bool keeping_ = false;   // lists are kept
  bool pictures_ = true;   // frames are drawn
  bool listing_ = false;   // lists are kept, and nothing is computed
  std::vector<particles::Bytes> kept_;
  Failure failure_;
  bool broken_ = false;  // all agreed on a failure: particles are half-way through a frame
  std::exception_ptr own_exception_;
  std::vector<particles::Digest> digests_;        // one a system: this rank's, then the agreed ones
  std::vector<std::uint64_t> exchange_bytes_;     // one a system
  image::Projector projector_;
  image::Records records_;
  image::Canvas canvas_;
  bool keep_linear_ = false;
  std::vector<std::uint8_t> pixels_;

  PhaseTimes times_, last_times_;
  double frame_start_s_ = 0;
  double waited_before_s_ = 0;
  Tail tail_;
  std::unique_ptr<Log> log_;
  std::unique_ptr<Spans> spans_;
  FrameRow row_;                       // of the frame whose rounds are being judged
  std::vector<particles::Digest> row_digests_;
  std::optional<FrameRow> open_row_;   // waits for the tails
  std::optional<FrameRow> last_row_;
  bool row_is_new_ = false;            // the log does not have it yet
  std::vector<Report> reports_;  // manager: of the last conversation, and the answers: their memory serves again
  std::vector<Orders> orders_;
  std::vector<Part> parts_;
  std::map<std::pair<std::size_t, std::int32_t>, BalanceRow> balance_rows_;  // by system and cut, until cuts are known
  std::vector<Asked> asked_;  // manager: whose proposals are under way
  std::vector<std::vector<balance::Histogram>> histograms_;  // manager: one list a system, one histogram a calculator
};

}  // namespace motes::frame
