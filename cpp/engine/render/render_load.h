// Collects the load of pictures from reports, and sends the plan for the next one to all ranks.
#pragma once

#include <optional>
#include <vector>

#include "engine/render/render_plan.h"
#include "engine/session/rank.h"
#include "engine/session/reports.h"
#include "engine/state/script.h"

namespace motes::engine {

/// Manager: notes the calculators' work in a round and, in the first round, all ranks' work on the last picture.
void note_pictures(const Rank& rank, const Script& script, const Round& round, const Judged& judged, RenderLoad& load);

/// Notes the image generator's time to assemble other ranks' tiles, for a picture whose counts are noted already.
void note_assembly(const Drawings& drawn, int image_generator, RenderLoad& load);

/// Manager: in the first round of a frame with a picture, plans the picture and appends the plan.
void put_plan(const Rank& rank, const Script& script, const Round& round, RenderLoad& load, base::Bytes& out);
/// Reads the plan from *begin*, on all ranks.
std::optional<RenderPlan> take_plan(base::Reader& in);

}  // namespace motes::engine
