#include "engine/log/alarms.h"

#include <cmath>
#include <utility>

namespace motes::engine {

std::vector<Alarm> Alarms::look(std::size_t system, const std::string& name, const Strain& strain, int substeps) {
  if (system >= systems_.size()) systems_.resize(system + 1);
  Watched& watched = systems_[system];
  std::vector<Alarm> alarms;
  const auto say = [&](bool& said, const char* kind, const std::string& text) {
    if (!std::exchange(said, true)) alarms.push_back({kind, "system '" + name + "': " + text});
  };
  if (strain.most_in_a_cell >= kCrowded) {
    say(watched.crowded, "crowded",
        std::to_string(strain.most_in_a_cell) +
            " particles are in one cell as wide as the reach, and a meeting there takes time with their square: a "
            "smaller radius, or births that are farther apart (collide(clear=...))");
  }
  if (!(strain.overlap_99 > kDeep)) {
    watched.frames = 0;
  } else if (watched.frames == 0 || strain.overlap_99 < 0.9f * watched.deepness) {  // grains born so make way
    watched.frames = 1;
    watched.deepness = strain.overlap_99;
  } else if (++watched.frames >= kPatience) {
    say(watched.deep, "overlap",
        "one in a hundred of those that touch overlap by " +
            std::to_string(static_cast<int>(std::lround(100 * strain.overlap_99))) + " % or more, since " +
            std::to_string(watched.frames) + " frames: more sub-steps (World(substeps=" + std::to_string(substeps) +
            ") now), or births that are farther apart");
  }
  if (strain.softened != 0) {
    say(watched.softened, "softened",
        "contact's springs are too stiff for the sub-step, and were softened: a lower stiffness, or more sub-steps "
        "(World(substeps=" +
            std::to_string(substeps) + ") now)");
  }
  return alarms;
}

}  // namespace motes::engine
