#include "snapshots/part.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>

#include "base/crc32c.h"
#include "base/fields.h"

namespace motes::snapshots {
namespace {

using base::Bytes;
using base::Reader;
using particles::Store;
using particles::Touch;

// Bytes that a thread copies at once.
constexpr std::size_t kRange = std::size_t{1} << 18;

struct PlaneBytes {
  const void* from;  // null: no plane in memory has these bytes
  std::uint64_t offset;
  std::size_t bytes;
};

// Appends a system's planes to the description, and where they are now to `sources`.
void describe(const Store& store, std::int32_t system, Description& description, std::vector<PlaneBytes>& sources,
              std::uint64_t& end) {
  const auto add = [&](SavedPlane plane, const void* from, std::size_t bytes) {
    plane.system = system;
    plane.offset = end;
    plane.bytes = bytes;
    sources.push_back({from, end, bytes});
    end += bytes;
    description.planes.push_back(std::move(plane));
  };
  const std::size_t rows = store.size();
  if (rows == 0) return;
  SavedPlane plane;
  add(plane, nullptr, rows * sizeof(std::uint64_t));
  if (store.remembers()) {
    std::size_t touches = 0;
    for (std::size_t i = 0; i < rows; ++i) touches += store.touches(i).size();
    plane.kind = Plane::touch_counts;
    add(plane, nullptr, rows * sizeof(std::uint32_t));
    plane.kind = Plane::touches;
    add(plane, nullptr, touches * sizeof(Touch));
  }
  for (int a = 0; a < store.schema().size(); ++a) {
    const particles::Attribute& attribute = store.schema()[a];
    plane.attribute = attribute.name;
    plane.width = attribute.width;
    plane.component = 0;
    plane.kind = store.uniform(a) ? Plane::uniform : Plane::component;
    if (store.uniform(a)) {
      add(plane, nullptr, sizeof(float) * static_cast<std::size_t>(attribute.width));
      continue;
    }
    for (int c = 0; c < attribute.width; ++c) {
      plane.component = c;
      add(plane, store.plane(a, c), rows * sizeof(float));
    }
  }
}

[[noreturn]] void damaged(const std::string& what) { throw std::runtime_error("damaged checkpoint: " + what); }

std::span<const std::byte> bytes_of(const SavedPlane& plane, std::span<const std::byte> planes) {
  if (plane.offset > planes.size() || plane.bytes > planes.size() - plane.offset) damaged("it ends too early");
  return planes.subspan(plane.offset, plane.bytes);
}

std::size_t width_of(const SavedPlane& plane) {
  switch (plane.kind) {
    case Plane::ids: return sizeof(std::uint64_t);
    case Plane::touch_counts: return sizeof(std::uint32_t);
    case Plane::touches: return sizeof(Touch);
    default: return sizeof(float);
  }
}

// Returns the bytes of `count` values from number `first` on.
std::span<const std::byte> values(const SavedPlane& plane, std::span<const std::byte> planes, std::uint64_t first,
                                  std::uint64_t count) {
  const std::size_t width = width_of(plane);
  return bytes_of(plane, planes).subspan(first * width, count * width);
}

void check(const SavedPlane& plane, const Description& description, std::span<const std::byte> planes) {
  if (plane.system < 0 || static_cast<std::size_t>(plane.system) >= description.systems.size()) {
    damaged("a plane belongs to no system");
  }
  const std::uint64_t rows = description.systems[static_cast<std::size_t>(plane.system)].rows;
  const std::size_t bytes = bytes_of(plane, planes).size();
  const std::uint64_t count = plane.kind == Plane::uniform   ? static_cast<std::uint64_t>(plane.width)
                              : plane.kind == Plane::touches ? bytes / sizeof(Touch)
                                                             : rows;
  if (plane.width < 1 || plane.width > 4 || bytes / width_of(plane) != count || bytes % width_of(plane) != 0) {
    damaged("a plane's length differs from its system's");
  }
}

particles::Value shared_value(const SavedPlane& plane, std::span<const std::byte> planes) {
  const auto bytes = bytes_of(plane, planes);
  particles::Value value{};
  std::memcpy(value.data(), bytes.data(), bytes.size());
  return value;
}

bool same(const particles::Value& a, const particles::Value& b) {
  return std::bit_cast<std::array<std::uint32_t, 4>>(a) == std::bit_cast<std::array<std::uint32_t, 4>>(b);
}

// Gives a store without particles the values that all arriving ones share.
void adopt_uniform(const Description& description, std::span<const std::byte> planes, std::size_t system,
                   Store& store) {
  if (store.size() != 0) return;
  for (const SavedPlane& plane : description.planes) {
    if (plane.system != static_cast<std::int32_t>(system) || plane.kind != Plane::uniform) continue;
    const int attribute = store.schema().find(plane.attribute);
    if (attribute >= 0 && store.uniform(attribute)) store.set_uniform(attribute, shared_value(plane, planes));
  }
}

// Runs copies in ranges, on all threads.
void run(threads::Pool& pool, const std::vector<std::pair<std::span<const std::byte>, std::byte*>>& copies) {
  std::vector<std::pair<std::span<const std::byte>, std::byte*>> ranges;
  for (const auto& [from, to] : copies) {
    for (std::size_t at = 0; at < from.size(); at += kRange) {
      ranges.emplace_back(from.subspan(at, std::min(kRange, from.size() - at)), to + at);
    }
  }
  pool.run(ranges.size(), [&](std::size_t i, std::size_t) {
    std::memcpy(ranges[i].second, ranges[i].first.data(), ranges[i].first.size());
  });
}

// Copies ids as 64-bit numbers. `planes` need not be aligned.
void copy_ids(const Store& store, std::byte* planes, threads::Pool& pool) {
  threads::over_ranges(pool, store.size(), kRange / sizeof(std::uint64_t), [&](std::size_t first, std::size_t last) {
    std::array<std::uint64_t, particles::kBlock> whole;
    for (std::size_t at = first; at < last; at += whole.size()) {
      const std::size_t count = std::min(whole.size(), last - at);
      particles::join(store.ids().from(at), count, whole.data());
      std::memcpy(planes + at * sizeof whole[0], whole.data(), count * sizeof whole[0]);
    }
  });
}

void append_ids(std::span<const std::byte> planes, std::size_t before, Store& store) {
  std::array<std::uint64_t, particles::kBlock> whole;
  for (std::size_t at = 0; at < planes.size(); at += sizeof whole) {
    const std::size_t bytes = std::min(sizeof whole, planes.size() - at);
    std::memcpy(whole.data(), planes.data() + at, bytes);
    store.set_ids(before + at / sizeof whole[0], std::span(whole).first(bytes / sizeof whole[0]));
  }
}

void copy_touch_counts(const Store& store, std::byte* planes) {
  for (std::size_t i = 0; i < store.size(); ++i) {
    const auto count = static_cast<std::uint32_t>(store.touches(i).size());
    std::memcpy(planes + i * sizeof count, &count, sizeof count);
  }
}

void copy_touches(const Store& store, std::byte* planes) {
  for (std::size_t i = 0; i < store.size(); ++i) {
    const auto touches = std::as_bytes(store.touches(i));
    std::copy(touches.begin(), touches.end(), planes);
    planes += touches.size();
  }
}

// Appends the touches of particles first .. last - 1 of a part to those of the store from index `to` on.
void append_touches(std::span<const std::byte> counts, std::span<const std::byte> touches, std::uint64_t first,
                    std::uint64_t last, std::size_t to, Store& store) {
  std::vector<Touch> row;
  std::size_t before = 0;
  if (counts.size() < last * sizeof(std::uint32_t)) damaged("it has touches without a count per particle");
  for (std::uint64_t i = 0; i < last; ++i) {
    std::uint32_t count = 0;
    std::memcpy(&count, counts.data() + i * sizeof count, sizeof count);
    const std::size_t bytes = std::size_t{count} * sizeof(Touch);
    if (bytes > touches.size() - before) damaged("it has fewer touches than its counts");
    if (i >= first) {
      row.resize(count);
      if (count != 0) std::memcpy(row.data(), touches.data() + before, bytes);
      store.set_touches(to + (i - first), row);
    }
    before += bytes;
  }
}

std::string quoted(const std::string& text) {
  std::string json(1, '"');
  for (const char c : text) {
    constexpr const char* kHex = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20) {
      json.append("\\u00").append(1, kHex[byte >> 4]).append(1, kHex[byte & 15]);
      continue;
    }
    if (c == '"' || c == '\\') json += '\\';
    json += c;
  }
  return json += '"';
}

std::string tensor(const std::string& name, const std::string& dtype, const std::string& shape, std::uint64_t begin,
                   std::uint64_t end) {
  return quoted(name) + R"(:{"dtype":")" + dtype + R"(","shape":[)" + shape + R"(],"data_offsets":[)" +
         std::to_string(begin) + "," + std::to_string(end) + "]}";
}

// Returns a plane's name: "id", "position.x", or "color" if all particles share it.
std::string name_of(const SavedPlane& plane) {
  switch (plane.kind) {
    case Plane::ids: return "id";
    case Plane::touch_counts: return "touch_counts";
    case Plane::touches: return "touches";
    case Plane::uniform: return plane.attribute;
    default: break;
  }
  std::string name = plane.attribute;
  if (plane.width > 1) name.append(".").append(1, "xyzw"[plane.component]);
  return name;
}

// Returns the JSON entry of a plane, such as "snow/position.x": F32 [n].
std::string tensor(const Description& description, const SavedPlane& plane, std::uint64_t before) {
  const SavedSystem& system = description.systems[static_cast<std::size_t>(plane.system)];
  const std::string rows = std::to_string(system.rows);
  const std::uint64_t begin = before + plane.offset;
  const auto entry = [&](const std::string& dtype, const std::string& shape) {
    return tensor(system.name + "/" + name_of(plane), dtype, shape, begin, begin + plane.bytes);
  };
  switch (plane.kind) {
    case Plane::ids: return entry("U64", rows);
    case Plane::touch_counts: return entry("U32", rows);
    case Plane::touches:
      return entry("U8", std::to_string(plane.bytes / sizeof(Touch)) + "," + std::to_string(sizeof(Touch)));
    case Plane::uniform: return entry("F32", std::to_string(plane.width));
    default: return entry("F32", rows);
  }
}

// Precedes the description in the file's first tensor.
struct Mark {
  std::array<char, 8> magic = {'m', 'o', 't', 'e', 's', '-', 'p', '1'};
  std::uint64_t bytes = 0;  // of the description, padded to a multiple of eight
  std::uint32_t crc = 0;    // of the description
  std::uint32_t reserved = 0;
};
static_assert(sizeof(Mark) == 24);

}  // namespace

