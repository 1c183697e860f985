#include "particles/store.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "base/memory.h"

namespace motes::particles {
namespace {

bool same_bits(Value a, Value b, int width) {
  return std::memcmp(a.data(), b.data(), sizeof(float) * static_cast<std::size_t>(width)) == 0;
}

// A column of packed particles holds the default initial value, another value shared by all, or separate values.
enum class Packed : std::uint8_t { initial, uniform, planes };

// Values per work item when threads copy: enough that fetching an item costs nothing.
constexpr std::size_t kRange = std::size_t{1} << 15;

// Number of values in all columns below which waking other threads costs more than it saves: for contiguous values, and
// for values in separate cache lines.
constexpr std::size_t kAlone = std::size_t{1} << 15, kAloneApart = std::size_t{1} << 11;

// Calls work(column, first, last) for ranges of 0..count of each column.
template <class Column, class Work>
void over_columns(threads::Pool& pool, const std::vector<Column>& columns, std::size_t count, std::size_t alone,
                  const Work& work) {
  if (count * columns.size() < pool.items(alone)) {
    for (const Column& column : columns) work(column, 0, count);
    return;
  }
  const std::size_t range = pool.items(kRange);
  const std::size_t ranges = (count + range - 1) / range;
  pool.run(ranges * columns.size(), [&](std::size_t part, std::size_t) {
    const std::size_t first = part % ranges * range;
    work(columns[part / ranges], first, std::min(count, first + range));
  });
}

// One column of a message: its values are contiguous.
struct PackedColumn {
  const void* plane;  // of floats or of halves of ids
  std::byte* bytes;
};

void gather(const PackedColumn& column, std::span<const std::uint32_t> indices, std::size_t first, std::size_t last) {
  const auto* plane = static_cast<const float*>(column.plane);
  for (std::size_t k = first; k < last; ++k)
    std::memcpy(column.bytes + k * sizeof(float), plane + indices[k], sizeof(float));
}

// Large allocations start on a page, so all columns would map to the same cache sets: eight of them fill sets of eight
// ways, and a step takes 1.5 times as long. Therefore each column's offset within its page is kApart values larger than
// that of the column before it. Short columns fit into the cache anyway.
constexpr std::size_t kOfPage = base::kPage / 4, kApart = 128;  // values of four bytes
constexpr std::size_t kShort = 4 * kOfPage;

// Planes of fewer bytes are cleared: their memory may hold old values, and vectors read beyond the last particle.
constexpr std::size_t kZeroed = std::size_t{4} << 20;

// Returns the distance in values between columns of one attribute. Columns begin on a cache line and have room for
// whole vectors after the last particle.
std::size_t stride_for(std::size_t capacity) {
  const std::size_t blocks = (capacity + kPadding + kBlock - 1) / kBlock * kBlock;
  return blocks <= kShort ? blocks : (blocks - kApart + kOfPage - 1) / kOfPage * kOfPage + kApart;
}

// The ids have the offset of the eighth column.
constexpr int kIds = 7;

// Returns the offset of a column within its page, in values.
std::size_t values_before(std::size_t count, int column) {
  return count <= kShort ? 0 : static_cast<std::size_t>(column) * kApart % kOfPage;
}

// Allocates `count` values at the offset of column number `column`, aligned to a cache line.
template <class T>
std::shared_ptr<T[]> take_plane(PlaneMemory& from, std::size_t count, int column) {
  const std::size_t before = values_before(count, column);
  const std::size_t bytes = (before + count) * sizeof(T);
  std::shared_ptr<std::byte[]> memory = from.take(bytes);
  if (bytes < kZeroed) std::memset(memory.get(), 0, bytes);
  T* first = reinterpret_cast<T*>(memory.get()) + before;
  return std::shared_ptr<T[]>(first, [memory = std::move(memory)](T*) {});
}

template <class T>
std::size_t bytes_of_plane(std::size_t count, int column) {
  return base::whole_pages((values_before(count, column) + count) * sizeof(T));
}

}  // namespace

Store::Store(const Schema& schema) : schema_(&schema), columns_(static_cast<std::size_t>(schema.size())) {
  for (int a = 0; a < schema.size(); ++a) columns_[index(a)].value = schema[a].initial;
}

const float* Store::plane(int attribute, int component) const {
  const Column& column = columns_[index(attribute)];
  return column.planes ? column.planes.get() + static_cast<std::size_t>(component) * capacity_ : nullptr;
}

float* Store::writable_plane(int attribute, int component) {
  materialize(attribute);
  return columns_[index(attribute)].planes.get() + static_cast<std::size_t>(component) * capacity_;
}

void Store::materialize(int attribute) {
  Column& column = columns_[index(attribute)];
  if (column.planes) return;
  if (capacity_ == 0) reserve(kBlock);
  const auto components = static_cast<std::size_t>(width(attribute));
  column.planes = take_plane<float>(memory_, components * capacity_, (*schema_)[attribute].first_component);
  const std::size_t filled = (size_ + kPadding - 1) / kPadding * kPadding;
  for (std::size_t c = 0; c < components; ++c) {
    float* plane = column.planes.get() + c * capacity_;
    for (std::size_t i = 0; i < filled; ++i) plane[i] = column.value[c];
  }
}

void Store::set_touches(std::size_t i, std::span<const Touch> touches) {
  if (!touches_) {
    if (capacity_ == 0) reserve(kBlock);
    touches_ = take_plane<TouchRow>(memory_, capacity_, 0);
    std::fill_n(touches_.get(), size_, TouchRow{});
  }
  memory_of_touches_.set(touches_.get()[i], touches);
}

std::uint32_t* Store::writable_upper_ids() {
  if (!upper_ids_) {
    upper_ids_ = take_plane<std::uint32_t>(memory_, capacity_, kIds);
    std::fill_n(upper_ids_.get(), size_, 0u);
  }
  return upper_ids_.get();
}

void Store::set_ids(std::size_t first, std::span<const std::uint64_t> ids) {
  std::uint64_t all = 0;
  for (std::uint32_t* lower = lower_ids_.get() + first; const std::uint64_t id : ids) {
    *lower++ = lower_half(id);
    all |= id;
  }
  if (!upper_ids_ && upper_half(all) == 0) return;
  std::transform(ids.begin(), ids.end(), writable_upper_ids() + first, upper_half);
}

void Store::part_from_holders() {
  PlaneMemory apart;  // separate, since holders may let go at any time and parts of a block are not reused
  const auto renew = [&](auto& memory, std::size_t count, int column) {
    if (!memory || memory.use_count() == 1) return;
    auto fresh = take_plane<std::remove_cvref_t<decltype(memory[0])>>(apart, count, column);
    std::memcpy(fresh.get(), memory.get(), count * sizeof(memory[0]));
    memory = std::move(fresh);
  };
  for (int a = 0; a < schema_->size(); ++a) {
    renew(columns_[index(a)].planes, static_cast<std::size_t>(width(a)) * capacity_, (*schema_)[a].first_component);
  }
}

std::size_t Store::bytes_of_planes(std::size_t capacity) const {
  std::size_t bytes = (upper_ids_ ? 2 : 1) * bytes_of_plane<std::uint32_t>(capacity, kIds);
  for (int a = 0; a < schema_->size(); ++a) {
    if (uniform(a)) continue;
    bytes += bytes_of_plane<float>(static_cast<std::size_t>(width(a)) * capacity, (*schema_)[a].first_component);
  }
  return bytes + (touches_ ? bytes_of_plane<TouchRow>(capacity, 0) : 0);
}

void Store::reserve(std::size_t capacity) {
  if (capacity_ != 0 && capacity + kPadding <= capacity_) return;
  const std::size_t rounded = stride_for(capacity);
  PlaneMemory memory(bytes_of_planes(rounded));
  const auto longer = [&](const std::shared_ptr<std::uint32_t[]>& halves) {
    auto plane = take_plane<std::uint32_t>(memory, rounded, kIds);
    if (size_ != 0) std::memcpy(plane.get(), halves.get(), size_ * sizeof(std::uint32_t));
    return plane;
  };
  auto lower_ids = longer(lower_ids_);
  auto upper_ids = upper_ids_ ? longer(upper_ids_) : nullptr;
  std::vector<std::shared_ptr<float[]>> wider(columns_.size());
  for (int a = 0; a < schema_->size(); ++a) {
    const Column& column = columns_[index(a)];
    if (!column.planes) continue;
    const auto components = static_cast<std::size_t>(width(a));
    wider[index(a)] = take_plane<float>(memory, components * rounded, (*schema_)[a].first_component);
    for (std::size_t c = 0; c < components && size_ != 0; ++c) {
      std::memcpy(wider[index(a)].get() + c * rounded, column.planes.get() + c * capacity_, size_ * sizeof(float));
    }
  }
  std::shared_ptr<TouchRow[]> touches;
  if (touches_) {
    memory_of_touches_.tidy({touches_.get(), size_});
    touches = take_plane<TouchRow>(memory, rounded, 0);
    std::copy_n(touches_.get(), size_, touches.get());
  }
  for (std::size_t a = 0; a < columns_.size(); ++a) {
    if (wider[a]) columns_[a].planes = std::move(wider[a]);
  }
  touches_ = std::move(touches);
  lower_ids_ = std::move(lower_ids);
  upper_ids_ = std::move(upper_ids);
  memory_ = std::move(memory);
  capacity_ = rounded;
}

void Store::make_room(std::size_t count) {
  if (count > UINT32_MAX - size_) {
    throw std::length_error(
        "a system would have " + std::to_string(size_ + count) +
        " particles on one rank, but at most 4294967295 fit: use more ranks, or give it a capacity");
  }
  if (size_ + count + kPadding <= capacity_) return;
  reserve(std::max(size_ + count, capacity_ + capacity_ / 2));
}

std::size_t Store::grow(std::size_t count) {
  make_room(count);
  const std::size_t first = size_;
  size_ += count;
  if (touches_) std::fill_n(touches_.get() + first, count, TouchRow{});
  if (upper_ids_) std::fill_n(upper_ids_.get() + first, count, 0u);
  return first;
}

void Store::set_uniform(int attribute, Value value) {
  Column& column = columns_[index(attribute)];
  if (size_ != 0 || column.planes) throw std::logic_error("set_uniform needs an empty store");
  column.value = value;
}

void Store::copy_attribute(int from, int to) {
  if (uniform(from)) {
    columns_[index(to)] = {nullptr, uniform_value(from)};
    return;
  }
  for (int c = 0; c < width(to); ++c) std::memcpy(writable_plane(to, c), plane(from, c), size_ * sizeof(float));
}

void Store::remove(std::span<const std::uint32_t> indices, threads::Pool& pool) {
  // Survivors above the new size fill the holes below it, each taken once, in order.
  const std::size_t left = size_ - indices.size();
  std::vector<std::uint32_t> from;
  std::size_t holes = 0;
  while (holes < indices.size() && indices[holes] < left) ++holes;
  from.reserve(holes);
  std::size_t next = holes;
  for (std::size_t i = left; i < size_; ++i) {
    if (next < indices.size() && indices[next] == i) {
      ++next;
    } else {
      from.push_back(static_cast<std::uint32_t>(i));
    }
  }
  over_columns(pool, planes_and_rows(), holes, kAloneApart,
               [&](const Plane& plane, std::size_t first, std::size_t last) {
                 plane.visit([&](auto* values) {
                   for (std::size_t h = first; h < last; ++h) values[indices[h]] = values[from[h]];
                 });
               });
  size_ = left;
  if (touches_) memory_of_touches_.tidy({touches_.get(), size_});
}

void Store::permute(std::span<const std::uint32_t> from, threads::Pool& pool) {
  if (size_ == 0) return;
  const std::vector<Plane> planes = planes_and_rows();
  std::vector<std::vector<std::byte>> before(static_cast<std::size_t>(pool.threads()));  // one per worker
  pool.run(planes.size(), [&](std::size_t part, std::size_t worker) {
    planes[part].visit([&](auto* values) {
      before[worker].resize(size_ * sizeof(values[0]));
      std::memcpy(before[worker].data(), values, before[worker].size());
      const auto* old = reinterpret_cast<const std::remove_pointer_t<decltype(values)>*>(before[worker].data());
      for (std::size_t i = 0; i < size_; ++i) values[i] = old[from[i]];
    });
  });
}

std::vector<Store::Plane> Store::planes_and_rows() const {
  std::vector<Plane> planes{{nullptr, lower_ids_.get()}};
  if (upper_ids_) planes.push_back({nullptr, upper_ids_.get()});
  for (int a = 0; a < schema_->size(); ++a) {
    const Column& column = columns_[index(a)];
    for (int c = 0; column.planes && c < width(a); ++c) {
      planes.push_back({column.planes.get() + static_cast<std::size_t>(c) * capacity_});
    }
  }
  if (touches_) planes.push_back({nullptr, nullptr, touches_.get()});
  return planes;
}

std::size_t Store::packed_bytes(std::size_t count) const {
  std::size_t each = sizeof(std::uint32_t);
  std::size_t once = sizeof(std::uint64_t) + 1 + columns_.size();
  if (upper_ids_) each += sizeof(std::uint32_t);
  for (int a = 0; a < schema_->size(); ++a) {
    (uniform(a) ? once : each) += sizeof(float) * static_cast<std::size_t>(width(a));
  }
  return once + count * each;
}

void Store::pack(std::span<const std::uint32_t> indices, base::Bytes& out, threads::Pool& pool) const {
  out.put(static_cast<std::uint64_t>(indices.size()));
  if (indices.empty()) return;
  out.reserve(out.size() + packed_bytes(indices.size()));  // so the message does not move from here on
  std::vector<PackedColumn> packed;
  const auto pack_plane = [&](const auto* plane) {
    packed.push_back({plane, out.extend(indices.size() * sizeof *plane)});
  };
  pack_plane(lower_ids_.get());
  out.put(upper_ids_ ? Packed::planes : Packed::initial);
  if (upper_ids_) pack_plane(upper_ids_.get());
  for (int a = 0; a < schema_->size(); ++a) {
    const Column& column = columns_[index(a)];
    const Packed how = column.planes                                              ? Packed::planes
                       : same_bits(column.value, (*schema_)[a].initial, width(a)) ? Packed::initial
                                                                                  : Packed::uniform;
    out.put(how);
    if (how == Packed::uniform) out.put_raw(column.value.data(), sizeof(float) * static_cast<std::size_t>(width(a)));
    for (int c = 0; how == Packed::planes && c < width(a); ++c) pack_plane(plane(a, c));
  }
  over_columns(
      pool, packed, indices.size(), kAlone,
      [&](const PackedColumn& column, std::size_t first, std::size_t last) { gather(column, indices, first, last); });
  pack_touches(indices, out);
}

// Writes how many touches each particle has, then all touches.
void Store::pack_touches(std::span<const std::uint32_t> indices, base::Bytes& out) const {
  out.put(touches_ ? Packed::planes : Packed::initial);
  if (!touches_) return;
  for (const std::uint32_t i : indices) out.put(static_cast<std::uint32_t>(touches(i).size()));
  for (const std::uint32_t i : indices) out.put_raw(touches(i).data(), touches(i).size_bytes());
}

void Store::unpack_touches(base::Reader& in, std::size_t first) {
  if (in.get<Packed>() != Packed::planes) return;
  std::vector<std::uint32_t> counts(size_ - first);
  for (std::uint32_t& count : counts) count = in.get<std::uint32_t>();
  std::vector<Touch> row;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto bytes = in.take(counts[i] * sizeof(Touch));
    row.resize(counts[i]);
    if (!row.empty()) std::memcpy(row.data(), bytes.data(), bytes.size());
    set_touches(first + i, row);
  }
}

