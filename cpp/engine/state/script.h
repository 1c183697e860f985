// What the script said: systems with their lists, and the record of the current conversation.
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

struct Script {
  std::vector<std::unique_ptr<System>> systems;
  recording::Record record;  // of the conversation under way; its lists are in the systems
  base::Bytes bytes;    // the same with lists: what all ranks hash
  base::Hash hash;
  std::vector<Round> rounds;
  bool overlaps = false;  // the messages of one round travel while the next one computes
  std::vector<NewCut> new_cuts;  // cuts from the last verdict, valid from the next frame on
  std::vector<NewCut> moved_cuts;  // cuts valid since this frame began; its exchange moves particles over them

  // The camera of the last frame that was drawn: its next one knows from where particles came across the screen.
  std::optional<image::Camera> camera;
  std::uint64_t camera_frame = 0;
  std::optional<image::Camera> camera_before;  // that frame's View::before

  bool in_frame() const { return record.verb == recording::Verb::render || record.verb == recording::Verb::step; }
  /// Tells whether this conversation carries signals and viewers' orders to all ranks.
  bool steered() const { return in_frame() || record.verb == recording::Verb::orders; }
  /// The systems that share this one's domains, itself among them; the one that they follow stands first.
  std::vector<std::size_t> sharing(std::size_t system) const;
  /// Gives all of them these domains.
  void divide(std::size_t system, const domains::Domains& domains);
  /// The one system of a round, or empty: what a timeline calls the round.
  std::string name_of(const Round& round) const;
};

/// Writes down what all ranks were asked to do. A view with an open shutter learns the last frame's camera: all ranks
/// know it, because their scripts recorded it.
void write_record(Script& script, const Settings& settings, std::uint64_t frame, recording::Verb verb,
                  const std::optional<image::View>& view, const std::string& argument);

/// The rounds of this conversation: the systems one by one, or all at once. Each takes a turn.
void split_rounds(Script& script, Combine combine, std::uint32_t& turn);

/// Tells whether the round's systems have pair interactions.
bool interacts(const Script& script, const Round& round);

}  // namespace motes::engine
