#include "recording/program.h"

#include <algorithm>
#include <array>

#include "particles/schema.h"
#include "particles/streams.h"
#include "simd/float_mode.h"

namespace motes::recording {
namespace {

using particles::kBlock;
using particles::Store;

bool turns(const Store& store) {
  const std::array<float, 3> spin = store.uniform_value(particles::rotational_velocity);
  return !store.uniform(particles::rotational_velocity) || spin[0] != 0 || spin[1] != 0 || spin[2] != 0;
}

// What an action touches in this store: without spin, move leaves the orientations alone.
std::uint32_t drop_turning(const actions::Action& action, const Store& store, std::uint32_t mask) {
  const bool still = action.kind == actions::Kind::move && (action.numbers[0] == 0 || !turns(store));
  return still ? mask & ~(1u << particles::up | 1u << particles::rotational_velocity) : mask;
}

// The planes of the attributes that a program touches, at a block's first particle. A uniform attribute that is only
// read is a page of its value.
class Planes {
 public:
  Planes(Store& store, std::uint32_t touched) : current_(static_cast<std::size_t>(store.schema().components())) {
    for (int a = 0; a < particles::builtin_count; ++a) {
      if ((touched >> a & 1u) == 0) continue;
      const particles::Attribute& attribute = store.schema()[a];
      for (int c = 0; c < attribute.width; ++c) {
        const auto at = static_cast<std::size_t>(attribute.first_component + c);
        if (store.uniform(a)) {
          pages_.emplace_back(kBlock + particles::kPadding, store.uniform_value(a)[static_cast<std::size_t>(c)]);
          current_[at] = pages_.back().data();
        } else {
          moving_.push_back({at, store.writable_plane(a, c)});
        }
      }
    }
  }

  float* const* at(std::size_t particle) {
    for (const auto& [component, plane] : moving_) current_[component] = plane + particle;
    return current_.data();
  }

 private:
  std::vector<float*> current_;
  std::vector<std::pair<std::size_t, float*>> moving_;
  std::vector<std::vector<float>> pages_;
};

// Room for one more block's indices; the collector reports how many it used.
void collect(const actions::Block& block, const float* axis, const Slice& slice, std::size_t base, Outcome& outcome) {
  const std::size_t dead = outcome.dead.size();
  const std::size_t left = outcome.left.size();
  static thread_local std::array<std::uint32_t, kBlock> dead_here;
  static thread_local std::array<std::uint32_t, kBlock> left_here;
  std::size_t dead_count = 0;
  std::size_t left_count = 0;
  actions::kernels().collect(block, axis, slice.low, slice.high, static_cast<std::uint32_t>(base), dead_here.data(),
                             dead_count, left_here.data(), left_count);
  outcome.dead.resize(dead + dead_count);
  outcome.left.resize(left + left_count);
  std::copy_n(dead_here.data(), dead_count, outcome.dead.data() + dead);
  std::copy_n(left_here.data(), left_count, outcome.left.data() + left);
}

}  // namespace

Program::Program(std::vector<actions::Action> list, std::uint32_t place) : list_(std::move(list)), place_(place) {}

std::vector<Program::Operation> Program::bind(Store& store) const {
  std::vector<Operation> operations;
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const actions::Action& action = list_[i];
    const actions::Parameters parameters{action.numbers.data(), action.shapes.data(),
                                         action.kind == actions::Kind::move && action.numbers[0] != 0 && turns(store)};
    operations.push_back({actions::kernels().action[static_cast<std::size_t>(action.kind)], parameters,
                          particles::action + place_ + static_cast<std::uint32_t>(i)});
  }
  return operations;
}

void Program::run(Store& store, std::size_t begin, std::size_t entry, const Span& span, particles::Key key,
                  const Slice& slice, Outcome& outcome) const {
  if (list_.empty() || begin >= store.size()) return;
  const simd::FloatMode mode;
  std::uint32_t reads = 0;
  std::uint32_t writes = 0;
  for (const actions::Action& action : list_) {
    reads |= drop_turning(action, store, actions::facts(action.kind).reads);
    writes |= drop_turning(action, store, actions::facts(action.kind).writes);
  }
  for (int a = 0; a < particles::builtin_count; ++a) {
    if ((writes >> a & 1u) != 0) store.writable_plane(a, 0);
  }
  const std::vector<Operation> operations = bind(store);
  Planes planes(store, reads | writes);
  const float* axis = store.plane(particles::position, slice.axis);
  const float dt = static_cast<float>(span.dt / span.substeps);
  std::array<std::int32_t, kBlock + particles::kPadding> dead{};

  for (std::size_t at = begin; at < store.size(); at += kBlock) {
    const std::size_t count = std::min(kBlock, store.size() - at);
    const actions::Block block{count, planes.at(at), store.ids() + at, dead.data()};
    for (int substep = span.first; substep < span.substeps; ++substep) {
      const auto step = static_cast<std::uint32_t>(span.frame * static_cast<std::uint64_t>(span.substeps)) +
                        static_cast<std::uint32_t>(substep);
      for (std::size_t o = substep == span.first ? entry : 0; o < operations.size(); ++o) {
        const Operation& operation = operations[o];
        operation.kernel(operation.parameters, block, {dt, step, operation.stream, key});
      }
    }
    collect(block, axis == nullptr ? nullptr : axis + at, slice, at, outcome);
    dead.fill(0);
  }
}

void Program::find_leavers(const Store& store, std::size_t begin, const Slice& slice, Outcome& outcome) {
  const float* axis = store.plane(particles::position, slice.axis);
  if (axis == nullptr) return;
  std::array<std::int32_t, kBlock + particles::kPadding> dead{};
  for (std::size_t at = begin; at < store.size(); at += kBlock) {
    const actions::Block block{std::min(kBlock, store.size() - at), nullptr, nullptr, dead.data()};
    collect(block, axis + at, slice, at, outcome);
  }
}

}  // namespace motes::recording
