#include "recording/program.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "particles/schema.h"
#include "particles/streams.h"
#include "recording/fetch_ahead.h"
#include "recording/planes.h"
#include "simd/float_mode.h"
#include "simd/isa.h"

namespace motes::recording {
namespace {

using particles::kBlock;
using particles::kShortBlock;
using particles::Store;

constexpr std::uint64_t kTurning = 1u << particles::up | 1u << particles::rotational_velocity;

// Whether a particle of this store may spin: it already does, or an action of the list will make it.
bool turns(const Store& store, const std::vector<actions::Action>& list) {
  const std::array<float, 3> spin = store.uniform_value(particles::rotational_velocity);
  if (!store.uniform(particles::rotational_velocity) || spin[0] != 0 || spin[1] != 0 || spin[2] != 0) return true;
  return std::any_of(list.begin(), list.end(), [&](const actions::Action& action) {
    return (actions::writes(action, store.schema()) >> particles::rotational_velocity & 1u) != 0;
  });
}

// The keys of draws are kept from block to block, for this many sub-steps.
constexpr std::size_t kKeptSteps = 64;

int last_of(const Span& span) { return span.last > 0 ? span.last : span.substeps; }

std::size_t substeps_of(const Span& span) { return static_cast<std::size_t>(std::max(last_of(span) - span.first, 1)); }

bool draws_any(const std::vector<actions::Action>& list) {
  return std::any_of(list.begin(), list.end(), [](const actions::Action& a) { return actions::facts(a.kind).draws; });
}

std::size_t kept_steps(const Span& span) {
  return std::min(kKeptSteps, static_cast<std::size_t>(std::max(span.substeps, 1)));
}

// Without spin, move leaves the orientations unchanged and they take no memory.
std::uint64_t untouched(const actions::Action& action, bool turns) {
  return action.kind == actions::Kind::move && (action.numbers[0] == 0 || !turns) ? kTurning : 0;
}

// A region's slices on the planes of a store. Positions without planes are not looked at.
class Bands {
 public:
  Bands(const Store& store, const Region& region) {
    for (const Slice& slice : region.slices()) {
      const float* x = store.plane(particles::position, slice.axis);
      if (x != nullptr) bands_[size_++] = {x, slice.low, slice.high};
    }
  }
  std::size_t size() const { return size_; }
  std::array<actions::Band, 3> at(std::size_t first) const {
    std::array<actions::Band, 3> here = bands_;
    for (std::size_t k = 0; k < size_; ++k) here[k].x += first;
    return here;
  }

 private:
  std::array<actions::Band, 3> bands_{};
  std::size_t size_ = 0;
};

// Room for one more block's indices; the collector reports how many it used.
bool collect(const actions::Block& block, const Bands& bands, std::size_t base, Outcome& outcome) {
  const std::size_t dead = outcome.dead.size();
  const std::size_t left = outcome.left.size();
  static thread_local std::array<std::uint32_t, kBlock + particles::kPadding> dead_here;
  static thread_local std::array<std::uint32_t, kBlock + particles::kPadding> left_here;
  std::size_t dead_count = 0;
  std::size_t left_count = 0;
  const std::array<actions::Band, 3> here = bands.at(base);
  actions::kernels().collect(block, here.data(), bands.size(), static_cast<std::uint32_t>(base), dead_here.data(),
                             dead_count, left_here.data(), left_count);
  if (dead_count + left_count == 0) return false;
  outcome.dead.resize(dead + dead_count);
  outcome.left.resize(left + left_count);
  std::copy_n(dead_here.data(), dead_count, outcome.dead.data() + dead);
  std::copy_n(left_here.data(), left_count, outcome.left.data() + left);
  return dead_count != 0;
}

// Brings particles that are to be removed to the front of a range.
class Front {
 public:
  Front(const Store& store, std::size_t first) : swapper_(store), next_(static_cast<std::uint32_t>(first)) {}

