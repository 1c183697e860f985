#include "image/project/projector.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/fields.h"
#include "base/invalid_argument.h"
#include "base/memory.h"
#include "image/camera.h"
#include "image/checks.h"
#include "image/footprint.h"
#include "image/mesh_corners.h"

namespace motes::image {
namespace {

// Extra numbers per array, because whole vectors are stored; they also keep a cache line between arrays.
constexpr std::size_t kSlack = 32;

// Returns the number of particles per batch. Its projected columns and its records (some 900 kB) stay in the
// second-level cache, so neither sorting nor the many streams of tiles touch main memory. Images of very many tiles
// need longer batches, or the offsets would outweigh the records. `particle_bytes`: of columns and records together.
std::size_t batch_size(std::size_t particle_bytes, int tiles) {
  constexpr std::size_t kBytes = 14 << 16, kWhole = 4096;
  return std::max(kBytes / particle_bytes / kWhole * kWhole, 16 * static_cast<std::size_t>(tiles));
}

// Takes arrays from a buffer, one after another.
class Columns {
 public:
  // `stride`: numbers per array; `most`: arrays of 32-bit numbers for which there is room.
  Columns(Buffer& memory, std::size_t stride, std::size_t most) : stride_(stride) {
    memory.resize(4 * most * stride);
    next_ = memory.data();
  }
  template <class Number>
  Number* take(bool wanted = true, std::size_t columns = 1) {
    if (!wanted) return nullptr;
    return reinterpret_cast<Number*>(std::exchange(next_, next_ + columns * stride_ * sizeof(Number)));
  }

