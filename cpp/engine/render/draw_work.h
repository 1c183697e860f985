// Runs a rank's work on a picture and reports insufficient memory.
#pragma once

#include <new>
#include <string>

#include "engine/session/rank.h"
#include "image/scene.h"

namespace motes::engine {

/// Thrown if a picture does not fit into a rank's memory.
class TooLarge : public std::bad_alloc {
 public:
  explicit TooLarge(const image::View& view)
      : text_("a picture of " + std::to_string(view.width) + "x" + std::to_string(view.height) +
              " pixels, with its scenery, light and layers, does not fit into the memory of a rank that draws it") {}
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

/// Runs work like Session::work, but reports insufficient memory as TooLarge, with the picture's size.
template <class Work>
void draw_work(Rank& rank, const image::View& view, const Work& draw) {
  rank.session.work("render", [&] {
    try {
      draw();
    } catch (const std::bad_alloc&) {
      throw TooLarge(view);
    }
  });
}

}  // namespace motes::engine
