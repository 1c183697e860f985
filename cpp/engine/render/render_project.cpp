#include "engine/render/render_project.h"

#include <algorithm>
#include <functional>
#include <numeric>

#include "base/fields.h"
#include "engine/render/drawn.h"
#include "engine/render/in_picture.h"
#include "engine/render/render_composite.h"
#include "image/raycast/solid_shadows.h"

namespace motes::engine {
namespace {

// Adds up the threads' counts of records by slot.
void add_up(const std::vector<std::vector<std::uint32_t>>& by_thread, Painter& painter) {
  painter.counts = by_thread[0];
  for (std::size_t t = 1; t < by_thread.size(); ++t) {
    std::transform(by_thread[t].begin(), by_thread[t].end(), painter.counts.begin(), painter.counts.begin(),
                   std::plus<>());
  }
  painter.drawing.records = std::accumulate(painter.counts.begin(), painter.counts.end(), std::uint64_t{0});
  painter.drawing.active =
      static_cast<std::uint32_t>(painter.counts.size()) -
      static_cast<std::uint32_t>(std::count(painter.counts.begin(), painter.counts.end(), std::uint32_t{0}));
}

// Particles of a system that one thread projects.
struct PartOfSystem {
  std::size_t system;
  image::Drawn particles;
  double place = 0;  // index of the first one, as a fraction of the system's particles
};

// Returns the size of the parts into which a system's particles are divided, at most pool.items(kParticles).
std::size_t size_of_part(const threads::Pool& pool, std::size_t count) {
  constexpr std::size_t kParticles = std::size_t{1} << 15, kWhole = 16;  // planes start with whole vectors
  if (pool.threads() == 1 || count == 0) return std::max(count, std::size_t{1});
  const std::size_t most = pool.items(kParticles), parts = (count + most - 1) / most;
  return ((count + parts - 1) / parts + kWhole - 1) / kWhole * kWhole;
}

// Splits the systems' particles into parts for threads. With one thread, each system is one part, since each part is a
// batch of its own.
std::vector<PartOfSystem> parts_of(const threads::Pool& pool, const std::vector<DrawnSystem>& systems) {
  std::vector<PartOfSystem> parts;
  for (std::size_t i = 0; i < systems.size(); ++i) {
    const image::Drawn& all = systems[i].columns();
    const std::size_t size = size_of_part(pool, all.count);
    std::size_t first = 0;
    do {  // a system without particles has one empty part
      parts.push_back({i, part_of(all, first, std::min(size, all.count - first)),
                       static_cast<double>(first) / static_cast<double>(std::max(all.count, std::size_t{1}))});
      first += size;
    } while (first < all.count);
  }
  // Lets threads project roughly the same particles that they acted on.
  std::stable_sort(parts.begin(), parts.end(),
                   [](const PartOfSystem& a, const PartOfSystem& b) { return a.place < b.place; });
  return parts;
}

// Appends the records in slots first .. end - 1, batch by batch, except those that are sent as partial tiles. Returns
// their number.
std::uint64_t put_records(const Painter& painter, int first, int end, base::Bytes& out) {
  std::uint64_t records = 0;
  std::uint32_t systems = 0;
  const std::size_t head = out.size();
  out.put(systems);
  for (const image::Records& all : painter.records) {
    const image::RecordsView view(all.bytes());
    if (view.sprite().blend == painter.merged) continue;
    ++systems;
    const std::size_t at = out.size();
    out.put(std::uint64_t{0});
    view.append_part(first, end, out);
    out.set(at, static_cast<std::uint64_t>(out.size() - at - sizeof(std::uint64_t)));
    records += view.count(first, end);
  }
  out.set(head, systems);
  return records;
}

}  // namespace

void project(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::project, "project");
  const double start = rank.machine.compute_seconds();
  rank.session.work("render", [&] {
    const image::View& view = *script.record.view;
    const std::vector<DrawnSystem> systems = drawn_systems(script, calculator, *rank.pool);
    const std::vector<PartOfSystem> parts = parts_of(*rank.pool, systems);
    painter.records.resize(parts.size());
    while (painter.projectors.size() < static_cast<std::size_t>(rank.pool->threads()))
      painter.projectors.emplace_back();
    const auto tiles = static_cast<std::size_t>(image::Grid{view.width, view.height}.tiles());
    painter.counts.assign(tiles, 0);
    std::vector<std::vector<std::uint32_t>> counts(painter.projectors.size(), painter.counts);
    std::vector<std::uint64_t> bytes(parts.size());
    std::vector<std::unique_ptr<const image::ParticleLight>> lights;
    const image::InSight in_sight = image::in_sight(view);
    for (const image::Sprite& sprite : script.record.sprites) {
      lights.push_back(image::ParticleLight::of(sprite, view, painter.shadows.get(), in_sight));
    }
    rank.pool->run(parts.size(), [&](std::size_t p, std::size_t worker) {
      const PartOfSystem& part = parts[p];
      image::Projection how = projection(script, part.system);
      how.light = lights[part.system].get();
      how.slots = &painter.slots;
      painter.projectors[worker].project(part.particles, script.record.sprites[part.system], view, painter.records[p],
                                         how);
      const image::RecordsView records(painter.records[p].bytes());
      records.add_counts(counts[worker]);
      bytes[p] = records.count() * records.record_bytes();
    });
    add_up(counts, painter);
    std::vector<std::uint64_t> records(calculator.populations.size());
    for (std::size_t p = 0; p < parts.size(); ++p) {
      records[parts[p].system] += image::RecordsView(painter.records[p].bytes()).count();
    }
    painter.drawing.record_bytes = std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0});
    painter.drawing.sighted = sighted(script, calculator, records, painter.pictures);
    std::uint64_t particles = 0;
    for (const PartOfSystem& part : parts) particles += part.particles.count;
    rank.machine.charge(rank.machine.costs().record * static_cast<double>(particles));
  });
  rank.machine.slow_down(start);
}

void send_records(Rank& rank, Painter& painter) {
  Session& session = rank.session;
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::project, "send records");
  const double start = rank.machine.compute_seconds();
  const RenderPlan& plan = painter.plan;
  for (int step = 1; step < session.size(); ++step) {  // ranks start with different receivers
    const int to = (session.rank() + step) % session.size();
    if (!plan.draws(to)) continue;
    comm::Message message;
    std::uint64_t records = 0, merged = 0;  // records sent as such; records in partial tiles
    session.work("render", [&] {
      records = put_records(painter, plan.first(to), plan.end(to), message.bytes());
      if (painter.merged) merged = put_partials(rank, painter, plan.first(to), plan.end(to), message.bytes());
    });
    if (session.failed()) message = failure_message(session.rank(), session.failure());
    painter.drawing.sent += records + merged;
    painter.drawing.bytes += message.payload().size();
    session.comm().post(to, comm::Phase::records, session.stamp(), std::move(message), records, session.failed());
  }
  rank.machine.slow_down(start);
  if (rank.settings.blocking) session.comm().flush();
}

comm::Message failure_message(int failed_rank, const Failure& failure) {
  comm::Message message;
  message.bytes().put(static_cast<std::int32_t>(failed_rank));
  base::write_fields(failure, message.bytes());
  return message;
}

void give_up_for(Rank& rank, const comm::Message& message) {
  base::Reader in = message.reader();
  Verdict verdict;
  verdict.failed_rank = in.get<std::int32_t>();
  base::read_fields(in, verdict.failure);
  rank.session.give_up(std::move(verdict));
}

}  // namespace motes::engine