void copy(const std::vector<const Store*>& stores, Description& description, Bytes& out, threads::Pool& pool) {
  description.planes.clear();
  std::vector<PlaneBytes> sources;
  std::uint64_t end = 0;
  for (std::size_t i = 0; i < stores.size(); ++i) {
    description.systems[i].rows = stores[i]->size();
    describe(*stores[i], static_cast<std::int32_t>(i), description, sources, end);
  }
  std::byte* planes = out.extend(end);
  std::vector<std::pair<std::span<const std::byte>, std::byte*>> copies;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    std::byte* to = planes + sources[i].offset;
    if (sources[i].from != nullptr) {
      copies.push_back({{static_cast<const std::byte*>(sources[i].from), sources[i].bytes}, to});
      continue;
    }
    const SavedPlane& plane = description.planes[i];
    const Store& store = *stores[static_cast<std::size_t>(plane.system)];
    if (plane.kind == Plane::ids) copy_ids(store, to, pool);
    if (plane.kind == Plane::touch_counts) copy_touch_counts(store, to);
    if (plane.kind == Plane::touches) copy_touches(store, to);
    if (plane.kind != Plane::uniform) continue;
    const particles::Value value = store.uniform_value(store.schema().find(plane.attribute));
    std::memcpy(to, value.data(), sources[i].bytes);
  }
  run(pool, copies);
}

