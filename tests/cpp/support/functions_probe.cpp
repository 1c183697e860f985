// Compiled once for each instruction set (see CMakeLists.txt).
#include "support/functions_probe.h"

#include "particles/noise.h"
#include "shapes/visit.h"
#include "simd/ieee.h"

namespace motes::MOTES_ISA {
namespace {

template <Floats (*Function)(Floats)>
void one(const float* v, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; i += kLanes) store(out + i, Function(load(v + i)));
}

template <Floats (*Function)(Floats, Floats)>
void two(const float* a, const float* b, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; i += kLanes) store(out + i, Function(load(a + i), load(b + i)));
}

Floats3 load3(const float* const* from, std::size_t i) {
  return {load(from[0] + i), load(from[1] + i), load(from[2] + i)};
}

void store3(float* const* to, std::size_t i, const Floats3& v) {
  store(to[0] + i, v.x);
  store(to[1] + i, v.y);
  store(to[2] + i, v.z);
}

void curls(const float* const* p, std::size_t count, int octaves, double time, std::uint32_t seed, float* const* out) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    store3(out, i, curl(load3(p, i), octaves, 0.5f, time, {{seed, 7}, 3}));
  }
}

void noises(const float* const* p, std::size_t count, int octaves, std::uint32_t field, float* out) {
  for (std::size_t i = 0; i < count; i += kLanes) store(out + i, noise(load3(p, i), load(p[3] + i), octaves, field));
}

void hits(const shapes::Shape& shape, const float* const* p, const float* const* path, std::size_t count, float* part,
          float* const* normal) {
  visit(shape, [&](const auto& lanes) {
    for (std::size_t i = 0; i < count; i += kLanes) {
      const Hit hit = lanes.hit(load3(p, i), load3(path, i));
      store(part + i, select(hit.mask, hit.part, all(-1.0f)));
      store3(normal, i, hit.normal);
    }
  });
}

void nears(const shapes::Shape& box, const float* const* p, const float* const* velocity, float dt, std::size_t count,
           float* exact, float* first) {
  const BoxLanes lanes = BoxLanes::from(box);
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Floats3 x = load3(p, i), v = load3(velocity, i);
    store(exact + i, only(lanes.may_meet(x, x + v * dt), all(1.0f)));
    store(first + i, only(lanes.clear().may_meet(x, v, dt), all(1.0f)));
  }
}

}  // namespace

extern const test::FunctionsProbe functions_probe;
const test::FunctionsProbe functions_probe = {one<sin>,   one<cos>,   one<exp>,         one<exp2>,  one<log>,
                                              one<asin>,  one<acos>,  one<natural_log>, one<floor>, two<pow>,
                                              two<atan2>, two<power>, two<modulo>,      curls,      noises,
                                              hits,       nears};

}  // namespace motes::MOTES_ISA
