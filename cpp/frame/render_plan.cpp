#include "frame/render_plan.h"

#include <algorithm>
#include <numeric>

namespace motes::frame {
namespace {

using Path = image::View::Path;
namespace costs = render_costs;

constexpr double kNano = 1e-9;

// What there is to draw, in seconds and records.
struct Work {
  std::vector<double> records;    // in each slot
  std::vector<double> pixels;     // in each slot
  double all_records = 0;
  double all_pixels = 0;
  double active = 0;              // tiles with records
  double particles = 0;
  double record_s = 0;            // drawing one record, the mean over systems
  double byte_s = costs::kByte * kNano;
  double crossing = 0;            // the part of records that go to other ranks' tiles
  double merged = 0;              // the part of records that may be drawn into partial tiles
  double partial_bytes = 0;       // of a pixel there
  Deal deal;
};

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
  double record = 0;
  for (const image::Sprite& sprite : sprites) record += costs::record(sprite, view);
  w.record_s = record * kNano / static_cast<double>(std::max<std::size_t>(1, sprites.size()));
  return w;
}

// Work is dealt out so that all ranks end together: `busy` seconds each has other things to do first. Returns when they
// end.
double level_of(const std::vector<double>& busy, double work) {
  std::vector<double> sorted = busy;
  std::sort(sorted.begin(), sorted.end());
  double level = sorted.front();
  double left = work;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const auto ranks = static_cast<double>(i + 1);
    const double next = i + 1 < sorted.size() ? sorted[i + 1] : sorted[i];
    if (i + 1 == sorted.size() || left <= (next - level) * ranks) return level + left / ranks;
    left -= (next - level) * ranks;
    level = next;
  }
  return level;
}

// How much more each has to do than who has least, up to an even share of the work: seconds of one frame say little of
// the next one where many particles were born, and a rank that was thought to be idle must not keep all others waiting.
std::vector<double> ahead(std::vector<double> busy, double work) {
  const double least = *std::min_element(busy.begin(), busy.end());
  const double most = work / static_cast<double>(busy.size());
  for (double& b : busy) b = std::min(b - least, most);
  return busy;
}

// Cuts the row of slots into stretches, one per rank, whose work comes near what each rank has time for.
RenderPlan deal_tiles(Path path, const Deal& deal, const std::vector<double>& work,
                      const std::vector<double>& seconds) {
  const double all = std::accumulate(work.begin(), work.end(), 0.0);
  const std::vector<double> busy = ahead(seconds, all);
  const double level = level_of(busy, all);
  RenderPlan plan{path, deal.order, std::vector<std::uint32_t>(busy.size()), std::vector<std::uint32_t>(busy.size())};
  // Sums are rounded: what is left goes to the last rank that draws at all.
  const auto draws = [&](int rank) { return level > busy[static_cast<std::size_t>(rank)]; };
  const auto found = std::find_if(deal.ranks.rbegin(), deal.ranks.rend(), draws);
  const int last = found == deal.ranks.rend() ? deal.ranks.back() : *found;
  double wanted = 0;
  double dealt = 0;
  std::uint32_t slot = 0;
  for (const int rank : deal.ranks) {
    const auto r = static_cast<std::size_t>(rank);
    plan.firsts[r] = slot;
    wanted += std::max(0.0, level - busy[r]);
    while (slot < work.size() && (rank == last || dealt + work[slot] / 2 <= wanted)) dealt += work[slot++];
    plan.ends[r] = slot;
  }
  return plan;
}

// The slowest rank's end, with the tiles that it really got.
double slowest(const RenderPlan& plan, const std::vector<double>& work, const std::vector<double>& busy) {
  double most = 0;
  for (std::size_t r = 0; r < busy.size(); ++r) {
    const int rank = static_cast<int>(r);
    most = std::max(most, std::accumulate(work.begin() + plan.first(rank), work.begin() + plan.end(rank), busy[r]));
  }
  return most;
}

