#include "program/program.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "particles/schema.h"
#include "particles/streams.h"
#include "particles/wrap.h"
#include "program/collector.h"
#include "program/fetch_ahead.h"
#include "program/planes.h"
#include "simd/float_mode.h"
#include "simd/isa.h"

namespace motes::program {
namespace {

using particles::kBlock;
using particles::kShortBlock;
using particles::Store;

std::uint64_t bit(int attribute) { return std::uint64_t{1} << attribute; }

// An attribute that move turns, and the attribute with its rate.
struct Turning {
  int turned, rate;
  std::uint64_t both() const { return bit(turned) | bit(rate); }
};
constexpr Turning kUps = {particles::up, particles::rotational_velocity};
constexpr Turning kOrientations = {particles::orientation, particles::spin};

// Returns whether a particle of this store may turn: it already does, or an action of the list may make it turn.
bool turns(const Turning& turning, const Store& store, const std::vector<actions::Action>& list) {
  const particles::Value rate = store.uniform_value(turning.rate);
  if (!store.uniform(turning.rate) || rate[0] != 0 || rate[1] != 0 || rate[2] != 0) return true;
  return std::any_of(list.begin(), list.end(), [&](const actions::Action& action) {
    return action.kind != actions::Kind::rest && (actions::writes(action) >> turning.rate & 1u) != 0;
  });
}

// Returns the attributes that move leaves unchanged, since no particle turns; they take no memory.
std::uint64_t at_rest(const Store& store, const std::vector<actions::Action>& list) {
  return (turns(kUps, store, list) ? 0 : kUps.both()) | (turns(kOrientations, store, list) ? 0 : kOrientations.both());
}

// The keys of draws are kept from block to block for this many sub-steps.
constexpr std::size_t kKeptSteps = 64;

int last_of(const Span& span) { return span.last > 0 ? span.last : span.substeps; }

std::size_t substeps_of(const Span& span) { return static_cast<std::size_t>(std::max(last_of(span) - span.first, 1)); }

bool draws_any(const std::vector<actions::Action>& list) {
  return std::any_of(list.begin(), list.end(), [](const actions::Action& a) { return actions::facts(a.kind).draws; });
}

std::size_t kept_steps(const Span& span) {
  return std::min(kKeptSteps, static_cast<std::size_t>(std::max(span.substeps, 1)));
}

bool rotational(const actions::Action& action) {
  return action.kind == actions::Kind::move && actions::numbers_of<actions::numbers::move>(action).rotational != 0;
}

// Returns the attributes that an action leaves unchanged, although its kind writes them.
std::uint64_t untouched(const actions::Action& action, std::uint64_t at_rest) {
  if (action.kind == actions::Kind::rest) return at_rest & (bit(kUps.rate) | bit(kOrientations.rate));
  if (action.kind != actions::Kind::move) return 0;
  return rotational(action) ? at_rest : kUps.both() | kOrientations.both();
}

const actions::ParticleLaw* law_of(const actions::Action& action) {
  return std::get_if<actions::ParticleLaw>(&action.specifics);
}

void append(std::vector<std::uint32_t>& to, const std::vector<std::uint32_t>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

// Particles per range: whole blocks, long enough that starting a range costs nothing. The last ranges are shorter, so
// that threads end together.
constexpr std::size_t kFullRange = 1024 * kShortBlock, kLastRange = 16 * kShortBlock;
constexpr std::size_t kAlone = 64 * kShortBlock;  // fewer are not worth waking threads for
constexpr std::size_t kWhole = 64;  // ranges are multiples of this, since kernels write whole vectors

// Starting an action costs as much as a dozen particles. If the next block is fetched ahead, long lists gain more from
// longer blocks than the processor's own prefetching is worth.
constexpr std::size_t kLongList = 8;
std::size_t block_for(std::size_t actions, bool fetched) {
  return fetched && actions > kLongList ? kBlock : kShortBlock;
}

// Calls work(first, last, outcome) for ranges of the particles, and joins the outcomes in order.
template <class Work>
void share(threads::Pool& pool, std::size_t begin, std::size_t end, ListResult& outcome, const Work& work) {
  const std::size_t count = end - begin;
  if (pool.threads() == 1 || count < pool.items(kAlone)) {
    for (std::size_t first = begin; first < end; first += kFullRange) {
      work(first, std::min(first + kFullRange, end), outcome);
      pool.pause();
    }
    return;
  }
  const std::vector<std::size_t> starts = threads::falling_ranges(pool, count, kFullRange, kLastRange, kWhole);
  std::vector<ListResult> outcomes(starts.size() - 1);
  pool.run(outcomes.size(), [&](std::size_t part, std::size_t) {
    ListResult here;  // local, so that threads do not wait for each other's cache lines
    here.wants_hits = outcome.wants_hits;
    here.gathers = outcome.gathers;
    work(begin + starts[part], begin + starts[part + 1], here);
    outcomes[part] = std::move(here);
  });
  for (const ListResult& part : outcomes) {
    append(outcome.dead, part.dead);
    append(outcome.left, part.left);
    append(outcome.hits, part.hits);
  }
}

// Returns a view of a table, which the process keeps until it ends.
actions::TableView view_of(const actions::LookupTable& table) {
  return {table.values.data(), {table.size[0], table.size[1], table.size[2]}};
}

// Returns the code of an action's values. `first`: the component that `set` writes first.
actions::ValuesCode code_of(const std::vector<actions::Expression>& values, int first = 0) {
  actions::ValuesCode code{first, static_cast<int>(values.size())};
  for (std::size_t v = 0; v < values.size(); ++v) {
    code.code[v] = values[v].data();
    code.length[v] = values[v].size();
  }
  return code;
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

Program::Program(std::vector<actions::Action> list, std::uint32_t place, const particles::Schema& schema)
    : list_(std::move(list)), place_(place) {
  const bool any = std::any_of(list_.begin(), list_.end(), law_of);
  if (any) compile_laws(schema);
}

void Program::compile_laws(const particles::Schema& schema) {
  laws_.resize(list_.size());
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const actions::ParticleLaw* const given = law_of(list_[i]);
    if (given == nullptr) continue;
    Law& law = laws_[i];
    law.formula = expressions::compile(given->values, schema.components(), schema[particles::position].first_component);
    for (std::size_t k = 0; k < given->results.size(); ++k) {
      const actions::Result& result = given->results[k];
      law.outcomes.push_back({schema[result.attribute].first_component + result.component, law.formula.results[k],
                              result.how == actions::Result::How::rate, result.how != actions::Result::How::value});
    }
    work_ = std::max(work_, static_cast<std::size_t>(law.formula.written()));
  }
}

// Binds what the kernel needs beside numbers and shapes.
void Program::bind_part(std::size_t number, const particles::Schema& schema, float* work, Operation& operation) const {
  const actions::Action& action = list_[number];
  actions::Bound& bound = operation.parameters.bound;
  if (actions::facts(action.kind).ramp > 0) bound.ramp = static_cast<int>(action.numbers.size());
  if (const auto* set = std::get_if<actions::Assignment>(&action.specifics))
    bound.values =
        &operation.bound.emplace<actions::ValuesCode>(code_of(set->values, schema[set->attribute].first_component));
  if (const auto* given = std::get_if<actions::PerParticle>(&action.specifics))
    bound.values = &operation.bound.emplace<actions::ValuesCode>(code_of(given->values));
  if (const auto* lookup = std::get_if<actions::Lookup>(&action.specifics))
    bound.table = &operation.bound.emplace<actions::TableView>(view_of(*actions::table(lookup->table)));
  if (law_of(action) != nullptr) bound.law = bind_law(number, work, operation);
}

const actions::LawCode* Program::bind_law(std::size_t number, float* work, Operation& operation) const {
  const Law& law = laws_[number];
  operation.planes.assign(static_cast<std::size_t>(law.formula.planes), nullptr);
  const auto columns = static_cast<std::size_t>(law.formula.columns);
  for (std::size_t p = columns; p < operation.planes.size(); ++p) {
    operation.planes[p] = work + (p - columns) * actions::kPlane;
  }
  return &operation.bound.emplace<actions::LawCode>(actions::LawCode{
      law.formula.constants.data(), law.formula.constants.size(), law.formula.steps.data(), law.formula.steps.size(),
      law.outcomes.data(), law.outcomes.size(), columns, operation.planes.data()});
}

std::vector<Program::Operation> Program::bind(const Store& store, std::uint64_t at_rest, float* scratch,
                                              float* work) const {
  std::vector<Operation> operations(list_.size());
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const actions::Action& action = list_[i];
    Operation& operation = operations[i];
    operation.kernel = actions::kernels().action[static_cast<std::size_t>(action.kind)];
    actions::Parameters& p = operation.parameters;
    const bool few = action.numbers.size() <= operation.numbers.size();
    if (few) std::copy(action.numbers.begin(), action.numbers.end(), operation.numbers.begin());
    p.number = few ? operation.numbers.data() : action.numbers.data();
    p.shape = action.shapes.data();
    if (rotational(action) || action.kind == actions::Kind::rest)
      p.bound.turns = {(at_rest & kUps.both()) == 0, (at_rest & kOrientations.both()) == 0};
    bind_part(i, store.schema(), work, operation);
    p.periods = &store.schema().periods();
    p.scratch = scratch;
    const std::uint64_t writes = actions::writes(action) & ~untouched(action, at_rest);
    operation.moves = store.schema().periods().any() && (writes >> particles::position & 1u) != 0;
    if (!action.where.empty()) {
      operation.where = &action.where;
      operation.written = components_of(writes, store.schema());
    }
  }
  return operations;
}

void Program::run(Store& store, std::size_t begin, std::size_t entry, const Span& span, particles::Key key,
                  const Region& region, ListResult& outcome, threads::Pool& pool) const {
  if (list_.empty() || begin >= store.size()) return;
  const Pass pass = prepare(store, entry, span, key, region);
  share(pool, begin, store.size(), outcome,
        [&](std::size_t first, std::size_t last, ListResult& of_range) { run_range(pass, first, last, of_range); });
}

// Allocates what the list writes to; afterwards, ranges may run at the same time.
Program::Pass Program::prepare(Store& store, std::size_t entry, const Span& span, particles::Key key,
                               const Region& region) const {
  const std::uint64_t still = at_rest(store, list_);
  std::uint64_t reads = 0;
  std::uint64_t writes = 0;
  bool conditional = false;
  for (const actions::Action& action : list_) {
    conditional |= !action.where.empty();
    reads |= actions::reads(action, store.schema()) & ~untouched(action, still);
    reads |= actions::named(action, store.schema());  // by an expression, whatever the kernel reads
    writes |= actions::writes(action) & ~untouched(action, still);
  }
  const bool wraps = store.schema().periods().any() && (writes >> particles::position & 1u) != 0;
  if (wraps) writes |= std::uint64_t{1} << store.schema().crossings();
  for (int a = 0; a < store.schema().size(); ++a) {
    if ((writes >> a & 1u) != 0) store.writable_plane(a, 0);
  }
  return {store, span, region, steps_of(entry, span, key), still, conditional, wraps, reads | writes};
}

void Program::run_range(const Pass& pass, std::size_t first, std::size_t last, ListResult& outcome) const {
  const simd::FloatMode mode;
  static thread_local std::array<float, actions::kScratch> scratch;  // reused, since a range takes little time
  static thread_local std::vector<float> work;
  if (work.size() < work_ * actions::kPlane) work.resize(work_ * actions::kPlane);
  const std::vector<Operation> operations = bind(pass.store, pass.at_rest, scratch.data(), work.data());
  Planes planes(pass.store, pass.touched);
  std::vector<particles::DrawKeys> draws(operations.size() * kept_steps(pass.span));
  std::array<std::int32_t, kBlock + particles::kPadding> hit{};
  const bool fetched = simd::fetches_ahead();
  const std::size_t size = block_for(operations.size(), fetched);
  std::optional<FetchAhead> ahead;
  if (fetched && last - first > size) {
    ahead.emplace(pass.store, pass.touched, draws_any(list_), operations.size() * substeps_of(pass.span), size);
  }
  Collector collector(pass.store, pass.region, outcome);
  if (outcome.gathers) collector.gather(pass.store, first);
  const particles::Ids ids = pass.store.ids();
  const bool wants_hits = outcome.wants_hits;
  for (std::size_t at = first; at < last; at += size) {
    const std::size_t count = std::min(size, last - at);
    if (ahead) ahead->aim(at + size, last);
    const actions::Block block{count, planes.at(at), ids.from(at), collector.dead(), wants_hits ? hit.data() : nullptr};
    run_block(pass, operations, block, draws, ahead ? &*ahead : nullptr);
    collector.collect(block, at);
    for (std::size_t i = 0; wants_hits && i < count; ++i) {
      if (hit[i] != 0) outcome.hits.push_back(static_cast<std::uint32_t>(at + i));
    }
    if (wants_hits) hit.fill(0);
  }
}

// Returns the sub-steps, prepared once per run: once per block would take as long as an action.
std::vector<Program::Substep> Program::steps_of(std::size_t entry, const Span& span, particles::Key key) const {
  const simd::FloatMode mode;
  const float dt = static_cast<float>(span.dt / span.substeps);
  const auto substeps = static_cast<float>(span.substeps);
  const auto before = static_cast<std::uint32_t>(span.frame * static_cast<std::uint64_t>(span.substeps));
  std::vector<Substep> steps;
  steps.reserve(substeps_of(span));
  for (int substep = span.first; substep < last_of(span); ++substep) {
    const actions::Step step{.dt = dt,
                             .step = before + static_cast<std::uint32_t>(substep),
                             .stream = particles::action + place_,
                             .key = key,
                             .time = time_of(span, substep),
                             .start = static_cast<float>(substep) / substeps,
                             .end = static_cast<float>(substep + 1) / substeps,
                             .ageing = actions::ageing_of(span.dt, substep, span.substeps)};
    steps.push_back({step, substep == span.first ? entry : 0, static_cast<std::size_t>(substep) % kKeptSteps});
  }
  return steps;
}

void Program::run_block(const Pass& pass, const std::vector<Operation>& operations, const actions::Block& block,
                        std::vector<particles::DrawKeys>& draws, FetchAhead* ahead) {
  for (const Substep& substep : pass.steps) {
    actions::Step now = substep.step;
    particles::DrawKeys* keys = draws.data() + substep.kept * operations.size();
    for (std::size_t o = substep.entry; o < operations.size(); ++o) {
      const Operation& operation = operations[o];
      if (ahead != nullptr) ahead->fetch();
      now.stream = substep.step.stream + static_cast<std::uint32_t>(o);
      now.draws = keys + o;
      if (pass.conditional && operation.where != nullptr) {
        run_where(operation, block, now);
      } else {
        operation.kernel(operation.parameters, block, now);
      }
      if (pass.wraps && operation.moves) wrap_block(pass.store.schema(), block);
    }
  }
}

// Wraps the positions, which have just been written.
void Program::wrap_block(const particles::Schema& schema, const actions::Block& block) {
  const auto plane = [&](int attribute, int axis) { return block.component[schema[attribute].first_component + axis]; };
  for (int axis = 0; axis < 3; ++axis) {
    if (!schema.periods().has(axis)) continue;
    particles::wrap(schema.periods()[axis], block.count, plane(particles::position, axis),
                    plane(schema.crossings(), axis));
  }
}

// Runs the action on the whole block, then undoes its writes where the condition does not hold.
void Program::run_where(const Operation& operation, const actions::Block& block, const actions::Step& step) {
  static thread_local std::array<std::int32_t, kBlock + particles::kPadding> mask;
  static thread_local std::array<std::int32_t, kBlock + particles::kPadding> hit;
  std::array<std::uint32_t, particles::kBlockWords> dead;
  static thread_local std::vector<float> before;
  const actions::Parameters& p = operation.parameters;
  actions::kernels().evaluate(operation.where->data(), operation.where->size(), p.shape, block,
                              static_cast<float>(step.time), p.scratch);
  std::memcpy(mask.data(), p.scratch, block.count * sizeof(float));
  std::copy_n(block.dead, dead.size(), dead.begin());
  if (block.hit != nullptr) std::memcpy(hit.data(), block.hit, block.count * sizeof(std::int32_t));
  before.resize(operation.written.size() * kBlock);
  for (std::size_t w = 0; w < operation.written.size(); ++w) {
    std::memcpy(before.data() + w * kBlock, block.component[operation.written[w]], block.count * sizeof(float));
  }
  operation.kernel(p, block, step);
  for (std::size_t i = 0; i < block.count; ++i) {
    if (mask[i] == 0) block.dead[i / 32] &= dead[i / 32] | ~(1u << i % 32);
  }
  for (std::size_t i = 0; block.hit != nullptr && i < block.count; ++i) {
    block.hit[i] = hit[i] | (block.hit[i] & mask[i]);
  }
  for (std::size_t w = 0; w < operation.written.size(); ++w) {
    float* plane = block.component[operation.written[w]];
    const float* saved = before.data() + w * kBlock;
    for (std::size_t i = 0; i < block.count; ++i) plane[i] = mask[i] != 0 ? plane[i] : saved[i];
  }
}

void Program::find_migrants(const Store& store, std::size_t begin, const Region& region, ListResult& outcome,
                            threads::Pool& pool) {
  if (region.slices().empty() || begin >= store.size()) return;
  share(pool, begin, store.size(), outcome, [&](std::size_t first, std::size_t last, ListResult& of_range) {
    Collector collector(store, region, of_range);
    for (std::size_t at = first; at < last; at += kBlock) {
      collector.collect({std::min(kBlock, last - at), nullptr, {}, collector.dead()}, at);
    }
  });
}

void tidy(ListResult& outcome) {
  for (std::vector<std::uint32_t>* list : {&outcome.dead, &outcome.left, &outcome.hits}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  std::erase_if(outcome.left,
                [&](std::uint32_t p) { return std::binary_search(outcome.dead.begin(), outcome.dead.end(), p); });
}

}  // namespace motes::program
