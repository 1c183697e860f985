// Columns of particles as NumPy arrays.
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstring>
#include <stdexcept>

#include "bindings/bindings.h"
#include "particles/rows.h"

namespace motes::bindings {
namespace {

constexpr std::size_t kCopiedTogether = 16384;  // particles

template <class T>
py::capsule keep(std::shared_ptr<T[]> memory) {
  auto* held = new std::shared_ptr<T[]>(std::move(memory));
  return py::capsule(held, [](void* p) { delete static_cast<std::shared_ptr<T[]>*>(p); });
}

}  // namespace

py::array column_view(particles::Store& store, int attribute, std::size_t begin, std::size_t end) {
  float* first = store.writable_plane(attribute, 0) + begin;
  const auto n = static_cast<py::ssize_t>(end - begin);
  const py::capsule owner = keep(store.planes(attribute));
  if (store.schema()[attribute].width == 1) return py::array_t<float>({n}, {sizeof(float)}, first, owner);
  const auto stride = static_cast<py::ssize_t>(store.plane_stride() * sizeof(float));
  const auto width = static_cast<py::ssize_t>(store.schema()[attribute].width);
  return py::array_t<float>({n, width}, {static_cast<py::ssize_t>(sizeof(float)), stride}, first, owner);
}

py::array id_copy(const particles::Store& store, std::size_t begin, std::size_t end) {
  std::vector<std::uint64_t> whole(end - begin);
  particles::join(store.ids().from(begin), whole.size(), whole.data());
  const auto n = static_cast<py::ssize_t>(whole.size());
  return owned_array(std::move(whole), {n});
}

namespace {

bool same_bits(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

bool all_are(const particles::Store& store, int attribute, int component, float wanted, std::size_t count) {
  const float* plane = store.plane(attribute, component);
  if (plane == nullptr) return same_bits(store.uniform_value(attribute)[static_cast<std::size_t>(component)], wanted);
  return std::all_of(plane, plane + count, [&](float value) { return same_bits(value, wanted); });
}

// Copies rows first .. last - 1 into an array of rows.
void copy_rows(const particles::Store& store, int attribute, std::size_t first, std::size_t last, float* rows) {
  const particles::Value all = store.uniform_value(attribute);
  const auto width = static_cast<std::size_t>(store.schema()[attribute].width);
  if (width == 1) {
    const float* plane = store.plane(attribute, 0);
    if (plane == nullptr) {
      std::fill(rows + first, rows + last, all[0]);
    } else {
      std::copy(plane + first, plane + last, rows + first);
    }
    return;
  }
  if (store.uniform(attribute)) {
    for (std::size_t i = first; i < last; ++i) std::copy_n(all.begin(), width, rows + width * i);
    return;
  }
  if (width != 3) {
    for (std::size_t c = 0; c < width; ++c) {
      const float* plane = store.plane(attribute, static_cast<int>(c));
      for (std::size_t i = first; i < last; ++i) rows[width * i + c] = plane[i];
    }
    return;
  }
  const float* x = store.plane(attribute, 0);
  const float* y = store.plane(attribute, 1);
  const float* z = store.plane(attribute, 2);
  for (std::size_t i = first; i < last; ++i) {
    rows[3 * i] = x[i];
    rows[3 * i + 1] = y[i];
    rows[3 * i + 2] = z[i];
  }
}

}  // namespace

py::list column_copies(const particles::Store& store, const std::vector<int>& attributes, std::size_t count,
                       threads::Pool& pool) {
  py::list arrays;
  std::vector<float*> rows;
  const auto n = static_cast<py::ssize_t>(count);
  for (const int attribute : attributes) {
    const int width = store.schema()[attribute].width;
    py::array_t<float> array(width == 1 ? std::vector<py::ssize_t>{n} : std::vector<py::ssize_t>{n, width});
    rows.push_back(array.mutable_data());
    arrays.append(array);
  }
  py::array_t<std::uint64_t> ids(n);
  std::uint64_t* id_rows = ids.mutable_data();
  arrays.append(ids);
  released([&] {
    threads::over_ranges(pool, count, kCopiedTogether, [&](std::size_t first, std::size_t last) {
      for (std::size_t a = 0; a < rows.size(); ++a) copy_rows(store, attributes[a], first, last, rows[a]);
      particles::join(store.ids().from(first), last - first, id_rows + first);
    });
  });
  return arrays;
}

namespace {

// Copies rows to the planes of their attribute. Returns whether all values are finite.
bool fill_planes(particles::Store& store, const Rows& rows, threads::Pool& pool) {
  constexpr std::size_t kTogether = 4096;
  const bool doubles = rows.values.dtype().itemsize() == sizeof(double);
  const particles::GivenRows from{rows.values.data(), rows.values.ndim() == 2 ? 3 : 1, doubles};
  float* planes[3] = {};
  for (int c = 0; c < from.width; ++c) planes[c] = store.writable_plane(rows.attribute, c);
  return released([&] {
    std::atomic<bool> finite{true};
    threads::over_ranges(pool, store.size(), kTogether, [&](std::size_t first, std::size_t last) {
      if (!particles::to_planes(from, first, last, planes)) finite = false;
    });
    return finite.load();
  });
}

// Returns a single row as an attribute's value; a single number counts for all components.
particles::Value value_of(const Rows& rows) {
  const py::array_t<double> numbers(rows.values);
  particles::Value value{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto at = numbers.size() == 1 ? py::ssize_t{0} : static_cast<py::ssize_t>(c);
    value[c] = static_cast<float>(numbers.data()[at]);
  }
  return value;
}

void number_by_place(particles::Store& store, threads::Pool& pool) {
  const float* planes[3] = {};
  for (int c = 0; c < 3; ++c) planes[c] = store.plane(particles::position, c);
  threads::over_ranges(pool, store.size(), kCopiedTogether, [&](std::size_t first, std::size_t last) {
    std::vector<std::uint64_t> ids(last - first);  // below 2^32
    for (std::size_t i = first; i < last; ++i) {
      std::uint32_t bits = 0;
      for (const float* plane : planes) bits = (bits ^ std::bit_cast<std::uint32_t>(plane[i])) * 0x9E3779B1u;
      ids[i - first] = bits ^ bits >> 15;
    }
    store.set_ids(first, ids);
  });
}

}  // namespace

int fill(particles::Store& store, std::size_t count, const std::vector<Rows>& columns, bool numbered,
         threads::Pool& pool) {
  for (const Rows& rows : columns) {
    if (rows.attribute == particles::position || rows.values.shape(0) != 1) continue;
    store.forget(rows.attribute);
    store.set_uniform(rows.attribute, value_of(rows));
  }
  store.grow(count);
  for (const Rows& rows : columns) {
    if (rows.attribute != particles::position && rows.values.shape(0) == 1) continue;
    if (rows.values.shape(0) != static_cast<py::ssize_t>(count)) throw std::invalid_argument("fill: one row each");
    if (!fill_planes(store, rows, pool)) return rows.attribute;
  }
  if (numbered) released([&] { number_by_place(store, pool); });
  return -1;
}

namespace {

// The order of ids jumps; without prefetching this many rows ahead, each jump would wait for memory.
constexpr std::size_t kRowsAhead = 32;

template <std::size_t kBytes>
void take(const std::byte* rows, const std::int64_t* order, std::size_t count, std::byte* into) {
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t next = std::min(k + kRowsAhead, count - 1);
    __builtin_prefetch(rows + kBytes * static_cast<std::size_t>(order[next]));
    std::memcpy(into + kBytes * k, rows + kBytes * static_cast<std::size_t>(order[k]), kBytes);
  }
}

}  // namespace

void take_rows(const py::array& rows, const py::array_t<std::int64_t>& order, py::array& into) {
  const auto count = static_cast<std::size_t>(order.size());
  if (count == 0) return;
  const auto there = static_cast<std::uint64_t>(rows.ndim() == 0 ? 0 : rows.shape(0));
  const auto bytes = static_cast<std::size_t>(rows.nbytes()) / std::max<std::size_t>(there, 1);
  const bool fits = into.nbytes() == static_cast<py::ssize_t>(count * bytes) && (rows.flags() & py::array::c_style) &&
                    (into.flags() & py::array::c_style) && (order.flags() & py::array::c_style);
  if (!fits) throw std::invalid_argument("take_rows: arrays must be in C order, with one row per number of the order");
  const std::int64_t* first = order.data();
  const auto* from = static_cast<const std::byte*>(rows.data());
  auto* to = static_cast<std::byte*>(into.mutable_data());
  released([&] {
    const bool known =
        std::all_of(first, first + count, [&](std::int64_t row) { return static_cast<std::uint64_t>(row) < there; });
    if (!known) throw std::out_of_range("take_rows: the order has a row that does not exist");
    if (bytes == 4) return take<4>(from, first, count, to);
    if (bytes == 8) return take<8>(from, first, count, to);
    if (bytes == 12) return take<12>(from, first, count, to);
    if (bytes == 16) return take<16>(from, first, count, to);
    throw std::invalid_argument("take_rows: rows must have 4, 8, 12 or 16 bytes");
  });
}

std::vector<bool> used_attributes(const particles::Store& store, std::size_t count) {
  std::vector<bool> used;
  for (int attribute = 0; attribute < store.schema().size(); ++attribute) {
    const particles::Attribute& facts = store.schema()[attribute];
    bool same = true;
    if (attribute == particles::landing) {  // only `rest` needs it
      used.push_back(false);
      continue;
    }
    for (int c = 0; c < facts.width && same && count > 0; ++c) {
      same = all_are(store, attribute, c, facts.initial[static_cast<std::size_t>(c)], count);
    }
    used.push_back(!same);
  }
  return used;
}

py::array column_copy(const particles::Store& store, int attribute) {
  const int width = store.schema()[attribute].width;
  const auto n = static_cast<py::ssize_t>(store.size());
  std::vector<float> values(store.size() * static_cast<std::size_t>(width));
  for (int c = 0; c < width; ++c) {
    const float* plane = store.plane(attribute, c);
    const float all = store.uniform_value(attribute)[static_cast<std::size_t>(c)];
    for (std::size_t i = 0; i < store.size(); ++i) {
      values[i * static_cast<std::size_t>(width) + static_cast<std::size_t>(c)] = plane != nullptr ? plane[i] : all;
    }
  }
  if (width == 1) return owned_array(std::move(values), {n});
  return owned_array(std::move(values), {n, py::ssize_t{width}});
}

}  // namespace motes::bindings
