#include "engine/replay.h"

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
  engine.run_frame(picture ? list.view : std::nullopt);
}

}  // namespace motes::engine