void Store::set_added(int attribute, Value value, std::size_t first) {
  Column& column = columns_[index(attribute)];
  if (!column.planes && first == 0) column.value = value;
  if (!column.planes && same_bits(column.value, value, width(attribute))) return;
  for (int c = 0; c < width(attribute); ++c) {
    std::fill_n(writable_plane(attribute, c) + first, size_ - first, value[static_cast<std::size_t>(c)]);
  }
}

void Store::open_added(int attribute, std::size_t first) {
  if (!uniform(attribute)) return;
  const std::size_t all = std::exchange(size_, first);  // only the earlier particles have the uniform value
  materialize(attribute);
  size_ = all;
}

void Store::append(const Store& from) {
  const std::size_t count = from.size_;
  if (count == 0) return;
  const std::size_t first = grow(count);
  const auto copy = [&](auto* to, const auto* values) { std::memcpy(to + first, values, count * sizeof *values); };
  copy(lower_ids_.get(), from.lower_ids_.get());
  if (from.upper_ids_) copy(writable_upper_ids(), from.upper_ids_.get());
  for (std::size_t i = 0; i < count && from.touches_; ++i) set_touches(first + i, from.touches(i));
  for (int a = 0; a < schema_->size(); ++a) {
    if (from.uniform(a)) {
      set_added(a, from.uniform_value(a), first);
    } else {
      open_added(a, first);
      for (int c = 0; c < width(a); ++c) copy(writable_plane(a, c), from.plane(a, c));
    }
  }
}