void append(const Description& description, std::span<const std::byte> planes, std::size_t system, std::uint64_t first,
            std::uint64_t last, Store& store, threads::Pool& pool) {
  if (first > last || last > description.systems.at(system).rows)
    damaged("it has fewer particles than its description");
  const std::uint64_t count = last - first;
  if (count == 0) return;
  adopt_uniform(description, planes, system, store);
  const std::size_t before = store.grow(count);
  std::vector<std::pair<std::span<const std::byte>, std::byte*>> copies;
  std::vector<bool> given(static_cast<std::size_t>(store.schema().size()), false);
  std::span<const std::byte> counts;  // of touches, whose plane follows
  bool has_ids = false;
  for (const SavedPlane& plane : description.planes) {
    if (plane.system != static_cast<std::int32_t>(system)) continue;
    if (plane.kind == Plane::ids) {
      has_ids = true;
      append_ids(values(plane, planes, first, count), before, store);
      continue;
    }
    if (plane.kind == Plane::touch_counts) {
      counts = bytes_of(plane, planes);
      continue;
    }
    if (plane.kind == Plane::touches) {
      append_touches(counts, bytes_of(plane, planes), first, last, before, store);
      continue;
    }
    const int attribute = store.schema().find(plane.attribute);
    if (attribute < 0 || store.schema()[attribute].width != plane.width || plane.component < 0 ||
        plane.component >= plane.width) {
      damaged("system '" + description.systems[system].name + "' has an attribute '" + plane.attribute +
              "' that the script's system lacks");
    }
    given[static_cast<std::size_t>(attribute)] = true;
    if (plane.kind == Plane::component) {
      copies.emplace_back(values(plane, planes, first, count),
                          reinterpret_cast<std::byte*>(store.writable_plane(attribute, plane.component) + before));
      continue;
    }
    const particles::Value value = shared_value(plane, planes);
    if (store.uniform(attribute) && same(store.uniform_value(attribute), value)) continue;
    for (int c = 0; c < plane.width; ++c) {
      std::fill_n(store.writable_plane(attribute, c) + before, count, value[static_cast<std::size_t>(c)]);
    }
  }
  if (!has_ids || std::find(given.begin(), given.end(), false) != given.end()) damaged("a plane is missing");
  run(pool, copies);
}

