#include "engine/log/alarms.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace motes::engine {

namespace {

// Formats a number with two digits, enough for advice.
std::string brief(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", number);
  return text;
}

}  // namespace

Alarms::Watched& Alarms::watched(std::size_t system) {
  if (system >= systems_.size()) systems_.resize(system + 1);
  return systems_[system];
}

std::vector<Alarm> Alarms::look_at_picture(std::size_t system, const std::string& name, Sighted sighted, bool last) {
  Watched& of = watched(system);
  of.seen |= sighted == Sighted::inside;
  if (of.seen || of.unseen) return {};
  const bool behind = sighted == Sighted::behind;
  const bool any = std::any_of(systems_.begin(), systems_.end(), [](const Watched& one) { return one.seen; });
  const bool again = of.beside && sighted == Sighted::beside;
  of.beside |= sighted == Sighted::beside;
  if (behind || again || (last && of.beside && !any)) {
    of.unseen = true;
    const std::string where = behind ? "behind the camera" : "outside the camera's view";
    return {{"unseen", "system '" + name + "': all its particles are " + where +
                           ", so no picture shows them: change Camera(position, look_at), or their positions"}};
  }
  return {};
}

std::vector<Alarm> Alarms::look_at_balancer(const std::string& name, double decided_s, double frame_s) {
  if (plans_ >= kTrials) return {};
  decided_s_ += decided_s;
  frames_s_ += frame_s;
  if (++plans_ < kTrials) return {};
  if (!(decided_s_ > kSlow * frames_s_)) {
    plans_ = 0;
    decided_s_ = frames_s_ = 0;
    return {};
  }
  const std::string mean = brief(1e3 * decided_s_ / kTrials), of = brief(1e3 * frames_s_ / kTrials);
  return {{"slow_balancer", "balancer " + name + ": its decide takes " + mean + " ms of a frame's " + of +
                                " ms on the manager, and all ranks wait for it: decide less often (an empty "
                                "Orders(()) changes nothing), or use arrays instead of loops"}};
}

std::vector<Alarm> Alarms::look(std::size_t system, const std::string& name, const Strain& strain, int substeps,
                                double frame_s) {
  Watched& watched = this->watched(system);
  std::vector<Alarm> alarms;
  const auto say = [&](bool& warned, const char* kind, const std::string& text) {
    if (!std::exchange(warned, true)) alarms.push_back({kind, "system '" + name + "': " + text});
  };
  if (strain.most_in_a_cell >= kCrowded) {
    say(watched.crowded, "crowded",
        std::to_string(strain.most_in_a_cell) +
            " particles are in one cell as wide as the reach, and an interaction's time there grows with their square: "
            "use a smaller radius, or place births farther apart (collide(clear=...))");
  }
  if (!(strain.overlap_99 > kDeep)) {
    watched.frames = 0;
  } else if (watched.frames == 0 || strain.overlap_99 < 0.9f * watched.deepness) {  // overlaps are decreasing
    watched.frames = 1;
    watched.deepness = strain.overlap_99;
  } else if (++watched.frames >= kPatience) {
    say(watched.deep, "overlap",
        "one in a hundred touching pairs overlaps by " +
            std::to_string(static_cast<int>(std::lround(100 * strain.overlap_99))) + " % or more, for " +
            std::to_string(watched.frames) + " frames: use more sub-steps (World(substeps=" + std::to_string(substeps) +
            ") now), or place births farther apart");
  }
  if (strain.substeps > static_cast<std::uint32_t>(substeps)) {
    const double part = static_cast<double>(substeps) / strain.substeps;
    say(watched.softened, "softened",
        "contact's springs are too stiff for its lightest particles in sub-steps of " + brief(frame_s / substeps) +
            " s, so their contacts are softened: use sub-steps of at most " + brief(frame_s / strain.substeps) +
            " s (World(substeps=" + std::to_string(strain.substeps) + "), now " + std::to_string(substeps) +
            "), or at most " + brief(part * part) + " times the stiffness");
  }
  return alarms;
}

}  // namespace motes::engine
