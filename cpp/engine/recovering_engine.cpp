// Recovery from the loss of ranks. The remaining ranks repeat the collective call that the loss interrupted: they agree
// on who is left, take new roles, restore the world from replicas (replicas.h), replay the lists of the frames since,
// and make the call again. Some ranks may be one call ahead of others, but never two, since a call ends on a rank only
// after all ranks have taken part in it. Ranks that were ahead then repeat their last call as well, and discard its
// result.
#include "engine/recovering_engine.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "base/fields.h"
#include "comm/clock.h"
#include "comm/last_words.h"
#include "engine/replay.h"
#include "engine/session/tell_all.h"

namespace motes::engine {

using recording::Verb;

namespace {

constexpr std::size_t kSample = 4096;  // positions of each system from which new domains are made

struct Samples {
  std::vector<Sample> systems;
};

template <class Visitor>
constexpr void fields(Visitor& visit, Samples& samples) {
  visit(samples.systems);
}

// Returns the samples of all ranks, in the order of ranks, on every rank. Collective.
Samples exchange_samples(Rank& rank, const Samples& own) {
  Samples all;
  all.systems.resize(own.systems.size());
  for (const Samples& samples : tell_all(rank, rank.session.stamp(), own)) {
    for (std::size_t system = 0; system < all.systems.size(); ++system) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::vector<float>& from = samples.systems.at(system)[axis];
        all.systems[system][axis].insert(all.systems[system][axis].end(), from.begin(), from.end());
      }
    }
  }
  return all;
}

std::string listed(const std::vector<int>& ranks) {
  std::string text = ranks.size() == 1 ? "rank " : "ranks ";
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    if (i > 0) text += i + 1 == ranks.size() ? " and " : ", ";
    text += std::to_string(ranks[i]);
  }
  return text + (ranks.size() == 1 ? " was lost" : " were lost");
}

Loss loss_of(const roles::Cast& before, int size, std::vector<int> survivors, int handle) {
  Loss loss;
  loss.before = before;
  loss.now = roles::cast_left(before, survivors);
  loss.handle = handle;
  for (int rank = 0; rank < size; ++rank) {
    if (!std::binary_search(survivors.begin(), survivors.end(), rank)) loss.lost.push_back(rank);
  }
  loss.survivors = std::move(survivors);
  return loss;
}

// Returns the run's settings for the remaining ranks.
Settings settings_of(Settings settings, const Loss& loss) {
  std::vector<std::string> hosts;
  for (const int rank : loss.survivors) {
    if (static_cast<std::size_t>(rank) < settings.log.hosts.size()) {
      hosts.push_back(settings.log.hosts[static_cast<std::size_t>(rank)]);
    }
  }
  settings.log.hosts = std::move(hosts);
  settings.log.openings.push_back(opening_of(settings.log));
  settings.log.lost = listed(loss.lost) + "; " + std::to_string(loss.survivors.size()) + " continue";
  try {
    if (settings.policy) settings.policy->check(loss.now.calculators.size());
  } catch (const std::invalid_argument&) {
    settings.policy = nullptr;  // the policy does not support this number of calculators: cuts stay
    settings.log.lost += "; the balancer does not support so few calculators, so cuts stay";
  }
  return settings;
}

// Returns the replicas that this rank restores: its own, and that of a lost neighbour.
std::vector<const Replica*> brought(const Generation& from, const std::vector<int>& holders, int rank) {
  std::vector<const Replica*> replicas;
  for (const Replica* replica : {&from.own, &from.other}) {
    if (replica->message && holders.at(static_cast<std::size_t>(replica->calculator)) == rank)
      replicas.push_back(replica);
  }
  return replicas;
}

// Returns whether this list can only run with the script.
bool needs_script(const Script& script) {
  return std::any_of(script.systems.begin(), script.systems.end(), [](const auto& system) {
    return std::any_of(system->list.begin(), system->list.end(),
                       [](const recording::Item& item) { return std::holds_alternative<recording::Callback>(item); });
  });
}