Bytes head(Description& description, std::span<const std::byte> planes) {
  for (SavedPlane& plane : description.planes) plane.crc = base::crc32c(bytes_of(plane, planes));
  Bytes described;
  base::write_fields(description, described);
  while (described.size() % sizeof(std::uint64_t) != 0) described.put(std::uint8_t{0});
  Mark mark;
  mark.bytes = described.size();
  mark.crc = base::crc32c(described.view());
  const std::uint64_t before = sizeof mark + described.size();
  std::string json = R"({"__metadata__":{"format":"motes checkpoint part","frame":")" +
                     std::to_string(description.frame) + R"(","part":")" + std::to_string(description.part) + R"("},)" +
                     tensor("motes", "U8", std::to_string(before), 0, before);
  for (const SavedPlane& plane : description.planes) json.append(",").append(tensor(description, plane, before));
  json += '}';
  while (json.size() % sizeof(std::uint64_t) != 0) json += ' ';
  Bytes bytes;
  bytes.put(static_cast<std::uint64_t>(json.size()));
  bytes.put_raw(json.data(), json.size());
  bytes.put_raw(&mark, sizeof mark);
  bytes.put_raw(described.data(), described.size());
  return bytes;
}

Opened open(std::span<const std::byte> file, bool sums) {
  Reader in(file);
  if (in.left() < sizeof(std::uint64_t)) damaged("it ends too early");
  const auto json = in.get<std::uint64_t>();
  if (json > in.left() || in.left() - json < sizeof(Mark)) damaged("it ends too early");
  in.take(json);
  const auto mark = in.get<Mark>();
  if (mark.magic != Mark{}.magic) damaged("it is not a part of a checkpoint of this version");
  if (mark.bytes > in.left()) damaged("it ends too early");
  const auto described = in.take(mark.bytes);
  if (base::crc32c(described) != mark.crc) damaged("its description has changed");
  Opened opened;
  Reader fields(described);
  base::read_fields(fields, opened.description);
  opened.planes = in.take(in.left());
  std::uint64_t end = 0;
  for (const SavedPlane& plane : opened.description.planes) {
    check(plane, opened.description, opened.planes);
    end = std::max(end, plane.offset + plane.bytes);
    if (sums && base::crc32c(bytes_of(plane, opened.planes)) != plane.crc)
      damaged("'" + name_of(plane) + "' has changed");
  }
  if (end != opened.planes.size()) damaged("its length differs from its description");
  return opened;
}

}  // namespace motes::snapshots
