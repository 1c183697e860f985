// Warnings about interactions, pictures and balancers: what still runs, and is right, but is not what a script wants.
// Each is said once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/session/report.h"

namespace motes::engine {

struct Alarm {
  std::string kind;  // "crowded", "overlap", "softened", "unseen", "slow_balancer"
  std::string text;  // what it is, and what to do
};

class Alarms {
 public:
  static constexpr std::uint32_t kCrowded = 1000;  // particles in a cell
  static constexpr float kDeep = 0.3f;  // parts of the sum of both radii
  static constexpr int kPatience = 12;  // frames: grains that are poured may overlap for a while
  static constexpr int kTrials = 10;    // plans: the first ones of a script's balancer import and compile
  static constexpr double kSlow = 0.1;  // parts of a frame

  /// Once per frame, of `frame_s` seconds, and system.
  std::vector<Alarm> look(std::size_t system, const std::string& name, const Strain& strain, int substeps,
                          double frame_s);

  /// Once per plan of a script's own balancer: the seconds that it took, and those of the last frame.
  std::vector<Alarm> look_at_balancer(const std::string& name, double decided_s, double frame_s);

  /// Once per picture and system; `last`: there will be no other one. What is behind the camera in the first picture is
  /// said at once. What is beside may be on its way into it, and is said in the next one that is looked at; in the last
  /// one only where no system was ever seen.
  std::vector<Alarm> look_at_picture(std::size_t system, const std::string& name, Sighted sighted, bool last);

 private:
  struct Watched {
    bool crowded = false, deep = false, softened = false;  // said
    std::int32_t frames = 0;  // frames in which overlaps were deep and did not decrease
    float deepness = 0;  // at the first of them
    bool seen = false, beside = false,
         unseen = false;  // was in a picture; was beside the first picture; a warning was given

    template <class Visitor>
    friend constexpr void fields(Visitor& visit, Watched& watched) {
      visit(watched.crowded, watched.deep, watched.softened, watched.frames, watched.deepness, watched.seen,
            watched.beside, watched.unseen);
    }
  };
  std::vector<Watched> systems_;
  std::int32_t plans_ = 0;
  double decided_s_ = 0, frames_s_ = 0;  // in so many plans
  Watched& watched(std::size_t system);

  // So that a run that goes on says nothing twice.
  template <class Visitor>
  friend constexpr void fields(Visitor& visit, Alarms& alarms) {
    visit(alarms.systems_, alarms.plans_, alarms.decided_s_, alarms.frames_s_);
  }
};

}  // namespace motes::engine
