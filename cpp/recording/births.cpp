#include "recording/births.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "base/invalid_argument.h"
#include "particles/wrap.h"

namespace motes::recording {
namespace {

namespace distributions = actions::distributions;
using particles::Store;

constexpr double kMostAtOnce = 4.0e9;
constexpr double kMostAtAll = 1e300;  // so that sums stay finite

void check_attribute(int attribute, const particles::Schema& schema) {
  if (attribute >= 0 && attribute < schema.size()) return;
  throw base::InvalidArgument("attribute", "be 0.." + std::to_string(schema.size() - 1), std::to_string(attribute));
}

// Checks what an attribute is drawn from, for each kind of distribution.
class Check {
 public:
  Check(int index, const particles::Attribute& attribute) : index_(index), attribute_(attribute) {}

  void operator()(const distributions::Value& value) const {
    const float* first = value.number;
    const bool zero = std::all_of(first, std::end(value.number), [](float number) { return number == 0; });
    if (index_ == particles::orientation && zero) refuse("not be 0");
    for (int i = 0; i < attribute_.width; ++i) {
      const bool endless = index_ == particles::lifetime && first[i] > 0;
      if (!std::isfinite(first[i]) && !endless) refuse("be finite");
    }
  }

  void operator()(const distributions::InShape& in) const {
    if (attribute_.width != 3) refuse("be drawn from numbers: a shape gives three");
    shapes::check(in.shape);
  }

  void operator()(const distributions::Uniform& uniform) const {
    check_numbers(uniform.low, uniform.high);
    for (int i = 0; i < attribute_.width; ++i) {
      if (uniform.low[i] <= uniform.high[i]) continue;
      refuse("be drawn from lo <= hi", std::to_string(uniform.low[i]) + " > " + std::to_string(uniform.high[i]));
    }
  }

  void operator()(const distributions::Normal& normal) const {
    check_numbers(normal.mean, normal.sigma);
    for (int i = 0; i < attribute_.width; ++i) {
      if (normal.sigma[i] < 0) refuse("have sigma >= 0", std::to_string(normal.sigma[i]));
    }
  }

  void operator()(const distributions::AnyRotation&) const {
    if (index_ != particles::orientation) refuse("be numbers: only orientation is drawn from rotations");
  }

  void operator()(const distributions::AlongNormal& along) const {
    if (!std::isfinite(along.length)) refuse("be finite");
  }

  void operator()(const distributions::SurfaceColor&) const {}

 private:
  [[noreturn]] void refuse(const std::string& rule, const std::string& got = "") const {
    throw base::InvalidArgument(attribute_.name, rule, got);
  }

  void check_numbers(const float* first, const float* second) const {
    if (attribute_.width > 3) refuse("be a value, or drawn from all rotations");
    const auto finite = [](float number) { return std::isfinite(number); };
    if (!std::all_of(first, first + attribute_.width, finite) ||
        !std::all_of(second, second + attribute_.width, finite))
      refuse("be finite");
  }

