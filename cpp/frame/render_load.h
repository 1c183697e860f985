// What the manager learns of pictures from reports, and how its plan for the next one reaches all ranks.
#pragma once

#include <optional>
#include <vector>

#include "frame/manager.h"
#include "frame/rank.h"
#include "frame/render_plan.h"
#include "frame/script.h"

namespace motes::frame {

/// Manager: a round's reports tell the work of calculators in it, and with the first one what ranks did for the last
/// picture.
void note_pictures(const Rank& rank, const Script& script, const Round& round, const Judged& judged, RenderLoad& load);

/// What the image generator did with the tiles of other ranks, of a picture whose counts have been noted.
void note_assembly(const Drawings& drawn, int image_generator, RenderLoad& load);

/// Manager: the plan of the frame's picture, where it has one and this is its first round.
void put_plan(const Rank& rank, const Script& script, const Round& round, RenderLoad& load, particles::Bytes& out);
/// All ranks.
std::optional<RenderPlan> take_plan(particles::Reader& in);

}  // namespace motes::frame
