// Warnings about interactions, pictures and balancers: results are correct, but probably not what the script's author
// wants. Each warning is given once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/session/report.h"

namespace motes::engine {

struct Alarm {
  std::string kind;  // "crowded", "overlap", "softened", "unseen", "slow_balancer"
  std::string text;  // the problem and what to do about it
};

class Alarms {
 public:
  static constexpr std::uint32_t kCrowded = 1000;  // particles in a cell
  static constexpr float kDeep = 0.3f;  // overlap as a fraction of the sum of both radii
  static constexpr int kPatience = 12;  // frames; poured grains may overlap for a while
  static constexpr int kTrials = 10;  // plans to average over: a scripted balancer's first ones compile code
  static constexpr double kSlow = 0.1;  // fraction of a frame

  /// Returns new warnings about a system's interactions. Call once per frame, of `frame_s` seconds, and system.
  std::vector<Alarm> look(std::size_t system, const std::string& name, const Strain& strain, int substeps,
                          double frame_s);

  /// Returns new warnings about a scripted balancer. Call once per plan, with the seconds that it took and those of the
  /// last frame.
  std::vector<Alarm> look_at_balancer(const std::string& name, double decided_s, double frame_s);

  /// Returns new warnings about a system that pictures do not show. Call once per picture and system; `last`: there are
  /// no more pictures. Particles behind the camera cause a warning at once. Particles outside the view may still move
  /// into it, so they cause one only if they are there again; in the last picture, only if no system was ever seen.
  std::vector<Alarm> look_at_picture(std::size_t system, const std::string& name, Sighted sighted, bool last);

 private:
  struct Watched {
    bool crowded = false, deep = false, softened = false;  // warnings given
    std::int32_t frames = 0;  // frames in which overlaps were deep and did not decrease
    float deepness = 0;  // overlap in the first of those frames
    // Was in a picture; was outside the view in one; the warning was given.
    bool seen = false, beside = false, unseen = false;

    template <class Visitor>
    friend constexpr void fields(Visitor& visit, Watched& watched) {
      visit(watched.crowded, watched.deep, watched.softened, watched.frames, watched.deepness, watched.seen,
            watched.beside, watched.unseen);
    }
  };
  std::vector<Watched> systems_;
  std::int32_t plans_ = 0;
  double decided_s_ = 0, frames_s_ = 0;  // sums over `plans_` plans
  Watched& watched(std::size_t system);

  // Saved in checkpoints, so a continued run repeats no warning.
  template <class Visitor>
  friend constexpr void fields(Visitor& visit, Alarms& alarms) {
    visit(alarms.systems_, alarms.plans_, alarms.decided_s_, alarms.frames_s_);
  }
};

}  // namespace motes::engine