  // The dead and those that left, from these places of the lists on: none of them in both.
  void gather(Outcome& outcome, std::size_t dead, std::size_t left) {
    while (dead < outcome.dead.size() || left < outcome.left.size()) {
      const bool dies =
          left == outcome.left.size() || (dead < outcome.dead.size() && outcome.dead[dead] < outcome.left[left]);
      std::uint32_t& particle = dies ? outcome.dead[dead++] : outcome.left[left++];
      // In ascending order: who stands at the front stays, or is this one.
      if (particle != next_) swapper_.swap(particle, next_);
      particle = next_++;
    }
  }

 private:
  Store::Swapper swapper_;
  std::uint32_t next_;
};

void append(std::vector<std::uint32_t>& to, const std::vector<std::uint32_t>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

// A range holds so many particles: whole blocks, long enough that starting one costs nothing; the last ones are
// shorter, so that threads end together.
constexpr std::size_t kRange = 1024 * kShortBlock, kLastRange = 16 * kShortBlock;
constexpr std::size_t kAlone = 64 * kShortBlock;  // fewer are not worth waking threads for
constexpr std::size_t kWhole = 64;  // whole vectors: kernels write whole ones

// Starting an action costs as much as a dozen particles. Where the next block is fetched ahead, long lists win more by
// longer blocks than the processor's guesses are worth.
constexpr std::size_t kLongList = 8;
struct Blocks {
  bool fetched;  // ahead
  std::size_t size;
};
Blocks blocks_for(std::size_t actions) {
  const bool is_long = actions > kLongList, fetched = simd::fetches_ahead(is_long);
  return {fetched, is_long && fetched ? kBlock : kShortBlock};
}

// Calls work(first, last, outcome) for ranges of the particles, and puts the outcomes together in order.
template <class Work>
void share(threads::Pool& pool, std::size_t begin, std::size_t end, Outcome& outcome, const Work& work) {
  const std::size_t count = end - begin;
  if (pool.threads() == 1 || count < pool.items(kAlone)) return work(begin, end, outcome);
  const std::vector<std::size_t> starts = threads::falling_ranges(pool, count, kRange, kLastRange, kWhole);
  std::vector<Outcome> outcomes(starts.size() - 1);
  pool.run(outcomes.size(), [&](std::size_t part, std::size_t) {
    Outcome here;  // not among the others yet: threads would wait for each other's cache lines
    here.wants_hits = outcome.wants_hits;
    here.gathers = outcome.gathers;
    work(begin + starts[part], begin + starts[part + 1], here);
    outcomes[part] = std::move(here);
  });
  for (const Outcome& part : outcomes) {
    append(outcome.dead, part.dead);
    append(outcome.left, part.left);
    append(outcome.hits, part.hits);
  }
}

// Tables are kept as long as the process lives.
void bind_table(const actions::Table& table, actions::Parameters& parameters) {
  parameters.table = table.values.data();
  std::copy(table.size.begin(), table.size.end(), parameters.table_size);
}

std::vector<int> components_of(std::uint64_t attributes, const particles::Schema& schema) {
  std::vector<int> components;
  for (int a = 0; a < schema.size(); ++a) {
    for (int c = 0; (attributes >> a & 1u) != 0 && c < schema[a].width; ++c) {
      components.push_back(schema[a].first_component + c);
    }
  }
  return components;
}

}  // namespace

double time_of(const Span& span, int substep) {
  return (static_cast<double>(span.frame) + static_cast<double>(substep) / span.substeps) * span.dt;
}

Program::Program(std::vector<actions::Action> list, std::uint32_t place) : list_(std::move(list)), place_(place) {}

std::vector<Program::Operation> Program::bind(const Store& store, bool turns, float* scratch) const {
  std::vector<Operation> operations;
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const actions::Action& action = list_[i];
    Operation operation;
    operation.kernel = actions::kernels().action[static_cast<std::size_t>(action.kind)];
    operation.stream = particles::action + place_ + static_cast<std::uint32_t>(i);
    operation.where = &action.where;
    actions::Parameters& p = operation.parameters;
    p.number = action.numbers.data();
    p.numbers = static_cast<int>(action.numbers.size());
    p.shape = action.shapes.data();
    p.flag = turns && action.kind == actions::Kind::move && action.numbers[0] != 0;
    p.scratch = scratch;
    if (action.table != 0) bind_table(*actions::table(action.table), p);
    if (action.target >= 0) {
      p.target = store.schema()[action.target].first_component;
      p.width = store.schema()[action.target].width;
    }
    for (std::size_t v = 0; v < action.values.size() && v < 3; ++v) {
      p.code[v] = action.values[v].data();
      p.length[v] = action.values[v].size();
    }
    if (!action.where.empty()) {
      const std::uint64_t writes = actions::writes(action, store.schema()) & ~untouched(action, turns);
      operation.written = components_of(writes, store.schema());
    }
    operations.push_back(std::move(operation));
  }
  return operations;
}

void Program::run(Store& store, std::size_t begin, std::size_t entry, const Span& span, particles::Key key,
                  const Region& region, Outcome& outcome, threads::Pool& pool) const {
  if (list_.empty() || begin >= store.size()) return;
  const Pass pass = prepare(store, entry, span, key, region);
  share(pool, begin, store.size(), outcome,
        [&](std::size_t first, std::size_t last, Outcome& of_range) { run_range(pass, first, last, of_range); });
}

// Allocates what the list writes to; from then on parts may run at the same time.
Program::Pass Program::prepare(Store& store, std::size_t entry, const Span& span, particles::Key key,
                               const Region& region) const {
  const bool spins = turns(store, list_);
  std::uint64_t reads = 0;
  std::uint64_t writes = 0;
  for (const actions::Action& action : list_) {
    reads |= actions::reads(action, store.schema()) & ~untouched(action, spins);
    reads |= actions::named(action, store.schema());  // by an expression, whatever the kernel does
    writes |= actions::writes(action, store.schema()) & ~untouched(action, spins);
  }
  for (int a = 0; a < store.schema().size(); ++a) {
    if ((writes >> a & 1u) != 0) store.writable_plane(a, 0);
  }
  return {store, span, region, steps_of(entry, span, key), spins, reads | writes};
}

void Program::run_range(const Pass& pass, std::size_t first, std::size_t last, Outcome& outcome) const {
  const simd::FloatMode mode;
  static thread_local std::array<float, actions::kScratch> scratch;  // kept: a range is soon done
  const std::vector<Operation> operations = bind(pass.store, pass.spins, scratch.data());
  Planes planes(pass.store, pass.touched);
  const Bands bands(pass.store, pass.region);
  std::vector<particles::DrawKeys> draws(operations.size() * kept_steps(pass.span));
  std::array<std::int32_t, kBlock + particles::kPadding> dead{};
  std::array<std::int32_t, kBlock + particles::kPadding> hit{};
  const auto [fetched, size] = blocks_for(operations.size());
  FetchAhead ahead(pass.store, pass.touched, draws_any(list_), operations.size() * substeps_of(pass.span),
                   last - first > size && fetched ? size : 0);
  std::optional<Front> front;
  if (outcome.gathers) front.emplace(pass.store, first);
  for (std::size_t at = first; at < last; at += size) {
    const std::size_t count = std::min(size, last - at);
    const std::size_t dead_before = outcome.dead.size(), left_before = outcome.left.size();
    ahead.aim(at + size, last);
    const actions::Block block{count, planes.at(at), pass.store.ids().from(at), dead.data(),
                               outcome.wants_hits ? hit.data() : nullptr};
    run_block(pass.steps, operations, block, draws, ahead);
    if (collect(block, bands, at, outcome)) std::memset(dead.data(), 0, count * sizeof dead[0]);
    if (front) front->gather(outcome, dead_before, left_before);
    for (std::size_t i = 0; outcome.wants_hits && i < count; ++i) {
      if (hit[i] != 0) outcome.hits.push_back(static_cast<std::uint32_t>(at + i));
    }
    if (outcome.wants_hits) hit.fill(0);
  }
}

// Made once for a run: for each block of particles it would take as long as an action.
std::vector<Program::Substep> Program::steps_of(std::size_t entry, const Span& span, particles::Key key) {
  const simd::FloatMode mode;
  const float dt = static_cast<float>(span.dt / span.substeps);
  const auto substeps = static_cast<float>(span.substeps);
  const auto before = static_cast<std::uint32_t>(span.frame * static_cast<std::uint64_t>(span.substeps));
  std::vector<Substep> steps;
  steps.reserve(substeps_of(span));
  for (int substep = span.first; substep < last_of(span); ++substep) {
    const float start = static_cast<float>(substep) / substeps, end = static_cast<float>(substep + 1) / substeps;
    steps.push_back(
        {{dt, before + static_cast<std::uint32_t>(substep), 0, key, time_of(span, substep), nullptr, start, end},
         substep == span.first ? entry : 0,
         static_cast<std::size_t>(substep) % kKeptSteps});
  }
  return steps;
}

void Program::run_block(const std::vector<Substep>& steps, const std::vector<Operation>& operations,
                        const actions::Block& block, std::vector<particles::DrawKeys>& draws, FetchAhead& ahead) {
  for (const Substep& substep : steps) {
    actions::Step now = substep.step;
    particles::DrawKeys* keys = draws.data() + substep.kept * operations.size();
    for (std::size_t o = substep.entry; o < operations.size(); ++o) {
      const Operation& operation = operations[o];
      ahead.fetch();
      now.stream = operation.stream;
      now.draws = keys + o;
      if (operation.where->empty()) {
        operation.kernel(operation.parameters, block, now);
      } else {
        run_where(operation, block, now);
      }
    }
  }
}

// The action runs on the whole block; its writes are undone where the condition does not hold.
void Program::run_where(const Operation& operation, const actions::Block& block, const actions::Step& step) {
  static thread_local std::array<std::int32_t, kBlock + particles::kPadding> mask;
  static thread_local std::array<std::int32_t, kBlock + particles::kPadding> dead;
  static thread_local std::array<std::int32_t, kBlock + particles::kPadding> hit;
  static thread_local std::vector<float> before;
  const actions::Parameters& p = operation.parameters;
  actions::kernels().evaluate(operation.where->data(), operation.where->size(), p.shape, block,
                              static_cast<float>(step.time), p.scratch);
  std::memcpy(mask.data(), p.scratch, block.count * sizeof(float));
  std::memcpy(dead.data(), block.dead, block.count * sizeof(std::int32_t));
  if (block.hit != nullptr) std::memcpy(hit.data(), block.hit, block.count * sizeof(std::int32_t));
  before.resize(operation.written.size() * kBlock);
  for (std::size_t w = 0; w < operation.written.size(); ++w) {
    std::memcpy(before.data() + w * kBlock, block.component[operation.written[w]], block.count * sizeof(float));
  }
  operation.kernel(p, block, step);
  for (std::size_t i = 0; i < block.count; ++i) block.dead[i] = dead[i] | (block.dead[i] & mask[i]);
  for (std::size_t i = 0; block.hit != nullptr && i < block.count; ++i) {
    block.hit[i] = hit[i] | (block.hit[i] & mask[i]);
  }
  for (std::size_t w = 0; w < operation.written.size(); ++w) {
    float* plane = block.component[operation.written[w]];
    const float* saved = before.data() + w * kBlock;
    for (std::size_t i = 0; i < block.count; ++i) plane[i] = mask[i] != 0 ? plane[i] : saved[i];
  }
}

void Program::find_leavers(const Store& store, std::size_t begin, const Region& region, Outcome& outcome,
                           threads::Pool& pool) {
  const Bands bands(store, region);
  if (bands.size() == 0 || begin >= store.size()) return;
  share(pool, begin, store.size(), outcome, [&](std::size_t first, std::size_t last, Outcome& of_range) {
    std::array<std::int32_t, kBlock + particles::kPadding> dead{};
    for (std::size_t at = first; at < last; at += kBlock) {
      const actions::Block block{std::min(kBlock, last - at), nullptr, {}, dead.data()};
      collect(block, bands, at, of_range);
    }
  });
}

}  // namespace motes::recording