void restore(Parts& p, const Generation& from, const std::vector<int>& holders) {
  SharedState state;
  base::Reader in(from.state.view());
  base::read_fields(in, state);
  std::vector<OpenedReplica> replicas;
  for (const Replica* replica : brought(from, holders, p.rank.session.rank())) replicas.push_back(open(*replica));
  Samples samples;
  samples.systems.resize(from.systems);
  const std::size_t most = kSample / std::max<std::size_t>(1, from.parts) + 1;
  for (const OpenedReplica& replica : replicas) {
    for (std::size_t i = 0; i < from.systems; ++i) {
      take_sample(replica.description, replica.planes, i, most, samples.systems[i]);
    }
  }
  samples = exchange_samples(p.rank, samples);
  restore_state(p, state, samples.systems);
  for (const OpenedReplica& replica : replicas) {
    for (std::size_t i = 0; i < from.systems; ++i) {
      const std::uint64_t rows = replica.description.systems[i].rows;
      if (rows > 0) restore_rows(p.rank, p.calculator, replica.description, replica.planes, i, 0, rows);
    }
  }
  if (!replicas.empty()) restore_speeds(p.calculator, replicas.front().description);
}

}  // namespace

// --- calls that may be repeated

// Makes a call that survives losses. `now` makes the call; `again` repeats it if it has ended on this rank but not on
// others.
template <class Now>
auto RecoveringEngine::surviving(const Now& now, bool frame, std::function<void()> again) {
  const auto inside = [&] {
    const comm::ActivityScope turn = between_phases();
    return now();
  };
  if (!replicas_.on() || recovering_) return inside();
  before_ = lengths();
  outside_before_ = outside();
  frame_before_ = this->frame();
  const auto lists = static_cast<std::ptrdiff_t>(kept_.lists.size());
  const auto ended = [&] {
    last_ = {last_.count + 1, frame, std::move(again), before_, lengths(), outside_before_};
    if (announced_) {
      parts_->rank.session.stop = announced_->stop;
      parts_->rank.session.orders = announced_->orders;
    }
    announced_.reset();
  };
  for (bool lost = false;;) {
    try {
      if (lost) recover();
      if constexpr (std::is_void_v<decltype(now())>) {
        inside();
        return ended();
      } else {
        auto result = inside();
        ended();
        return result;
      }
    } catch (const comm::RankLost&) {
      lost = true;
      kept_.lists.erase(kept_.lists.begin() + lists, kept_.lists.end());
    }
  }
}

// Makes a call that survives losses, and that ranks on which it has ended can make again.
template <class Call>
auto RecoveringEngine::repeatable(const Call& call) {
  return surviving(call, false, call);
}

void RecoveringEngine::finish() {
  const auto now = [&] {
    replicas_.take_rest(parts_->rank);
    Engine::finish();
  };
  surviving(now, false);
}

void RecoveringEngine::secure(const std::function<void()>& first) {
  repeatable([=, this] { Engine::secure(first); });
}

std::vector<std::string> RecoveringEngine::tell(const std::function<std::string()>& say) {
  return repeatable([=, this] { return Engine::tell(say); });
}

void RecoveringEngine::run_frame(const std::optional<image::View>& view, const std::string& argument) {
  const std::optional<image::Camera> passing = parts_->script.passing;
  const auto now = [&] {
    parts_->script.passing = passing;  // after a loss, the parts are new
    const std::uint64_t number = this->frame();
    const bool needs = wrote_ || needs_script(parts_->script);
    Engine::run_frame(view, argument);
    wrote_ = false;
    if (!replicas_.on()) return;
    replicas_.note_list(number, parts_->script.bytes, needs);
    replicas_.at_border(*parts_, parts_->rank.session.all_unsaved_from);
  };
  surviving(now, true);
}

void RecoveringEngine::redraw(const image::View& view, const std::string& argument) {
  repeatable([=, this] { Engine::redraw(view, argument); });
}

void RecoveringEngine::hear_orders(const std::string& argument) {
  repeatable([=, this] { Engine::hear_orders(argument); });
}

std::vector<particles::Digest> RecoveringEngine::digest() {
  return repeatable([this] { return Engine::digest(); });
}

std::unique_ptr<particles::Store> RecoveringEngine::gather(int system, bool to_all) {
  return repeatable([=, this] { return Engine::gather(system, to_all); });
}

program::Totals RecoveringEngine::sum(int system, Verb verb, const program::Sum& what) {
  return repeatable([=, this] { return Engine::sum(system, verb, what); });
}

surfaces::Skin RecoveringEngine::surface(int system, const surfaces::Measure& measure) {
  return repeatable([=, this] { return Engine::surface(system, measure); });
}

Notes RecoveringEngine::prepare_write(const std::string& what, bool reads, const std::function<Note()>& prepare) {
  return surviving([&] { return Engine::prepare_write(what, reads, prepare); }, false);
}

void RecoveringEngine::keep_preview(int system) {
  wrote_ = true;
  Engine::keep_preview(system);
}

// During recovery viewers are not asked for orders; new orders apply to the next frame after it.
void RecoveringEngine::on_orders(std::function<std::string()> orders) {
  Engine::on_orders([this, ask = std::move(orders)] { return recovering_ || announced_ ? std::string() : ask(); });
}

