#include "engine/act/course.h"

#include <algorithm>
#include <utility>

#include "engine/act/act.h"
#include "engine/act/meet.h"
#include "engine/act/run_list.h"
#include "engine/session/item_failure.h"

namespace motes::engine {

using particles::Store;

namespace {

bool collides(const Piece& piece) { return piece.meeting != nullptr && piece.meeting->kind == actions::Kind::collide; }

}  // namespace

Course::Course(Rank& rank, const Script& script, Calculator& calculator, const Round& round)
    : rank_(rank), script_(script), calculator_(calculator), round_(round) {}

void Course::take_births(std::size_t index, Newborn& newborn) {
  const System& system = *script_.systems[index];
  Population& here = *calculator_.populations[index];
  here.outcome.gathers = false;  // the list runs in parts
  here.outcome.wants_hits = asks_for(system, recording::Spawn::On::collision);
  Runner& runner = runners_.emplace_back(Runner{index, system.pending_pieces(), {}});
  runner.newborn_from = system.counts.newborn_from;
  for (const BirthGroup& group : system.groups) {
    of_item(system.list, index, group.item, [&] {
      Store births(system.schema);
      if (rank_.creates_in_place()) {
        create_own(rank_, system, group, births);
      } else {
        engine::take_births(rank_, system, group, newborn, births);
      }
      here.tally.created += births.size();
      runner.births.push_back(std::move(births));
    });
  }
}

void Course::run() {
  for (int substep = 0; substep < rank_.settings.substeps; ++substep) {
    if (!run_substep(substep)) return;
  }
}

// Systems take turns; where one waits for another that it meets, the other goes on to that place in its own list.
bool Course::run_substep(int substep) {
  for (Runner& runner : runners_) {
    runner.next_piece = 0;
    runner.collided = Collided::none;
    runner.contacts = 0;
    calculator_.populations[runner.system]->collided.clear();
  }
  std::vector<const Piece*> waits(runners_.size(), nullptr);
  for (std::size_t done = 0; done < runners_.size();) {
    done = 0;
    bool moved = false;
    for (std::size_t r = 0; r < runners_.size(); ++r) {
      Runner& runner = runners_[r];
      while (true) {
        if (waits[r] == nullptr) waits[r] = run_to_meeting(runner, substep);
        if (waits[r] == nullptr) break;
        std::size_t first = r;
        std::size_t second = r;
        if (waits[r]->meeting->other >= 0) {
          const std::size_t other = partner_of(runner, *waits[r]);
          if (waits[other] == nullptr || waits[other]->meeting->other != static_cast<std::int32_t>(runner.system))
            break;
          (waits[r]->meeting->second ? first : second) = other;
        }
        const Meeting meeting = meeting_of(*waits[first], runners_[first], runners_[second], substep);
        waits[first] = nullptr;
        waits[second] = nullptr;
        moved = true;
        if (!meet(rank_, script_, calculator_, round_, meeting)) return false;
      }
      if (waits[r] == nullptr && runner.next_piece == runner.pieces.size()) ++done;
    }
    if (!moved && done < runners_.size()) throw std::logic_error("systems wait for each other to meet");
  }
  return true;
}

Meeting Course::meeting_of(const Piece& piece, Runner& first, Runner& second, int substep) const {
  Meeting meeting{piece.meeting, piece.end, {first.system, second.system}, &first == &second ? 1u : 2u};
  const auto substeps = static_cast<std::uint64_t>(rank_.settings.substeps);
  meeting.substep = static_cast<std::uint32_t>(rank_.talk.frame * substeps) + static_cast<std::uint32_t>(substep) + 1;
  meeting.time = program::time_of({rank_.talk.frame, rank_.settings.substeps, rank_.settings.dt}, substep);
  meeting.last = substep + 1 == rank_.settings.substeps;
  if (piece.meeting->kind == actions::Kind::contact) meeting.law = first.contacts++;
  if (piece.meeting->kind != actions::Kind::collide) return meeting;
  Runner* const runners[2] = {&first, &second};
  for (std::size_t side = 0; side < meeting.count; ++side) {
    Runner& runner = *runners[side];
    const System& system = *script_.systems[runner.system];
    meeting.newborn_from[side] = runner.newborn_from;
    meeting.collided[side] = runner.collided;
    const auto rest = runner.pieces.begin() + static_cast<std::ptrdiff_t>(runner.next_piece);
    meeting.collides_again[side] = std::any_of(rest, runner.pieces.end(), collides);
    const bool some = side == 0 && !piece.meeting->where.empty() && runner.collided != Collided::all;
    runner.collided = some ? Collided::some : Collided::all;
    runner.newborn_from =
        runner.next_group < system.groups.size() ? system.groups[runner.next_group].first_id : system.counts.born;
  }
  return meeting;
}

std::size_t Course::partner_of(const Runner& runner, const Piece& piece) const {
  const auto found = std::find_if(runners_.begin(), runners_.end(), [&](const Runner& other) {
    return other.system == static_cast<std::size_t>(piece.meeting->other);
  });
  if (found == runners_.end() || &*found == &runner) throw std::logic_error("two systems meet, but one has no list");
  return static_cast<std::size_t>(found - runners_.begin());
}

const Piece* Course::run_to_meeting(Runner& runner, int substep) {
  while (runner.next_piece < runner.pieces.size()) {
    const Piece& piece = runner.pieces[runner.next_piece++];
    rank_.talk.work("act", [&] {
      calculator_.populations[runner.system]->tally.compute_s +=
          rank_.machine.timed([&] { run_piece(runner, piece, substep); });
    });
    if (piece.meeting != nullptr) return &piece;
  }
  return nullptr;
}

// Old particles run the piece; those that are born in it join behind their birth.
void Course::run_piece(Runner& runner, const Piece& piece, int substep) {
  const System& system = *script_.systems[runner.system];
  Population& here = *calculator_.populations[runner.system];
  const Settings& settings = rank_.settings;
  const program::Span span{rank_.talk.frame, settings.substeps, settings.dt, substep, substep + 1};
  const program::Region everywhere;
  const auto run = [&](std::size_t begin, std::size_t skip) {
    piece.program.run(here.store, begin, skip, span, system.key, everywhere, here.outcome, *rank_.pool);
  };
  run(0, 0);
  std::size_t& g = runner.next_group;
  for (; g < system.groups.size() && system.groups[g].substep == substep && system.groups[g].item < piece.end; ++g) {
    const std::size_t begin = here.store.size();
    const Store& births = runner.births[g];
    here.store.append(births);
    run(begin, system.groups[g].entry - piece.first);
  }
  here.moved = true;
  if (piece.callback != nullptr) {
    call_back(calculator_, runner.system, *piece.callback, program::time_of(span, substep), 0);
  }
}

}  // namespace motes::engine
