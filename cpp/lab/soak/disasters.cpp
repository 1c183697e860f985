#include "lab/soak/disasters.h"

#include <algorithm>
#include <map>
#include <string_view>
#include <utility>

#include "lab/soak/player.h"

namespace motes::soak {
namespace {

using Death = comm::Simulation::Death;
constexpr std::string_view kUnstarted = "before the first frame";  // where no run can continue without a rank

// Returns the film of an undisturbed run, played once per story.
const Film& model_of(const Story& story) {
  thread_local std::map<Story, Film> models;
  const auto [place, fresh] = models.try_emplace(story);
  if (fresh) play(story, Way{}, {}, place->second);
  return place->second;
}

std::string_view compared(const Film& film, const Film& model) {
  if (film.particles != model.particles) return "particles differ from those of an undisturbed run";
  if (film.pictures != model.pictures) return "pictures differ from those of an undisturbed run";
  if (film.reel != model.reel) return "the film differs from that of an undisturbed run";
  return "";
}

Death random_death(Random& random, int ranks, std::uint64_t points) {
  const auto rank = static_cast<int>(random.below(static_cast<std::size_t>(ranks)));
  const auto at = [&](std::uint64_t most) { return 1 + static_cast<std::uint64_t>(random.below(most)); };
  switch (random.below(8)) {
    case 0: return {rank, at(2), Death::At::shrink};  // while it recovers from another loss, if it gets there
    case 1: return {rank, at(points / 4 + 1), Death::At::send};
    default: return {rank, at(points), Death::At::point};
  }
}

// Draws deaths at any moment of the run as it would be without them.
void draw_deaths(Random& random, const Story& story, const Way& way, std::size_t deaths, bool saves,
                 Accidents& accidents) {
  Film quiet;
  Disk disk;
  const Played played = play(story, way, accidents, quiet, saves ? &disk : nullptr);
  const std::uint64_t points = played.points / static_cast<std::uint64_t>(way.ranks) + 1;
  for (std::size_t i = 0; i < deaths; ++i) accidents.deaths.push_back(random_death(random, way.ranks, points));
  const bool at_once = deaths > 1 && random.below(2) == 0;
  if (at_once) accidents.deaths[1].point = accidents.deaths[0].point;
}

void lose_ranks(Random& random, const Story& story, const Way& way, Disaster& disaster) {
  Accidents accidents;
  accidents.order = random.next();
  Disk disk;
  Disk* const saves = random.below(2) == 0 ? &disk : nullptr;
  const std::size_t deaths = 1 + (random.below(2) == 0 ? random.below(3) : 0);
  draw_deaths(random, story, way, deaths, saves != nullptr, accidents);
  Film film;
  const Played played = play(story, way, accidents, film, saves);
  disaster.died = static_cast<int>(played.dead.size());
  disaster.survived = static_cast<int>(played.losses);
  disaster.reported = !played.end.empty();
  disaster.broken = played.broken;
  const bool before = played.end.starts_with(kUnstarted);
  if (disaster.reported && !before && deaths == 1)
    disaster.broken = "the loss of one rank ended the run: " + played.end;
  if (!disaster.broken.empty() || disaster.reported || disaster.died == way.ranks) return;
  disaster.broken = compared(film, model_of(story));
}

// Damages a checkpoint: a bit flips, a file is cut off or deleted.
void damage(Random& random, Disk& disk) {
  if (disk.checkpoints.empty() || random.below(2) == 0) return;
  auto& parts = disk.checkpoints.rbegin()->second.parts;
  if (parts.empty()) return;
  auto part = parts.begin();
  std::advance(part, static_cast<std::ptrdiff_t>(random.below(parts.size())));
  base::Bytes& file = part->second;
  switch (random.below(3)) {
    case 0: parts.erase(part); break;
    case 1: file.resize(random.below(file.size())); break;
    default: file.data()[random.below(file.size())] ^= std::byte{1} << random.below(8);
  }
}

void kill_jobs(Random& random, const Story& story, Way way, Disaster& disaster) {
  Film film;
  Disk disk;
  for (;;) {
    Accidents accidents;
    accidents.order = random.next();
    if (disaster.died < 3) {
      // Ranks may be lost before: what the others save then must be whole, too.
      if (way.ranks > 1 && random.below(2) == 0) draw_deaths(random, story, way, 1, true, accidents);
      accidents.killed_at = random.below(kFrames + 4);
    }
    const Played played = play(story, way, accidents, film, &disk);
    disaster.broken = played.broken;
    if (!played.end.empty() && played.end != "killed" && !played.end.starts_with(kUnstarted)) {
      disaster.broken = "the loss of one rank ended the run: " + played.end;
    }
    if (played.end.empty() && static_cast<int>(played.dead.size()) < way.ranks) break;
    if (!disaster.broken.empty()) return;
    ++disaster.died;
    ++disaster.survived;
    damage(random, disk);
    way = random_way(random);
  }
  if (disaster.broken.empty()) disaster.broken = compared(film, model_of(story));
}

}  // namespace

Disaster disaster(std::uint64_t seed) {
  Random random(seed * 2 + 1);
  Disaster disaster;
  const Story story = random_story(random);
  const Way way = random_way(random);
  disaster.ranks = way.ranks;
  const std::size_t kind = random.below(8);
  if (kind < 5 && way.ranks > 1) {
    disaster.kind = Disaster::Kind::losses;
    lose_ranks(random, story, way, disaster);
  } else if (kind < 7) {
    disaster.kind = Disaster::Kind::restarts;
    kill_jobs(random, story, way, disaster);
  } else {
    Accidents accidents;
    accidents.order = random.next();
    Film film;
    disaster.broken = play(story, way, accidents, film).broken;
    if (disaster.broken.empty()) disaster.broken = compared(film, model_of(story));
  }
  return disaster;
}

}  // namespace motes::soak