// A tile's scenery is rendered by its owner and kept while camera and objects stand still. So tiles with objects stay
// with their owners, as long as other stretches would not be better by more than what seconds differ from frame to
// frame.
RenderPlan steady(RenderPlan next, const image::View& view, const RenderLoad& load, const std::vector<double>& work,
                  const std::vector<double>& busy) {
  constexpr double kNoise = 1.02;
  const bool comparable = load.last.path == next.path && load.last.order == next.order &&
                          load.grid.width == view.width && load.grid.height == view.height;
  if (view.objects.empty() || !comparable) return next;
  return slowest(load.last, work, busy) <= kNoise * slowest(next, work, busy) ? load.last : next;
}

// When the picture's records are there, each rank has this to do beside drawing until the next frame's actions are
// over. Calculators act; the manager acts on nothing before it has told the births of the next frame, for which all
// calculators wait; the image generator alone may go on drawing meanwhile.
std::vector<double> busy(const RenderLoad& load, const roles::Cast& cast, int ranks) {
  std::vector<double> seconds(static_cast<std::size_t>(ranks), 0.0);
  double most = 0;
  for (std::size_t c = 0; c < load.calculators.size(); ++c) {
    seconds[static_cast<std::size_t>(cast.calculators[c])] = load.calculators[c].act_s;
    most = std::max(most, load.calculators[c].act_s);
  }
  seconds[static_cast<std::size_t>(cast.manager)] = most;
  return seconds;
}

double slowest_projection(const RenderLoad& load) {
  double most = 0;
  for (const auto& calculator : load.calculators) most = std::max(most, calculator.particles);
  return most * load.scale * costs::kProject * kNano;
}

RenderEstimate estimate_gather(const Work& w, const image::View& view, const RenderLoad& load, const roles::Cast& cast,
                               std::vector<double> seconds) {
  RenderEstimate e;
  const auto home = static_cast<std::size_t>(cast.image_generator);
  e.plan.path = Path::gather;
  e.plan.firsts.assign(seconds.size(), 0);
  e.plan.ends.assign(seconds.size(), 0);
  e.plan.ends[home] = static_cast<std::uint32_t>(w.pixels.size());
  const double own = cast.calculator_of(cast.image_generator) >= 0 && !load.calculators.empty()
                         ? 1.0 / static_cast<double>(load.calculators.size())
                         : 0.0;
  const double bytes = w.all_records * (1 - own) * costs::record_bytes(view);
  seconds[home] += w.all_records * w.record_s + w.all_pixels * costs::kPixel * kNano + bytes * w.byte_s;
  const auto senders = static_cast<double>(std::max<std::size_t>(1, load.calculators.size()));
  e.seconds = slowest_projection(load) + bytes / senders * w.byte_s + *std::max_element(seconds.begin(), seconds.end());
  return e;
}

// The image generator puts together what others have drawn.
double assembly(const Work& w, std::size_t ranks) {
  const double others = 1 - 1 / static_cast<double>(ranks);
  return (w.all_pixels * costs::kShownBytes * others * costs::kByte + costs::kMessage * static_cast<double>(ranks)) *
         kNano;
}

// Records that go from `senders` to `ranks`: that part of all which is sent at all.
double exchange(const Work& w, double part, const image::View& view, double senders, double ranks) {
  const double bytes = w.all_records * part * w.crossing * costs::record_bytes(view);
  return bytes * w.byte_s * (1 / senders + 1 / ranks) + (ranks + senders) * costs::kMessage * kNano;
}

// Seconds that each slot takes if one rank draws all of it.
std::vector<double> drawing(const Work& w) {
  std::vector<double> work(w.pixels.size());
  for (std::size_t s = 0; s < work.size(); ++s) {
    work[s] = w.records[s] * w.record_s + w.pixels[s] * costs::kPixel * kNano;
  }
  return work;
}

