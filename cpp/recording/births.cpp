#include "recording/births.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "base/invalid_argument.h"
#include "particles/wrap.h"

namespace motes::recording {
namespace {

using actions::Distribution;
using particles::Store;

constexpr double kMostAtOnce = 4.0e9;
constexpr double kMostAtAll = 1e300;  // so that sums stay finite

void check_attribute(int attribute, const particles::Schema& schema) {
  if (attribute >= 0 && attribute < schema.size()) return;
  throw base::InvalidArgument("attribute", "be 0.." + std::to_string(schema.size() - 1), std::to_string(attribute));
}

bool is_zero(const Distribution& d) {
  return d.kind == Distribution::Kind::value &&
         std::all_of(std::begin(d.first), std::end(d.first), [](float number) { return number == 0; });
}

void check_distribution(const Given& given, const particles::Schema& schema) {
  check_attribute(given.attribute, schema);
  const particles::Attribute& attribute = schema[given.attribute];
  const Distribution& d = given.distribution;
  const auto refuse = [&](const std::string& rule, const std::string& got = "") {
    throw base::InvalidArgument(attribute.name, rule, got);
  };
  const bool drawn = d.kind == Distribution::Kind::uniform || d.kind == Distribution::Kind::normal;
  if (d.kind == Distribution::Kind::rotation) {
    if (given.attribute != particles::orientation) refuse("be numbers: only orientation is drawn from rotations");
    return;
  }
  if (drawn && attribute.width > 3) refuse("be a value, or drawn from all rotations");
  if (given.attribute == particles::orientation && is_zero(d)) refuse("not be 0");
  for (int i = 0; i < attribute.width; ++i) {
    const bool endless = given.attribute == particles::lifetime && d.kind == Distribution::Kind::value;
    if (!std::isfinite(d.first[i]) && !(endless && d.first[i] > 0)) refuse("be finite");
    if (drawn && !std::isfinite(d.second[i])) refuse("be finite");
    if (d.kind == Distribution::Kind::uniform && d.first[i] > d.second[i]) {
      refuse("be drawn from lo <= hi", std::to_string(d.first[i]) + " > " + std::to_string(d.second[i]));
    }
    if (d.kind == Distribution::Kind::normal && d.second[i] < 0) {
      refuse("have sigma >= 0", std::to_string(d.second[i]));
    }
  }
  if (d.kind == Distribution::Kind::shape) {
    if (attribute.width != 3) refuse("be drawn from numbers: a shape gives three");
    shapes::check(d.shape);
  }
}

// Only births on the surface of a mesh have a normal and a colour there.
void check_surface(const Given& given, const Birth& birth, const particles::Schema& schema) {
  const particles::Attribute& attribute = schema[given.attribute];
  if (attribute.width != 3)
    throw base::InvalidArgument(attribute.name, "have three numbers to be taken from a surface");
  const bool on_mesh = birth.kind != Birth::Kind::emit && birth.shape.kind == shapes::Kind::mesh &&
                       !shapes::drawn_inside(birth.shape) && birth.shape.form != nullptr &&
                       birth.shape.form->triangles > 0;
  if (!on_mesh) {
    throw base::InvalidArgument(attribute.name, "be taken from a surface only for births on a mesh without solid=True");
  }
  if (given.distribution.kind == Distribution::Kind::surface_color && birth.shape.form->colors == nullptr) {
    throw base::InvalidArgument(attribute.name,
                                "be taken from a surface's colors only for births on a mesh with colors=");
  }
}

void check_way(const Birth& birth) {
  for (const shapes::Shape& before : birth.before) {
    shapes::check(before);
    if (before.kind == shapes::Kind::mesh && birth.shape.kind == shapes::Kind::mesh &&
        before.mesh != birth.shape.mesh) {
      throw base::InvalidArgument("moving_from",
                                  "be the same mesh at another place: births have no path between different vertices");
    }
    if (before.kind != birth.shape.kind || before.kind == shapes::Kind::united) {
      throw base::InvalidArgument("moving_from",
                                  "be a " + shapes::name(birth.shape.kind) + ", as shape is, and not a union");
    }
  }
  if (birth.before.size() > 1) throw base::InvalidArgument("moving_from", "be a single shape");
}

void draw_attribute(const Given& given, particles::Key key, Store& into) {
  const Distribution& d = given.distribution;
  const int width = into.schema()[given.attribute].width;
  float* planes[4] = {};
  for (int c = 0; c < width; ++c) planes[c] = into.writable_plane(given.attribute, c);
  const int drawn = d.of_surface() ? particles::position : given.attribute;  // the draws that placed the particle
  const auto stream = particles::birth_stream(drawn);
  particles::DrawKeys draws;
  actions::kernels().draw(d, {0, 0, stream, key, 0, &draws}, into.ids(), into.size(), planes, width);
}

void copy_column(const Emitted& column, std::optional<std::uint64_t> first_of_call, Store& into) {
  const auto width = static_cast<std::size_t>(into.schema()[column.attribute].width);
  for (std::size_t c = 0; c < width; ++c) {
    float* plane = into.writable_plane(column.attribute, static_cast<int>(c));
    for (std::size_t i = 0; i < into.size(); ++i) {
      const std::size_t row = first_of_call ? into.ids()[i] - *first_of_call : i;
      plane[i] = column.values[row * width + c];
    }
  }
}

void jitter(particles::Key key, float dt, Store& into) {
  std::vector<float*> components(static_cast<std::size_t>(into.schema().components()), nullptr);
  for (const int a : {particles::position, particles::velocity, particles::age}) {
    for (int c = 0; c < into.schema()[a].width; ++c) {
      const auto at = static_cast<std::size_t>(into.schema()[a].first_component + c);
      components[at] = into.writable_plane(a, c);
    }
  }
  const actions::Block block{into.size(), components.data(), into.ids(), nullptr};
  particles::DrawKeys draws;
  actions::kernels().jitter(block, {dt, 0, particles::birth_jitter, key, 0, &draws});
}

// Draws an attribute of three numbers from a shape that moves during the frame: for each particle on the segment
// between what the same random numbers draw from the shape `before` and from its present place, as far along as the
// frame has advanced when the particle is born.
void draw_moving(const Given& given, const shapes::Shape& before, particles::Key key, const BirthStep& moment,
                 Store& into) {
  draw_attribute(given, key, into);
  Store first(into.schema());
  first.grow(into.size());
  std::vector<std::uint64_t> ids(into.size());
  particles::join(into.ids(), ids.size(), ids.data());
  first.set_ids(0, ids);
  Given earlier = given;
  earlier.distribution.shape = before;
  draw_attribute(earlier, key, first);
  std::vector<float*> now(3), then(3);
  for (int c = 0; c < 3; ++c) {
    now[static_cast<std::size_t>(c)] = into.writable_plane(given.attribute, c);
    then[static_cast<std::size_t>(c)] = first.writable_plane(given.attribute, c);
  }
  const actions::Block block{into.size(), now.data(), into.ids(), nullptr};
  particles::DrawKeys draws;
  actions::kernels().spread(block, then.data(), moment.start, moment.end,
                            {moment.dt, 0, particles::birth_jitter, key, 0, &draws});
}

// Gives vectors between two normals the length of a normal. Where the surface has turned over, so that there is nothing
// between its two normals, particles get a normal of length 0.
void restore_length(int attribute, float length, Store& into) {
  float* planes[3] = {};
  for (int c = 0; c < 3; ++c) planes[c] = into.writable_plane(attribute, c);
  const float wanted = std::abs(length);
  for (std::size_t i = 0; i < into.size(); ++i) {
    const float x = planes[0][i] / wanted, y = planes[1][i] / wanted, z = planes[2][i] / wanted;
    const float between = std::sqrt(x * x + y * y + z * z);
    if (!(between > 0)) continue;
    for (float* plane : planes) plane[i] /= between;
  }
}

// Draws the normals or colours of the surface on which particles are born.
void draw_surface(Given given, const Birth& birth, particles::Key key, const BirthStep& moment, Store& into) {
  given.distribution.shape = birth.shape;
  const bool turns = given.distribution.kind == Distribution::Kind::along_normal && given.distribution.first[0] != 0;
  if (birth.before.empty() || !turns) return draw_attribute(given, key, into);
  draw_moving(given, birth.before[0], key, moment, into);
  restore_length(given.attribute, given.distribution.first[0], into);
}

// Checks the integral of a rate that changes within the frame.
void check_until(const Birth& birth) {
  const auto refuse = [](const std::string& what) { throw base::InvalidArgument("rate", "be " + what); };
  const auto wrong = [](double value) { return !(value >= 0 && value <= kMostAtAll); };
  if (wrong(birth.scale) || std::any_of(birth.until.begin(), birth.until.end(), wrong)) {
    refuse("such that its integral is 0..1e300");
  }
  const auto too_many = [](double before, double after) { return after - before > kMostAtOnce; };
  if (std::adjacent_find(birth.until.begin(), birth.until.end(), too_many) != birth.until.end()) {
    refuse("at most 4000000000 particles per step");
  }
}

}  // namespace

BirthStep moment_of(const Birth& birth, float dt, int substep, int substeps) {
  return birth.before.empty() ? BirthStep(dt) : BirthStep(dt, substep, substeps);
}

void check(const Birth& birth, const particles::Schema& schema) {
  if (birth.kind != Birth::Kind::emit) shapes::check(birth.shape);
  if (birth.kind == Birth::Kind::source && !(birth.rate >= 0 && birth.rate <= 1e12)) {
    throw base::InvalidArgument("rate", "be 0..1e12 particles per second", std::to_string(birth.rate));
  }
  check_until(birth);
  check_way(birth);
  if (static_cast<double>(birth.amount) > kMostAtOnce) {
    throw base::InvalidArgument("count", "be 0..4000000000", std::to_string(birth.amount));
  }
  for (const Given& given : birth.state) {
    check_distribution(given, schema);
    if (given.distribution.of_surface()) check_surface(given, birth, schema);
  }
  const auto is_position = [](const Emitted& column) { return column.attribute == particles::position; };
  if (birth.kind == Birth::Kind::emit && std::none_of(birth.columns.begin(), birth.columns.end(), is_position)) {
    throw base::InvalidArgument("position", "be given, one row per particle");
  }
  for (const Emitted& column : birth.columns) {
    check_attribute(column.attribute, schema);
    const auto width = static_cast<std::size_t>(schema[column.attribute].width);
    if (column.values.size() != birth.amount * width) {
      throw base::InvalidArgument(schema[column.attribute].name, "have one row per particle");
    }
  }
}

bool gives_copies(const Birth& birth) {
  const auto is_copy = [](int attribute) { return attribute >= particles::position_b && attribute <= particles::up_b; };
  return std::any_of(birth.state.begin(), birth.state.end(), [&](const Given& g) { return is_copy(g.attribute); }) ||
         std::any_of(birth.columns.begin(), birth.columns.end(),
                     [&](const Emitted& e) { return is_copy(e.attribute); });
}

std::vector<std::uint64_t> meshes_of(const Birth& birth) {
  std::vector<std::uint64_t> keys = shapes::meshes_of(birth.shape);
  const auto add = [&](const shapes::Shape& shape) {
    const std::vector<std::uint64_t> its = shapes::meshes_of(shape);
    keys.insert(keys.end(), its.begin(), its.end());
  };
  for (const shapes::Shape& shape : birth.before) add(shape);
  for (const Given& given : birth.state) add(given.distribution.shape);
  return keys;
}

Store make(const Birth& birth, const particles::Schema& schema, particles::Key key, std::uint64_t first_id,
           std::uint64_t count, const BirthStep& moment, bool keeps_copies, std::uint64_t skip) {
  std::vector<std::uint64_t> ids(count);
  std::iota(ids.begin(), ids.end(), first_id);
  return make(birth, schema, key, ids, moment, keeps_copies, first_id - skip);
}

Store make(const Birth& birth, const particles::Schema& schema, particles::Key key, std::span<const std::uint64_t> ids,
           const BirthStep& moment, bool keeps_copies, std::optional<std::uint64_t> first_of_call) {
  Store newborn(schema);
  if (ids.empty()) return newborn;
  std::vector<bool> emitted(static_cast<std::size_t>(schema.size()), false);
  std::vector<bool> given_at_all(static_cast<std::size_t>(schema.size()), false);
  for (const Emitted& column : birth.columns) emitted[static_cast<std::size_t>(column.attribute)] = true;
  for (const Given& given : birth.state) given_at_all[static_cast<std::size_t>(given.attribute)] = true;
  std::vector<const Given*> drawn;
  for (const Given& given : birth.state) {
    if (emitted[static_cast<std::size_t>(given.attribute)]) continue;
    const float* v = given.distribution.first;
    if (given.distribution.kind == Distribution::Kind::value) {
      newborn.set_uniform(given.attribute, {v[0], v[1], v[2], v[3]});  // one value for all: no memory is needed
    } else {
      drawn.push_back(&given);
    }
  }
  newborn.reserve(ids.size());
  newborn.grow(ids.size());
  newborn.set_ids(0, ids);
  if (birth.kind != Birth::Kind::emit) {
    Given place{particles::position, {}};
    place.distribution.kind = Distribution::Kind::shape;
    place.distribution.shape = birth.shape;
    if (birth.before.empty()) {
      draw_attribute(place, key, newborn);
    } else {
      draw_moving(place, birth.before[0], key, moment, newborn);
    }
  }
  for (const Given* given : drawn) {
    if (given->distribution.of_surface()) {
      draw_surface(*given, birth, key, moment, newborn);
    } else {
      draw_attribute(*given, key, newborn);
    }
  }
  for (const Emitted& column : birth.columns) copy_column(column, first_of_call, newborn);
  particles::wrap(newborn);
  for (const auto& [copy, original] : particles::kCopies) {
    if (keeps_copies && !emitted[copy] && !given_at_all[copy]) newborn.copy_attribute(original, copy);
  }
  if (birth.jitter) {
    jitter(key, moment.dt, newborn);
    particles::wrap(newborn);
  }
  return newborn;
}

}  // namespace motes::recording
