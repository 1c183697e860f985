// Warnings about meetings: what still runs, and is right, but is not what a script wants. Each is said once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/session/report.h"

namespace motes::engine {

struct Alarm {
  std::string kind;  // "crowded", "overlap", "softened"
  std::string text;  // what it is, and what to do
};

class Alarms {
 public:
  static constexpr std::uint32_t kCrowded = 1000;  // particles in a cell
  static constexpr float kDeep = 0.3f;             // parts of the sum of both radii
  static constexpr int kPatience = 12;             // frames: grains that are poured may overlap for a while

  /// Once per frame and system.
  std::vector<Alarm> look(std::size_t system, const std::string& name, const Strain& strain, int substeps);

 private:
  struct Watched {
    bool crowded = false, deep = false, softened = false;  // said
    std::int32_t frames = 0;  // in which overlaps were deep, and became no less
    float deepness = 0;       // at the first of them

    template <class Visitor>
    friend constexpr void fields(Visitor& visit, Watched& watched) {
      visit(watched.crowded, watched.deep, watched.softened, watched.frames, watched.deepness);
    }
  };
  std::vector<Watched> systems_;

  // So that a run that goes on says nothing twice.
  template <class Visitor>
  friend constexpr void fields(Visitor& visit, Alarms& alarms) {
    visit(alarms.systems_);
  }
};

}  // namespace motes::engine
