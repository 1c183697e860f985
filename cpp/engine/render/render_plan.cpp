#include "engine/render/render_plan.h"

#include <algorithm>
#include <numeric>

#include "image/exposures.h"

namespace motes::engine {
namespace {

using Path = image::View::Path;
namespace costs = render_costs;

constexpr double kNano = 1e-9;

// The work of a picture.
struct Work {
  std::vector<double> records;    // in each slot
  std::vector<double> pixels;     // in each slot
  double all_records = 0;
  double all_pixels = 0;
  double active = 0;              // number of tiles with records
  double particles = 0;
  double record_s = 0;            // seconds to draw a record, mean over systems
  double record_bytes = 0;        // mean bytes per record
  double byte_s = costs::kByte * kNano;
  double crossing = 0;            // fraction of records that go to other ranks' tiles
  double merged = 0;              // fraction of records that may be drawn into partial tiles
  double partial_bytes = 0;       // bytes per pixel of a partial tile
  double pixel_s = 0;
  double glow_bytes = 0;          // extra bytes per pixel for bloom
  Deal deal;
};

double mean_record_s(const image::View& view, std::span<const image::Sprite> sprites) {
  double record = 0;
  for (const image::Sprite& sprite : sprites) record += costs::record(sprite, view);
  return record * kNano / static_cast<double>(std::max<std::size_t>(1, sprites.size()));
}

// Returns the seconds to draw on a rank of speed 1.
double draw_s(double records, double record_s, double pixels, double pixel_s) {
  return records * record_s + pixels * pixel_s;
}

Work work_of(const image::View& view, std::span<const image::Sprite> sprites, const RenderLoad& load,
             const roles::Cast& cast, int ranks) {
  Work w;
  w.deal = deal_along(load.axis, view, cast, ranks);
  const image::Grid grid{view.width, view.height};
  const auto tiles = static_cast<std::size_t>(grid.tiles());
  const image::Slots slots = slots_of(w.deal.order, grid);
  for (const auto& calculator : load.calculators) w.particles += calculator.particles * load.scale;
  w.all_pixels = static_cast<double>(view.width) * view.height;
  const bool counted = load.grid.width == view.width && load.grid.height == view.height && load.counts.size() == tiles;
  for (std::size_t s = 0; s < tiles; ++s) {
    const int tile = slots.tile(static_cast<int>(s));
    const image::Area area = grid.area(tile);
    w.pixels.push_back(static_cast<double>(area.width) * area.height);
    w.records.push_back(counted ? load.counts[static_cast<std::size_t>(tile)] * load.scale
                                : w.particles * w.pixels[s] / w.all_pixels);
    w.all_records += w.records[s];
    w.active += w.records[s] > 0 ? 1 : 0;
  }
  w.crossing = load.crossing >= 0 ? load.crossing : 1 - 1 / static_cast<double>(ranks);
  if (const auto blend = merged_blend(view, sprites); blend && !sprites.empty()) {
    const auto same = [&](const image::Sprite& s) { return s.blend == *blend; };
    w.merged =
        static_cast<double>(std::count_if(sprites.begin(), sprites.end(), same)) / static_cast<double>(sprites.size());
    w.partial_bytes = *blend == image::Sprite::Blend::add ? costs::kLightBytes : costs::kSurfaceBytes;
  }
  w.record_s = mean_record_s(view, sprites);
  w.pixel_s = costs::pixel(view) * kNano;
  w.glow_bytes = view.bloom > 0 ? costs::kGlowBytes : 0;
  w.record_bytes = load.record_bytes > 0 ? load.record_bytes : costs::record_bytes(view);
  return w;
}

// A rank's other work, and its drawing speed.
struct Drawer {
  double busy = 0;  // seconds
  double speed = 1;
};

bool less_busy(const Drawer& a, const Drawer& b) { return a.busy < b.busy; }

double sum_of_speeds(const std::vector<Drawer>& drawers) {
  return std::accumulate(drawers.begin(), drawers.end(), 0.0,
                         [](double sum, const Drawer& d) { return sum + d.speed; });
}

// Returns when the ranks finish if work is dealt out so they finish together. `work`: seconds that a rank of speed 1
// takes for all of it.
double level_of(std::vector<Drawer> drawers, double work) {
  std::sort(drawers.begin(), drawers.end(), less_busy);
  double level = drawers.front().busy;
  double left = work;
  double speed = 0;  // sum of the speeds of ranks that are drawing at `level`
  for (std::size_t i = 0; i < drawers.size(); ++i) {
    speed += drawers[i].speed;
    const bool last = i + 1 == drawers.size();
    const double next = last ? level : drawers[i + 1].busy;
    if (last || left <= (next - level) * speed) return level + left / speed;
    left -= (next - level) * speed;
    level = next;
  }
  return level;
}

// Returns how much busier each rank is than the least busy one, limited to an even share of the work. After many
// births, times of one frame predict the next badly, and all ranks would wait for one that was thought to be idle.
std::vector<Drawer> ahead(const std::vector<Drawer>& drawers, double work) {
  const double least = std::min_element(drawers.begin(), drawers.end(), less_busy)->busy;
  const double most = work / sum_of_speeds(drawers);
  std::vector<Drawer> next;
  next.reserve(drawers.size());
  for (const Drawer& d : drawers) next.push_back({std::min(d.busy - least, most), d.speed});
  return next;
}

// Cuts the sequence of slots into one stretch per rank, by the time that each rank has.
RenderPlan deal_tiles(Path path, const Deal& deal, const std::vector<double>& work,
                      const std::vector<Drawer>& drawers) {
  const double all = std::accumulate(work.begin(), work.end(), 0.0);
  const std::vector<Drawer> next = ahead(drawers, all);
  const double level = level_of(next, all);
  RenderPlan plan{path, deal.order, std::vector<std::uint32_t>(next.size()), std::vector<std::uint32_t>(next.size())};
  // Sums are rounded, so remaining slots go to the last rank that draws.
  const auto draws = [&](int rank) { return level > next[static_cast<std::size_t>(rank)].busy; };
  const auto found = std::find_if(deal.ranks.rbegin(), deal.ranks.rend(), draws);
  const int last = found == deal.ranks.rend() ? deal.ranks.back() : *found;
  double wanted = 0;
  double dealt = 0;
  std::uint32_t slot = 0;
  for (const int rank : deal.ranks) {
    const auto r = static_cast<std::size_t>(rank);
    plan.firsts[r] = slot;
    wanted += std::max(0.0, level - next[r].busy) * next[r].speed;
    while (slot < work.size() && (rank == last || dealt + work[slot] / 2 <= wanted)) dealt += work[slot++];
    plan.ends[r] = slot;
  }
  return plan;
}

// Returns when the last rank finishes, with the tiles of this plan, in seconds.
double end_of(const RenderPlan& plan, const std::vector<double>& work, const std::vector<Drawer>& drawers) {
  double most = 0;
  for (std::size_t r = 0; r < drawers.size(); ++r) {
    const int rank = static_cast<int>(r);
    const double drawn = std::accumulate(work.begin() + plan.first(rank), work.begin() + plan.end(rank), 0.0);
    most = std::max(most, drawers[r].busy + drawn / drawers[r].speed);
  }
  return most;
}

// Keeps the last plan unless the next one is better by more than the noise of measured times, because owners cache the
// rendered scenery of tiles with objects.
RenderPlan steady(RenderPlan next, const image::View& view, const RenderLoad& load, const std::vector<double>& work,
                  const std::vector<Drawer>& drawers) {
  constexpr double kNoise = 1.02;
  const bool comparable = load.last.path == next.path && load.last.order == next.order &&
                          load.last.covers(static_cast<int>(work.size()), static_cast<int>(drawers.size()));
  if (view.objects.empty() || !comparable) return next;
  return end_of(load.last, work, drawers) <= kNoise * end_of(next, work, drawers) ? load.last : next;
}

// Returns each rank's drawing speed and its work other than drawing, from the arrival of records to the end of the next
// frame's actions, in seconds of the machine of render_costs.h. Calculators act. The manager must deal the next frame's
// births before any calculator can act, so it counts as busy as the slowest calculator. Only the image generator can
// continue drawing meanwhile. If it is also the manager, no calculator acts before the picture is complete.
std::vector<Drawer> drawers_of(const RenderLoad& load, const roles::Cast& cast, int ranks) {
  std::vector<Drawer> drawers(static_cast<std::size_t>(ranks));
  for (std::size_t r = 0; r < drawers.size(); ++r) drawers[r].speed = load.speeds.of(r);
  if (cast.manager == cast.image_generator) return drawers;
  double most = 0;
  for (std::size_t c = 0; c < load.calculators.size(); ++c) {
    const double act_s = load.calculators[c].act_s / load.speeds.slowness();
    drawers[static_cast<std::size_t>(cast.calculators[c])].busy = act_s;
    most = std::max(most, act_s);
  }
  drawers[static_cast<std::size_t>(cast.manager)].busy = most;
  return drawers;
}

// Returns when the last rank has finished its other work, in seconds.
double last_free(const std::vector<Drawer>& drawers) {
  return std::max_element(drawers.begin(), drawers.end(), less_busy)->busy;
}

double slowest_projection(const RenderLoad& load) {
  double most = 0;
  for (const auto& calculator : load.calculators) most = std::max(most, calculator.particles);
  return most * load.scale * costs::kProject * kNano;
}

RenderEstimate estimate_gather(const Work& w, const RenderLoad& load, const roles::Cast& cast,
                               std::vector<Drawer> drawers) {
  RenderEstimate e;
  const auto home = static_cast<std::size_t>(cast.image_generator);
  e.plan.path = Path::gather;
  e.plan.firsts.assign(drawers.size(), 0);
  e.plan.ends.assign(drawers.size(), 0);
  e.plan.ends[home] = static_cast<std::uint32_t>(w.pixels.size());
  const double own = cast.calculator_of(cast.image_generator) >= 0 && !load.calculators.empty()
                         ? 1.0 / static_cast<double>(load.calculators.size())
                         : 0.0;
  const double bytes = w.all_records * (1 - own) * w.record_bytes;
  drawers[home].busy +=
      bytes * w.byte_s + draw_s(w.all_records, w.record_s, w.all_pixels, w.pixel_s) / drawers[home].speed;
  const auto senders = static_cast<double>(std::max<std::size_t>(1, load.calculators.size()));
  e.seconds = slowest_projection(load) + bytes / senders * w.byte_s + last_free(drawers);
  return e;
}

// Returns the image generator's seconds to assemble the tiles of other ranks.
double assembly(const Work& w, const RenderLoad& load, std::size_t ranks) {
  const double pixels = w.all_pixels * (1 - 1 / static_cast<double>(ranks));
  const double known = load.assembled_pixel_s / load.speeds.slowness();
  const double pixel_s = known > 0 ? known : costs::kShownBytes * costs::kByte * kNano;
  const double glow_s = w.glow_bytes * w.byte_s;
  return pixels * (pixel_s + glow_s) + static_cast<double>(ranks) * costs::kMessage * kNano;
}

// Returns the seconds to send records from `senders` calculators to `ranks` ranks. `part`: fraction of all records that
// are drawn by tile owners.
double exchange(const Work& w, double part, double senders, double ranks) {
  const double bytes = w.all_records * part * w.crossing * w.record_bytes;
  return bytes * w.byte_s * (1 / senders + 1 / ranks) + (ranks + senders) * costs::kMessage * kNano;
}

// Returns the seconds to draw each slot on a rank of speed 1.
std::vector<double> drawing(const Work& w) {
  std::vector<double> work(w.pixels.size());
  for (std::size_t s = 0; s < work.size(); ++s) work[s] = draw_s(w.records[s], w.record_s, w.pixels[s], w.pixel_s);
  return work;
}

RenderEstimate estimate_tiles(const Work& w, const image::View& view, const RenderLoad& load, const roles::Cast& cast,
                              std::vector<Drawer> drawers) {
  RenderEstimate e;
  const auto ranks = static_cast<double>(drawers.size());
  const auto senders = static_cast<double>(std::max<std::size_t>(1, load.calculators.size()));
  drawers[static_cast<std::size_t>(cast.image_generator)].busy += assembly(w, load, drawers.size());
  const std::vector<double> work = drawing(w);
  e.plan = steady(deal_tiles(Path::tiles, w.deal, work, drawers), view, load, work, drawers);
  e.seconds = slowest_projection(load) + exchange(w, 1, senders, ranks) + end_of(e.plan, work, drawers);
  return e;
}

RenderEstimate estimate_composite(const Work& w, const RenderLoad& load, const roles::Cast& cast,
                                  std::vector<Drawer> drawers) {
  RenderEstimate e;
  const auto ranks = static_cast<double>(drawers.size());
  const auto senders = static_cast<double>(std::max<std::size_t>(1, load.calculators.size()));
  const double tile_pixels = w.all_pixels / static_cast<double>(w.pixels.size());
  const double partial_pixel_s = (costs::kPartialPixel + w.partial_bytes * costs::kByte) * kNano;
  double most = 0;      // seconds of the slowest calculator for its own particles
  double partials = 0;  // number of partial tiles that calculators send
  for (std::size_t i = 0; i < load.calculators.size(); ++i) {
    const RenderLoad::Calculator& c = load.calculators[i];
    const double sent = (c.active > 0 ? c.active : w.active) * w.crossing;
    const double share = w.particles > 0 ? c.particles * load.scale / w.particles : 0;
    const double own_s = share * w.merged * w.all_records * w.record_s + sent * tile_pixels * partial_pixel_s;
    partials += sent;
    most = std::max(most, own_s / load.speeds.of(static_cast<std::size_t>(cast.calculators[i])));
  }
  drawers[static_cast<std::size_t>(cast.image_generator)].busy += assembly(w, load, drawers.size());
  const double others = 1 - w.merged;  // fraction of records that are not merged
  std::vector<double> work(w.pixels.size());
  for (std::size_t t = 0; t < work.size(); ++t) {
    const double added = w.records[t] > 0 && w.active > 0 ? partials / w.active : 0;
    work[t] = w.pixels[t] * (w.pixel_s + added * partial_pixel_s) + others * w.records[t] * w.record_s;
  }
  // Deals tiles as if owners drew everything: then most stretches are over calculators' own particles, which need not
  // be sent.
  e.plan = deal_tiles(Path::composite, w.deal, drawing(w), drawers);
  e.seconds = slowest_projection(load) + most + exchange(w, others, senders, ranks) + end_of(e.plan, work, drawers);
  return e;
}

}  // namespace

bool RenderPlan::covers(int tiles, int ranks) const {
  const auto all = static_cast<std::size_t>(ranks);
  if (firsts.size() != all || ends.size() != all) return false;
  std::uint64_t dealt = 0;
  for (std::size_t r = 0; r < all; ++r) {
    if (firsts[r] > ends[r] || ends[r] > static_cast<std::uint32_t>(tiles)) return false;
    dealt += ends[r] - firsts[r];
  }
  return dealt == static_cast<std::uint64_t>(tiles);  // stretches do not overlap: see deal_tiles
}

double drawing_s(const image::View& view, std::span<const image::Sprite> sprites, double records, double pixels) {
  return draw_s(records, mean_record_s(view, sprites), pixels, costs::pixel(view) * kNano);
}

namespace {

// Returns whether pixels are means of exposures: see image/exposures.h.
bool exposes(const image::View& view, std::span<const image::Sprite> sprites) {
  if (!image::has_exposures(view)) return false;
  const auto opaque = [](const image::Sprite& s) { return s.blend == image::Sprite::Blend::opaque; };
  return image::scenery_blurs(view) || std::any_of(sprites.begin(), sprites.end(), opaque);
}

}  // namespace

std::optional<image::Sprite::Blend> merged_blend(const image::View& view, std::span<const image::Sprite> sprites) {
  using Blend = image::Sprite::Blend;
  if (exposes(view, sprites)) return std::nullopt;  // a partial tile has one surface per pixel
  const auto blends = [](Blend blend) { return [blend](const image::Sprite& s) { return s.blend == blend; }; };
  if (std::all_of(sprites.begin(), sprites.end(), blends(Blend::add))) return Blend::add;
  const bool any = std::any_of(sprites.begin(), sprites.end(), blends(Blend::opaque));
  if (any && (view.layers & image::kVelocityLayer) == 0) return Blend::opaque;
  return std::nullopt;
}

RenderEstimate estimate(Path path, const image::View& view, std::span<const image::Sprite> sprites,
                        const RenderLoad& load, const roles::Cast& cast, int ranks) {
  const Work w = work_of(view, sprites, load, cast, ranks);
  std::vector<Drawer> drawers = drawers_of(load, cast, ranks);
  if (path == Path::tiles) return estimate_tiles(w, view, load, cast, std::move(drawers));
  if (path == Path::composite) return estimate_composite(w, load, cast, std::move(drawers));
  return estimate_gather(w, load, cast, std::move(drawers));
}

RenderPlan plan_render(const image::View& view, std::span<const image::Sprite> sprites, const RenderLoad& load,
                       const roles::Cast& cast, int ranks) {
  std::vector<Path> paths;
  const bool merges = merged_blend(view, sprites).has_value();
  const auto is_liquid = [](const image::Sprite& s) { return s.is(image::Sprite::Kind::surface); };
  if (std::any_of(sprites.begin(), sprites.end(), is_liquid)) {
    paths = {Path::gather};
  } else if (view.path == Path::automatic) {
    paths = {Path::gather};
    if (ranks > 1) paths.push_back(Path::tiles);
    if (ranks > 1 && merges) paths.push_back(Path::composite);
  } else {
    paths = {view.path == Path::composite && !merges ? Path::tiles : view.path};
  }
  RenderEstimate best = estimate(paths.front(), view, sprites, load, cast, ranks);
  for (std::size_t i = 1; i < paths.size(); ++i) {
    RenderEstimate other = estimate(paths[i], view, sprites, load, cast, ranks);
    if (other.seconds < best.seconds) best = std::move(other);
  }
  return best.plan;
}

}  // namespace motes::engine
