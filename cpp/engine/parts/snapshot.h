// A snapshot: a world between two frames, as bytes. It holds what all ranks know, and each calculator's particles
// (snapshots/part.h). The world can go on from it with the same bits on any number of ranks, in any roles, with any
// cuts. Clocks start anew; domains stay if their number is unchanged.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/log/alarms.h"
#include "engine/parts/parts.h"
#include "snapshots/part.h"

namespace motes::engine {

/// A system as all ranks know it. Its axes and its space may be others when the world goes on.
struct SharedSystem {
  std::string name;
  std::uint64_t capacity = 0;
  std::vector<recording::UserAttribute> attributes;
  Counts counts;
  std::vector<recording::SourceTotal> sources;
  bool keeps_copies = false;
  BirthHistory history;
  domains::Axes axes;
  std::vector<domains::Cut> cuts;
};

template <class Visitor>
constexpr void fields(Visitor& visit, SharedSystem& system) {
  visit(system.name, system.capacity, system.attributes, system.counts, system.sources, system.keeps_copies,
        system.history, system.axes, system.cuts);
}

/// State of the manager alone, so that balancing continues and no warning is repeated.
struct ManagerState {
  std::vector<std::uint64_t> evaluations;  // one per system: Balancing::evaluations
  Alarms alarms;
};

template <class Visitor>
constexpr void fields(Visitor& visit, ManagerState& state) {
  visit(state.evaluations, state.alarms);
}

struct SharedState {
  std::uint64_t frame = 0;  // the next one to run
  std::uint64_t seed = 0;
  double dt = 0;
  int substeps = 1;
  std::vector<SharedSystem> systems;
  std::optional<image::Camera> camera;  // camera of the last picture
  std::uint64_t camera_frame = 0;
  ManagerState manager;  // empty where another rank describes the world
};

template <class Visitor>
constexpr void fields(Visitor& visit, SharedState& state) {
  visit(state.frame, state.seed, state.dt, state.substeps, state.systems, state.camera, state.camera_frame,
        state.manager);
}

/// Some of a system's positions, from which new domains are made: x, y and z, each of the same length.
using Sample = std::array<std::vector<float>, 3>;

SharedState shared_state(const Parts& parts);

/// Writes the state for a file, with the meshes that a continuing process needs.
void write(const SharedState& state, base::Bytes& out);
/// Throws std::runtime_error where the bytes are not such a state. From then on this process keeps its meshes.
SharedState read_state(std::span<const std::byte> bytes);

/// Describes this calculator's particles, and what is known of its speeds; appends the planes to `out`.
snapshots::Description copy_part(const Rank& rank, const Script& script, const Calculator& calculator,
                                 base::Bytes& out);

/// Adds up to `most` of the positions that a part holds of a system.
void take_sample(const snapshots::Description& description, std::span<const std::byte> planes, std::size_t system,
                 std::size_t most, Sample& sample);

/// The systems, defined as they were then, continue from this state; their particles follow by restore_rows(). Equal on
/// all ranks but for what the manager alone uses. Throws std::runtime_error where the state is not of these systems,
/// this seed or this step of time.
void restore_state(Parts& parts, const SharedState& state, const std::vector<Sample>& samples);

/// Particles first .. last - 1 that a part holds of a system are this calculator's from now on; those that belong to
/// others go there in the next frame's exchange.
void restore_rows(const Rank& rank, const Calculator& calculator, const snapshots::Description& description,
                  std::span<const std::byte> planes, std::size_t system, std::uint64_t first, std::uint64_t last);

/// This calculator continues the part of one that was as fast.
void restore_speeds(const Calculator& calculator, const snapshots::Description& description);

}  // namespace motes::engine
