// A snapshot: a world between two frames, as bytes. It holds the state that all ranks share, and each calculator's
// particles (snapshots/part.h). The world continues from it with the same bits on any number of ranks, in any roles,
// with any cuts. Clocks restart; domains stay if their number is unchanged.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/log/alarms.h"
#include "engine/parts/parts.h"
#include "snapshots/part.h"

namespace motes::engine {

/// The state of a system that all ranks share. Its axes and space may differ when the world continues.
struct SharedSystem {
  std::string name;
  std::uint64_t capacity = 0;
  std::vector<recording::UserAttribute> attributes;
  Counts counts;
  std::vector<recording::SourceTotal> sources;
  bool keeps_copies = false;
  BirthHistory history;
  std::vector<shapes::Shape> walls;  // System::walls_before
  domains::Axes axes;
  std::vector<domains::Cut> cuts;
  std::optional<image::Sprite> sprite;  // if the script has changed it since it made the system
};

template <class Visitor>
constexpr void fields(Visitor& visit, SharedSystem& system) {
  visit(system.name, system.capacity, system.attributes, system.counts, system.sources, system.keeps_copies,
        system.history, system.walls, system.axes, system.cuts, system.sprite);
}

/// State that only the manager has, saved so that balancing continues and no warning is repeated.
struct ManagerState {
  std::vector<std::uint64_t> evaluations;  // one per system: Balancing::evaluations
  Alarms alarms;
};

template <class Visitor>
constexpr void fields(Visitor& visit, ManagerState& state) {
  visit(state.evaluations, state.alarms);
}

struct SharedState {
  std::uint64_t frame = 0;  // the next frame
  std::uint64_t seed = 0;
  double dt = 0;
  int substeps = 1;
  std::vector<SharedSystem> systems;
  std::optional<image::Camera> camera;  // camera of the last picture
  std::uint64_t camera_frame = 0;
  std::optional<image::Camera> camera_before;  // the camera before that, for its streaks
  ManagerState manager;  // empty if not written by the manager
  std::vector<PressedWall> walls;
};

template <class Visitor>
constexpr void fields(Visitor& visit, SharedState& state) {
  visit(state.frame, state.seed, state.dt, state.substeps, state.systems, state.camera, state.camera_frame,
        state.camera_before, state.manager, state.walls);
}

/// A sample of a system's positions from which new domains are made: x, y and z of equal length, in metres.
using Sample = std::array<std::vector<float>, 3>;

SharedState shared_state(const Parts& parts);

/// Writes the state for a file, with the meshes that a continuing process needs.
void write(const SharedState& state, base::Bytes& out);
/// Reads a state and registers its meshes in this process. Throws std::runtime_error if the bytes are not a state.
SharedState read_state(std::span<const std::byte> bytes);

/// Describes this calculator's particles and measured speeds; appends the planes to `out`.
snapshots::Description copy_part(const Rank& rank, const Script& script, const Calculator& calculator,
                                 base::Bytes& out);

/// Adds about `most` of a system's positions in a part to `sample`.
void take_sample(const snapshots::Description& description, std::span<const std::byte> planes, std::size_t system,
                 std::size_t most, Sample& sample);

/// Restores the state of systems that are defined as when it was saved; restore_rows() then adds their particles. The
/// state must be the same on all ranks, except for ManagerState. Throws std::runtime_error if the state is of other
/// systems, another seed or another time step.
void restore_state(Parts& parts, const SharedState& state, const std::vector<Sample>& samples);

/// Adds particles first .. last - 1 of a system in a part to this calculator; those that belong to others migrate in
/// the next frame's exchange.
void restore_rows(const Rank& rank, const Calculator& calculator, const snapshots::Description& description,
                  std::span<const std::byte> planes, std::size_t system, std::uint64_t first, std::uint64_t last);

/// Restores the measured speeds of the calculator that saved a part.
void restore_speeds(const Calculator& calculator, const snapshots::Description& description);

}  // namespace motes::engine