 private:
  std::byte* next_;
  std::size_t stride_;
};

ProjectedBatch columns_for(std::size_t stride, bool with_depth, bool with_velocity, Buffer& memory) {
  Columns all(memory, stride, 8);
  ProjectedBatch batch{};
  batch.position = all.take<std::uint32_t>();
  batch.color = all.take<std::uint32_t>();
  batch.depth = all.take<std::uint32_t>(with_depth);
  batch.velocity = all.take<std::uint32_t>(with_velocity, 3);
  batch.velocity_stride = stride;
  batch.several = all.take<std::uint32_t>();
  batch.tile = all.take<std::uint16_t>();
  return batch;
}

template <std::size_t kCount>
void copy(const Vector& from, float (&to)[kCount]) {
  for (std::size_t i = 0; i < kCount; ++i) to[i] = static_cast<float>(from[i]);
}

// Converts a lens to single precision. `unit`: units of positions per px.
LensLanes lens_lanes(const Lens& lens, int unit) {
  LensLanes lanes{};
  copy(lens.eye, lanes.eye);
  copy(lens.right, lanes.right);
  copy(lens.up, lanes.up);
  copy(lens.forward, lanes.forward);
  lanes.scale = static_cast<float>(lens.focal_px * unit);
  return lanes;
}

// Makes a task with the values that both kinds of projection need.
template <class Task>
Task task_of(const Drawn& particles, const Sprite& sprite, const View& view, int unit) {
  Task t{};
  t.now = lens_lanes(lens(view), unit);
  for (std::size_t i = 0; i < 3; ++i) {
    t.position[i] = particles.position[i];
    t.color[i] = particles.color[i];
    t.color_of_all[i] = particles.color_of_all[i];
    t.velocity[i] = particles.velocity[i];
    t.velocity_of_all[i] = particles.velocity_of_all[i];
  }
  t.alpha = particles.alpha;
  t.alpha_of_all = particles.alpha_of_all;
  t.dark = sprite.blend == Sprite::Blend::add ? 0 : 0xffffffu;
  t.near = static_cast<float>(view.camera.near);
  t.width = view.width;
  t.height = view.height;
  return t;
}

ProjectTask fixed_task(const Drawn& particles, const Sprite& sprite, const View& view) {
  const Grid grid{view.width, view.height};
  const int unit = 1 << grid.sub_bits();
  auto t = task_of<ProjectTask>(particles, sprite, view, unit);
  t.sub_bits = grid.sub_bits();
  t.columns = grid.columns();
  t.footprint = footprint_size(sprite, view.height);
  // Half the image and 12 px, more than half of the largest footprint; below 32768 (see Grid::sub_bits).
  t.limit_x = static_cast<float>((grid.width + 1) / 2 * unit + 12 * unit);
  t.limit_y = static_cast<float>((grid.height + 1) / 2 * unit + 12 * unit);
  return t;
}

// Computes the quaternion of the rotation from the world's axes to those of a camera: right, up and back.
void set_turn(const Lens& lens, float (&turn)[4]) {
  const Vector rows[3] = {lens.right, lens.up, lens.forward * -1.0};
  // Start from the greatest of the four squares, to avoid a division by nearly 0 (Shepperd).
  const double x = rows[0][0], y = rows[1][1], z = rows[2][2];
  const double squares[4] = {1 + x - y - z, 1 - x + y - z, 1 - x - y + z, 1 + x + y + z};
  const auto greatest = static_cast<std::size_t>(std::max_element(squares, squares + 4) - squares);
  const double xy = rows[0][1] + rows[1][0], xz = rows[0][2] + rows[2][0], yz = rows[1][2] + rows[2][1];
  const double xw = rows[2][1] - rows[1][2], yw = rows[0][2] - rows[2][0], zw = rows[1][0] - rows[0][1];
  const double products[4][4] = {
      {squares[0], xy, xz, xw}, {xy, squares[1], yz, yw}, {xz, yz, squares[2], zw}, {xw, yw, zw, squares[3]}};
  const double scale = 0.5 / std::sqrt(squares[greatest]);
  for (std::size_t c = 0; c < 4; ++c) turn[c] = static_cast<float>(products[greatest][c] * scale);
}

void set_pose(const Drawn& particles, const Sprite& sprite, const View& view, WideTask& t) {
  t.posed = is_posed(sprite);
  t.breadth = 1;
  if (!t.posed) return;
  t.along_velocity = along_velocity(sprite);
  std::copy_n(particles.orientation.begin(), 4, t.orientation);
  std::copy_n(particles.orientation_of_all.begin(), 4, t.orientation_of_all);
  std::copy_n(particles.spin.begin(), 3, t.spin);
  std::copy_n(particles.spin_of_all.begin(), 3, t.spin_of_all);
  const auto* card = sprite.as<CardSprite>();
  t.toward_camera = card != nullptr && card->facing == Facing::camera;
  set_turn(lens(view), t.camera_turn);
  const bool mesh = sprite.is(Sprite::Kind::mesh);
  t.breadth = mesh ? 2 * reach_of_mesh(sprite.asset()) : 1;
  t.diagonal = mesh ? 1.0f : 1.4143f;
}

WideTask wide_task(const Drawn& particles, const Sprite& sprite, const View& view, double dt) {
  auto t = task_of<WideTask>(particles, sprite, view, 1 << kWideBits);
  t.size = particles.size;
  t.size_of_all = particles.size_of_all;
  for (std::size_t i = 0; i < 3; ++i) {
    t.up[i] = particles.up[i];
    t.up_of_all[i] = particles.up_of_all[i];
  }
  t.then = lens_lanes(lens_at_opening(view), 1 << kWideBits);
  t.streaks = view.shutter > 0;
  t.open = static_cast<float>(view.shutter * dt);
  t.diameter = diameter_of(sprite, view.height);
  t.opaque = sprite.blend == Sprite::Blend::opaque;
  if (blurs_in_painter(sprite)) {
    t.lens_focus = static_cast<float>(view.camera.focus);
    t.lens_blur = static_cast<float>(0.5 * blur_of(view)) * static_cast<float>(1 << kWideBits);
  } else {
    t.focus = static_cast<float>(view.camera.focus);
    t.blur = static_cast<float>(blur_of(view)) * static_cast<float>(1 << kSizeBits);
  }
  t.oriented = sprite.is(Sprite::Kind::image);
  t.tiles = sprite.tiled() ? static_cast<int>(sprite.sheet()->tiles.count) : 1;
  t.tile = particles.tile;
  t.ids = particles.ids;
  set_pose(particles, sprite, view, t);
  // Half the image, plus the reach of the largest sprite when turned.
  const int blurred = t.lens_blur > 0 ? static_cast<int>(kMostPosedReach) : 0;
  const int reach = t.posed ? static_cast<int>(kMostPosedReach) + 2 : kMaxDiameter * 182 / 256 + 2 + blurred;
  t.limit_x = static_cast<float>(((view.width + 1) / 2 + reach) << kWideBits);
  t.limit_y = static_cast<float>(((view.height + 1) / 2 + reach) << kWideBits);
  return t;
}

// Returns an upper bound on the alpha of records. It is 255 if each particle has its own alpha, because searching for
// the greatest one costs more than it saves, and for additive particles, because records of bright colours have a
// greater alpha than their particles (see share_light()).
std::uint8_t most_alpha(const Drawn& particles, const Sprite& sprite) {
  const bool own = particles.alpha != nullptr || sprite.blend == Sprite::Blend::add;
  if (own || !(particles.alpha_of_all < 1)) return 255;
  return static_cast<std::uint8_t>(std::ceil(255 * std::max(particles.alpha_of_all, 0.0f)));
}

// Sets the colour that all records of a message have.
void say_color(std::uint32_t color, RecordsHead& head) {
  head.color = color;
  head.most_alpha = static_cast<std::uint8_t>(color >> 24);
}

// Returns the sprite as painters see it: points are discs where they may be out of focus, unless they are opaque, and
// through a lens each record has its size.
Sprite sprite_of_records(const Sprite& sprite, const View& view) {
  Sprite sent = painted(sprite);
  const bool blurred = view.camera.aperture > 0;
  const bool widened = blurred && sprite.blend != Sprite::Blend::opaque;
  if (drawn_as_point(sprite)) sent.look = widened ? Sprite::Kind::disc : Sprite::Kind::point, sent.finish = {};
  if (drawn_as_point(sent)) sent.pixels = 1;
  if (blurred) sent.pixels = 0, sent.of_height = 0;
  return sent;
}

// Appends the fields of a sprite, and zeros, so that records are as aligned as the head.
void put_sprite(const Sprite& sprite, Buffer& buffer, RecordsHead& head) {
  base::Bytes bytes;
  base::write_fields(sprite, bytes);
  constexpr std::size_t kAligned = RecordsHead::kAligned;
  head.sprite_bytes = static_cast<std::uint32_t>((bytes.size() + kAligned - 1) / kAligned * kAligned);
  buffer.resize(sizeof head + head.sprite_bytes);
  std::fill_n(buffer.data() + sizeof head, head.sprite_bytes, std::byte{0});
  std::memcpy(buffer.data() + sizeof head, bytes.data(), bytes.size());
}

RecordsHead head_of(const Sprite& sprite, const View& view, const Projection& projection) {
  const Grid grid{view.width, view.height};
  RecordsHead head;
  head.system = static_cast<std::uint32_t>(projection.system);
  head.layout = static_cast<std::uint8_t>(layout(sprite, view, projection.any_depth));
  head.with_velocity = with_velocity(sprite, view);
  const bool in_order = projection.in_order || in_order_of_depth({&sprite, 1});
  head.colored = in_order || !may_lack_color(static_cast<Layout>(head.layout)) ? 1 : 0;
  head.width = view.width;
  head.height = view.height;
  head.slots = static_cast<std::uint32_t>(grid.tiles());
  return head;
}

RecordForm form_of(const RecordsHead& head) { return form(static_cast<Layout>(head.layout), head.colored != 0); }

std::size_t bytes_of(const RecordsHead& head) {
  return static_cast<std::size_t>(form_of(head).bytes) + (head.with_velocity != 0 ? kVelocityBytes : 0);
}

}  // namespace

void Projector::project(const Drawn& particles, const Sprite& sprite, const View& view, Records& records,
                        const Projection& projection) {
  check(view);
  check(sprite);
  for (const float* plane : particles.position) {
    if (plane == nullptr && particles.count != 0) throw base::InvalidArgument("position", "have three planes");
  }
  if (sprite.tiled() && particles.count != 0 && particles.tile == nullptr && particles.ids.lower == nullptr) {
    throw base::InvalidArgument("ids", "be given where tiles are chosen at random");
  }
  slots_ = projection.slots;
  if (slots_ != nullptr && !slots_->fits(Grid{view.width, view.height}.tiles())) {
    throw base::InvalidArgument("slots", "list each tile of the view");
  }
  sprite_ = sprite;
  records.head_ = head_of(sprite, view, projection);
  records.head_.most_alpha = most_alpha(particles, sprite);
  put_sprite(sprite_of_records(sprite, view), records.buffer_, records.head_);
  if (sprite.is(Sprite::Kind::ribbon)) {
    project_ribbons(particles, projection, view, records);
  } else if (!of_fixed_size(static_cast<Layout>(records.head_.layout))) {
    project_wide(particles, projection, view, records);
  } else {
    project_fixed(particles, projection, view, records);
  }
  std::memcpy(records.buffer_.data(), &records.head_, sizeof records.head_);
}

// Replaces the colours of particles first .. last - 1 by their lit colours.
void Projector::light(const Drawn& particles, const Projection& projection, std::size_t first, std::size_t last,
                      SeenTask& task) {
  if (projection.light == nullptr) return;
  const std::size_t stride = last - first + kSlack;
  lit_.resize(4 * stride);
  projection.light->light(particles, first, last, lit_.data(), stride);
  for (std::size_t c = 0; c < 3; ++c) task.color[c] = lit_.data() + c * stride - first;
}

void Projector::project_fixed(const Drawn& particles, const Projection& projection, const View& view,
                              Records& records) {
  const Grid grid{view.width, view.height};
  const auto tiles = static_cast<std::size_t>(grid.tiles()), columns = static_cast<std::size_t>(grid.columns());
  ProjectTask task = fixed_task(particles, sprite_, view);
  light(particles, projection, 0, 0, task);
  if (!task.one_color()) records.head_.colored = 1;
  const std::size_t record_bytes = bytes_of(records.head_);
  const bool with_depth = records.head_.layout != static_cast<std::uint8_t>(Layout::plain);
  const bool with_velocity = records.head_.with_velocity != 0, one_color = task.one_color();
  // The column of particles that touch several tiles is not counted: it is short.
  const std::size_t column_bytes = (one_color ? 6 : 10) + (with_depth ? 4 : 0) + (with_velocity ? 12 : 0);
  const std::size_t step = batch_size(column_bytes + record_bytes, grid.tiles());
  for (std::size_t first = 0; first < particles.count; first += step) {
    const std::size_t last = std::min(first + step, particles.count);
    const std::size_t stride = last - first + kSlack;
    const ProjectedBatch batch = columns_for(stride, with_depth, with_velocity, projected_);
    light(particles, projection, first, last, task);
    const ProjectedCount number = lanes_->project(task, first, last, batch);
    if (number.visible == 0) continue;
    const Touched touched{batch.tile, batch.several, number.visible, number.several, columns};
    count(touched, tiles, record_bytes, records);
    std::byte* to = open_batch(tiles, record_bytes, number.visible, records);
    if (one_color) say_color(batch.color[0], records.head_);
    const Colors colors = !one_color ? Colors::each : records.head_.colored != 0 ? Colors::same : Colors::none;
    scatter_fixed(batch, colors, number.visible, cursor_.data(), further_.all(), to);
  }
}

void Projector::project_wide(const Drawn& particles, const Projection& projection, const View& view, Records& records) {
  const Grid grid{view.width, view.height};
  const auto tiles = static_cast<std::size_t>(grid.tiles()), columns = static_cast<std::size_t>(grid.columns());
  WideTask task = wide_task(particles, sprite_, view, projection.dt);
  light(particles, projection, 0, 0, task);
  if (!task.one_color()) records.head_.colored = 1;
  const std::size_t record_bytes = bytes_of(records.head_);
  task.form = form_of(records.head_);
  task.columns = grid.columns();
  task.bits = grid.far_bits();
  task.pick = projection.pick;
  const bool gains = projection.light != nullptr && projection.light->has_gain();
  const auto words = static_cast<std::size_t>(task.form.bytes) / 4;
  const std::size_t step = batch_size(4 * words + 2 + record_bytes, grid.tiles());
  for (std::size_t first = 0; first < particles.count; first += step) {
    const std::size_t last = std::min(first + step, particles.count);
    const std::size_t stride = last - first + kSlack;
    Columns all(projected_, stride, words + 9);
    WideBatch batch{};
    batch.words = all.take<std::uint32_t>(true, std::max(words, kFour * fours_of(words)));
    batch.stride = stride;
    batch.boxes = task.lens_blur > 0;
    batch.velocity = all.take<std::uint32_t>(records.head_.with_velocity != 0, 3);
    batch.several = all.take<std::uint32_t>();
    batch.many = all.take<ManyTiles>();
    batch.tile = all.take<std::uint16_t>();
    light(particles, projection, first, last, task);
    if (gains) task.gain = task.color[2] + stride;
    const WideCount number = wide_lanes_->project(task, first, last, batch);
    if (number.visible == 0) continue;
    const Touched touched{batch.tile, batch.several, number.visible, number.several, columns};
    count(touched, tiles, record_bytes, records);
    count_many(batch, number.many, task.form, grid, cursor_.data(), further_);
    std::byte* to = open_batch(tiles, record_bytes, number.visible, records);
    if (task.one_color()) say_color(number.color, records.head_);
    scatter_wide(batch, number.visible, words, cursor_.data(), further_.all(), to);
  }
}

// Returns the colours of particles first .. last - 1 at all points of their ribbons.
RibbonLight Projector::ribbon_light(const Drawn& particles, const Projection& projection, std::size_t first,
                                    std::size_t last) {
  if (projection.light == nullptr) return {};
  const std::size_t stride = last - first + kSlack;
  lit_.resize(3 * (kMostPast + 1) * stride);
  projection.light->light(particles, first, last, lit_.data(), stride);
  Drawn before = particles;
  for (std::size_t k = 0; k < kMostPast; ++k) {
    before.position = particles.past[k].position;
    if (before.position[0] == nullptr) continue;
    projection.light->light(before, first, last, lit_.data() + 3 * (k + 1) * stride, stride);
  }
  return {lit_.data(), stride};
}

void Projector::project_ribbons(const Drawn& particles, const Projection& projection, const View& view,
                                Records& records) {
  constexpr std::size_t kTogether = 4096;
  const auto tiles = static_cast<std::size_t>(Grid{view.width, view.height}.tiles());
  const std::size_t record_bytes = bytes_of(records.head_);
  const bool with_velocity = records.head_.with_velocity != 0;
  const std::size_t step = std::max(kTogether, tiles / 16 * 16);
  for (std::size_t first = 0; first < particles.count; first += step) {
    const std::size_t last = std::min(first + step, particles.count);
    const RibbonLight light = ribbon_light(particles, projection, first, last);
    image::project_ribbons(particles, sprite_, view, view.shutter * projection.dt, light, first, last, ribbons_);
    if (ribbons_.records.empty()) continue;
    cursor_.assign(tiles, 0);
    for (const FurtherTile& one : ribbons_.tiles) ++cursor_[one.tile];
    std::byte* const to = open_batch(tiles, record_bytes, ribbons_.tiles.size(), records);
    for (const FurtherTile& one : ribbons_.tiles) {
      std::byte* const record = to + cursor_[one.tile]++ * record_bytes;
      std::memcpy(record, &ribbons_.records[one.particle], sizeof(RibbonRecord));
      for (std::size_t c = 0; with_velocity && c < 3; ++c) {
        const float* plane = particles.velocity[c];
        const float v = plane != nullptr ? plane[ribbons_.particles[one.particle]] : particles.velocity_of_all[c];
        const float finite = std::isfinite(v) ? v : 0;
        std::memcpy(record + sizeof(RibbonRecord) + 4 * c, &finite, sizeof finite);
      }
    }
  }
}

// Counts the records of each tile, and prefetches the memory of one record per visible particle.
void Projector::count(const Touched& touched, std::size_t tiles, std::size_t record_bytes, Records& records) {
  cursor_.assign(tiles, 0);
  const std::size_t at = records.buffer_.size() + 4 * (tiles + 1);
  records.buffer_.reserve(at + touched.visible * record_bytes);
  count_tiles(touched, cursor_.data(), further_, records.buffer_.data() + at, record_bytes);
}

// Makes room for as many records as cursor_ counts, and turns its counts into indices of each tile's first record.
// Returns the memory of the records. `asked`: number of records whose memory has been prefetched.
std::byte* Projector::open_batch(std::size_t tiles, std::size_t record_bytes, std::size_t asked, Records& records) {
  offsets_.resize(tiles + 1);
  std::uint32_t total = 0;
  for (std::size_t slot = 0; slot < tiles; ++slot) {
    const std::size_t tile = slots_ == nullptr ? slot : static_cast<std::size_t>(slots_->tile(static_cast<int>(slot)));
    offsets_[slot] = total;
    total += std::exchange(cursor_[tile], total);
  }
  offsets_[tiles] = total;
  const std::size_t offset_bytes = 4 * (tiles + 1);
  const std::size_t at = records.buffer_.size();
  records.buffer_.resize(at + offset_bytes + total * record_bytes);
  std::byte* to = records.buffer_.data() + at;
  std::memcpy(to, offsets_.data(), offset_bytes);
  to += offset_bytes;
  if (total > asked) base::prefetch_for_write(to + asked * record_bytes, (total - asked) * record_bytes);
  ++records.head_.batches;
  records.head_.records += total;
  return to;
}

}  // namespace motes::image
