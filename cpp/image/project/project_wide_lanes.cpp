// Compiled once for each instruction set: see simd/simd.h for the rules.
#include "image/project/project_wide_lanes.h"

#include "image/grid.h"
#include "image/layout.h"
#include "image/moments.h"
#include "image/project/screen_lanes.h"
#include "particles/random.h"
#include "simd/floats3.h"
#include "simd/rotations.h"
#include "simd/simd.h"

namespace motes::MOTES_ISA {
namespace {

constexpr int kUnit = 1 << image::kWideBits;                                    // 1 px in positions
constexpr float kSizeUnit = 1 << image::kSizeBits;                              // 1 px in sizes
constexpr float kNarrow = 2 * kSizeUnit;  // narrower sprites are drawn this wide, and fainter
constexpr float kWidest = static_cast<float>(image::kMostDiameter) * kSizeUnit;
constexpr float kMostUnlimited = 65536 * kSizeUnit;
constexpr int kUnitsPerSize = kUnit / (1 << image::kSizeBits);

// The part of a particle's path on the screen that may touch the image: from (x, y), the end of the path, back to
// (x + dx, y + dy), in 1/256 px; and the fraction of the particle's light there.
struct Way {
  Mask visible;
  Floats x, y, dx, dy, light;
};

// Narrows the part from..to of a path, 0..1, to what is within the limit.
MOTES_INLINE Mask clip(Floats at, Floats way, Floats limit, Floats& from, Floats& to) {
  const Mask moves = abs(way) >= 1.0f;
  const Floats scale = all(1.0f) / select(moves, way, all(1.0f));
  const Floats low = (-limit - at) * scale, high = (limit - at) * scale;
  from = max(from, only(moves, min(low, high)));
  to = min(to, select(moves, max(low, high), all(1.0f)));
  return moves | (abs(at) <= limit);
}

// Clamps to the limit, because clipping points far away leaves rounding errors.
MOTES_INLINE Floats within(Floats v, Floats limit) { return min(max(v, -limit), limit); }

MOTES_INLINE Floats3 vector_at(const float* const (&planes)[3], const float (&of_all)[3], std::size_t i) {
  return {load_or(planes[0], i, of_all[0]), load_or(planes[1], i, of_all[1]), load_or(planes[2], i, of_all[2])};
}

// The greatest distance of a sprite's middle from the middle of the image, 1/256 px.
struct Limit {
  Floats x, y;
};

MOTES_INLINE Way still(Limit limit, Floats x, Floats y, Mask visible) {
  const Floats none = all(0.0f);
  visible &= (abs(x) <= limit.x) & (abs(y) <= limit.y);
  return {visible, x, y, none, none, all(1.0f)};
}

// Moves `then` to the near plane if the particle was behind that plane when the shutter opened. Returns the remaining
// fraction of the path.
MOTES_INLINE Floats cut_at_near(const image::WideTask& t, Mask behind, ViewPosition now, ViewPosition& then) {
  const Floats part = select(behind, (now.depth - all(t.near)) / (now.depth - then.depth), all(1.0f));
  then.across = select(behind, now.across + (then.across - now.across) * part, then.across);
  then.upward = select(behind, now.upward + (then.upward - now.upward) * part, then.upward);
  then.depth = select(behind, all(t.near), then.depth);
  return part;
}

// Returns the path since the shutter opened; without motion if it is not finite.
MOTES_INLINE Way moving(const image::WideTask& t, Limit limit, std::size_t i, Floats3 place, ViewPosition now, Floats x,
                        Floats y, Mask visible) {
  ViewPosition then = view_position(t.then, place - vector_at(t.velocity, t.velocity_of_all, i) * t.open);
  const Mask behind = then.depth < all(t.near);
  const Floats part = any(visible & behind) ? cut_at_near(t, behind, now, then) : all(1.0f);
  const Floats k = all(t.then.scale) / then.depth;
  Floats dx = then.across * k - x, dy = -(then.upward * k) - y;
  const Mask known = (abs(dx) <= all(kLargest)) & (abs(dy) <= all(kLargest));
  dx = only(known, dx);
  dy = only(known, dy);
  const Floats ends_x = max(abs(x), abs(x + dx)), ends_y = max(abs(y), abs(y + dy));
  const Mask inside = ~behind & known & (ends_x <= 0.99f * limit.x) & (ends_y <= 0.99f * limit.y);
  if (!any(visible & ~inside)) return {visible, x, y, (x + dx) - x, (y + dy) - y, all(1.0f)};
  Floats from = all(0.0f), to = all(1.0f);
  visible &= clip(x, dx, limit.x, from, to) & clip(y, dy, limit.y, from, to);
  visible &= from <= to;
  Way w{visible, {}, {}, {}, {}, (to - from) * select(known, part, all(1.0f))};
  w.x = within(x + dx * from, limit.x);
  w.y = within(y + dy * from, limit.y);
  w.dx = within(x + dx * to, limit.x) - w.x;
  w.dy = within(y + dy * to, limit.y) - w.y;
  return w;
}

MOTES_INLINE Way way(const image::WideTask& t, Limit limit, std::size_t i, Floats3 place, ViewPosition now) {
  const Floats k = all(t.now.scale) / now.depth;
  const Floats x = now.across * k, y = -(now.upward * k);
  const Mask sane =
      (now.depth >= all(t.near)) & (now.depth <= all(kLargest)) & (abs(x) <= all(kLargest)) & (abs(y) <= all(kLargest));
  return t.streaks ? moving(t, limit, i, place, now, x, y, sane) : still(limit, x, y, sane);
}

// Diameter in 1/64 px, and the fraction of its light that a sprite keeps.
struct Size {
  Mask visible;
  Floats diameter, light;
  Floats unlimited;  // the diameter without the limit kWidest
};
MOTES_INLINE Size size_vector(const image::WideTask& t, std::size_t i, Floats depth) {
  Floats wide = all(t.diameter * kSizeUnit);
  Mask visible = ~Mask{};
  if (!(t.diameter > 0)) {
    const Floats metres = load_or(t.size, i, t.size_of_all);
    visible = (metres > 0.0f) & (metres <= all(kLargest));
    wide = metres * (all(t.now.scale * (kSizeUnit / kUnit) * t.breadth) / depth);
  }
  if (t.blur > 0) {
    // Add the squares of both diameters, which is right on average, and spread the light of the smaller disc over the
    // larger one.
    const Floats blur = abs(1.0f - t.focus / depth) * t.blur;
    const Floats whole = max(sqrt(wide * wide + blur * blur), all(kNarrow));
    const Floats left = min(wide / whole, all(1.0f));
    return {visible, min(whole, all(kWidest)), left * left, min(whole, all(kMostUnlimited))};
  }
  const Floats part = min(wide * all(1 / kNarrow), all(1.0f));
  const Floats shown = max(wide, all(kNarrow));
  return {visible, min(shown, all(kWidest)), part * part, min(shown, all(kMostUnlimited))};
}

// The direction of `up` on the screen, of length 32767 or 0 if it is unknown; y points down.
struct Upward {
  Floats x, y;
};
// Returns the direction in which the projection moves if the particle moves along `up`.
MOTES_INLINE Upward upward(const image::WideTask& t, std::size_t i, ViewPosition now) {
  const Floats3 up = vector_at(t.up, t.up_of_all, i);
  const Floats ahead = dot(up, all3(t.now.forward)) / now.depth;
  Floats x = dot(up, all3(t.now.right)) - now.across * ahead;
  Floats y = now.upward * ahead - dot(up, all3(t.now.up));
  const Floats larger = max(abs(x), abs(y));
  const Mask known = (larger > 0.0f) & (abs(x) + abs(y) <= all(kLargest));
  x = only(known, x / larger);
  y = only(known, y / larger);
  const Floats scale = all(32767.0f) / sqrt(select(known, x * x + y * y, all(1.0f)));
  return {x * scale, y * scale};
}
MOTES_INLINE Uints up_vector(const image::WideTask& t, std::size_t i, ViewPosition now) {
  const Upward up = upward(t, i, now);
  const Ints across = floor_to_ints(up.x + all(0.5f)), down = floor_to_ints(up.y + all(0.5f));
  return ((Uints)across & 0xffffu) | ((Uints)down << 16);
}
// Returns the rotation about the camera's axis that turns the top of a sprite to `up`.
MOTES_INLINE Rotations toward_camera(const image::WideTask& t, std::size_t i, ViewPosition now) {
  const Upward up = upward(t, i, now);
  const Mask known = (up.x != 0.0f) | (up.y != 0.0f);
  const Floats cosine = select(known, up.y * (-1.0f / 32767), all(1.0f));
  const Floats w = sqrt(max(0.5f + 0.5f * cosine, Floats{})), z = sqrt(max(0.5f - 0.5f * cosine, Floats{}));
  return {Floats{}, Floats{}, select(up.x > 0.0f, -z, z), w};
}

// Returns the orientation whose front faces along the velocity and whose top is as close to `up` as possible.
MOTES_INLINE Rotations along_velocity(const image::WideTask& t, std::size_t i, Mask& known) {
  const Floats3 velocity = vector_at(t.velocity, t.velocity_of_all, i), up = vector_at(t.up, t.up_of_all, i);
  const Floats speed = sqrt(dot(velocity, velocity));
  known = (speed > 1e-15f) & (speed < 1e15f);
  const Floats3 front = velocity * (1.0f / select(known, speed, all(1.0f)));
  const Floats none{}, one = all(1.0f);
  const Rotations turn = shortest({none, none, one}, front, {none, one, none});
  const Floats3 side = cross(up, front);
  const Floats square = dot(side, side);
  const Mask turns = (square > 1e-12f * dot(up, up)) & (square < 1e30f);
  const Floats3 top = cross(front, side) * (1.0f / sqrt(select(turns, square, one)));
  return select(turns, unit(shortest(turned_y(turn), top, front) * turn), turn);
}

// The orientation, scale and reach of a posed sprite.
struct Stance {
  Uints turn[2];  // PosedRecord::turn
  Uints turning;  // rotation while the shutter is open, as in PosedRecord
  Floats scale;   // m per unit of length
  Ints reach;     // 1/256 px
};
// Returns the rotation while the shutter is open, about the camera's axes, as image::unpack_turn() reads it.
MOTES_INLINE Uints turning(const image::WideTask& t, std::size_t i, Rotations camera) {
  const Floats3 spin = vector_at(t.spin, t.spin_of_all, i) * t.open;
  const Floats3 x = turned_x(camera), y = turned_y(camera), z = turned_z(camera);
  const Floats3 by{x.x * spin.x + y.x * spin.y + z.x * spin.z, x.y * spin.x + y.y * spin.y + z.y * spin.z,
                   x.z * spin.x + y.z * spin.y + z.z * spin.z};
  constexpr float kLeast = 1.0f / 4096, kMost = 64;
  const Floats most = max(max(abs(by.x), abs(by.y)), abs(by.z));
  const Mask turns = (most > kLeast) & (abs(by.x) + abs(by.y) + abs(by.z) <= all(kLargest));
  const Floats shorter = min(kMost / select(turns, most, all(1.0f)), all(1.0f));
  const Uints exponent = (Uints)select(turns, most * shorter, all(1.0f)) >> 23;  // biased by 127
  const Floats per = (Floats)((254u + 7u - exponent) << 23);  // 2^7 / 2^exponent: the greatest is 128..255
  Uints word = (exponent + (image::kTurnExponent - 7u - 127u)) << 27;
  const Floats number[3] = {by.x, by.y, by.z};
  for (int c = 0; c < 3; ++c) {
    const Ints part = floor_to_ints(within(only(turns, number[c] * shorter) * per, all(255.0f)) + 0.5f);
    word |= ((Uints)part & ((1u << image::kTurnBits) - 1)) << (image::kTurnBits * c);
  }
  return (Uints)turns & word;
}

MOTES_INLINE Stance stance_vector(const image::WideTask& t, std::size_t i, ViewPosition now, const Size& size,
                                  Mask visible) {
  const Rotations camera = {all(t.camera_turn[0]), all(t.camera_turn[1]), all(t.camera_turn[2]), all(t.camera_turn[3])};
  Mask known = ~Mask{};
  Rotations own{};
  if (t.along_velocity) {
    own = along_velocity(t, i, known);
  } else {
    own = unit(Rotations{
        load_or(t.orientation[0], i, t.orientation_of_all[0]), load_or(t.orientation[1], i, t.orientation_of_all[1]),
        load_or(t.orientation[2], i, t.orientation_of_all[2]), load_or(t.orientation[3], i, t.orientation_of_all[3])});
  }
  // Sprites that should face along their velocity face the camera if they do not move.
  Rotations turn = select(known, unit(camera * own), Rotations{{}, {}, {}, all(1.0f)});
  if (t.toward_camera) turn = toward_camera(t, i, now);
  const auto part = [](Floats v) { return (Uints)floor_to_ints(v * 32767.0f + 0.5f); };
  Stance p;
  p.turn[0] = (part(turn.x) & 0xffffu) | part(turn.y) << 16;
  p.turn[1] = (part(turn.z) & 0xffffu) | part(turn.w) << 16;
  // Width, m: the longer side of a card, or the diameter of a mesh's bounding ball.
  const Floats metres = size.unlimited * now.depth * (1 / (t.now.scale * (kSizeUnit / kUnit)));
  p.scale = metres * (1 / t.breadth);
  const Floats radius = metres * (t.diagonal * 0.5f), focal = all(t.now.scale);
  const Floats across = abs(now.across) + abs(now.upward);
  const Floats nearest = max(now.depth - radius, all(t.near));
  const Floats reach = radius * focal * (1.0f + across / now.depth) / nearest;
  Floats spread{};
  if (t.lens_blur > 0) {  // with the margin that the painter needs
    const Floats near = abs(1.0f - t.lens_focus / nearest), far = abs(1.0f - t.lens_focus / (now.depth + radius));
    spread = max(near, far) * (1.25f * t.lens_blur) + 3.0f * kUnit;
  }
  p.reach = to_ints(only(visible, min(reach + spread, all(image::kMostPosedReach * kUnit))));
  p.turning = t.streaks && !t.along_velocity && !t.toward_camera ? turning(t, i, camera) : Uints{};
  return p;
}

// The tiles that a sprite touches along one axis.
struct TileSpan {
  Mask inside;
  Ints first, last;
};
MOTES_INLINE TileSpan span(Ints middle, Ints reach, int pixels) {
  const Ints first = (middle - reach + pixels * (kUnit / 2)) >> image::kWideBits;
  const Ints last = (middle + reach + pixels * (kUnit / 2)) >> image::kWideBits;
  return {(last >= 0) & (first < pixels), max_ints(first, Ints{}) >> image::kTileBits,
          min_ints(last, all_ints(pixels - 1)) >> image::kTileBits};
}
MOTES_INLINE Uints tile_of(const image::WideTask& t, Ints column, Ints row) {
  return multiply_short((Uints)row, all_uints(static_cast<std::uint32_t>(t.columns))) + (Uints)column;
}
MOTES_INLINE Ints half_of(Ints v) { return (max_ints(v, -v) + 1) >> 1; }

// In groups of four: see fours_of().
constexpr std::size_t kMostWords = image::kFour * image::fours_of(image::form(image::Layout::posed_tiled).bytes / 4);

struct Columns {
  Mask visible;
  Uints word[kMostWords];  // of a record
  Uints tile, flags;  // as in WideBatch
  Mask many;  // touches more than 2x2 tiles
  Ints diameter;  // 1/64 px
  Uints light;    // as in a record
  TileSpan across, down;
};

// Returns the number of a tile, as records store it.
MOTES_INLINE Uints tile_number(const image::WideTask& t, std::size_t i) {
  const auto count = static_cast<float>(t.tiles);
  if (t.tile == nullptr) {
    const Floats part = unit(random_bits(t.pick, t.ids, i).a);
    return (Uints)min_ints(floor_to_ints(part * count), all_ints(t.tiles - 1)) << image::kTileNumberBits;
  }
  constexpr float kOne = 1 << image::kTileNumberBits;
  Floats number = load(t.tile + i);
  number = only(abs(number) <= 1e9f, number);  // others select the first tile
  number -= to_floats(floor_to_ints(number * (1 / count))) * count;
  return (Uints)to_ints(max(number, Floats{}) * kOne + 0.5f);  // may be `count`, which readers take as 0
}

// Returns the gain of a particle's light, as records store it.
MOTES_INLINE Uints gain_vector(const image::WideTask& t, std::size_t i) {
  using Record = image::WideRecord;
  if (t.gain == nullptr) return Uints{};
  const Floats gain = min(max(load(t.gain + i), all(1.0f)), all(1e9f));
  return (((Uints)gain + (1u << (Record::kGainShift - 1))) >> Record::kGainShift) - Record::kGainOne;
}

MOTES_INLINE Uints pair_of(Ints x, Ints y) { return ((Uints)x & 0xffffu) | ((Uints)y << 16); }
// Returns v / 2^bits, rounded to the nearest integer.
MOTES_INLINE Ints rounded(Ints v, int bits) { return (v + (1 << (bits - 1))) >> bits; }

// Assigns particles that touch many tiles to the tile of their middle, which even a slanted streak touches.
MOTES_INLINE void place_many(const image::WideTask& t, Ints x, Ints y, Columns& c) {
  const auto tile = [](Ints middle, const TileSpan& span, int pixels) {
    const Ints at = (middle + pixels * (kUnit / 2)) >> (image::kWideBits + image::kTileBits);
    return min_ints(max_ints(at, span.first), span.last);
  };
  c.tile = (Uints)select(c.many, (Ints)tile_of(t, tile(x, c.across, t.width), tile(y, c.down, t.height)), (Ints)c.tile);
}

// Returns the limit for sprites: those of up to 512 px, turned, are within reach of the image; bigger ones from
// farther.
MOTES_INLINE Limit limit_of(const image::WideTask& t, const Size& s, Mask big) {
  if (!any(big)) return {all(t.limit_x), all(t.limit_y)};
  const Floats more = only(big, s.diameter * (0.72f * kUnitsPerSize));
  return {more + t.limit_x, more + t.limit_y};
}

// Recodes the sizes of big sprites, and the positions of those whose records are not wide: see kBigSize.
__attribute__((noinline)) void recode_big(const image::WideTask& t, Mask big, Ints x, Ints y, Ints dx, Ints dy,
                                          Columns& c) {
  constexpr int kBig = image::kBigSize, kHalfUnit = 1 << (image::kBigSizeBits - 1);
  const auto put = [&](int word, Uints coarse) { c.word[word] = (Uints)select(big, (Ints)coarse, (Ints)c.word[word]); };
  const int word = t.form.size / 4;
  const Ints coded = min_ints(((c.diameter - kBig + kHalfUnit) >> image::kBigSizeBits) + kBig, all_ints(0xffff));
  put(word, (Uints)coded | c.light << 16);
  if (t.form.color == 8) return;
  const int less = image::kWideBits - t.bits + image::kBigBits;
  if (t.form.way != 0) put(t.form.way / 4, pair_of(rounded(dx, less + 1), rounded(dy, less + 1)));
  put(0, pair_of(rounded(x, less), rounded(y, less)));
}

MOTES_INLINE Columns project_vector(const image::WideTask& t, std::size_t i, Uints color) {
  const Floats3 place = place_of(t, i);
  const ViewPosition now = view_position(t.now, place);
  const Size s = size_vector(t, i, now.depth);
  const Mask big = s.diameter >= static_cast<float>(image::kBigSize);
  const Way w = way(t, limit_of(t, s, big), i, place, now);
  const Mask visible = w.visible & s.visible;
  const Ints x1 = floor_to_ints(only(visible, w.x)), x0 = floor_to_ints(only(visible, w.x + w.dx));
  const Ints y1 = floor_to_ints(only(visible, w.y)), y0 = floor_to_ints(only(visible, w.y + w.dy));
  const Ints diameter = to_ints(only(visible, s.diameter + all(0.5f)));
  const Floats part = t.opaque && t.lens_blur > 0 ? w.light : w.light * s.light;
  const Ints light = to_ints(only(visible, part * all(float{image::kAllLight}) + all(0.5f)));
  const Ints x = (x0 + x1) >> 1, y = (y0 + y1) >> 1, dx = x1 - x0, dy = y1 - y0;
  // Half a pixel more than the radius: pixels at the edge are partly covered. A square reaches sqrt(2) times as far.
  const Ints radius = diameter * (kUnitsPerSize / 2);
  Ints reach = (t.oriented ? (radius * 363) >> 8 : radius) + kUnit / 2;
  if (!t.posed && t.lens_blur > 0) {
    const Floats spread = abs(1.0f - t.lens_focus / now.depth) * t.lens_blur;
    reach += to_ints(only(visible, min(spread, all(image::kMostPosedReach * kUnit)))) + kUnit;
  }
  Stance stance;
  if (t.posed) {
    stance = stance_vector(t, i, now, s, visible);
    reach = stance.reach + 2 * kUnit;
  }
  const TileSpan columns = span(x, reach + half_of(dx), t.width), rows = span(y, reach + half_of(dy), t.height);
  Columns c;
  c.visible = visible & (light > 0) & columns.inside & rows.inside & gives_light(color, t.dark);
  const Uints size = (Uints)diameter | ((Uints)light << 16);
  if (t.form.color == 8) {
    c.word[0] = (Uints)x;
    c.word[1] = (Uints)y;
    c.word[2] = color;
    c.word[3] = (Uints)now.depth;
    c.word[4] = size;
    c.word[5] = t.oriented ? up_vector(t, i, now) : t.posed ? stance.turning : Uints{};
    const Uints gain = gain_vector(t, i);
    c.word[6] = ((Uints)dx & 0xffffffu) | gain << 24;
    c.word[7] = ((Uints)dy & 0xffffffu) | gain >> 8 << 24;
    if (t.posed) {
      c.word[8] = stance.turn[0];
      c.word[9] = stance.turn[1];
      c.word[10] = (Uints)stance.scale;
      c.word[11] = Uints{};
    }
    if (t.tiles > 1) c.word[t.form.tile / 4] = tile_number(t, i);
  } else {
    const int less = image::kWideBits - t.bits;
    // Members that a record lacks are written to its first word, which is overwritten by the position.
    c.word[t.form.color / 4] = color;
    c.word[t.form.depth / 4] = (Uints)now.depth;
    c.word[t.form.way / 4] = pair_of(rounded(dx, less + 1), rounded(dy, less + 1));
    c.word[t.form.size / 4] = size;
    c.word[0] = pair_of(rounded(x, less), rounded(y, less));
  }
  c.diameter = diameter;
  c.light = (Uints)light;
  if (any(c.visible & big)) recode_big(t, big, x, y, dx, dy, c);
  const Ints further = columns.last - columns.first, below = rows.last - rows.first;
  c.many = max_ints(further, below) > 1;
  c.flags = ((Uints)further << 30 | (Uints)below << 31) & ~(Uints)c.many;
  c.tile = tile_of(t, columns.first, rows.first);
  c.across = columns;
  c.down = rows;
  if (any(c.visible & c.many)) place_many(t, x, y, c);
  return c;
}

// Lists those of the visible particles n, n + 1, ... that touch many tiles, and returns how many. Few scenes have any.
__attribute__((noinline)) std::size_t list_many(image::ManyTiles* to, std::size_t n, const Columns& c, Mask visible) {
  std::size_t count = 0;
  const auto corner = [](std::int32_t column, std::int32_t row) {
    return static_cast<std::uint32_t>(column) | static_cast<std::uint32_t>(row) << 16;
  };
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (visible[lane] == 0) continue;
    if (c.many[lane] != 0) {
      to[count++] = {static_cast<std::uint32_t>(n), corner(c.across.first[lane], c.down.first[lane]),
                     corner(c.across.last[lane], c.down.last[lane])};
    }
    ++n;
  }
  return count;
}

MOTES_INLINE void store_velocity(const image::WideTask& t, std::size_t i, const Selected& k, std::uint32_t* to,
                                 std::size_t stride) {
  const Floats3 velocity = vector_at(t.velocity, t.velocity_of_all, i);
  store_selected(to, k, finite_bits(velocity.x));
  store_selected(to + stride, k, finite_bits(velocity.y));
  store_selected(to + 2 * stride, k, finite_bits(velocity.z));
}

image::WideCount project(const image::WideTask& task, std::size_t first, std::size_t last,
                         const image::WideBatch& batch) {
  const image::WideTask t = task;  // copies whose members the stores below cannot change
  const image::WideBatch out = batch;
  const bool same = t.one_color();
  const Uints color_of_all = same ? color_vector(t, 0) : Uints{};
  Ahead ahead(t);
  if (t.streaks || out.velocity != nullptr) ahead.add(t.velocity);
  if (!(t.diameter > 0)) ahead.add(t.size);
  if (t.oriented || (t.posed && (t.along_velocity || t.toward_camera))) ahead.add(t.up);
  if (t.posed && t.along_velocity && !t.streaks && out.velocity == nullptr) ahead.add(t.velocity);
  if (t.tiles > 1 && t.tile != nullptr) ahead.add(t.tile);
  if (t.posed && !t.along_velocity && !t.toward_camera) {
    for (const float* plane : t.orientation) ahead.add(plane);
    if (t.streaks) ahead.add(t.spin);
  }
  const auto words = static_cast<std::size_t>(t.form.bytes) / 4;
  const std::size_t in_fours = image::kFour * image::fours_of(words);
  std::size_t n = 0, several = 0, many = 0;
  for (std::size_t i = first; i < last; i += kLanes) {
    ahead.fetch(i);
    const Columns c = project_vector(t, i, same ? color_of_all : color_vector(t, i));
    Mask visible = c.visible;
    if (last - i < kLanes) visible &= first_lanes(last - i);
    const Selected k(visible);
    if (k.number() == 0) continue;
    store_selected(out.tile + n, k, c.tile);
    several += list_several(out.several + several, n, c.flags, visible, k);
    if (any(visible & c.many)) many += list_many(out.many + many, n, c, visible);
    if (out.velocity != nullptr) store_velocity(t, i, k, out.velocity + n, out.stride);
    std::size_t w = 0;
    for (; w < in_fours; w += image::kFour) {
      store_selected(out.words + w * out.stride + image::kFour * n, k, c.word[w], c.word[w + 1], c.word[w + 2],
                     c.word[w + 3]);
    }
    for (; w < words; ++w) store_selected(out.words + w * out.stride + n, k, c.word[w]);
    n += k.number();
  }
  return {n, several, many, same ? color_of_all[0] : 0};
}

}  // namespace

extern const image::ProjectWideLanes project_wide_lanes = {project};

}  // namespace motes::MOTES_ISA
