#include "frame/engine.h"

#include "comm/clock.h"
#include "comm/last_words.h"
#include "frame/work.h"

namespace motes::frame {

using recording::Verb;

Engine::Engine(std::unique_ptr<comm::Communicator> communicator, roles::Cast cast, Options options)
    : comm_(std::move(communicator)), cast_(std::move(cast)), relay_(*comm_, cast_), options_(std::move(options)) {
  if (options_.policy) options_.policy->check(cast_.calculators.size());
  comm_->weigh({options_.costs.scale, options_.costs.message, options_.costs.byte});
}

// The paper's Algorithm 1 and section 3.2, from a recorded list on.
void Engine::run_frame(const std::optional<image::View>& view) {
  begin_frame(view ? Verb::render : Verb::step, view, "");
  keep_list();
  if (listing_) return end_frame();
  talk();    // create, act, agree, exchange, balance
  order();   // calculators, each by itself
  render();  // calculators -> image generator
  end_frame();
}

// Round by round; or, overlapped, what one round says travels while the next ones compute.
void Engine::talk() {
  take_all_proposals();  // of the last frame: the manager hands the new cuts out now
  const std::size_t lag = in_frame() && options_.combine == Combine::overlapped ? 1 : 0;
  if (manages() && lag > 0) {
    for (const Round& round : rounds_) deal(round);
  }
  for (std::size_t step = 0; step < rounds_.size() + 2 * lag; ++step) {
    if (step < rounds_.size()) {
      if (manages() && lag == 0) deal(rounds_[step]);
      open(step);
    }
    if (step >= lag && step - lag < rounds_.size()) settle(rounds_[step - lag]);
    if (step >= 2 * lag) close(rounds_[step - 2 * lag]);
  }
}

void Engine::open(std::size_t round) {
  Newborn newborn = receive_births(round);  // may learn that the manager has other rounds
  act(rounds_[round], newborn);  // calculators run the list and set leavers aside
  report(rounds_[round]);       // all -> manager: loads, failures
}

void Engine::settle(Round& round) {
  if (manages()) judge(round);
  const Timed timed(*this, times_.report, "wait for verdict", name_of(round));
  relay_.hand_up(comm::Phase::report, stamp(round));
  const Heard answer = relay_.hear(comm::Phase::verdict, stamp(round));
  particles::Reader common(answer.common);
  particles::Reader own(answer.own);
  obey(round, read_verdict(common), own.done() ? Orders{} : read_orders(own));
  send_leavers(round);  // calculators -> calculators
}

void Engine::close(Round& round) {
  receive_strangers(round);
  if (in_frame()) balance(round);
  if (spans_ && in_frame()) spans_->add(frame_, "messages", name_of(round), round.reported_s, comm::wall_seconds());
}

// The rounds of this conversation: the systems one by one, or all at once.
void Engine::split() {
  rounds_.clear();
  const std::size_t n = systems_.size();
  const std::size_t width = in_frame() && options_.combine != Combine::together ? 1 : n;
  for (std::size_t first = 0; first < n; first += width)
    rounds_.push_back({first, first + width, ++turn_, {}, {}, {}, 0});
  if (rounds_.empty()) rounds_.push_back({0, 0, ++turn_, {}, {}, {}, 0});
}

std::string Engine::name_of(const Round& round) const {
  return round.last == round.first + 1 ? systems_[round.first]->definition.name : "";
}

void Engine::start() {
  frame_start_s_ = comm::wall_seconds();
  // Rounds and conversations depend on these: ranks that differ must hear of it before they get stuck.
  constexpr const char* kCombine[] = {"one_by_one", "together", "overlapped"};
  std::string shared = kCombine[static_cast<int>(options_.combine)];
  shared.append(", ").append(options_.policy ? options_.policy->name() : "cuts stay");
  shared.append(options_.births == Births::calculators ? ", births by calculators" : "");
  shared.append(", fan-out ").append(std::to_string(options_.fan_out));
  converse(Verb::start, shared);
  relay_.grow(cast_, options_.fan_out);  // all have agreed on it
  if (manages() && !options_.log.empty()) {
    work("log", [&] { log_ = std::make_unique<Log>(options_.log, options_.hosts); });
    if (log_) log_->event("start", frame_, "");
  }
  converse(Verb::start, "log");  // all know now whether the manager can write its log
  if (!options_.spans) return;
  const double zero = comm::wall_seconds();
  work("spans", [&] { spans_ = std::make_unique<Spans>(options_.log, rank(), zero); });
}

void Engine::finish() {
  converse(Verb::finish, "");  // brings the last frame's tails, so its row is whole
  write_rows();
  if (log_) log_->event("end", frame_, "");
  comm_->finish();
}

std::vector<particles::Digest> Engine::digest() {
  catch_up();
  converse(Verb::digest, "");
  return digests_;
}

int Engine::add_system(recording::SystemDefinition definition) {
  const auto index = static_cast<std::uint32_t>(systems_.size());
  const int calculators = static_cast<int>(cast_.calculators.size());
  systems_.push_back(std::make_unique<System>(std::move(definition), options_.seed, index, calculators));
  if (options_.policy) {
    balance::SpeedOptions speeds = options_.policy->speeds;
    speeds.min_particles = static_cast<std::uint64_t>(static_cast<double>(speeds.min_particles) / options_.costs.scale);
    systems_.back()->speeds = balance::Speeds(calculators, speeds);
  }
  return static_cast<int>(index);
}

void Engine::record(int index, recording::Item item) {
  System& s = system(index);
  if (const auto* action = std::get_if<actions::Action>(&item)) {
    actions::check(*action);
    actions::check(*action, s.schema);
    if (actions::uses_copies(*action, s.schema)) s.keep_copies();
  }
  if (const auto* birth = std::get_if<recording::Birth>(&item)) {
    recording::check(*birth, s.schema);
    if (recording::gives_copies(*birth)) s.keep_copies();
  }
  if (const auto* spawn = std::get_if<recording::Spawn>(&item)) {
    if (spawn->into < 0 || spawn->into >= system_count()) throw std::invalid_argument("into must be a system");
    recording::check(*spawn, s.schema, system(spawn->into).schema);
    if (actions::uses_copies(spawn->where, s.schema)) s.keep_copies();
    system(spawn->into).keep_copies();  // only the manager knows what children are made of
  }
  if (const auto* callback = std::get_if<recording::Callback>(&item)) {
    actions::check_condition(callback->where, callback->shapes, s.schema);
    if (actions::uses_copies(callback->where, s.schema)) s.keep_copies();
  }
  s.list.push_back(std::move(item));
}

void Engine::begin_frame(Verb verb, const std::optional<image::View>& view, const std::string& argument) {
  if (broken_) throw std::runtime_error("the run ended when frame " + std::to_string(frame_) + " failed");
  times_ = {};
  waited_before_s_ = comm_->waited_s();
  record_ = {};
  record_.verb = verb;
  record_.frame = frame_;
  record_.seed = options_.seed;
  record_.dt = options_.dt;
  record_.substeps = options_.substeps;
  for (const auto& s : systems_) {
    record_.systems.push_back(s->definition);
    record_.lists.push_back(std::move(s->list));  // lent: moved back below
    record_.sprites.push_back(s->sprite);
  }
  record_.view = view;
  record_.argument = argument;
  record_bytes_.clear();
  recording::write(record_, record_bytes_);
  for (std::size_t i = 0; i < systems_.size(); ++i) systems_[i]->list = std::move(record_.lists[i]);
  record_.lists.clear();
  digests_.assign(systems_.size(), {});
  count_births();
  split();
}

void Engine::end_frame() {
  const double now = comm::wall_seconds();
  times_.wait = comm_->waited_s() - waited_before_s_;
  times_.frame = now - frame_start_s_;
  frame_start_s_ = now;
  tail_.valid = true;
  tail_.frame = frame_;
  tail_.times = last_times_ = times_;
  tail_.bytes_sent = exchange_bytes_;
  if (!options_.log.empty()) note_density();
  if (spans_) work("spans", [&] { spans_->write(); });
  ++frame_;
  for (const auto& s : systems_) s->start_frame();
  comm::set_place("rank " + std::to_string(rank()) + " (" + cast_.describe(rank()) + "), frame " +
                  std::to_string(frame_));
}

// A conversation outside the frame: all ranks are here and ask the same.
void Engine::converse(Verb verb, const std::string& argument) {
  for (int i = 0; i < system_count(); ++i) {
    if (verb == Verb::digest || verb == Verb::gather) work("act", [&] { local(i); });
  }
  begin_frame(verb, std::nullopt, argument);
  talk();
}

}  // namespace motes::frame
