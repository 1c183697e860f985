#include "engine/act/follow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "engine/births/spawn.h"
#include "engine/session/all_reduce.h"
#include "engine/session/item_failure.h"
#include "program/select.h"

namespace motes::engine {

using comm::Message;
using comm::Phase;

namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

using Position = std::array<float, 3>;

// A particle as known to the keeper of its id.
struct Known {
  std::uint64_t id;
  Position at;
  std::uint32_t from;   // calculator that owns it
  std::uint32_t entry;  // index in that calculator's message
};

// The next id may be on any rank, so ghosts of what is near would not do. Keepers sort what they are told by id; the
// last particle of a keeper follows the first of the next keeper that knows one, hence the second all-reduce.
class Following {
 public:
  Following(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
            const Interaction& interaction)
      : rank_(rank), round_(round), interaction_(interaction), side_(interaction.meeting.sides[0]),
        system_(*script.systems[side_.system]), here_(*calculator.populations[side_.system]),
        count_(static_cast<int>(rank.session.calculators())), self_(rank.session.calculator()) {}

  bool run() {
    compute([&] { clear_dead(rank_, system_, here_); });
    if (all_reduce_max(rank_, round_, {rank_.session.failed() ? 1.0f : 0.0f})[0] > 0) return false;
    std::vector<Message> places(static_cast<std::size_t>(count_));
    compute([&] { tell(places); });
    trade(places);  // `places` now holds the messages to this keeper
    compute([&] { note(places); });
    const Maxima firsts = all_reduce_max(rank_, round_, first_places());
    if (firsts[0] > 0) return false;
    std::vector<Message> answers(static_cast<std::size_t>(count_));
    compute([&] { answer(firsts, answers); });
    trade(answers);
    compute([&] { act(answers); });
    return true;
  }

 private:
  template <class Work>
  void compute(const Work& work) {
    rank_.session.work("follow", [&] {
      here_.tally.compute_s +=
          rank_.machine.timed([&] { of_item(system_.list, side_.system, interaction_.item, work); });
    });
  }

  // Returns the calculator that keeps an id; each keeps an equal range of the ids assigned so far.
  std::size_t keeper_of(std::uint64_t id) const {
    const std::uint64_t width = system_.counts.born / static_cast<std::uint64_t>(count_) + 1;
    return std::min<std::size_t>(id / width, static_cast<std::size_t>(count_) - 1);
  }

  Position position_of(std::size_t i) const {
    Position at;
    for (int c = 0; c < 3; ++c) at[static_cast<std::size_t>(c)] = here_.store.value(particles::position, c, i);
    return at;
  }

  // Packs this rank's particles for their keepers.
  void tell(std::vector<Message>& told) {
    keepers_.assign(here_.store.size(), 0);
    for (std::size_t i = 0; i < here_.store.size(); ++i) {
      const std::uint64_t id = here_.store.ids()[i];
      keepers_[i] = static_cast<std::uint32_t>(keeper_of(id));
      base::Bytes& bytes = told[keepers_[i]].bytes();
      bytes.put(id);
      const Position at = position_of(i);
      bytes.put_raw(at.data(), sizeof at);
    }
  }

  // Exchanges one message between each pair of calculators, and with itself: replaces `messages`, by receiver, with
  // those received, by sender.
  void trade(std::vector<Message>& messages) {
    comm::Communicator& comm = rank_.session.comm();
    std::vector<Message> heard(messages.size());
    for (int step = 1; step < count_; ++step) {
      comm.await(rank_.session.rank_of((self_ + count_ - step) % count_), Phase::interaction);
    }
    for (int step = 1; step < count_; ++step) {
      const int to = (self_ + step) % count_;
      Message& message = messages[static_cast<std::size_t>(to)];
      here_.interaction.bytes += message.payload().size();
      comm.post(rank_.session.rank_of(to), Phase::interaction, rank_.session.stamp(round_), std::move(message), 0,
                rank_.session.failed());
    }
    heard[static_cast<std::size_t>(self_)] = std::move(messages[static_cast<std::size_t>(self_)]);
    for (int step = 1; step < count_; ++step) {
      const int from = (self_ + count_ - step) % count_;
      heard[static_cast<std::size_t>(from)] =
          comm.expect(rank_.session.rank_of(from), Phase::interaction, rank_.session.stamp(round_));
      silent_ = silent_ || heard[static_cast<std::size_t>(from)].header().failed != 0;
    }
    messages = std::move(heard);
  }