RenderEstimate estimate_tiles(const Work& w, const image::View& view, const RenderLoad& load, const roles::Cast& cast,
                              std::vector<double> seconds) {
  RenderEstimate e;
  const auto ranks = static_cast<double>(seconds.size());
  const auto senders = static_cast<double>(std::max<std::size_t>(1, load.calculators.size()));
  seconds[static_cast<std::size_t>(cast.image_generator)] += assembly(w, seconds.size());
  const std::vector<double> work = drawing(w);
  e.plan = steady(deal_tiles(Path::tiles, w.deal, work, seconds), view, load, work, seconds);
  e.seconds = slowest_projection(load) + exchange(w, 1, view, senders, ranks) + slowest(e.plan, work, seconds);
  return e;
}

RenderEstimate estimate_composite(const Work& w, const image::View& view, const RenderLoad& load,
                                  const roles::Cast& cast, std::vector<double> seconds) {
  RenderEstimate e;
  const auto ranks = static_cast<double>(seconds.size());
  const auto senders = static_cast<double>(std::max<std::size_t>(1, load.calculators.size()));
  const double tile_pixels = w.all_pixels / static_cast<double>(w.pixels.size());
  const double partial_pixel_s = (costs::kPartialPixel + w.partial_bytes * costs::kByte) * kNano;
  double most = 0;      // the slowest calculator's own particles
  double partials = 0;  // partial tiles that calculators send
  for (const RenderLoad::Calculator& c : load.calculators) {
    const double sent = (c.active > 0 ? c.active : w.active) * w.crossing;
    const double share = w.particles > 0 ? c.particles * load.scale / w.particles : 0;
    partials += sent;
    most = std::max(most, share * w.merged * w.all_records * w.record_s + sent * tile_pixels * partial_pixel_s);
  }
  seconds[static_cast<std::size_t>(cast.image_generator)] += assembly(w, seconds.size());
  const double others = 1 - w.merged;  // of the records
  std::vector<double> work(w.pixels.size());
  for (std::size_t t = 0; t < work.size(); ++t) {
    const double added = w.records[t] > 0 && w.active > 0 ? partials / w.active : 0;
    work[t] = w.pixels[t] * (costs::kPixel * kNano + added * partial_pixel_s) + others * w.records[t] * w.record_s;
  }
  // As if owners drew all of it: so most stretches lie over the calculators' own particles, of which nothing is sent.
  e.plan = deal_tiles(Path::composite, w.deal, drawing(w), seconds);
  e.seconds =
      slowest_projection(load) + most + exchange(w, others, view, senders, ranks) + slowest(e.plan, work, seconds);
  return e;
}

}  // namespace

std::optional<image::Sprite::Blend> merged_blend(const image::View& view, std::span<const image::Sprite> sprites) {
  using Blend = image::Sprite::Blend;
  const auto blends = [](Blend blend) { return [blend](const image::Sprite& s) { return s.blend == blend; }; };
  if (std::all_of(sprites.begin(), sprites.end(), blends(Blend::add))) return Blend::add;
  const bool any = std::any_of(sprites.begin(), sprites.end(), blends(Blend::opaque));
  if (any && (view.layers & image::kVelocityLayer) == 0) return Blend::opaque;
  return std::nullopt;
}

RenderEstimate estimate(Path path, const image::View& view, std::span<const image::Sprite> sprites,
                        const RenderLoad& load, const roles::Cast& cast, int ranks) {
  const Work w = work_of(view, sprites, load, cast, ranks);
  std::vector<double> seconds = busy(load, cast, ranks);
  if (path == Path::tiles) return estimate_tiles(w, view, load, cast, std::move(seconds));
  if (path == Path::composite) return estimate_composite(w, view, load, cast, std::move(seconds));
  return estimate_gather(w, view, load, cast, std::move(seconds));
}

RenderPlan plan_render(const image::View& view, std::span<const image::Sprite> sprites, const RenderLoad& load,
                       const roles::Cast& cast, int ranks) {
  std::vector<Path> paths;
  const bool merges = merged_blend(view, sprites).has_value();
  if (view.path == Path::automatic) {
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

}  // namespace motes::frame
