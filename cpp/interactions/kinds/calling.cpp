// pairs: a function of the script is called with all pairs of this rank, and its changes are added in their order.
#include "interactions/kinds/families.h"
#include "interactions/kinds/sweeping.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

class Calling : public Sweeping {
 public:
  using Sweeping::Sweeping;

  float reach(const Agreement&) const override {
    return static_cast<float>(actions::numbers_of<actions::numbers::pairs>(action()).radius);
  }
  double range(const Agreement& agreed) const override {
    return static_cast<double>(reach(agreed)) * (1 + 4 * kMargin);
  }

  InteractionCounts act(const Agreement& agreed) override {
    reach_ = reach(agreed);
    if (!(reach_ > 0)) return {};
    const simd::FloatMode mode;
    gather(0);
    const float* column[6];
    for (std::size_t c = 0; c < 6; ++c) column[c] = party(0).column[c].data();
    const PairList list = pairs_within(reach_, cells(0), crowds_[0], column, side(0).chosen);
    const std::vector<float> changes = meeting_.ask_script(list);
    float* v[3];
    for (int c = 0; c < 3; ++c) v[c] = side(0).store->writable_plane(particles::velocity, c);
    for (std::size_t k = 0; k < changes.size() / 3; ++k) {
      for (std::size_t c = 0; c < 3; ++c) v[c][list.own[k]] += changes[3 * k + c];
    }
    return {list.size(), cells(0).most_in_a_cell()};
  }
};

}  // namespace

std::unique_ptr<PairAction> families::calling(const Meeting& meeting) { return std::make_unique<Calling>(meeting); }

}  // namespace motes::interactions
