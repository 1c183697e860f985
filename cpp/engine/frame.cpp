// The loop: the phases of a frame and of every other conversation of all ranks.
#include <algorithm>
#include <iterator>

#include "base/checks.h"
#include "base/enumerators.h"
#include "comm/clock.h"
#include "comm/last_words.h"
#include "engine/act/act.h"
#include "engine/act/exchange.h"
#include "engine/agree.h"
#include "engine/balance/balance.h"
#include "engine/balance/donate.h"
#include "engine/balance/neighbours.h"
#include "engine/births/create.h"
#include "engine/births/spawn.h"
#include "engine/engine.h"
#include "engine/session/links.h"
#include "engine/session/tell_all.h"
#include "engine/state/histories.h"
#include "engine/sums/sums.h"
#include "engine/sums/surface.h"

namespace motes::engine {

using recording::Verb;

namespace {

void act_and_report(Parts& p, std::size_t index) {
  Newborn newborn = receive_births(p.rank, p.script, p.calculator, index);  // may adopt the manager's rounds
  if (newborn.plan) p.painter.plan = *newborn.plan;
  Round& round = p.script.rounds[index];
  act(p.rank, p.script, p.calculator, round, newborn);  // calculators run the list and pack migrants
  report(p.rank, p.script, p.calculator, round, newborn);  // all -> manager: loads, events, failures
}

void agree_and_send_migrants(Parts& p, Round& round) {
  if (p.rank.session.manages()) judge(p.rank, p.script, p.manager, round);
  hear_verdict(p.rank, p.script, round);  // manager -> all
  send_migrants(p.rank, p.script, p.calculator, round);  // calculators -> calculators
}

void receive_migrants(Parts& p, const Round& round) {
  receive_arrivals(p.rank, p.script, p.calculator, round);
  p.rank.watch.note_messages(p.script.name_of(round), round.reported_s);
}

// Continues one round after another. All ranks have acted in the first.
void run_in_turn(Parts& p) {
  std::vector<Round>& rounds = p.script.rounds;
  for (std::size_t index = 0; index < rounds.size(); ++index) {
    if (index > 0) {
      if (p.rank.session.manages()) deal(p.rank, p.script, p.manager, rounds[index]);
      act_and_report(p, index);
    }
    agree_and_send_migrants(p, rounds[index]);
    receive_migrants(p, rounds[index]);
  }
}

// Continues all rounds at once, so messages of one travel while the next ones compute: a rank acts in round n + 2,
// agrees on round n + 1, then receives the migrants of round n. All ranks have acted in the first.
void run_overlapped(Parts& p) {
  std::vector<Round>& rounds = p.script.rounds;
  for (std::size_t step = 1; step < rounds.size() + 2; ++step) {
    if (step < rounds.size()) act_and_report(p, step);
    if (step <= rounds.size()) agree_and_send_migrants(p, rounds[step - 1]);
    if (step >= 2) receive_migrants(p, rounds[step - 2]);
  }
}

// Runs all rounds, in turn or overlapped.
void converse(Parts& p) {
  const bool manages = p.rank.session.manages();
  if (p.script.in_frame()) take_new_cuts(p.rank, p.script, p.calculator);  // cuts from the last verdict
  if (manages) take_all_proposals(p.rank, p.script, p.manager);  // of the last frame; new cuts are sent with the births
  std::vector<Round>& rounds = p.script.rounds;
  const std::size_t dealt = p.script.overlaps ? rounds.size() : 1;
  for (std::size_t index = 0; manages && index < dealt; ++index) deal(p.rank, p.script, p.manager, rounds[index]);
  act_and_report(p, 0);  // from here on `overlaps` is the manager's
  if (p.script.overlaps) {
    run_overlapped(p);
  } else {
    run_in_turn(p);
  }
}

void begin(Parts& p, Verb verb, const std::optional<image::View>& view, const std::string& argument) {
  p.rank.session.check_alive();
  const Settings& run = p.rank.settings;
  write_record(p.script, run, p.rank.session.frame, verb, view, argument);
  p.rank.watch.begin(p.rank.session.frame, p.script.in_frame(), p.rank.session.comm().waited_s());
  for (const auto& system : p.script.systems) {
    system->groups.clear();
    if (p.script.in_frame()) system->count_births(run.dt, run.substeps);
  }
  if (p.script.in_frame()) ask_for_oldest(p.script);
  if (p.script.steered()) {
    p.rank.session.stop = 0;
    p.rank.session.orders.clear();
  }
  p.script.overlaps = p.script.in_frame() && run.combine == Combine::overlapped;
  split_rounds(p.script, run.combine, p.rank.session.turn);
}

// Collects what the log needs about each system on this calculator.
void note_tails(const Script& script, Calculator& calculator) {
  const std::vector<Density> densities = engine::densities(script, calculator);
  const PhaseTimes& times = calculator.tail.times;
  for (std::size_t i = 0; i < densities.size(); ++i) {
    CalculatorTail tail;
    tail.bytes_sent = calculator.populations[i]->tally.bytes_sent + calculator.populations[i]->interaction.bytes;
    tail.particles = densities[i].particles;
    std::copy(std::begin(densities[i].quantiles), std::end(densities[i].quantiles), tail.quantiles);
    tail.exchange_s = static_cast<float>(times.exchange);
    const Handling& handling = calculator.populations[i]->handling;
    tail.pack_s = handling.pack.each_s();
    tail.unpack_s = handling.unpack.each_s();
    tail.search_s = handling.search.each_s();
    tail.migrant_bytes = handling.bytes;
    tail.ways = calculator.populations[i]->ways;
    tail.interaction = calculator.populations[i]->interaction;
    tail.wait_s = static_cast<float>(times.wait);
    tail.image_s = static_cast<float>(times.render);
    tail.project_s = static_cast<float>(times.project);
    calculator.tails.push_back(tail);
  }
}

void end(Parts& p) {
  Session& session = p.rank.session;
  p.rank.watch.end(session.comm().waited_s());
  Tail& tail = p.calculator.tail;
  tail.valid = true;
  tail.frame = session.frame;
  tail.times = p.rank.watch.last();
  tail.ended_s = p.rank.watch.spent().ended_s;
  tail.drawings = drawings_of(std::move(p.painter.drawing), session.rank(), session.calculates());
  for (const auto& here : p.calculator.populations) {
    tail.exchanged_bytes += here->tally.bytes_sent + here->interaction.bytes;
    tail.moved += here->interaction.moved_out;
  }
  p.calculator.tails.clear();
  if (!p.rank.settings.log.directory.empty() && session.calculates()) note_tails(p.script, p.calculator);
  session.work("spans", [&] { p.rank.watch.write_spans(); });
  bound_histories(p.script, p.calculator);
  ++session.frame;
  for (const auto& system : p.script.systems) system->start_frame();
  for (const auto& here : p.calculator.populations) start_frame(*here);
  comm::set_place("rank " + std::to_string(session.rank()) + " (" + session.cast().describe(session.rank()) +
                  "), frame " + std::to_string(session.frame));
}

// Holds a conversation outside a frame. Collective.
void ask_all(Parts& p, Verb verb, const std::string& argument) {
  begin(p, verb, std::nullopt, argument);
  converse(p);
  if (!p.rank.session.manages()) return;
  keep_account(p.rank, p.script, p.manager);
  take_tails(p.rank, p.manager);
}

struct RankText {
  std::string text;
};

template <class Visitor>
constexpr void fields(Visitor& visit, RankText& text) {
  visit(text.text);
}

// Returns the settings that rounds and conversations depend on. Ranks compare them at the start, because ranks that
// differ would deadlock.
std::string shared_settings(const Settings& run) {
  std::string shared(base::name_of(run.combine));
  shared.append(", ").append(run.policy ? run.policy->name() : "cuts stay");
  shared.append(", births ").append(base::name_of(run.births));
  return shared.append(", fan-out ").append(std::to_string(run.fan_out));
}

// Returns whether this rank draws and should answer the plan before it draws. The next frame begins when all ranks have
// answered, so they need not wait for the picture. The rank must get the plan directly from the manager, have no ranks
// below it, and no neighbours to compare loads with first, since those may wait for its records.
bool answers_before_drawing(const Rank& rank) {
  const roles::Tree& tree = rank.session.relay().tree();
  const balance::Policy* policy = rank.settings.policy.get();
  const bool apart = policy != nullptr && !policy->decentralised() && tree.depth() == 1 && tree.leaf();
  return apart && rank.session.draws() && !rank.session.manages();
}

}  // namespace

comm::ActivityScope Engine::between_phases() {
  comm::Ledger& ledger = parts_->rank.watch.ledger();
  const bool saves = ledger.now() == comm::Activity::checkpoint;
  return {ledger, saves ? comm::Activity::checkpoint : comm::Activity::other};
}

// Runs the frame of the paper's Algorithm 1 and section 3.2, given the recorded list.
void Engine::run_frame(const std::optional<image::View>& view, const std::string& argument) {
  const comm::ActivityScope turn = between_phases();
  Parts& p = *parts_;
  begin(p, view ? Verb::render : Verb::step, view, argument);
  kept_.keep(p.script);
  if (!kept_.only) {
    converse(p);  // create, act, agree, exchange
    if (p.rank.session.manages()) plan(p.rank, p.script, p.manager);  // while the others continue
    spawn(p.rank, p.script, p.calculator);  // calculators, without messages
    sort_all(p.rank, p.script, p.calculator);  // calculators, without messages
    const bool answers_first = answers_before_drawing(p.rank);
    if (answers_first) balance(p.rank, p.script, p.calculator, p.manager);
    render(p.rank, p.script, p.calculator, p.painter);  // calculators -> image generator
    if (p.rank.session.manages()) keep_account(p.rank, p.script, p.manager);
    if (!answers_first) balance(p.rank, p.script, p.calculator, p.manager);  // manager's plan -> calculators -> manager
    if (view) p.rank.session.rethrow();  // a frame that could not be drawn must not reach the script
  } else if (p.rank.settings.stop_signal) {
    p.rank.session.stop = p.rank.settings.stop_signal();
  }
  end(p);
}

void Engine::redraw(const image::View& view, const std::string& argument) {
  const comm::ActivityScope turn = between_phases();
  catch_up();
  for (const auto& system : parts_->script.systems) {
    const auto run = system->list.begin() + static_cast<std::ptrdiff_t>(system->run_items);
    if (std::none_of(system->list.begin(), run, recording::is_call)) continue;
    throw std::invalid_argument(
        "particles of system '" + system->definition.name +
        "' were read after a part of this frame's list: redraw before that, or after the frame");
  }
  begin(*parts_, Verb::redraw, view, argument);
  converse(*parts_);
  render(parts_->rank, parts_->script, parts_->calculator, parts_->painter);
  if (parts_->rank.session.manages()) keep_account(parts_->rank, parts_->script, parts_->manager);
  parts_->rank.session.rethrow();
}

void Engine::hear_orders(const std::string& argument) {
  const comm::ActivityScope turn = between_phases();
  ask_all(*parts_, Verb::orders, argument);
  parts_->rank.watch.ledger().restart();  // do not count a pause in the next frame's time
  parts_->manager.account.restart_clock();
}

void Engine::start() {
  Rank& rank = parts_->rank;
  const Logging& log = rank.settings.log;
  if (log.lost.empty()) rank.watch.ledger().restart();
  ask_all(*parts_, Verb::start, shared_settings(rank.settings));
  rank.session.relay().grow(rank.session.cast(), rank.settings.fan_out);  // all ranks have agreed on the fan-out
  if (rank.session.manages() && !log.directory.empty()) {
    rank.session.work("log", [&] { parts_->manager.account.open_log(log); });
  }
  if (!log.directory.empty()) {
    const std::vector<Link> links = measure_links(rank);
    rank.session.work("log", [&] { parts_->manager.account.note_links(links); });
  }
  ask_all(*parts_, Verb::start, "log");  // fails on all ranks if the manager could not open the log
  if (!log.spans) return;
  if (log.lost.empty()) zero_ = comm::wall_seconds();
  const std::uint64_t first = log.lost.empty() ? 0 : log.continued_from;
  rank.session.work("spans", [&] { rank.watch.keep_spans(log.directory, rank.session.rank(), zero_, first); });
}

void Engine::secure(const std::function<void()>& first) {
  const comm::ActivityScope turn = between_phases();
  if (first) parts_->rank.session.work("movie", first);
  ask_all(*parts_, Verb::start, "log's rows");  // sends the last frame's tails, so its row is complete
  if (parts_->rank.settings.log.directory.empty()) return;
  if (parts_->rank.session.manages()) {
    parts_->rank.session.work("log", [&] { parts_->manager.account.secure_rows(); });
  }
  ask_all(*parts_, Verb::start, "log on the disk");  // fails on all ranks if the manager could not write the rows
}

std::vector<std::string> Engine::tell(const std::function<std::string()>& say) {
  const comm::ActivityScope turn = between_phases();
  RankText own;
  parts_->rank.session.work("checkpoint", [&] { own.text = say(); });
  ask_all(*parts_, Verb::start, "what each rank says");  // fails on all ranks if `say` failed on one
  std::vector<std::string> texts;
  for (RankText& each : tell_all(parts_->rank, parts_->rank.session.stamp(), own))
    texts.push_back(std::move(each.text));
  return texts;
}

void Engine::finish() {
  const comm::ActivityScope turn = between_phases();
  ask_all(*parts_, Verb::finish, "");  // sends the last frame's tails, so its row is complete
  parts_->manager.account.write_rows();
  if (Log* log = parts_->manager.account.log()) log->event("end", frame(), "");
  parts_->rank.session.comm().finish();
}

// Runs the list so far and then `compute`, before a conversation about particles: computing may fail, conversations may
// not.
template <class Compute>
void Engine::look_at(int index, const Compute& compute) {
  const std::optional<ParticlesView> seen = try_read(index);
  if (seen) parts_->rank.session.work("act", [&] { compute(*seen); });
}

std::vector<particles::Digest> Engine::digest() {
  const comm::ActivityScope turn = between_phases();
  catch_up();
  for (const auto& system : parts_->script.systems) check_readable(*system);
  for (int i = 0; i < system_count(); ++i) {
    look_at(i, [&](const ParticlesView& seen) { note_digest(parts_->rank, seen, population(i)); });
  }
  ask_all(*parts_, Verb::digest, "");
  std::vector<particles::Digest> digests;
  for (const auto& system : parts_->script.systems) digests.push_back(system->digest);
  return digests;
}

std::unique_ptr<particles::Store> Engine::gather(int index, bool to_all) {
  const comm::ActivityScope turn = between_phases();
  catch_up();
  check_readable(system(index));
  look_at(index, [](const ParticlesView&) {});
  ask_all(*parts_, Verb::gather, system(index).definition.name + (to_all ? ", to all" : ", to rank 0"));
  return engine::gather(parts_->rank, system(index), seen(index), to_all);
}

program::Totals Engine::sum(int index, Verb verb, const program::Sum& what) {
  const comm::ActivityScope turn = between_phases();
  catch_up();
  check_readable(system(index));
  program::check(what, system(index).schema);
  if (program::uses_copies(what, system(index).schema)) read_copies(system(index), population(index));
  program::Summed own;
  look_at(index,
          [&](const ParticlesView& seen) { own = program::sum_up(what, *seen.store, seen.count, *parts_->rank.pool); });
  ask_all(*parts_, verb, system(index).definition.name + ", " + program::fingerprint(what));
  return total_of_all(parts_->rank, std::move(own));
}

surfaces::Skin Engine::surface(int index, const surfaces::Measure& measure) {
  const comm::ActivityScope turn = between_phases();
  surfaces::check(measure);
  catch_up();
  check_readable(system(index));
  surfaces::Field own(measure);
  look_at(index, [&](const ParticlesView& seen) { own = field_of(parts_->rank, seen, measure); });
  const std::string& name = system(index).definition.name;
  ask_all(*parts_, Verb::surface,
          name + ", cells of " + base::number_text(measure.cell) + ", radius " + base::number_text(measure.radius));
  surfaces::Skin skin = surface_of_all(parts_->rank, std::move(own));
  ask_all(*parts_, Verb::surface, name);  // fails on all ranks if one could not make its surface
  return skin;
}

Notes Engine::prepare_write(const std::string& what, bool reads, const std::function<Note()>& prepare) {
  const comm::ActivityScope turn = between_phases();
  if (reads) {
    catch_up();
    for (const auto& system : parts_->script.systems) check_readable(*system);
    for (int i = 0; i < system_count(); ++i) look_at(i, [](const ParticlesView&) {});
  }
  Note own;
  parts_->rank.session.work("write", [&] { own = prepare(); });
  ask_all(*parts_, Verb::write, what);
  return exchange_notes(parts_->rank, std::move(own));
}

}  // namespace motes::engine
