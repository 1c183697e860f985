#include "image/raycast/prepared_scene.h"

#include "image/checks.h"
#include "image/tone.h"

namespace motes::image {

void PreparedScene::prepare(const View& view, std::size_t workers, const ShadowGrids* shadows) {
  check(view);
  const std::uint64_t before = scenery_.version();
  scenery_.prepare(view, workers, shadows);
  if (!prepared_ || scenery_.version() != before || view.exposure != view_.exposure) {
    tone_ = tone_table(view.exposure);
    ++version_;
  }
  view_ = view;
  grid_ = {view.width, view.height};
  prepared_ = true;
}

}  // namespace motes::image
