// run.json: what was run and on which machine, in the form that python/motes/_run/run_file.py writes for scripts.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "engine/engine.h"
#include "recording/scene.h"

namespace motes::driver {

struct RunFacts {
  std::vector<std::string> argv;  // the command line
  const recording::Scene* scene = nullptr;
  engine::Settings settings;
  std::string combine;
  roles::Cast cast;
  std::vector<recording::SystemDefinition> systems;
  std::map<int, double> speeds;  // of ranks that emulate slower machines
};

/// Writes `directory`/run.json, completely or not at all. Throws std::runtime_error.
void write_run(const std::string& directory, const RunFacts& facts);

}  // namespace motes::driver
