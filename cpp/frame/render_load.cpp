#include "frame/render_load.h"

#include <algorithm>
#include <array>

#include "particles/fields.h"

namespace motes::frame {
namespace {

// Before the first report of a frame nobody has told anything: particles to be born, shared out evenly.
void expect_births(const Script& script, RenderLoad& load) {
  double particles = 0;
  for (const auto& system : script.systems) {
    particles += static_cast<double>(system->counts.alive);
    for (const BirthGroup& group : system->groups) particles += static_cast<double>(group.count);
  }
  for (RenderLoad::Calculator& calculator : load.calculators) {
    calculator.particles = particles / static_cast<double>(load.calculators.size());
  }
}

// The domains of most particles are slices along this axis.
int axis_of_most(const Script& script) {
  std::array<std::uint64_t, 3> particles{};
  for (const auto& system : script.systems) {
    particles[static_cast<std::size_t>(system->definition.axis)] += system->counts.alive + 1;
  }
  return static_cast<int>(std::max_element(particles.begin(), particles.end()) - particles.begin());
}

void note_tiles(const std::vector<Report>& reports, const roles::Cast& cast, RenderLoad& load) {
  const auto drawn = [](const Report& r) { return r.tail.valid && r.tail.drawing.width > 0; };
  const auto any = std::find_if(reports.begin(), reports.end(), drawn);
  if (any == reports.end()) return;
  load.grid = {any->tail.drawing.width, any->tail.drawing.height};
  load.counts.assign(static_cast<std::size_t>(load.grid.tiles()), 0);
  const image::Slots slots = slots_of(any->tail.drawing.order, load.grid);
  double records = 0, sent = 0;
  for (std::size_t rank = 0; rank < reports.size(); ++rank) {
    const Drawing& drawing = reports[rank].tail.drawing;
    if (drawing.first + drawing.counts.size() > load.counts.size()) continue;
    for (std::size_t i = 0; i < drawing.counts.size(); ++i) {
      load.counts[static_cast<std::size_t>(slots.tile(static_cast<int>(drawing.first + i)))] = drawing.counts[i];
    }
    records += static_cast<double>(drawing.records);
    sent += static_cast<double>(drawing.sent);
    const int calculator = cast.calculator_of(static_cast<int>(rank));
    if (calculator >= 0) load.calculators[static_cast<std::size_t>(calculator)].active = drawing.active;
  }
  if (any->tail.drawing.path != image::View::Path::gather && records > 0) load.crossing = sent / records;
}

}  // namespace

void note_pictures(const Rank& rank, const Script& script, const Round& round, const std::vector<Report>& reports,
                   RenderLoad& load) {
  const roles::Cast& cast = rank.talk.cast();
  load.calculators.resize(cast.calculators.size());
  load.scale = rank.settings.costs.messages.scale;
  if (round.first == 0) note_tiles(reports, cast, load);
  if (!script.in_frame()) return;
  for (std::size_t c = 0; c < cast.calculators.size(); ++c) {
    RenderLoad::Calculator& calculator = load.calculators[c];
    if (round.first == 0) calculator.particles = calculator.act_s = 0;
    for (const SystemReport& system : reports[static_cast<std::size_t>(cast.calculators[c])].systems) {
      calculator.particles += static_cast<double>(system.kept);
      calculator.act_s += system.compute_s;
    }
  }
}

void put_plan(const Rank& rank, const Script& script, const Round& round, RenderLoad& load, particles::Bytes& out) {
  const bool first = round.first == 0 && script.record.view.has_value();
  out.put(first);
  if (!first) return;
  RenderLoad expected;
  const bool nothing_known = load.calculators.empty() || script.record.frame == 0;
  if (nothing_known) {
    expected.calculators.resize(rank.talk.calculators());
    expected.scale = rank.settings.costs.messages.scale;
    expect_births(script, expected);
  }
  expected.axis = load.axis = axis_of_most(script);
  load.last = plan_render(*script.record.view, script.record.sprites, nothing_known ? expected : load, rank.talk.cast(),
                          rank.talk.size());
  particles::write_fields(load.last, out);
}

std::optional<RenderPlan> take_plan(particles::Reader& in) {
  if (!in.get<bool>()) return std::nullopt;
  RenderPlan plan;
  particles::read_fields(in, plan);
  return plan;
}

}  // namespace motes::frame
