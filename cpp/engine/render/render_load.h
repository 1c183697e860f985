// Collects the load of pictures from reports, and sends the plan for the next one to all ranks.
#pragma once

#include <optional>
#include <vector>

#include "engine/render/render_plan.h"
#include "engine/session/rank.h"
#include "engine/session/reports.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Manager: a round's reports tell the work of calculators in it, and with the first one what ranks did for the last
/// picture.
void note_pictures(const Rank& rank, const Script& script, const Round& round, const Judged& judged, RenderLoad& load);

/// Notes the image generator's work on other ranks' tiles, for a picture whose counts are noted already.
void note_assembly(const Drawings& drawn, int image_generator, RenderLoad& load);

/// Manager: the plan of the frame's picture, where it has one and this is its first round.
void put_plan(const Rank& rank, const Script& script, const Round& round, RenderLoad& load, base::Bytes& out);
/// Reads the plan from *begin*, on all ranks.
std::optional<RenderPlan> take_plan(base::Reader& in);

}  // namespace motes::engine
