// render (paper 3.2.4): calculators project their particles and send what is visible; the image generator draws it with
// the external objects.
#pragma once

#include <cstdint>
#include <vector>

#include "frame/population.h"
#include "frame/rank.h"
#include "frame/script.h"
#include "image/canvas.h"
#include "image/projector.h"
#include "image/records.h"

namespace motes::frame {

/// Who draws: working memory of projecting and drawing, kept from frame to frame, and the last picture.
struct Painter {
  image::Projector projector;
  image::Records records;
  image::Canvas canvas;
  std::vector<std::uint8_t> pixels;

  /// The picture of the last frame, on the image generator: height * width * 3 bytes of sRGB, moved out.
  std::vector<std::uint8_t> take_pixels() { return std::move(pixels); }
  /// Its light, where the view keeps it: linear RGB, height * width * 3.
  std::vector<float> linear() const { return canvas.linear(); }
};

/// Draws the frame where its record has a view.
void render(Rank& rank, const Script& script, const Calculator& calculator, Painter& painter);

}  // namespace motes::frame
