#include "engine/replay.h"

#include <stdexcept>
#include <utility>

namespace motes::engine {
namespace {

void define(Engine& engine, const recording::Record& list) {
  for (std::size_t i = 0; i < list.systems.size(); ++i) {
    const int index = static_cast<int>(i);
    if (index == engine.system_count()) engine.add_system(list.systems[i]);
    System& system = engine.system(index);
    if (system.definition != list.systems[i]) {
      throw std::runtime_error("system '" + list.systems[i].name + "' differs from that of earlier frames");
    }
    system.outside.sprite = list.sprites[i];
    system.outside.clumps = list.clumps[i];
  }
}

}  // namespace

void record_again(Engine& engine, const recording::Record& list) {
  define(engine, list);
  for (std::size_t i = 0; i < list.lists.size(); ++i) {
    const int system = static_cast<int>(i);
    for (const recording::Item& item : list.lists[i]) {
      if (std::holds_alternative<recording::Read>(item)) {
        engine.local(system);  // run the items so far now, as the script did
        continue;
      }
      if (const auto* callback = std::get_if<recording::Callback>(&item)) {
        throw std::runtime_error("system '" + list.systems[i].name + "' uses the callback " + callback->name +
                                 ", a function that exists only in its script");
      }
      engine.record(system, item);
    }
  }
}

void replay(Engine& engine, const recording::Record& list, bool picture) {
  if (list.frame != engine.frame()) {
    throw std::runtime_error("the scene has frame " + std::to_string(list.frame) + " where frame " +
                             std::to_string(engine.frame()) + " is expected");
  }
  record_again(engine, list);
  if (list.camera) engine.pass_camera(*list.camera);
  engine.run_frame(picture ? list.view : std::nullopt);
}

// Replays the kept lists if they have not been computed, which only happens on a single rank.
void Engine::catch_up() {
  if (!kept_.only) return;
  kept_.only = false;
  const std::vector<std::unique_ptr<System>> as_they_are = std::exchange(parts_->script.systems, {});
  parts_->calculator.populations.clear();
  parts_->manager.systems.clear();
  for (const auto& s : as_they_are) add_system(s->definition);
  parts_->rank.session.frame = 0;
  kept_.on = false;  // the replayed lists are kept already
  for (const base::Bytes& bytes : kept_.lists) {
    base::Reader in(bytes.view());
    replay(*this, recording::read(in), false);
  }
  kept_.on = true;
  for (std::size_t i = 0; i < as_they_are.size(); ++i) {
    parts_->script.systems[i]->outside = as_they_are[i]->outside;
    for (recording::Item& item : as_they_are[i]->list) record(static_cast<int>(i), std::move(item));
  }
}

}  // namespace motes::engine