  // Sorts what calculators have told this keeper. Ids are unique, so the order does not depend on who told it.
  void note(const std::vector<Message>& told) {
    for (std::size_t from = 0; from < told.size(); ++from) {
      base::Reader in = told[from].reader();
      for (std::uint32_t entry = 0; !in.done(); ++entry) {
        const auto id = in.get<std::uint64_t>();
        known_.push_back({id, in.get<Position>(), static_cast<std::uint32_t>(from), entry});
      }
    }
    std::sort(known_.begin(), known_.end(), [](const Known& a, const Known& b) { return a.id < b.id; });
  }

  // Returns a failure flag and, per keeper, whether it knows a particle and the position of the one with the lowest id.
  Maxima first_places() const {
    Maxima numbers(1 + 4 * static_cast<std::size_t>(count_), -kInf);
    numbers[0] = rank_.session.failed() ? 1.0f : 0.0f;
    if (known_.empty()) return numbers;
    float* own = &numbers[1 + 4 * static_cast<std::size_t>(self_)];
    own[0] = 1;
    std::copy(known_.front().at.begin(), known_.front().at.end(), own + 1);
    return numbers;
  }

  // Packs, for each calculator, the positions of the next particles, in the order in which it told its own: ids need
  // not travel back.
  void answer(const Maxima& firsts, std::vector<Message>& answers) {
    Position last{};
    bool more = false;  // a later keeper knows a particle; `last` is its position
    for (int keeper = self_ + 1; keeper < count_ && !more; ++keeper) {
      const float* first = &firsts[1 + 4 * static_cast<std::size_t>(keeper)];
      more = first[0] > 0;
      if (more) std::copy(first + 1, first + 4, last.begin());
    }
    std::vector<std::vector<Position>> next(answers.size());
    std::vector<std::uint32_t> entries(answers.size(), 0);
    for (const Known& one : known_) entries[one.from] = std::max(entries[one.from], one.entry + 1);
    for (std::size_t c = 0; c < next.size(); ++c) next[c].resize(entries[c]);
    const Position nobody = {NAN, NAN, NAN};
    for (std::size_t k = 0; k < known_.size(); ++k) {
      next[known_[k].from][known_[k].entry] = k + 1 < known_.size() ? known_[k + 1].at : more ? last : nobody;
    }
    for (std::size_t c = 0; c < next.size(); ++c) {
      answers[c].bytes().put_raw(next[c].data(), next[c].size() * sizeof(Position));
    }
  }

  // Applies v += d magnitude dt / (r (r^2 + epsilon)), where d points to the next particle (McAllister's Follow).
  void act(const std::vector<Message>& answers) {
    if (silent_) return;  // all ranks give up at the next all-reduce, or at the report
    const actions::Action& action = *side_.action;
    const auto given = actions::numbers_of<actions::numbers::follow, float>(action);
    const float strength = given.magnitude * interaction_.meeting.step.dt, reach = given.max_radius;
    std::vector<std::uint8_t> chosen(here_.store.size(), action.where.empty() ? 1 : 0);
    if (!action.where.empty()) {
      for (const std::uint32_t p :
           program::select(action.where, action.shapes, interaction_.meeting.step.time, here_.store))
        chosen[p] = 1;
    }
    const particles::Periods& periods = system_.definition.periods;
    std::vector<base::Reader> readers;
    for (const Message& message : answers) readers.push_back(message.reader());
    float* v[3];
    for (int c = 0; c < 3; ++c) v[c] = here_.store.writable_plane(particles::velocity, c);
    for (std::size_t i = 0; i < here_.store.size(); ++i) {
      const auto target = readers[keepers_[i]].get<Position>();
      const Position own = position_of(i);
      Position d = {target[0] - own[0], target[1] - own[1], target[2] - own[2]};
      for (std::size_t c = 0; c < 3; ++c) d[c] = periods.shortest(static_cast<int>(c), d[c]);
      const float r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      if (!(r2 > 0 && r2 < reach * reach) || chosen[i] == 0) continue;
      ++here_.interaction.pairs;
      const float part = strength / (std::sqrt(r2) * (r2 + given.epsilon));
      for (std::size_t c = 0; c < 3; ++c) v[c][i] += d[c] * part;
    }
  }

  Rank& rank_;
  const Round& round_;
  const Interaction& interaction_;
  const interactions::Side& side_;
  const System& system_;
  Population& here_;
  int count_, self_;
  std::vector<std::uint32_t> keepers_;
  std::vector<Known> known_;
  bool silent_ = false;  // another calculator failed during the exchange
};

}  // namespace

bool follow(Rank& rank, const Script& script, Calculator& calculator, const Round& round,
            const Interaction& interaction) {
  return Following(rank, script, calculator, round, interaction).run();
}

}  // namespace motes::engine
