// The driver's command line.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>

namespace motes::driver {

struct Options {
  std::string scene;
  bool help = false;
  bool digest = false;
  bool images = true;
  std::string out;               // directory for the pictures, or empty
  std::string log;               // directory for the log, or empty
  std::string roles = "auto";    // auto | shared | managing | all
  std::string path;              // auto | gather | tiles | composite, or empty: that of the scene's views
  std::string balancer;          // empty: the scene's own
  std::string ask;               // directory of a balancer in another program, or empty
  std::string combine;           // one_by_one | together | overlapped, or empty: the scene's own
  std::string births = "auto";  // auto | manager | calculators
  int fan_out = 8;  // each rank relays the manager's messages to at most this many
  int threads = 1;  // of each rank
  std::string costs;  // file with the costs on a simulated machine, or empty
  double scale = 1;  // particles that each computed one represents
  bool blocking = false;  // calculators wait for the image generator, as in the paper
  bool spans = false;  // with a log: a timeline of each rank
  std::uint64_t frames = UINT64_MAX;  // at most
};

/// Reads the arguments after the program's name. Throws std::invalid_argument naming the wrong one and what is allowed.
Options read_options(std::span<char* const> arguments);

/// Reads the speeds of ranks that emulate slower machines, as in MOTES_SPEEDS="2:1.0,3:0.5"; none if `text` is null or
/// empty. Throws std::invalid_argument naming what is allowed with this many ranks.
std::map<int, double> read_speeds(const char* text, int ranks);

/// Returns the text that --help prints.
const char* usage();

}  // namespace motes::driver
