// The columns of a store in the form that kernels need: one pointer per component.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "particles/store.h"

namespace motes::program {

/// The planes of some attributes (one bit each) at a block's first particle. A uniform attribute gives a page filled
/// with its value, which must not be written to.
class Planes {
 public:
  Planes(particles::Store& store, std::uint64_t attributes)
      : current_(static_cast<std::size_t>(store.schema().components())) {
    for (int a = 0; a < store.schema().size(); ++a) {
      if ((attributes >> a & 1u) == 0) continue;
      const particles::Attribute& attribute = store.schema()[a];
      for (int c = 0; c < attribute.width; ++c) {
        const auto at = static_cast<std::size_t>(attribute.first_component + c);
        if (store.uniform(a)) {
          pages_.emplace_back(particles::kBlock + particles::kPadding,
                              store.uniform_value(a)[static_cast<std::size_t>(c)]);
          current_[at] = pages_.back().data();
        } else {
          current_[at] = store.writable_plane(a, c);
          moving_.push_back(static_cast<std::uint16_t>(at));
        }
      }
    }
  }

  float* const* at(std::size_t particle) {
    const auto here = static_cast<std::ptrdiff_t>(particle);
    for (const std::uint16_t component : moving_) current_[component] += here - at_;
    at_ = here;
    return current_.data();
  }

 private:
  std::vector<float*> current_;
  std::vector<std::uint16_t> moving_;  // components
  std::ptrdiff_t at_ = 0;  // the particle that the planes begin at; the next one may be before it
  std::vector<std::vector<float>> pages_;
};

}  // namespace motes::program
