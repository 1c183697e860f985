// motes_replay: replays a recorded scene without Python, on one rank or many.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>

#include "balance/named.h"
#include "base/enumerators.h"
#include "base/invalid_argument.h"
#include "base/sha256.h"
#include "comm/clock.h"
#include "comm/environment.h"
#include "comm/errors.h"
#include "comm/last_words.h"
#include "comm/mpi_transport.h"
#include "driver/files.h"
#include "driver/options.h"
#include "driver/piped_policy.h"
#include "driver/run_file.h"
#include "engine/births/share.h"
#include "engine/replay.h"
#include "image/camera.h"
#include "simd/isa.h"

namespace motes::driver {
namespace {

// A scene in memory, ready to be played.
struct Opened {
  explicit Opened(const std::string& path) : file(path) {
    try {
      scene = recording::read_scene(file.bytes());
      if (!scene.frames.empty()) first = recording::read_frame(scene.frames.front());
    } catch (const std::exception& error) {
      throw std::runtime_error(path + " " + error.what());
    }
  }
  MappedFile file;
  recording::Scene scene;
  recording::Record first;
};

double stall_limit() {
  const char* text = std::getenv("MOTES_STALL_S");
  if (text == nullptr || *text == '\0') return comm::Watch{}.limit_s;
  char* end = nullptr;
  const double seconds = std::strtod(text, &end);
  if (*end != '\0' || !std::isfinite(seconds) || seconds <= 0) {
    throw base::InvalidArgument("MOTES_STALL_S", "be a number of seconds > 0", std::string("'") + text + "'");
  }
  return seconds;
}

void complain(const std::string& text) {
  std::fflush(stdout);
  std::fprintf(stderr, "motes_replay: %s\n", text.c_str());
  std::fflush(stderr);
}

class Player {
 public:
  Player(const comm::Environment& mpi, const Options& options, const Opened& opened)
      : options_(options), opened_(opened), cast_(cast(options.roles, mpi.size())) {
    comm::Watch watch;
    watch.limit_s = stall_limit();
    watch.warn = complain;
    watch.describe = [this](int rank) { return describe(rank); };
    run_.seed = opened.first.seed;
    run_.dt = opened.first.dt;
    run_.substeps = opened.first.substeps;
    run_.log.digest = options.digest;
    run_.log.directory = options.log;
    run_.log.hosts = mpi.hosts(cast_.manager);
    run_.policy = policy();
    run_.policy->check(cast_.calculators.size());
    run_.combine = combine();
    run_.births = engine::births_named(options.births);
    run_.fan_out = options.fan_out;
    run_.threads = options.threads;
    run_.log.spans = options.spans;
    run_.blocking = options.blocking;
    run_.costs = costs();
    speeds_ = read_speeds(std::getenv("MOTES_SPEEDS"), mpi.size());
    if (const auto own = speeds_.find(mpi.rank()); own != speeds_.end()) run_.speed = own->second;
    auto communicator = std::make_unique<comm::Communicator>(comm::make_mpi(mpi.world()), std::move(watch));
    engine_ = std::make_unique<engine::Engine>(std::move(communicator), cast_, run_);
    if (!comm::simulated()) {
      comm::name_crashes("", "");
      comm::set_place(place());
    }
  }

  void play(std::span<char* const> argv) {
    for (const recording::SystemDefinition& system : opened_.first.systems) engine_->add_system(system);
    engine_->start();
    if (engine_->session().manages() && !options_.log.empty()) note_run(argv);
    const std::size_t frames = std::min<std::uint64_t>(options_.frames, opened_.scene.frames.size());
    for (std::size_t i = 0; i < frames; ++i) play_frame(i == 0 ? opened_.first : read(i));
    engine_->finish();
  }

  /// "rank 2 (calculator 0), frame 7".
  std::string place() const {
    return describe(engine_->session().rank()) + ", frame " + std::to_string(engine_->frame());
  }

 private:
  static roles::Cast cast(const std::string& name, int size) {
    if (name == "managing") return roles::cast_managing(size);
    if (name == "all") {
      roles::Cast cast = roles::cast_auto(size);
      cast.calculators = roles::cast_shared(size).calculators;
      std::rotate(cast.calculators.begin(), cast.calculators.begin() + 1, cast.calculators.end());
      return cast;
    }
    return name == "shared" ? roles::cast_shared(size) : roles::cast_auto(size);
  }

  // Returns the chosen balancer, or the one that the scene names. The scene does not contain a balancer that its script
  // defines.
  balance::PolicyPtr policy() const {
    const std::string own = opened_.scene.fact("balancer");
    if (!options_.ask.empty()) return open_piped_policy(options_.ask);
    if (!options_.balancer.empty()) return balance::policy_named(options_.balancer);
    try {
      return balance::policy_named(own.empty() ? "Static" : own);
    } catch (const std::invalid_argument&) {
      throw std::runtime_error("the scene's balancer " + own + " is defined by its script: choose one with --balancer");
    }
  }

