// Columns of particles as NumPy arrays.
#include "bindings/bindings.h"

namespace motes::bindings {
namespace {

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
  return py::array_t<float>({n, py::ssize_t{3}}, {static_cast<py::ssize_t>(sizeof(float)), stride}, first, owner);
}

py::array id_view(particles::Store& store, std::size_t begin, std::size_t end) {
  store.reserve(1);
  const auto n = static_cast<py::ssize_t>(end - begin);
  py::array_t<std::uint64_t> ids({n}, {sizeof(std::uint64_t)}, store.ids() + begin, keep(store.shared_ids()));
  py::object flags = ids.attr("flags");
  flags.attr("writeable") = false;  // ids never change
  return ids;
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
  return owned_array(std::move(values), {n, py::ssize_t{3}});
}

}  // namespace motes::bindings
