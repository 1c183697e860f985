#include "soak/player.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <utility>

#include "base/fields.h"
#include "base/sha256.h"
#include "snapshots/part.h"

namespace motes::soak {
namespace {

constexpr std::uint64_t kCopiesEvery = 4;
constexpr std::uint64_t kSaveEvery = 3;

// The end of the whole job at once.
struct Killed : std::exception {};

bool whole(const Saved& saved) {
  if (saved.calculators == 0 || saved.parts.size() != saved.calculators) return false;
  return std::all_of(saved.parts.begin(), saved.parts.end(), [](const auto& part) {
    try {
      snapshots::open(part.second.view(), true);
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  });
}

Saved copied(const Saved& saved) {
  const auto bytes = [](const base::Bytes& from) {
    base::Bytes copy;
    copy.put_raw(from.data(), from.size());
    return copy;
  };
  Saved copy{saved.calculators, bytes(saved.shared), {}};
  for (const auto& [calculator, file] : saved.parts) copy.parts[calculator] = bytes(file);
  return copy;
}

// What a run goes on from: the newest checkpoint that is whole.
const Saved* newest(const Disk& disk) {
  const auto& all = disk.checkpoints;
  const auto found = std::find_if(all.rbegin(), all.rend(), [](const auto& each) { return whole(each.second); });
  return found == all.rend() ? nullptr : &found->second;
}

// The script's side of one rank.
class Player {
 public:
  Player(comm::SimulatedRank& self, const Story& story, const Way& way, const Accidents& accidents, Film& film,
         Disk* disk, const Saved* from, Played& played)
      : story_(story), way_(way), accidents_(accidents), film_(film), disk_(disk), from_(from), played_(played),
        engine_(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), way.cast, settings(story, way)) {
  }

  void play() {
    define(engine_, way_);
    engine_.start();
    if (engine_.talk().comm().survives()) engine_.survive_losses(kCopiesEvery, bystander());
    if (from_ != nullptr) restore(*from_);
    saved_ = engine_.frame();
    while (engine_.frame() < kFrames) one_frame();
    engine_.finish();
    played_.losses = std::max(played_.losses, engine_.losses());
  }

 private:
  engine::Bystander bystander() {
    engine::Bystander bystander;
    bystander.unsaved_from = [this](const engine::Loss&) { return first_unsaved(); };
    bystander.redrawn = [this](std::uint64_t frame, const image::View&) { note_picture(frame); };
    return bystander;
  }

  void one_frame() {
    const std::uint64_t frame = engine_.frame();
    if (disk_ != nullptr && frame > saved_ && frame % kSaveEvery == 0) save();
    record(engine_, story_, frame);
    if (frame == accidents_.killed_at && engine_.talk().manages()) throw Killed();
    engine_.run_frame(view(story_, way_, frame));
    ran_ = frame + 1;
    if (story_.pictures && engine_.talk().draws()) note_picture(frame);
    const std::string digest = particles::combine(engine_.digest()).text();
    note(film_.particles, frame, digest + " " + std::to_string(engine_.system(1).counts.dropped));
  }

  void note(std::map<std::uint64_t, std::string>& lines, std::uint64_t frame, const std::string& line) {
    const auto [place, fresh] = lines.emplace(frame, line);
    if (!fresh && place->second != line) played_.broken = "frame " + std::to_string(frame) + " came out twice";
  }

  void note_picture(std::uint64_t frame) {
    note(film_.pictures, frame, base::picture_sha256(kWidth, kHeight, engine_.painter().take_pixels()));
  }

  // What the ranks that died have drawn is in files, but for the last pictures.
  std::uint64_t first_unsaved() const {
    std::uint64_t frame = 0;
    while (film_.pictures.contains(frame)) ++frame;
    return story_.pictures && frame < ran_ ? frame : UINT64_MAX;
  }

  // As checkpoints are: each calculator its part, then a manifest, which one rank writes when all are there.
  void save() {
    const std::uint64_t frame = saved_ = engine_.frame();
    Saved& saved = played_.drafts[frame];
    if (engine_.talk().calculates()) {
      base::Bytes planes;
      snapshots::Description description = engine_.copy_part(planes);
      base::Bytes file = snapshots::head(description, planes.view());
      file.put_raw(planes.data(), planes.size());
      saved.parts[engine_.talk().calculator()] = std::move(file);
    }
    engine_.secure();
    engine_.digest();
    if (!engine_.talk().manages()) return;
    saved.shared = engine_.shared_state();
    saved.calculators = static_cast<std::uint32_t>(engine_.talk().calculators());
    disk_->checkpoints[frame] = std::move(saved);
    while (disk_->checkpoints.size() > 2) disk_->checkpoints.erase(disk_->checkpoints.begin());
  }

  // Each calculator takes its share of all parts.
  void restore(const Saved& saved) {
    std::vector<snapshots::Opened> parts;
    for (const auto& [calculator, file] : saved.parts) parts.push_back(snapshots::open(file.view(), false));
    std::vector<engine::Sample> samples(2);
    for (const snapshots::Opened& part : parts) {
      for (std::size_t i = 0; i < 2; ++i) engine::take_sample(part.description, part.planes, i, 40, samples[i]);
    }
    engine_.restore_state(saved.shared.view(), samples);
    if (engine_.talk().calculates()) {
      const auto own = static_cast<std::uint64_t>(engine_.talk().calculator());
      const std::uint64_t count = engine_.talk().calculators();
      for (const snapshots::Opened& part : parts) {
        for (std::size_t i = 0; i < 2; ++i) {
          const std::uint64_t rows = part.description.systems[i].rows;
          engine_.restore_rows(part.description, part.planes, i, rows * own / count, rows * (own + 1) / count);
        }
      }
    }
    engine_.copy_restored();
  }

  const Story& story_;
  const Way& way_;
  const Accidents& accidents_;
  Film& film_;
  Disk* disk_;
  const Saved* from_;
  Played& played_;
  engine::Engine engine_;
  std::uint64_t ran_ = 0;    // frames of which it has the outcome
  std::uint64_t saved_ = 0;  // the frame of the last checkpoint
};

}  // namespace

Played play(const Story& story, const Way& way, const Accidents& accidents, Film& film, Disk* disk) {
  comm::Simulation simulation;
  simulation.ranks = way.ranks;
  simulation.seed = accidents.order;
  simulation.survives = !accidents.deaths.empty();
  simulation.deaths = accidents.deaths;
  std::optional<Saved> from;  // on a disk that goes on changing
  if (const Saved* found = disk == nullptr ? nullptr : newest(*disk)) from = copied(*found);
  Played played;
  try {
    const comm::SimulatedRun run = comm::simulate(simulation, [&](comm::SimulatedRank& self) {
      Player(self, story, way, accidents, film, disk, from ? &*from : nullptr, played).play();
    });
    played.points = run.points;
    played.dead = run.dead;
  } catch (const Killed&) {
    played.end = "killed";
  } catch (const engine::Unrecoverable& error) {
    played.end = error.what();
  } catch (const comm::RankLost& error) {
    played.end = std::string("before the first frame: ") + error.what();
  } catch (const std::exception& error) {
    played.broken = error.what();
  }
  return played;
}

}  // namespace motes::soak
