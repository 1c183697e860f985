#include "engine/render/render_output.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/memory.h"

namespace motes::engine {
namespace {

using image::Area;
using image::TileLight;
using image::TilePainter;

// The content of a tile in a message: sums of light if the picture's light is kept, otherwise sRGB.
enum class Content : std::uint8_t {
  one_color,  // always the sums of one pixel: sRGB is dithered
  pixels,
  drawn_one_color,  // no pixels in the message: they are in shared memory
  drawn_pixels
};

std::size_t lanes(const Area& area) {
  return 3 * static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height);
}

std::size_t first_pixel(const Area& area, std::size_t row) {
  return static_cast<std::size_t>(area.y) * row + 3 * static_cast<std::size_t>(area.x);
}

std::size_t row_of(const image::View& view) { return 3 * static_cast<std::size_t>(view.width); }

}  // namespace

// Splits a rank's part of the picture into messages: one if it is below 2 * kBytes, otherwise several of at least
// kBytes each, not counting what blank tiles save.
std::vector<Parcel> parcels_of(const RenderPlan& plan, int rank, const image::View& view) {
  constexpr double kBytes = 1 << 19;
  const int first = plan.first(rank), tiles = plan.end(rank) - first;
  const double pixel = view.linear ? sizeof(std::uint32_t) : sizeof(std::uint8_t);
  const double bytes = 3 * pixel * view.width * view.height * tiles / image::Grid{view.width, view.height}.tiles();
  const int parcels = std::clamp(static_cast<int>(bytes / kBytes), 1, std::max(1, tiles));
  std::vector<Parcel> all;
  for (int i = 0; i < parcels; ++i) all.push_back({first + tiles * i / parcels, first + tiles * (i + 1) / parcels});
  return all;
}

TileOutput::TileOutput(const Rank& rank, const image::View& view, Painter& painter)
    : view_(view), painter_(painter),
      shared_(rank.session.draws() ? nullptr : painter.shared.find(rank.session.stamp())) {}

std::size_t TileOutput::at(int slot) const { return first_pixel(painter_.area(slot), row_of(view_)); }

void TileOutput::show(const TilePainter& by, const TileLight& light, int slot) const {
  if (view_.linear) {
    light.copy_to(painter_.whole.at(painter_.area(slot)), row_of(view_));
  } else {
    by.show(light, painter_.pixels.data() + at(slot), row_of(view_));
  }
}

void TileOutput::put(const TilePainter& by, const TileLight& light, int slot, bool blank, base::Bytes& out) const {
  if (shared_ == nullptr) {
    out.put(blank ? Content::one_color : Content::pixels);
    return put_pixels(by, light, blank, out);
  }
  out.put(blank ? Content::drawn_one_color : Content::drawn_pixels);
  if (view_.linear) {
    light.copy_to(reinterpret_cast<std::uint32_t*>(shared_) + at(slot), row_of(view_));
  } else {
    by.show(light, shared_ + at(slot), row_of(view_));
  }
}

void TileOutput::put_pixels(const TilePainter& by, const TileLight& light, bool blank, base::Bytes& out) const {
  const std::size_t row = 3 * static_cast<std::size_t>(light.width), all = row * static_cast<std::size_t>(light.height);
  if (blank) {
    out.put_raw(light.first, 3 * sizeof(std::uint32_t));
  } else if (view_.linear) {
    std::vector<std::uint32_t> sums(all);
    light.copy_to(sums.data(), row);
    out.put_raw(sums.data(), all * sizeof(std::uint32_t));
  } else {
    by.show(light, reinterpret_cast<std::uint8_t*>(out.extend(all)), row);
  }
}

bool take_tile(base::Reader& in, int slot, const image::View& view, bool shared, Painter& painter) {
  const Area area = painter.area(slot);
  const std::size_t row = 3 * static_cast<std::size_t>(area.width);
  const auto content = in.get<Content>();
  const Content last = shared ? Content::drawn_pixels : Content::pixels;
  if (content > last) {
    throw std::runtime_error("a tile's content must be 0.." + std::to_string(static_cast<int>(last)) + ", got " +
                             std::to_string(static_cast<int>(content)));
  }
  const bool blank = content == Content::one_color || content == Content::drawn_one_color;
  if (content >= Content::drawn_one_color) return blank;
  if (blank) {
    std::array<std::uint32_t, 3 * image::kTile> sums;
    std::memcpy(sums.data(), in.take(3 * sizeof(std::uint32_t)).data(), 3 * sizeof(std::uint32_t));
    for (std::size_t i = 3; i < sums.size(); ++i) sums[i] = sums[i - 3];
    const TileLight light{sums.data(), 0, area.width, area.height, area.x, area.y};
    if (view.linear) {
      light.copy_to(painter.whole.at(area), row_of(view));
    } else {
      painter.workers[0].painter.show(light, painter.pixels.data() + first_pixel(area, row_of(view)), row_of(view));
    }
    return true;
  }
  const auto put = [&]<class T>(T* to) {
    const auto bytes = in.take(lanes(area) * sizeof(T));
    constexpr int kAhead = 8;  // rows
    for (int y = 0; y < area.height; ++y, to += row_of(view)) {
      if (y + kAhead < area.height) base::prefetch_for_write(to + kAhead * row_of(view), row * sizeof(T));
      std::memcpy(to, bytes.data() + static_cast<std::size_t>(y) * row * sizeof(T), row * sizeof(T));
    }
  };
  view.linear ? put(painter.whole.at(area)) : put(painter.pixels.data() + first_pixel(area, row_of(view)));
  return false;
}

void send_to_image_generator(Rank& rank, comm::Phase phase, comm::Message message, bool failed, Painter& painter) {
  Session& session = rank.session;
  painter.drawing.bytes += message.payload().size();
  session.comm().post(session.cast().image_generator, phase, session.stamp(), std::move(message), 0, failed);
}

}  // namespace motes::engine
