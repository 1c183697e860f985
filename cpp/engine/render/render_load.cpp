#include "engine/render/render_load.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "base/fields.h"

namespace motes::engine {
namespace {

// Estimates loads before the first report: live particles and births, evenly distributed over calculators.
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

// Returns the axis along which most particles' domains are cut. Bricks count for the axis of the first cut, through all
// of space; domains by id count for no axis.
int axis_of_most(const Script& script) {
  std::array<std::uint64_t, 3> particles{};
  for (const auto& system : script.systems) {
    const int axis = system->domains.halved();
    if (axis < 3) particles[static_cast<std::size_t>(axis)] += system->counts.alive + 1;
  }
  return static_cast<int>(std::max_element(particles.begin(), particles.end()) - particles.begin());
}

bool in_picture(const DrawnTiles& tiles, const RenderLoad& load) {
  return tiles.first + tiles.counts.size() <= load.counts.size();
}

void note_tiles(const Drawings& drawn, const roles::Tree& tree, RenderLoad& load) {
  load.grid = {drawn.width, drawn.height};
  load.counts.assign(static_cast<std::size_t>(load.grid.tiles()), 0);
  const image::Slots slots = slots_of(drawn.order, load.grid);
  for (const DrawnTiles& tiles : drawn.tiles) {
    if (!in_picture(tiles, load)) continue;
    for (std::size_t i = 0; i < tiles.counts.size(); ++i) {
      load.counts[static_cast<std::size_t>(slots.tile(static_cast<int>(tiles.first + i)))] = tiles.counts[i];
    }
  }
  for (std::size_t c = 0; c < load.calculators.size(); ++c) {
    load.calculators[c].active = drawn.active.at(static_cast<std::size_t>(tree.row_of(static_cast<int>(c))));
  }
  if (drawn.records == 0) return;
  load.record_bytes = static_cast<double>(drawn.record_bytes) / static_cast<double>(drawn.records);
  if (drawn.path != image::View::Path::gather) {
    load.crossing = static_cast<double>(drawn.sent) / static_cast<double>(drawn.records);
  }
}

double pixels_of(const DrawnTiles& tiles, const image::Slots& slots, const image::Grid& grid) {
  double pixels = 0;
  for (std::size_t i = 0; i < tiles.counts.size(); ++i) {
    const image::Area area = grid.area(slots.tile(static_cast<int>(tiles.first + i)));
    pixels += static_cast<double>(area.width) * area.height;
  }
  return pixels;
}

// Updates the drawing speeds from a picture's measured times. Expected times use the current sprites instead of that
// picture's, since only ratios between ranks matter.
void note_speeds(const Drawings& drawn, const Script& script, RenderLoad& load) {
  if (!script.record.view) return;
  const image::Slots slots = slots_of(drawn.order, load.grid);
  std::vector<DrawSample> samples;
  for (const DrawnTiles& tiles : drawn.tiles) {
    if (!in_picture(tiles, load)) continue;
    const double records = std::accumulate(tiles.counts.begin(), tiles.counts.end(), 0.0) * load.scale;
    const double pixels = pixels_of(tiles, slots, load.grid);
    const double expected = drawing_s(*script.record.view, script.record.sprites, records, pixels);
    samples.push_back({tiles.rank, expected, double{tiles.seconds}});
  }
  load.speeds.add(samples);
}

}  // namespace

void note_assembly(const Drawings& drawn, int image_generator, RenderLoad& load) {
  if (!(drawn.assemble_s > 0)) return;
  const image::Slots slots = slots_of(drawn.order, load.grid);
  double pixels = 0;
  for (const DrawnTiles& tiles : drawn.tiles) {
    if (tiles.rank == image_generator || !in_picture(tiles, load)) continue;
    pixels += pixels_of(tiles, slots, load.grid);
  }
  if (pixels > 0) load.assembled_pixel_s = smoothed(load.assembled_pixel_s, drawn.assemble_s / pixels);
}

void note_pictures(const Rank& rank, const Script& script, const Round& round, const Judged& judged, RenderLoad& load) {
  const roles::Tree& tree = rank.session.relay().tree();
  load.calculators.resize(rank.session.calculators());
  load.scale = rank.settings.costs.messages.scale;
  if (round.first == 0 && judged.tail.valid && judged.tail.drawings.width > 0) {
    note_tiles(judged.tail.drawings, tree, load);
    note_speeds(judged.tail.drawings, script, load);
    note_assembly(judged.tail.drawings, rank.session.cast().image_generator, load);
  }
  if (!script.in_frame()) return;
  for (std::size_t c = 0; c < load.calculators.size(); ++c) {
    RenderLoad::Calculator& calculator = load.calculators[c];
    if (round.first == 0) calculator.particles = calculator.act_s = 0;
    for (std::size_t system = 0; system < judged.loads.systems; ++system) {
      const CalculatorLoad& of = judged.loads.of(tree, static_cast<int>(c), system);
      calculator.particles += static_cast<double>(of.stayed);
      calculator.act_s += of.compute_s;
    }
  }
}

void put_plan(const Rank& rank, const Script& script, const Round& round, RenderLoad& load, base::Bytes& out) {
  const bool first = round.first == 0 && script.record.view.has_value();
  out.put(first);
  if (!first) return;
  RenderLoad expected;
  const bool nothing_known = load.calculators.empty() || script.record.frame == 0;
  if (nothing_known) {
    expected.calculators.resize(rank.session.calculators());
    expected.scale = rank.settings.costs.messages.scale;
    expect_births(script, expected);
  }
  expected.axis = load.axis = axis_of_most(script);
  load.last = plan_render(*script.record.view, script.record.sprites, nothing_known ? expected : load,
                          rank.session.cast(), rank.session.size());
  base::write_fields(load.last, out);
}

std::optional<RenderPlan> take_plan(base::Reader& in) {
  if (!in.get<bool>()) return std::nullopt;
  RenderPlan plan;
  base::read_fields(in, plan);
  return plan;
}

}  // namespace motes::engine
