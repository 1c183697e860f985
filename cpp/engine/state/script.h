// What the script recorded: systems with their lists, and the record of the current conversation.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/hash.h"
#include "engine/session/round.h"
#include "engine/session/settings.h"
#include "engine/state/system.h"
#include "image/scene.h"
#include "recording/record.h"

namespace motes::engine {

/// A wall of the last frame's contacts, and the forces of all systems on it in all sub-steps.
struct PressedWall {
  shapes::Shape shape;
  interactions::WallSum sum;
};

template <class Visitor>
void fields(Visitor& visit, PressedWall& wall) {
  visit(wall.shape, wall.sum);
}

struct Script {
  std::vector<std::unique_ptr<System>> systems;
  recording::Record record;  // the current conversation; its lists are in `systems`
  base::Bytes bytes;    // the record with its lists, serialised
  base::Hash hash;      // hash of `bytes`, compared across ranks
  std::vector<Round> rounds;
  bool overlaps = false;  // messages of one round travel while the next one computes
  std::vector<NewCut> new_cuts;  // cuts from the last verdict, valid from the next frame on
  std::vector<NewCut> moved_cuts;  // cuts valid since this frame began; its exchange moves particles across them

  std::vector<PressedWall> walls;  // of the last frame, in the order of lists and walls; equal shapes are one wall

  // The camera of the last frame, needed for the streaks of the next frame.
  std::optional<image::Camera> camera;
  std::uint64_t camera_frame = 0;
  std::optional<image::Camera> camera_before;  // View::before of that frame

  std::optional<image::Camera> passing;  // the camera of the frame being recorded, if it ends without a picture

  bool in_frame() const { return record.verb == recording::Verb::render || record.verb == recording::Verb::step; }
  /// Returns whether this conversation carries signals and viewers' orders to all ranks.
  bool steered() const { return in_frame() || record.verb == recording::Verb::orders; }
  /// Returns the systems that share this one's domains, itself included; the one that the others follow comes first.
  std::vector<std::size_t> sharing(std::size_t system) const;
  /// Gives these domains to all systems that share this one's.
  void divide(std::size_t system, const domains::Domains& domains);
  /// Returns the name of a round in a timeline: its system, or empty if it has several.
  std::string name_of(const Round& round) const;
};

/// Serialises and hashes what the script recorded for this conversation. A view with an open shutter also gets the last
/// frame's camera, which is the same on all ranks.
void write_record(Script& script, const Settings& settings, std::uint64_t frame, recording::Verb verb,
                  const std::optional<image::View>& view, const std::string& argument);

/// Splits the systems into the rounds of this conversation. Each round takes a turn.
void split_rounds(Script& script, Combine combine, std::uint32_t& turn);

/// Returns whether the round's systems have pair interactions.
bool interacts(const Script& script, const Round& round);

}  // namespace motes::engine
