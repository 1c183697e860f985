#include "lab/soak/player.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <utility>

#include "base/fields.h"
#include "base/sha256.h"
#include "engine/recovering_engine.h"
#include "snapshots/part.h"

namespace motes::soak {
namespace {

constexpr std::uint64_t kCopiesEvery = 4;
constexpr std::uint64_t kSaveEvery = 3;
constexpr std::size_t kSegment = 4;  // pictures that go to the film's file together, unless a checkpoint is due

// Ends the whole job at once.
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
  Saved copy{saved.calculators, bytes(saved.shared), {}, saved.reel};
  for (const auto& [calculator, file] : saved.parts) copy.parts[calculator] = bytes(file);
  return copy;
}

// Returns the checkpoint that a run continues from: the newest whole one.
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
    if (engine_.session().comm().survives()) engine_.survive_losses(kCopiesEvery, bystander());
    engine_.on_orders([this] { return std::to_string(engine_.session().rank()) + ":" + std::to_string(++asked_); });
    if (from_ != nullptr) restore(*from_);
    written_ = from_ == nullptr ? 0 : from_->reel;
    saved_ = engine_.frame();
    while (engine_.frame() < kFrames) one_frame();
    if (disk_ != nullptr) save();
    close_film();
    engine_.finish();
    for (const auto& [frame, orders] : orders_) note(played_.orders, frame, orders);
    played_.losses = std::max(played_.losses, engine_.losses());
  }

 private:
  engine::Bystander bystander() {
    engine::Bystander bystander;
    bystander.unsaved_from = [this](const engine::Loss&) { return take_over(); };
    bystander.redrawn = [this](std::uint64_t frame, const image::View&) {
      const std::string picture = note_picture(frame);
      if (again_.empty() || again_.front() != frame) return;
      again_.erase(again_.begin());
      shoot(frame, picture);
      if (again_.empty() && closed_) flush();
    };
    return bystander;
  }

  void one_frame() {
    const std::uint64_t frame = engine_.frame();
    if (disk_ != nullptr && frame > saved_ && frame % kSaveEvery == 0) save();
    record(engine_, story_, frame);
    if (frame == accidents_.killed_at && engine_.session().manages()) throw Killed();
    if (engine_.session().draws()) engine_.set_unsaved_from(queue_.empty() ? UINT64_MAX : queue_.front().first);
    engine_.run_frame(view(story_, way_, frame));
    orders_[frame] = engine_.orders();
    if (story_.pictures) {
      if (engine_.session().draws()) shoot(frame, note_picture(frame));
      ++written_;
      unsecured_.push_back(frame);
    }
    const std::string digest = particles::combine(engine_.digest()).text();
    note(film_.particles, frame, digest + " " + std::to_string(engine_.system(1).counts.dropped));
  }

  void note(std::map<std::uint64_t, std::string>& lines, std::uint64_t frame, const std::string& line) {
    const auto [place, fresh] = lines.emplace(frame, line);
    if (!fresh && place->second != line)
      played_.broken = "frame " + std::to_string(frame) + " was produced twice: " + place->second + " and " + line;
  }

  std::string note_picture(std::uint64_t frame) {
    std::string picture = base::picture_sha256(kWidth, kHeight, engine_.painter().take_pixels());
    note(film_.pictures, frame, picture);
    return picture;
  }

  // --- the film, as the script's side keeps it (python/motes/_film/movie.py)

  // Queues pictures on the rank that draws; several are written to the file together.
  void shoot(std::uint64_t frame, const std::string& picture) {
    queue_.emplace_back(frame, picture);
    if ((film_.reel.size() + queue_.size()) % kSegment == 0) flush();
  }

  void flush() {
    for (auto& [frame, picture] : queue_) film_.reel.push_back(std::move(picture));
    queue_.clear();
  }

  void close_film() {
    closed_ = true;
    flush();
  }

  // Continues the film of a lost rank, whose pictures are in the file except for the last ones. Returns the first frame
  // to draw again.
  std::uint64_t take_over() {
    const std::size_t behind = written_ - unsecured_.size();
    const std::size_t held = std::min(film_.reel.size(), written_);
    if (held < behind) throw std::runtime_error("the film lacks pictures that were reported as written");
    film_.reel.resize(held);
    queue_.clear();
    again_.assign(unsecured_.begin() + static_cast<std::ptrdiff_t>(held - behind), unsecured_.end());
    return again_.empty() ? UINT64_MAX : again_.front();
  }

  // --- checkpoints (python/motes/_checkpoint/saving.py)

  // Each calculator writes its part; when all parts are there, one rank writes a manifest. Repeated if ranks were lost
  // before all others knew that the checkpoint is whole.
  void save() {
    const std::uint64_t frame = saved_ = engine_.frame();
    while (whole_ != frame) {
      engine_.secure([this] { flush(); });
      unsecured_.clear();
      const std::uint32_t losses = engine_.losses();
      Saved& saved = played_.drafts[{frame, losses}];
      if (engine_.session().calculates()) saved.parts[engine_.session().calculator()] = part();
      const std::vector<std::string> parts =
          engine_.tell([this, losses] { return std::string(engine_.losses() == losses ? "part" : ""); });
      const bool all = std::count(parts.begin(), parts.end(), "part") == static_cast<std::ptrdiff_t>(parts.size());
      if (all && engine_.losses() == losses && engine_.session().manages()) finish(frame, saved);
      const std::vector<std::string> answers =
          engine_.tell([this, frame] { return std::string(whole_ == frame ? "whole" : ""); });
      if (std::count(answers.begin(), answers.end(), "whole") > 0) whole_ = frame;
    }
  }

  base::Bytes part() {
    base::Bytes planes;
    snapshots::Description description = engine_.copy_part(planes);
    base::Bytes file = snapshots::head(description, planes.view());
    file.put_raw(planes.data(), planes.size());
    return file;
  }

  void finish(std::uint64_t frame, Saved& saved) {
    saved.shared = engine_.shared_state();
    saved.calculators = static_cast<std::uint32_t>(engine_.session().calculators());
    saved.reel = written_;
    if (film_.reel.size() < written_) played_.broken = "a checkpoint counts pictures that are in no file";
    disk_->checkpoints[frame] = std::move(saved);
    while (disk_->checkpoints.size() > 2) disk_->checkpoints.erase(disk_->checkpoints.begin());
    whole_ = frame;
  }

  // Restores this calculator's share of all parts.
  void restore(const Saved& saved) {
    std::vector<snapshots::Opened> parts;
    for (const auto& [calculator, file] : saved.parts) parts.push_back(snapshots::open(file.view(), false));
    std::vector<engine::Sample> samples(2);
    for (const snapshots::Opened& part : parts) {
      for (std::size_t i = 0; i < 2; ++i) engine::take_sample(part.description, part.planes, i, 40, samples[i]);
    }
    engine_.restore_state(saved.shared.view(), samples);
    if (engine_.session().calculates()) {
      const auto own = static_cast<std::uint64_t>(engine_.session().calculator());
      const std::uint64_t count = engine_.session().calculators();
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
  engine::RecoveringEngine engine_;
  std::uint64_t saved_ = 0;  // frame of the last checkpoint
  std::uint64_t whole_ = UINT64_MAX;  // frame of the last one known to be whole
  std::map<std::uint64_t, std::string> orders_;  // what this rank received in each frame
  int asked_ = 0;  // how often it was asked for orders

  std::size_t written_ = 0;  // pictures of the film, the same on every rank
  std::vector<std::uint64_t> unsecured_;  // frames of the last ones, which may not be in its file
  std::vector<std::uint64_t> again_;  // to draw again: a lost rank had their pictures
  std::vector<std::pair<std::uint64_t, std::string>> queue_;  // pictures not yet in the file
  bool closed_ = false;  // whether the film is closed
};

}  // namespace

Played play(const Story& story, const Way& way, const Accidents& accidents, Film& film, Disk* disk) {
  comm::Simulation simulation;
  simulation.ranks = way.ranks;
  simulation.seed = accidents.order;
  simulation.survives = !accidents.deaths.empty();
  simulation.deaths = accidents.deaths;
  std::optional<Saved> from;  // a copy, since the disk keeps changing
  if (const Saved* found = disk == nullptr ? nullptr : newest(*disk)) from = copied(*found);
  film.reel.resize(from ? from->reel : 0);
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