void Store::append(const Store& from, const std::vector<std::uint32_t>& indices, threads::Pool& pool) {
  base::Bytes bytes;
  from.pack(indices, bytes, pool);
  base::Reader in(bytes.view());
  unpack(in, pool);
}

void Store::unpack(base::Reader& in, threads::Pool& pool) {
  const auto count = in.get<std::uint64_t>();
  if (count == 0) return;
  struct Arrived {
    const std::byte* bytes;
    std::byte* plane;
    std::size_t width;
  };
  const auto lower_ids = in.take(count * sizeof(std::uint32_t));
  const std::size_t first = grow(count);
  std::vector<Arrived> arrived;
  const auto arrive = [&](std::span<const std::byte> bytes, auto* plane) {
    arrived.push_back({bytes.data(), reinterpret_cast<std::byte*>(plane + first), sizeof *plane});
  };
  arrive(lower_ids, lower_ids_.get());
  if (in.get<Packed>() == Packed::planes) arrive(in.take(count * sizeof(std::uint32_t)), writable_upper_ids());
  for (int a = 0; a < schema_->size(); ++a) {
    const int components = width(a);
    const auto how = in.get<Packed>();
    if (how > Packed::planes) throw std::runtime_error("packed particles have a column of unknown kind");
    if (how == Packed::planes) {
      open_added(a, first);
      for (int c = 0; c < components; ++c) arrive(in.take(count * sizeof(float)), writable_plane(a, c));
      continue;
    }
    Value value = (*schema_)[a].initial;
    for (int c = 0; how == Packed::uniform && c < components; ++c) value[static_cast<std::size_t>(c)] = in.get<float>();
    set_added(a, value, first);
  }
  over_columns(pool, arrived, count, kAlone, [](const Arrived& column, std::size_t begin, std::size_t end) {
    std::memcpy(column.plane + begin * column.width, column.bytes + begin * column.width, (end - begin) * column.width);
  });
  unpack_touches(in, first);
}

std::size_t Store::memory_bytes() const {
  std::size_t total =
      (lower_ids_ ? capacity_ * sizeof(std::uint32_t) : 0) + (upper_ids_ ? capacity_ * sizeof(std::uint32_t) : 0);
  for (int a = 0; a < schema_->size(); ++a) {
    if (!uniform(a)) total += capacity_ * sizeof(float) * static_cast<std::size_t>(width(a));
  }
  if (touches_) total += capacity_ * sizeof(TouchRow) + memory_of_touches_.bytes();
  return total;
}

}  // namespace motes::particles
