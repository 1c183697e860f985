#include "program/select.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "actions/action.h"
#include "actions/kernels.h"
#include "program/planes.h"
#include "simd/float_mode.h"

namespace motes::program {

using particles::kBlock;

std::vector<std::uint32_t> select(const actions::Expression& where, const std::vector<shapes::Shape>& shapes,
                                  double time, particles::Store& store, std::size_t begin) {
  std::vector<std::uint32_t> chosen;
  if (begin >= store.size()) return chosen;
  if (where.empty()) {
    chosen.resize(store.size() - begin);
    std::iota(chosen.begin(), chosen.end(), static_cast<std::uint32_t>(begin));
    return chosen;
  }
  const simd::FloatMode mode;
  std::vector<float> scratch(actions::kScratch);
  Planes planes(store, actions::columns_of(where, store.schema()));
  for (std::size_t at = begin; at < store.size(); at += kBlock) {
    const actions::Block block{std::min(kBlock, store.size() - at), planes.at(at), store.ids().from(at), nullptr};
    actions::kernels().evaluate(where.data(), where.size(), shapes.data(), block, static_cast<float>(time),
                                scratch.data());
    for (std::size_t i = 0; i < block.count; ++i) {
      std::uint32_t truth;
      std::memcpy(&truth, &scratch[i], sizeof truth);
      if (truth != 0) chosen.push_back(static_cast<std::uint32_t>(at + i));
    }
  }
  return chosen;
}

}  // namespace motes::program
