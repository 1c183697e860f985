#include "driver/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <sstream>
#include <stdexcept>

#include "balance/named.h"
#include "base/invalid_argument.h"
#include "threads/pool.h"

namespace motes::driver {
namespace {

constexpr double kLeastSpeed = 0.001;  // of a rank that emulates a slower machine

std::uint64_t number(const std::string& name, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw base::InvalidArgument(name, "be a whole number", "'" + text + "'");
  }
  return value;
}

int number_up_to(int most, const std::string& name, const std::string& text) {
  const std::uint64_t value = number(name, text);
  if (value < 1 || value > static_cast<std::uint64_t>(most)) {
    throw base::InvalidArgument(name, "be 1.." + std::to_string(most), text);
  }
  return static_cast<int>(value);
}

double scale(const std::string& name, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (!whole || !(value > 0) || !std::isfinite(value)) {
    throw base::InvalidArgument(name, "be a number > 0", "'" + text + "'");
  }
  return value;
}

std::string chosen(const std::string& name, const std::string& text, std::initializer_list<const char*> allowed) {
  std::string list;
  for (const char* each : allowed) {
    if (text == each) return text;
    list += (list.empty() ? "" : ", ") + std::string(each);
  }
  throw base::InvalidArgument(name, "be one of " + list, "'" + text + "'");
}

}  // namespace

Options read_options(std::span<char* const> arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string argument = arguments[i];
    const auto value = [&]() -> std::string {
      if (i + 1 == arguments.size()) throw base::InvalidArgument(argument, "be followed by a value");
      return arguments[++i];
    };
    if (argument == "--help" || argument == "-h") {
      options.help = true;
    } else if (argument == "--digest") {
      options.digest = true;
    } else if (argument == "--no-images") {
      options.images = false;
    } else if (argument == "--out") {
      options.out = value();
    } else if (argument == "--log") {
      options.log = value();
    } else if (argument == "--frames") {
      options.frames = number(argument, value());
    } else if (argument == "--roles") {
      options.roles = chosen(argument, value(), {"auto", "shared", "managing", "all"});
    } else if (argument == "--path") {
      options.path = chosen(argument, value(), {"auto", "gather", "tiles", "composite"});
    } else if (argument == "--combine") {
      options.combine = chosen(argument, value(), {"one_by_one", "together", "overlapped"});
    } else if (argument == "--balancer") {
      options.balancer = value();
      balance::policy_named(options.balancer);
    } else if (argument == "--ask") {
      options.ask = value();
    } else if (argument == "--births") {
      options.births = chosen(argument, value(), {"auto", "manager", "calculators"});
    } else if (argument == "--fan-out") {
      options.fan_out = number_up_to(INT32_MAX, argument, value());
    } else if (argument == "--threads") {
      options.threads = number_up_to(threads::Pool::kMost, argument, value());
    } else if (argument == "--costs") {
      options.costs = value();
    } else if (argument == "--scale") {
      options.scale = scale(argument, value());
    } else if (argument == "--blocking") {
      options.blocking = true;
    } else if (argument == "--spans") {
      options.spans = true;
    } else if (argument.starts_with('-')) {
      throw std::invalid_argument("unknown option " + argument + "; --help lists the options");
    } else if (!options.scene.empty()) {
      throw std::invalid_argument("only one scene can be replayed, got " + options.scene + " and " + argument);
    } else {
      options.scene = argument;
    }
  }
  if (options.spans && options.log.empty())
    throw std::invalid_argument("--spans needs --log, the directory for the timelines");
  if (!options.ask.empty() && !options.balancer.empty())
    throw std::invalid_argument("--ask and --balancer both name a balancer: give only one");
  if (options.scene.empty() && !options.help) {
    throw std::invalid_argument("no scene given: run motes_replay scene.motes, or see --help");
  }
  return options;
}

std::map<int, double> read_speeds(const char* text, int ranks) {
  std::map<int, double> speeds;
  const std::string all = text == nullptr || *text == '\0' ? "" : std::string(text) + ",";
  std::istringstream pairs(all);
  for (std::string pair; std::getline(pairs, pair, ',');) {
    const std::size_t colon = std::min(pair.find(':'), pair.size());
    const char* const end = pair.data() + pair.size();
    int rank = -1;
    double speed = 0;
    const bool numbered = std::from_chars(pair.data(), pair.data() + colon, rank).ptr == pair.data() + colon;
    const bool timed = colon < pair.size() && std::from_chars(pair.data() + colon + 1, end, speed).ptr == end;
    if (!numbered || !timed || rank < 0 || rank >= ranks || !(speed >= kLeastSpeed && speed <= 1)) {
      throw base::InvalidArgument(
          "MOTES_SPEEDS",
          "be rank:speed pairs such as 0:1.0,1:0.5 with ranks 0.." + std::to_string(ranks - 1) + " and speeds 0.001..1",
          std::string("'") + text + "'");
    }
    speeds[rank] = speed;
  }
  return speeds;
}

const char* usage() {
  return R"text(usage: motes_replay scene.motes [options]
       mpirun -n 4 motes_replay scene.motes [options]

Replays a scene that `python -m motes record` wrote, without Python, on any number of ranks.

  --digest              print one line per frame: frame particles_digest image_sha256 ("-" without a picture)
  --no-images           draw no pictures
  --out DIR             write the pictures there: frame-00000.ppm, ...
  --log DIR             write the run's log there
  --roles WHO           auto: rank 0 draws, rank 1 manages, the others calculate; managing: rank 1 calculates, too;
                        all: ranks 0 and 1 calculate, too; shared: all calculate, and rank 0 draws and manages
  --path WAY            which ranks draw, instead of the scene's path: auto, gather, tiles or composite
  --spans               with --log: also write a timeline of each rank
  --balancer TEXT       instead of the scene's, such as "Pairwise(threshold=0.1)", "PrefixCuts" or "Static"
  --ask DIR             a balancer in another program, which answers over pipes in this directory (cpp/driver/piped_policy.h)
  --combine WAY         instead of the scene's: one_by_one, together or overlapped
  --births WHO          who creates particles: manager (and sends them to their owners), calculators (each a part), or
                        auto: the faster of the two in each frame
  --fan-out N           each rank relays the manager's messages to at most N others (8)
  --threads N           threads per rank for calculating and drawing (1)
  --blocking            calculators wait until the image generator has taken their particles, as in the paper
  --costs FILE          under a simulator: what work costs, in lines "name = nanoseconds" (cpp/engine/session/costs.h)
  --scale R             under a simulator: each computed particle stands for R
  --frames N            only the first N frames
  --help                this text

Exit code: 0; 1 if the run failed; 2 if the scene or an argument is wrong.
Environment: MOTES_SIMD (sse2, avx2, avx512, neon), MOTES_STALL_S (the longest wait for a rank's answer, in seconds),
MOTES_SPEEDS (2:1.0,3:0.5: rank 3 spends as much time as a machine of half the speed would).
)text";
}

}  // namespace motes::driver