  int index_;
  const particles::Attribute& attribute_;
};

// Only births on the surface of a mesh have a normal and a colour there.
void check_surface(const Given& given, const particles::Schema& schema, const shapes::Shape* shape) {
  const particles::Attribute& attribute = schema[given.attribute];
  if (attribute.width != 3)
    throw base::InvalidArgument(attribute.name, "have three numbers to be taken from a surface");
  const bool on_mesh = shape != nullptr && shape->kind == shapes::Kind::mesh && !shapes::drawn_inside(*shape) &&
                       shape->form != nullptr && shape->form->triangles > 0;
  if (!on_mesh) {
    throw base::InvalidArgument(attribute.name, "be taken from a surface only for births on a mesh without solid=True");
  }
  if (std::holds_alternative<distributions::SurfaceColor>(given.distribution) && shape->form->colors == nullptr) {
    throw base::InvalidArgument(attribute.name,
                                "be taken from a surface's colors only for births on a mesh with colors=");
  }
}

void check_way(const Source& source) {
  for (const shapes::Shape& before : source.before) {
    shapes::check(before);
    if (before.kind == shapes::Kind::mesh && source.shape.kind == shapes::Kind::mesh &&
        before.mesh != source.shape.mesh) {
      throw base::InvalidArgument("moving_from",
                                  "be the same mesh at another place: births have no path between different vertices");
    }
    if (before.kind != source.shape.kind || before.kind == shapes::Kind::united) {
      throw base::InvalidArgument("moving_from",
                                  "be a " + shapes::name(source.shape.kind) + ", as shape is, and not a union");
    }
  }
  if (source.before.size() > 1) throw base::InvalidArgument("moving_from", "be a single shape");
}

void check_rate(const Source& source) {
  if (!(source.rate >= 0 && source.rate <= 1e12)) {
    throw base::InvalidArgument("rate", "be 0..1e12 particles per second", std::to_string(source.rate));
  }
  const auto refuse = [](const std::string& what) { throw base::InvalidArgument("rate", "be " + what); };
  const auto wrong = [](double value) { return !(value >= 0 && value <= kMostAtAll); };
  if (wrong(source.scale) || std::any_of(source.integral.begin(), source.integral.end(), wrong)) {
    refuse("such that its integral is 0..1e300");
  }
  const auto too_many = [](double before, double after) { return after - before > kMostAtOnce; };
  if (std::adjacent_find(source.integral.begin(), source.integral.end(), too_many) != source.integral.end()) {
    refuse("at most 4000000000 particles per step");
  }
}

void check_count(std::uint64_t count) {
  if (static_cast<double>(count) <= kMostAtOnce) return;
  throw base::InvalidArgument("count", "be 0..4000000000", std::to_string(count));
}

// Draws an attribute. `birthplace`: the mesh on whose surface the particles are born, if the surface gives the
// attribute.
void draw_attribute(const Given& given, const shapes::Shape* birthplace, particles::Key key, Store& into) {
  const int width = into.schema()[given.attribute].width;
  float* planes[4] = {};
  for (int c = 0; c < width; ++c) planes[c] = into.writable_plane(given.attribute, c);
  const int drawn = actions::of_surface(given.distribution) ? particles::position
                                                            : given.attribute;  // the draws that placed the particle
  const auto stream = particles::birth_stream(drawn);
  particles::DrawKeys draws;
  actions::kernels().draw(given.distribution, birthplace, {0, 0, stream, key, 0, &draws}, into.ids(), into.size(),
                          planes, width);
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

Given place_in(const shapes::Shape& shape) { return {particles::position, distributions::InShape{shape}}; }

// Draws positions, or what their surface gives, from a shape that moves during the frame: for each particle on the
// segment between what the same random numbers draw from the shape `before` and from its present place, as far along as
// the frame has advanced when the particle is born.
void draw_moving(const Given& given, const shapes::Shape& shape, const shapes::Shape& before, particles::Key key,
                 const BirthStep& moment, Store& into) {
  draw_attribute(given, &shape, key, into);
  Store first(into.schema());
  first.grow(into.size());
  std::vector<std::uint64_t> ids(into.size());
  particles::join(into.ids(), ids.size(), ids.data());
  first.set_ids(0, ids);
  draw_attribute(given.attribute == particles::position ? place_in(before) : given, &before, key, first);
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

// Returns the value that all get; null: what differs between particles.
const float* value_of(const Given& given) {
  const auto* value = std::get_if<distributions::Value>(&given.distribution);
  return value == nullptr ? nullptr : value->number;
}

// Returns whether a list gives an attribute.
template <class T>
bool gives(const std::vector<T>& list, int attribute) {
  return std::any_of(list.begin(), list.end(), [&](const T& values) { return values.attribute == attribute; });
}

// Creates the particles of a birth that have these ids.
class Maker {
 public:
  Maker(const particles::Schema& schema, particles::Key key, std::span<const std::uint64_t> ids,
        const BirthStep& moment, bool keeps_copies, std::optional<std::uint64_t> first_of_call)
      : schema_(schema), key_(key), ids_(ids), moment_(moment), keeps_copies_(keeps_copies),
        first_of_call_(first_of_call) {}

  Store operator()(const Source& source) const {
    Store newborn = unplaced(source.state);
    draw_in(source.shape, source.before.empty() ? nullptr : source.before.data(), source.state, newborn);
    complete(newborn, source.state);
    if (source.jitter) {
      jitter(key_, moment_.dt, newborn);
      particles::wrap(newborn);
    }
    return newborn;
  }

  Store operator()(const Burst& burst) const {
    Store newborn = unplaced(burst.state);
    draw_in(burst.shape, nullptr, burst.state, newborn);
    complete(newborn, burst.state);
    return newborn;
  }

  Store operator()(const Emit& emit) const {
    std::vector<Given> others = emit.state;
    std::erase_if(others, [&](const Given& given) { return gives(emit.columns, given.attribute); });
    Store newborn = unplaced(others);
    for (const Given& given : others) {
      if (value_of(given) == nullptr) draw_attribute(given, nullptr, key_, newborn);
    }
    for (const Emitted& column : emit.columns) copy_column(column, first_of_call_, newborn);
    complete(newborn, emit.state, emit.columns);
    return newborn;
  }

 private:
  // Creates the particles with the values that are equal for all of them, which need no memory.
  Store unplaced(const std::vector<Given>& state) const {
    Store newborn(schema_);
    for (const Given& given : state) {
      const float* v = value_of(given);
      if (v != nullptr) newborn.set_uniform(given.attribute, {v[0], v[1], v[2], v[3]});
    }
    newborn.reserve(ids_.size());
    newborn.grow(ids_.size());
    newborn.set_ids(0, ids_);
    return newborn;
  }

  // Draws positions in a shape, and the values that differ between particles. `before`: the shape when the frame began;
  // null: it does not move.
  void draw_in(const shapes::Shape& shape, const shapes::Shape* before, const std::vector<Given>& state,
               Store& newborn) const {
    if (before == nullptr) {
      draw_attribute(place_in(shape), nullptr, key_, newborn);
    } else {
      draw_moving(place_in(shape), shape, *before, key_, moment_, newborn);
    }
    for (const Given& given : state) {
      if (actions::of_surface(given.distribution)) {
        draw_surface(given, shape, before, newborn);
      } else if (value_of(given) == nullptr) {
        draw_attribute(given, nullptr, key_, newborn);
      }
    }
  }

  // Draws the normals or colours of the surface on which particles are born.
  void draw_surface(const Given& given, const shapes::Shape& shape, const shapes::Shape* before, Store& newborn) const {
    const auto* along = std::get_if<distributions::AlongNormal>(&given.distribution);
    const bool turns = along != nullptr && along->length != 0;
    if (before == nullptr || !turns) return draw_attribute(given, &shape, key_, newborn);
    draw_moving(given, shape, *before, key_, moment_, newborn);
    restore_length(given.attribute, along->length, newborn);
  }

  // Wraps positions; copies the attributes whose copies are kept, unless one of the lists gives the copy.
  template <class... T>
  void complete(Store& newborn, const std::vector<T>&... lists) const {
    particles::wrap(newborn);
    for (const auto& [copy, original] : particles::kCopies) {
      if (keeps_copies_ && !(gives(lists, copy) || ...)) newborn.copy_attribute(original, copy);
    }
  }

  const particles::Schema& schema_;
  particles::Key key_;
  std::span<const std::uint64_t> ids_;
  const BirthStep& moment_;
  bool keeps_copies_;
  std::optional<std::uint64_t> first_of_call_;
};

}  // namespace

BirthStep moment_of(const Birth& birth, float dt, int substep, int substeps) {
  const auto* source = std::get_if<Source>(&birth);
  return source == nullptr || source->before.empty() ? BirthStep(dt) : BirthStep(dt, substep, substeps);
}

void check(const std::vector<Given>& state, const particles::Schema& schema, const shapes::Shape* shape) {
  for (const Given& given : state) {
    check_attribute(given.attribute, schema);
    std::visit(Check(given.attribute, schema[given.attribute]), given.distribution);
    if (actions::of_surface(given.distribution)) check_surface(given, schema, shape);
  }
}

void check(const Source& source, const particles::Schema& schema) {
  shapes::check(source.shape);
  check_rate(source);
  check_way(source);
  check(source.state, schema, &source.shape);
}

void check(const Burst& burst, const particles::Schema& schema) {
  shapes::check(burst.shape);
  check_count(burst.count);
  check(burst.state, schema, &burst.shape);
}

void check(const Emit& emit, const particles::Schema& schema) {
  check_count(emit.count);
  check(emit.state, schema, nullptr);
  if (!gives(emit.columns, particles::position)) {
    throw base::InvalidArgument("position", "be given, one row per particle");
  }
  for (const Emitted& column : emit.columns) {
    check_attribute(column.attribute, schema);
    const auto width = static_cast<std::size_t>(schema[column.attribute].width);
    if (column.values.size() != emit.count * width) {
      throw base::InvalidArgument(schema[column.attribute].name, "have one row per particle");
    }
  }
}

void check(const Birth& birth, const particles::Schema& schema) {
  std::visit([&](const auto& kind) { check(kind, schema); }, birth);
}

std::string name(const Birth& birth) {
  constexpr const char* kNames[] = {"source", "burst", "emit"};
  static_assert(std::size(kNames) == std::variant_size_v<Birth>);
  return kNames[birth.index()];
}

bool gives_copies(const Birth& birth) {
  const auto* emit = std::get_if<Emit>(&birth);
  return std::any_of(particles::kCopies.begin(), particles::kCopies.end(), [&](const auto& copied) {
    return gives(state_of(birth), copied.first) || (emit != nullptr && gives(emit->columns, copied.first));
  });
}

std::vector<std::uint64_t> meshes_of(const Birth& birth) {
  std::vector<std::uint64_t> keys;
  const auto add = [&](const shapes::Shape& shape) {
    const std::vector<std::uint64_t> more = shapes::meshes_of(shape);
    keys.insert(keys.end(), more.begin(), more.end());
  };
  if (const auto* source = std::get_if<Source>(&birth)) {
    add(source->shape);
    for (const shapes::Shape& shape : source->before) add(shape);
  }
  if (const auto* burst = std::get_if<Burst>(&birth)) add(burst->shape);
  for (const Given& given : state_of(birth)) {
    if (const auto* in = std::get_if<distributions::InShape>(&given.distribution)) add(in->shape);
  }
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
  if (ids.empty()) return Store(schema);
  return std::visit(Maker(schema, key, ids, moment, keeps_copies, first_of_call), birth);
}

}  // namespace motes::recording
