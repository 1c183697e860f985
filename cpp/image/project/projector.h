// Turns particles into records: projects, culls and sorts them by tile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/buffer.h"
#include "image/light/particle_light.h"
#include "image/project/project_lanes.h"
#include "image/project/project_ribbons.h"
#include "image/project/project_wide_lanes.h"
#include "image/project/records.h"
#include "image/project/sort_tiles.h"
#include "image/scene.h"
#include "image/slots.h"
#include "particles/streams.h"

namespace motes::image {

/// What a system's records depend on besides its sprite and the view. Equal on every rank.
struct Projection {
  int system = 0;                // its number, passed to the ranks that draw
  bool any_depth = false;        // see anything_hides()
  bool in_order = false;         // see in_order_of_depth()
  double dt = 0;                 // time per frame, s; determines the length of streaks
  const Slots* slots = nullptr;  // null: tile t is in slot t
  particles::DrawKey pick{};     // key of random tile numbers
  const ParticleLight* light = nullptr;  // null: particles have their own colours
};

/// Projects particles to records. Keeps its working memory from frame to frame.
class Projector {
 public:
  explicit Projector(const ProjectLanes& lanes = project_lanes(), const ProjectWideLanes& wide = project_wide_lanes())
      : lanes_(&lanes), wide_lanes_(&wide) {}

  /// Replaces the content of `records` by the records of `particles`, reusing its memory. Records carry no colours if
  /// all particles have the same colour and alpha and nothing requires a colour per record. Leaves out particles that
  /// are not finite, nearer than the camera's `near`, outside the image, without light, or of no width. Throws
  /// std::invalid_argument if view, sprite or slots are not valid, or a position plane is missing.
  void project(const Drawn& particles, const Sprite& sprite, const View& view, Records& records,
               const Projection& projection = {});

 private:
  void project_fixed(const Drawn& particles, const Projection& projection, const View& view, Records& records);
  void light(const Drawn& particles, const Projection& projection, std::size_t first, std::size_t last, SeenTask& task);
  void project_wide(const Drawn& particles, const Projection& projection, const View& view, Records& records);
  void project_ribbons(const Drawn& particles, const Projection& projection, const View& view, Records& records);
  RibbonLight ribbon_light(const Drawn& particles, const Projection& projection, std::size_t first, std::size_t last);
  void count(const Touched& touched, std::size_t tiles, std::size_t record_bytes, Records& records);
  std::byte* open_batch(std::size_t tiles, std::size_t record_bytes, std::size_t asked, Records& records);

  BufferOf<float> lit_;  // colours of a batch
  const ProjectLanes* lanes_;
  const ProjectWideLanes* wide_lanes_;
  Buffer projected_;
  RibbonBatch ribbons_;
  FurtherTiles further_;
  std::vector<std::uint32_t> cursor_;   // by tile: its number of records, then the index of its next record
  std::vector<std::uint32_t> offsets_;  // by slot
  Sprite sprite_;
  const Slots* slots_ = nullptr;  // of the current call
};

}  // namespace motes::image