void RecoveringEngine::survive_losses(std::uint64_t every, Bystander bystander) {
  bystander_ = std::move(bystander);
  if (!parts_->rank.session.comm().survives() || kept_.only) return;
  replicas_.begin(*parts_, every);
}

void RecoveringEngine::copy_restored() {
  if (replicas_.on()) replicas_.make(*parts_, true, true);  // no earlier replicas are valid
}

std::vector<Outside> RecoveringEngine::outside() const {
  std::vector<Outside> all;
  for (const auto& system : parts_->script.systems) all.push_back(system->outside);
  return all;
}

// Adds the script's systems up to number outside.size() that are missing, and tells all of them what the script told.
void RecoveringEngine::tell_systems(const std::vector<Outside>& outside) {
  for (std::size_t i = 0; i < outside.size(); ++i) {
    if (i == parts_->script.systems.size()) add_system(interrupted_->systems.at(i)->definition);
    parts_->script.systems[i]->outside = outside[i];
  }
}

std::vector<std::size_t> RecoveringEngine::lengths() const {
  std::vector<std::size_t> lengths;
  for (const auto& system : parts_->script.systems) lengths.push_back(system->list.size());
  return lengths;
}

// --- recovery

void RecoveringEngine::recover() {
  const struct Recovering {
    explicit Recovering(RecoveringEngine& of) : on(of.recovering_), keeps(of.kept_.on), before(of.kept_.on) {
      on = true;
      keeps = false;  // the lists of replayed frames are kept already
    }
    ~Recovering() {
      on = false;
      keeps = before;
    }
    bool &on, &keeps;
    bool before;
  } recovering(*this);
  // Open MPI 5.0 itself may crash if another rank dies while the others create their communicator. The launcher
  // recognises the error message (supervisor.py).
  const comm::WhileLost lost;
  regroup();
  const Standing own = standing();
  const WayBack way = way_back(tell_all(parts_->rank, {0, replicas_.losses}, own));
  if (!way.refusal.empty()) throw Unrecoverable(listed(loss_.lost) + ", and " + way.refusal);
  go_back(way);
  run_again(way, own.call > way.call);
  interrupted_.reset();
}

// Creates new parts for the remaining ranks in their new roles, still without systems.
void RecoveringEngine::regroup() {
  Rank& then = parts_->rank;
  std::vector<int> survivors;
  std::unique_ptr<comm::Communicator> among = then.session.comm().shrink(survivors);
  ++replicas_.losses;
  loss_ = loss_of(then.session.cast(), then.session.size(), std::move(survivors), among->handle());
  if (!interrupted_) {
    interrupted_ = std::make_unique<Interrupted>();
    interrupted_->systems = std::move(parts_->script.systems);
    if (frame() > frame_before_) bring_lists_back();
    interrupted_->callback = std::move(parts_->calculator.callback);
    interrupted_->announced = {then.session.stop, then.session.orders};
  }
  const std::uint64_t unsaved_from = then.session.unsaved_from;
  Settings settings = settings_of(then.settings, loss_);
  auto parts = std::make_unique<Parts>(std::move(among), loss_.now, std::move(settings));
  parts_.swap(parts);
  parts.reset();
  Rank& rank = parts_->rank;
  rank.session.comm().weigh(rank.settings.costs.messages);
  parts_->calculator.callback = interrupted_->callback;
  const std::string refusal = bystander_.regroup ? bystander_.regroup(loss_) : "";
  if (bystander_.watch.while_waiting) rank.session.comm().set_watch(bystander_.watch);
  interrupted_->refusal = refusal;
  const bool drew = loss_.before.image_generator == loss_.survivors[static_cast<std::size_t>(rank.session.rank())];
  if (rank.session.draws() && !drew && refusal.empty() && bystander_.unsaved_from) {
    interrupted_->unsaved_from = std::min(interrupted_->unsaved_from, bystander_.unsaved_from(loss_));
  }
  rank.session.unsaved_from = drew ? unsaved_from : interrupted_->unsaved_from;
  rank.session.all_unsaved_from = rank.session.unsaved_from;
}

// Restores the lists of a frame that had ended on this rank except for its replicas.
void RecoveringEngine::bring_lists_back() {
  base::Reader in(replicas_.lists().back().record.view());
  recording::Record record = recording::read(in);
  for (std::size_t i = 0; i < record.lists.size(); ++i) interrupted_->systems[i]->list = std::move(record.lists[i]);
}

