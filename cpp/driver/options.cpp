#include "driver/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <sstream>
#include <stdexcept>

#include "balance/named.h"

namespace motes::driver {
namespace {

constexpr double kLeastSpeed = 0.001;  // of a rank that behaves like a slower machine

std::uint64_t number(const std::string& name, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw std::invalid_argument(name + " takes a whole number, got '" + text + "'");
  }
  return value;
}

double scale(const std::string& name, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (!whole || !(value > 0) || !std::isfinite(value)) {
    throw std::invalid_argument(name + " takes a number > 0, got '" + text + "'");
  }
  return value;
}

std::string chosen(const std::string& name, const std::string& text, std::initializer_list<const char*> allowed) {
  std::string list;
  for (const char* each : allowed) {
    if (text == each) return text;
    list += (list.empty() ? "" : ", ") + std::string(each);
  }
  throw std::invalid_argument(name + " is one of " + list + "; got '" + text + "'");
}

}  // namespace

Options read_options(std::span<char* const> words) {
  Options options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string word = words[i];
    const auto value = [&]() -> std::string {
      if (i + 1 == words.size()) throw std::invalid_argument(word + " needs a value behind it");
      return words[++i];
    };
    if (word == "--help" || word == "-h") {
      options.help = true;
    } else if (word == "--digest") {
      options.digest = true;
    } else if (word == "--no-images") {
      options.images = false;
    } else if (word == "--out") {
      options.out = value();
    } else if (word == "--log") {
      options.log = value();
    } else if (word == "--frames") {
      options.frames = number(word, value());
    } else if (word == "--roles") {
      options.roles = chosen(word, value(), {"auto", "shared"});
    } else if (word == "--combine") {
      options.combine = chosen(word, value(), {"one_by_one", "together", "overlapped"});
    } else if (word == "--balancer") {
      options.balancer = value();
      balance::policy_named(options.balancer);
    } else if (word == "--births") {
      options.births = chosen(word, value(), {"manager", "calculators"});
    } else if (word == "--fan-out") {
      const std::uint64_t most = number(word, value());
      if (most < 1 || most > INT32_MAX) throw std::invalid_argument("--fan-out takes a whole number from 1 on");
      options.fan_out = static_cast<int>(most);
    } else if (word == "--costs") {
      options.costs = value();
    } else if (word == "--scale") {
      options.scale = scale(word, value());
    } else if (word == "--blocking") {
      options.blocking = true;
    } else if (word == "--spans") {
      options.spans = true;
    } else if (word.starts_with('-')) {
      throw std::invalid_argument("no option is called " + word + "; --help lists them");
    } else if (!options.scene.empty()) {
      throw std::invalid_argument("one scene at a time, got " + options.scene + " and " + word);
    } else {
      options.scene = word;
    }
  }
  if (options.spans && options.log.empty()) throw std::invalid_argument("--spans needs --log: timelines go there");
  if (options.scene.empty() && !options.help) {
    throw std::invalid_argument("no scene given: motes_replay scene.motes; --help says more");
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
      throw std::invalid_argument("MOTES_SPEEDS must be rank:speed pairs such as 0:1.0,1:0.5 with ranks 0.." +
                                  std::to_string(ranks - 1) + " and speeds 0.001..1, got '" + text + "'");
    }
    speeds[rank] = speed;
  }
  return speeds;
}

const char* usage() {
  return R"text(usage: motes_replay scene.motes [options]
       mpirun -n 4 motes_replay scene.motes [options]

Replays a scene that `python -m motes record` wrote, without Python, on any number of ranks.

  --digest              print a line a frame: frame particles_digest image_sha256 ("-" without a picture)
  --no-images           make no pictures
  --out DIR             write the pictures there: frame-00000.ppm, ...
  --log DIR             write the run's log there
  --roles auto|shared   auto: ranks 0 and 1 draw and manage, the others calculate; shared: all calculate
  --spans               with --log: a timeline of each rank too
  --balancer TEXT       in place of the scene's, as "Pairwise(threshold=0.1)", "PrefixCuts" or "Static"
  --combine WAY         in place of the scene's: one_by_one, together or overlapped
  --births WHO          who makes newborn particles: manager (it deals them out) or calculators (each a part)
  --fan-out N           to N ranks at most does one pass on what the manager says to all (8)
  --blocking            calculators wait until the image generator has taken their particles, as in the paper
  --costs FILE          under a simulator: what work costs there, lines "name = nanoseconds" (cpp/frame/costs.h)
  --scale R             under a simulator: each computed particle stands for R
  --frames N            the first N frames only
  --help                this text

Exit code: 0, or 1 where the run failed, or 2 where the scene or the arguments are wrong.
Environment: MOTES_SIMD (sse2, avx2, avx512), MOTES_STALL_S (seconds without an answer before giving up),
MOTES_SPEEDS (2:1.0,3:0.5: rank 3 spends as much time as a machine of half the speed would).
)text";
}

}  // namespace motes::driver