  engine::Costs costs() const {
    engine::Costs costs;
    if (!options_.costs.empty()) {
      const MappedFile file(options_.costs);
      try {
        costs = engine::read_costs({reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()});
      } catch (const std::invalid_argument& error) {
        throw std::runtime_error(options_.costs + ", " + error.what());
      }
    }
    costs.messages.scale = options_.scale;
    return costs;
  }

  std::string combine_name() const {
    const std::string own = opened_.scene.fact("combine");
    return !options_.combine.empty() ? options_.combine : own.empty() ? "together" : own;
  }

  engine::Combine combine() const { return base::enumerator<engine::Combine>("combine", combine_name()); }

  std::string describe(int rank) const { return "rank " + std::to_string(rank) + " (" + cast_.describe(rank) + ")"; }

  recording::Record read(std::size_t i) const {
    recording::Record record = recording::read_frame(opened_.scene.frames[i]);
    if (record.seed != run_.seed || record.dt != run_.dt || record.substeps != run_.substeps) {
      throw std::runtime_error("its seed, dt or substeps differ from those of the first frame");
    }
    return record;
  }

  void play_frame(recording::Record record) {
    if (record.view && !options_.path.empty()) record.view->path = image::path_named(options_.path);
    const std::uint64_t index = engine_->frame();
    engine::replay(*engine_, record, options_.images);
    std::string sha256 = "-";
    if (engine_->session().draws() && options_.images && record.view) {
      const image::Pixels pixels = engine_->painter().take_pixels();
      const auto [width, height] = std::pair(record.view->width, record.view->height);
      if (options_.digest) {
        sha256 = base::picture_sha256(width, height, pixels);
        engine_->set_image_sha256(sha256);
      }
      if (!options_.out.empty()) {
        char name[32];
        std::snprintf(name, sizeof name, "/frame-%05llu.ppm", static_cast<unsigned long long>(index));
        write_ppm(options_.out + name, width, height, pixels);
      }
    }
    if (options_.digest) {
      const std::string particles = particles::combine(engine_->digest()).text();
      if (engine_->session().draws())
        std::printf("%llu %s %s\n", static_cast<unsigned long long>(index), particles.c_str(), sha256.c_str());
      std::fflush(stdout);
    }
  }

  void note_run(std::span<char* const> argv) const {
    write_run(
        options_.log,
        {{argv.begin(), argv.end()}, &opened_.scene, run_, combine_name(), cast_, opened_.first.systems, speeds_});
  }

  const Options& options_;
  const Opened& opened_;
  roles::Cast cast_;
  engine::Settings run_;
  std::map<int, double> speeds_;  // of ranks that emulate slower machines
  std::unique_ptr<engine::Engine> engine_;
};

// Reports an error from one rank and ends the job on all ranks, so that none keeps waiting for a failed rank.
[[noreturn]] void give_up(const comm::Environment& mpi, const std::string& text, bool others_speak) {
  const double wait_s = others_speak ? 2.5 : std::min(1.0, 0.05 * mpi.rank());
  const timespec nap{static_cast<time_t>(wait_s), static_cast<long>((wait_s - std::floor(wait_s)) * 1e9)};
  if (!comm::simulated()) nanosleep(&nap, nullptr);  // the first rank to report ends the others before they report too
  complain(text);
  mpi.abort(1);
}

void run(const comm::Environment& mpi, const Options& options, const Opened& opened, std::span<char* const> argv) {
  std::optional<Player> player;
  try {
    player.emplace(mpi, options, opened);
    player->play(argv);
  } catch (const engine::Agreed& error) {
    give_up(mpi, error.what(), error.verdict().failed_rank != mpi.rank());
  } catch (const std::exception& error) {
    give_up(mpi, (player ? player->place() + ": " : "") + error.what(), false);
  }
}

int main(int argc, char** argv) {
  const comm::Environment mpi(argc, argv);
  const std::span<char* const> arguments(argv, static_cast<std::size_t>(argc));
  Options options;
  std::optional<Opened> opened;
  std::string wrong;
  try {
    options = read_options(arguments.subspan(1));
    if (!options.help) opened.emplace(options.scene);
    simd::isa();
    stall_limit();
    read_speeds(std::getenv("MOTES_SPEEDS"), mpi.size());
  } catch (const std::exception& error) {
    wrong = error.what();
  }
  const int first = mpi.first(!wrong.empty());
  if (first == mpi.rank()) complain(wrong);
  if (first >= 0) return 2;
  if (options.help) {
    if (mpi.rank() == 0) std::fputs(usage(), stdout);
    return 0;
  }
  run(mpi, options, *opened, arguments);
  return 0;
}

}  // namespace
}  // namespace motes::driver

// Visible, since a simulator loads the program as a library and looks for main.
[[gnu::visibility("default")]] int main(int argc, char** argv) {
  try {
    return motes::driver::main(argc, argv);
  } catch (const motes::comm::CommError& error) {  // MPI cannot start
    motes::driver::complain(error.what());
    return 1;
  }
}