Standing RecoveringEngine::standing() const {
  Standing own;
  own.call = last_.count;
  own.frame = frame_before_;
  own.announced = interrupted_->announced;
  own.unsaved_from = interrupted_->unsaved_from;
  own.wrote = wrote_;
  own.repeatable = last_.count == 0 || last_.frame || last_.again;
  own.refusal = interrupted_->refusal;
  for (const Generation& generation : replicas_.generations()) {
    if (!generation.counts) continue;
    Holding holding{generation.of, generation.parts, -1, -1};
    if (generation.own.message) holding.own = generation.own.calculator;
    if (generation.other.message) holding.other = generation.other.calculator;
    own.holdings.push_back(holding);
  }
  for (const KeptList& list : replicas_.lists()) {
    if (list.needs_script) own.needs_script.push_back(list.frame);
  }
  return own;
}

// Starts a new world with the same systems on the remaining ranks, and continues the log.
void RecoveringEngine::start_again(const Generation& from) {
  Rank& rank = parts_->rank;
  rank.session.frame = from.of.frame;
  rank.settings.log.continued_from = from.of.frame;
  for (std::size_t i = 0; i < from.systems; ++i) add_system(interrupted_->systems.at(i)->definition);
  start();
}

void RecoveringEngine::go_back(const WayBack& way) {
  replicas_.forget_behind(way.from);
  const Generation& from = *replicas_.find(way.from);
  comm::Ledger& ledger = parts_->rank.watch.ledger();
  const comm::ActivityScope turn(ledger, comm::Activity::recovery);
  ledger.go_back(from.border);
  start_again(from);
  Parts& p = *parts_;
  restore(p, from, way.holders);
  replicas_.make(p, false, true);
  p.rank.session.work("movie", [&] {
    if (bystander_.resumed) bystander_.resumed(way.from.frame);
  });
}

// Replays the kept lists, up to the script's current place on this rank.
void RecoveringEngine::run_again(const WayBack& way, bool ahead) {
  const std::uint64_t end = ahead && last_.frame ? way.frame + 1 : way.frame;
  for (std::uint64_t number = way.from.frame; number < end; ++number) {
    const std::deque<KeptList>& lists = replicas_.lists();
    replay_frame(lists.at(number - lists.front().frame), way);
  }
  if (!ahead || !last_.frame) replicas_.forget_lists_from(way.frame);
  std::vector<std::size_t> done;
  if (ahead && !last_.frame) {  // as things were then: the other ranks have not come further
    tell_systems(last_.outside);
    record_items({}, last_.before);
    last_.again();
    done = last_.after;
  }
  tell_systems(outside_before_);
  record_items(done, before_);
  announced_.reset();
  if (ahead) {
    parts_->rank.session.stop = interrupted_->announced.stop;
    parts_->rank.session.orders = interrupted_->announced.orders;
  } else if (way.anyone_ahead) {
    announced_ = way.announced;
  }
}

// Replays a frame, with its picture if the other ranks draw it too or if it is needed again.
void RecoveringEngine::replay_frame(const KeptList& list, const WayBack& way) {
  base::Reader in(list.record.view());
  const recording::Record record = recording::read(in);
  record_again(*this, record);
  const bool wanted = list.frame >= way.frame || list.frame >= way.unsaved_from || parts_->rank.settings.log.digest;
  if (record.view && !wanted) {  // the next picture's streaks need this camera
    parts_->script.camera = record.view->camera;
    parts_->script.camera_frame = record.frame;
    parts_->script.camera_before = record.view->before;
  }
  if (record.camera) pass_camera(*record.camera);
  Engine::run_frame(wanted ? record.view : std::nullopt, record.argument);
  replicas_.at_border(*parts_, parts_->rank.session.all_unsaved_from);
  if (!record.view || !wanted || !parts_->rank.session.draws() || !bystander_.redrawn) return;
  parts_->rank.session.work("movie", [&] { bystander_.redrawn(list.frame, *record.view); });
}

// Records items from[i] .. to[i] - 1 of each system's interrupted list again.
void RecoveringEngine::record_items(const std::vector<std::size_t>& from, const std::vector<std::size_t>& to) {
  for (std::size_t i = 0; i < to.size() && i < interrupted_->systems.size(); ++i) {
    const std::vector<recording::Item>& list = interrupted_->systems[i]->list;
    for (std::size_t item = i < from.size() ? from[i] : 0; item < to[i]; ++item) {
      if (std::holds_alternative<recording::Read>(list.at(item))) {
        local(static_cast<int>(i));
      } else {
        record(static_cast<int>(i), list[item]);
      }
    }
  }
}

}  // namespace motes::engine
