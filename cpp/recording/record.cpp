#include "recording/record.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace motes::recording {
namespace {

using particles::Bytes;
using particles::Reader;

// Writing and reading share one description of each value's fields, so they cannot drift apart: Put appends, Get fills.
struct Put {
  Bytes& bytes;
  template <class T>
  void plain(T& value) {
    bytes.put(value);
  }
  void text(std::string& value) { bytes.put_text(value); }
  template <class T>
  std::size_t length(std::vector<T>& list) {
    bytes.put(static_cast<std::uint64_t>(list.size()));
    return list.size();
  }
};

// How many enumerators a type has: damaged bytes must not become one that does not exist.
template <class T>
constexpr int kEnumerators = 0;
template <>
constexpr int kEnumerators<shapes::Kind> = shapes::kKinds;
template <>
constexpr int kEnumerators<actions::Kind> = actions::kKinds;
template <>
constexpr int kEnumerators<actions::Op> = actions::kOps;
template <>
constexpr int kEnumerators<actions::Distribution::Kind> = 4;
template <>
constexpr int kEnumerators<Birth::Kind> = 3;
template <>
constexpr int kEnumerators<image::Sprite::Kind> = 2;
template <>
constexpr int kEnumerators<domains::Space::Kind> = 3;
template <>
constexpr int kEnumerators<Spawn::On> = 3;
template <>
constexpr int kEnumerators<Verb> = 6;

struct Get {
  Reader& bytes;
  template <class T>
  void plain(T& value) {
    const auto from = bytes.take(sizeof value);
    if constexpr (std::is_same_v<T, bool>) {
      value = from[0] != std::byte{0};
    } else {
      std::memcpy(&value, from.data(), sizeof value);
    }
    if constexpr (std::is_enum_v<T>) {
      static_assert(kEnumerators<T> > 0);
      if (static_cast<int>(value) >= kEnumerators<T>) throw std::runtime_error("not a recorded list");
    }
  }
  void text(std::string& value) { value = bytes.get_text(); }
  template <class T>
  std::size_t length(std::vector<T>& list) {
    const auto count = bytes.get<std::uint64_t>();
    if (count > bytes.left()) throw std::runtime_error("not a recorded list");  // an element takes a byte at least
    list.assign(count, T{});
    return count;
  }
};

template <class Way, class T>
void plain_list(Way& way, std::vector<T>& list) {
  way.length(list);
  for (T& value : list) way.plain(value);
}

// A union's parts have none themselves, so they are their kinds and numbers.
void parts(Put& put, const shapes::Shape& s) {
  std::vector<shapes::Shape> list(s.part, s.part + s.parts);
  put.length(list);
  for (shapes::Shape& part : list) {
    put.plain(part.kind);
    put.plain(part.number);
  }
}

void parts(Get& get, shapes::Shape& s) {
  std::vector<shapes::Shape> list;
  get.length(list);
  for (shapes::Shape& part : list) {
    get.plain(part.kind);
    get.plain(part.number);
    if (part.kind >= shapes::Kind::united) throw std::runtime_error("not a recorded list");
  }
  if (list.empty() || list.size() > shapes::kMostParts) throw std::runtime_error("not a recorded list");
  s = shapes::unite(list);
}

// Field by field: padding inside the structs never reaches the bytes.
template <class Way>
void fields(Way& way, shapes::Shape& s) {
  way.plain(s.kind);
  way.plain(s.number);
  if (s.kind == shapes::Kind::united) parts(way, s);
}

template <class Way>
void fields(Way& way, actions::Distribution& d) {
  way.plain(d.kind);
  way.plain(d.first);
  way.plain(d.second);
  fields(way, d.shape);
}

template <class Way>
void fields(Way& way, actions::Expression& expression) {
  way.length(expression);
  for (actions::Instruction& instruction : expression) {
    way.plain(instruction.op);
    way.plain(instruction.index);
    way.plain(instruction.value);
  }
}

template <class Way>
void fields(Way& way, actions::Action& a) {
  way.plain(a.kind);
  plain_list(way, a.numbers);
  way.length(a.shapes);
  for (shapes::Shape& shape : a.shapes) fields(way, shape);
  fields(way, a.where);
  way.plain(a.target);
  way.length(a.values);
  for (actions::Expression& value : a.values) fields(way, value);
}

template <class Way>
void state(Way& way, std::vector<Given>& list) {
  way.length(list);
  for (Given& given : list) {
    way.plain(given.attribute);
    fields(way, given.distribution);
  }
}

template <class Way>
void fields(Way& way, Birth& b) {
  way.plain(b.kind);
  fields(way, b.shape);
  way.plain(b.rate);
  way.plain(b.amount);
  way.plain(b.jitter);
  state(way, b.state);
  way.length(b.columns);
  for (Emitted& column : b.columns) {
    way.plain(column.attribute);
    plain_list(way, column.values);
  }
}

template <class Way>
void fields(Way&, Read&) {}

template <class Way>
void fields(Way& way, Spawn& s) {
  way.plain(s.into);
  way.plain(s.on);
  way.plain(s.count);
  way.plain(s.inherit_velocity);
  state(way, s.state);
  fields(way, s.where);
  way.length(s.shapes);
  for (shapes::Shape& shape : s.shapes) fields(way, shape);
}

template <class Way>
void fields(Way& way, Callback& c) {
  way.text(c.name);
  way.plain(c.number);
  fields(way, c.where);
  way.length(c.shapes);
  for (shapes::Shape& shape : c.shapes) fields(way, shape);
}

template <class Way>
void fields(Way& way, image::Sprite& s) {
  way.plain(s.kind);
  way.plain(s.pixels);
}

template <class Way>
void fields(Way& way, SystemDefinition& s) {
  way.text(s.name);
  way.plain(s.capacity);
  way.plain(s.axis);
  way.plain(s.space.kind);
  way.plain(s.space.low);
  way.plain(s.space.high);
  fields(way, s.sprite);
  way.length(s.attributes);
  for (UserAttribute& attribute : s.attributes) {
    way.text(attribute.name);
    way.plain(attribute.width);
    way.plain(attribute.initial);
  }
}

template <class Way>
void fields(Way& way, image::View& v) {
  way.plain(v.width);
  way.plain(v.height);
  way.plain(v.camera.position);
  way.plain(v.camera.look_at);
  way.plain(v.camera.up);
  way.plain(v.camera.fov_deg);
  way.plain(v.camera.near);
  way.plain(v.background);
  way.plain(v.exposure);
  way.length(v.objects);
  for (image::Solid& solid : v.objects) {
    fields(way, solid.shape);
    way.plain(solid.color);
  }
}

void item(Put& put, Item& value) {
  auto kind = static_cast<std::uint8_t>(value.index());
  put.plain(kind);
  std::visit([&](auto& held) { fields(put, held); }, value);
}

void item(Get& get, Item& value) {
  std::uint8_t kind = 0;
  get.plain(kind);
  switch (kind) {
    case 0: value = Birth{}; break;
    case 1: value = actions::Action{}; break;
    case 2: value = Read{}; break;
    case 3: value = Spawn{}; break;
    case 4: value = Callback{}; break;
    default: throw std::runtime_error("not a recorded list");
  }
  std::visit([&](auto& held) { fields(get, held); }, value);
}

template <class Way>
void fields(Way& way, Record& r) {
  way.plain(r.verb);
  way.plain(r.frame);
  way.plain(r.seed);
  way.plain(r.dt);
  way.plain(r.substeps);
  way.length(r.systems);
  for (SystemDefinition& system : r.systems) fields(way, system);
  way.length(r.lists);
  for (std::vector<Item>& list : r.lists) {
    way.length(list);
    for (Item& value : list) item(way, value);
  }
  way.length(r.sprites);
  for (image::Sprite& sprite : r.sprites) fields(way, sprite);
  bool seen = r.view.has_value();
  way.plain(seen);
  if (seen) {
    if (!r.view) r.view.emplace();
    fields(way, *r.view);
  }
  way.text(r.argument);
}

std::uint64_t mix(std::uint64_t x) {  // the finaliser of SplitMix64 (Steele, Lea, Flood 2014)
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

std::string item_name(const Item& value) {
  if (const auto* action = std::get_if<actions::Action>(&value)) return actions::facts(action->kind).name;
  if (const auto* birth = std::get_if<Birth>(&value)) {
    constexpr const char* kNames[] = {"source", "burst", "emit"};
    return kNames[static_cast<std::size_t>(birth->kind)];
  }
  if (const auto* callback = std::get_if<Callback>(&value)) return "callback " + callback->name;
  return std::holds_alternative<Spawn>(value) ? "spawn" : "local";
}

std::string list_difference(const std::string& system, const std::vector<Item>& ours, const std::vector<Item>& theirs) {
  for (std::size_t i = 0; i < ours.size() || i < theirs.size(); ++i) {
    const std::string place = "system '" + system + "', call " + std::to_string(i + 1) + ": ";
    if (i >= ours.size()) return place + "nothing here, " + item_name(theirs[i]) + " there";
    if (i >= theirs.size()) return place + item_name(ours[i]) + " here, nothing there";
    if (ours[i] == theirs[i]) continue;
    const std::string a = item_name(ours[i]);
    const std::string b = item_name(theirs[i]);
    return place + (a == b ? a + " with other arguments" : a + " here, " + b + " there");
  }
  return {};
}

}  // namespace

std::string name(Verb verb) {
  constexpr const char* kNames[] = {"entering the world", "render", "step", "digest", "gather", "leaving the world"};
  return kNames[static_cast<std::size_t>(verb)];
}

void write(const Record& record, Bytes& out) {
  Put put{out};
  fields(put, const_cast<Record&>(record));  // Put reads only
}

Record read(Reader& in) {
  Record record;
  Get get{in};
  fields(get, record);
  return record;
}

Hash hash(std::span<const std::byte> bytes) {
  Hash h{0x9e3779b97f4a7c15u, bytes.size()};
  std::size_t at = 0;
  for (; at < bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
    h.low = mix(h.low ^ word) + 0x9e3779b97f4a7c15u;
    h.high = mix(h.high + word * 0xd6e8feb86659fd93u) ^ h.low;
  }
  return {mix(h.low), mix(h.high)};
}

std::string first_difference(const Record& ours, const Record& theirs) {
  if (ours.verb != theirs.verb) return name(ours.verb) + " here, " + name(theirs.verb) + " there";
  if (ours.frame != theirs.frame) {
    return "frame " + std::to_string(ours.frame) + " here, " + std::to_string(theirs.frame) + " there";
  }
  if (ours.seed != theirs.seed) return "another seed";
  if (ours.dt != theirs.dt || ours.substeps != theirs.substeps) return "another dt or substeps";
  if (ours.systems != theirs.systems) {
    if (ours.systems.size() != theirs.systems.size()) {
      return std::to_string(ours.systems.size()) + " systems here, " + std::to_string(theirs.systems.size()) + " there";
    }
    for (std::size_t i = 0; i < ours.systems.size(); ++i) {
      if (ours.systems[i] != theirs.systems[i]) return "system '" + ours.systems[i].name + "' is defined otherwise";
    }
  }
  for (std::size_t i = 0; i < ours.lists.size() && i < theirs.lists.size(); ++i) {
    const std::string found = list_difference(ours.systems[i].name, ours.lists[i], theirs.lists[i]);
    if (!found.empty()) return found;
  }
  if (ours.sprites != theirs.sprites) return "another sprite";
  if (ours.view != theirs.view) return "another camera or renderer";
  if (ours.argument != theirs.argument)
    return "other arguments: " + ours.argument + " here, " + theirs.argument + " there";
  return "no difference in value";
}

}  // namespace motes::recording
