#include "engine/state/script.h"

#include <algorithm>
#include <utility>

#include "image/layout.h"

namespace motes::engine {

std::string Script::name_of(const Round& round) const {
  return round.last == round.first + 1 ? systems[round.first]->definition.name : "";
}

std::vector<std::size_t> Script::sharing(std::size_t system) const {
  const std::int32_t leader = systems[system]->definition.domains_of;
  const std::size_t first = leader < 0 ? system : static_cast<std::size_t>(leader);
  std::vector<std::size_t> all{first};
  for (std::size_t i = first + 1; i < systems.size(); ++i) {
    if (systems[i]->definition.domains_of == static_cast<std::int32_t>(first)) all.push_back(i);
  }
  return all;
}

void Script::divide(std::size_t system, const domains::Domains& domains) {
  for (const std::size_t i : sharing(system)) {
    systems[i]->domains = domains;
    systems[i]->waits_for_fit = false;
  }
}

namespace {

// Keeps the camera of a frame, for the streaks of the next one, and the camera before it, for a redraw.
void note_camera(Script& script, std::uint64_t frame, const image::Camera& camera) {
  const bool in_sequence = script.camera && script.camera_frame + 1 == frame;
  script.camera_before = in_sequence ? script.camera : std::nullopt;
  script.camera = camera;
  script.camera_frame = frame;
}

void begin_streaks(Script& script, std::uint64_t frame, image::View& view) {
  note_camera(script, frame, view.camera);
  if (view.before) script.camera_before = view.before;
  if (view.shutter > 0) view.before = script.camera_before;
}

// If the last frame is redrawn from the same camera, restores the camera before it, so its streaks look the same.
void recall_camera(const Script& script, std::uint64_t frame, image::View& view) {
  const bool same = script.camera == view.camera && script.camera_frame + 1 == frame;
  if (view.shutter > 0 && !view.before && same) view.before = script.camera_before;
}

}  // namespace

void write_record(Script& script, const Settings& settings, std::uint64_t frame, recording::Verb verb,
                  const std::optional<image::View>& view, const std::string& argument) {
  recording::Record& record = script.record;
  record = {};
  record.verb = verb;
  record.frame = frame;
  record.seed = settings.seed;
  record.dt = settings.dt;
  record.substeps = settings.substeps;
  record.view = view;
  if (record.view && verb == recording::Verb::render) begin_streaks(script, frame, *record.view);
  const std::optional<image::Camera> passing = std::exchange(script.passing, std::nullopt);
  if (passing && verb == recording::Verb::step) {
    record.camera = passing;
    note_camera(script, frame, *passing);
  }
  if (record.view && verb == recording::Verb::redraw) recall_camera(script, frame, *record.view);
  record.argument = argument;
  for (const auto& system : script.systems) {  // borrows definitions and lists, which are moved back below
    record.systems.push_back(std::move(system->definition));
    record.lists.push_back(std::move(system->list));
    const image::Sprite& sprite = system->outside.sprite;
    record.clumps.push_back(system->outside.clumps);
    record.sprites.push_back(record.view ? image::as_seen(sprite, *record.view) : sprite);
  }
  script.bytes.clear();
  recording::write(record, script.bytes);
  for (std::size_t i = 0; i < script.systems.size(); ++i) {
    script.systems[i]->definition = std::move(record.systems[i]);
    script.systems[i]->list = std::move(record.lists[i]);
  }
  record.systems.clear();
  record.lists.clear();
  script.hash = base::hash(script.bytes.view());
}

namespace {

// Returns the last system that must be in a round that begins at `first`: systems that interact share a round, together
// with the systems between them.
std::size_t last_to_meet(const Script& script, std::size_t first) {
  std::size_t last = first;
  for (std::size_t i = first; i <= last; ++i) {
    for (const recording::Item& item : script.systems[i]->list) {
      const auto* action = std::get_if<actions::Action>(&item);
      if (action != nullptr && action->partner)
        last = std::max(last, static_cast<std::size_t>(action->partner->system));
    }
  }
  return last;
}

}  // namespace

void split_rounds(Script& script, Combine combine, std::uint32_t& turn) {
  script.rounds.clear();
  const std::size_t n = script.systems.size();
  const bool apart = script.in_frame() && combine != Combine::together;
  for (std::size_t first = 0, last = 0; first < n; first = last) {
    last = apart ? last_to_meet(script, first) + 1 : n;
    script.rounds.push_back({first, last, ++turn, {}, {}, {}, 0});
  }
  if (script.rounds.empty()) script.rounds.push_back({0, 0, ++turn, {}, {}, {}, 0});
}

bool interacts(const Script& script, const Round& round) {
  bool any = false;
  for (std::size_t i = round.first; script.in_frame() && i < round.last; ++i)
    any = any || script.systems[i]->interacts();
  return any;
}

}  // namespace motes::engine
