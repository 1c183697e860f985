// interact: laws that scripts write as expressions. Sources are within reach, in the same system or in the second one,
// whose particles do not change.
#include <algorithm>
#include <utility>

#include "interactions/kinds/families.h"
#include "interactions/scratch.h"
#include "simd/float_mode.h"

namespace motes::interactions {

namespace {

using actions::Leaf;
using actions::PairLaw;
using actions::Result;
using expressions::Formula;
using particles::Store;

// Returns the compiled values of a law; those of the last few laws are cached.
const Formula& compiled(const PairLaw& law, std::vector<ScriptedMemory::Compiled>& known) {
  constexpr std::size_t kKept = 8;
  for (const ScriptedMemory::Compiled& one : known) {
    if (one.values == law.values) return one.formula;
  }
  if (known.size() == kKept) known.erase(known.begin());
  known.push_back({law.values, expressions::compile(law.values, static_cast<int>(law.leaves.size()))});
  return known.back().formula;
}

class Scripted : public PairAction {
 public:
  explicit Scripted(const Meeting& meeting) : PairAction(meeting) {}

  std::vector<Component> reads(std::size_t s) const override {
    if (between() && s == 0) return {};  // only the other system's particles are sources
    std::vector<Component> read = read_by(action());
    for (const Leaf& leaf : law_.leaves) {
      const Component one{leaf.attribute, leaf.component};
      if (leaf.of == Leaf::Of::other && std::find(read.begin(), read.end(), one) == read.end()) read.push_back(one);
    }
    return read;
  }

  bool holds(std::size_t s) override {
    return list_holds(side(s), s == 0 ? kind() : kNoted, {0.5f * reach({}), {}, {}}, meeting_);
  }

  InteractionCounts act(const Agreement& agreed) override {
    reach_ = reach(agreed);
    if (!(reach_ > 0)) return {};
    const simd::FloatMode mode;
    formula_ = &compiled(law_, scratch_.formulas);
    gather();
    list();
    InteractionCounts seen;
    if (crowd_.own == 0) {
      list_.view(now_);  // no targets, but the list counts as used in this sub-step
      return seen;
    }
    for (std::size_t c = 3; c < read_.size(); ++c) arrange(c, sources_[c]);
    for (const Leaf& leaf : law_.leaves) leaves_.push_back(source_of(leaf));
    find_results();
    run(seen);
    apply();
    if (meeting_.step.last && states() > 0) list_.write_down(*own_.store, own_.kept.law, now_);
    seen.most_in_a_cell = list_.cells().most_in_a_cell();
    return seen;
  }

 private:
  bool between() const { return meeting_.count == 2; }
  int states() const { return actions::states_of(action()); }

  NeighbourList::Kind kind() const {
    return {static_cast<std::uint32_t>((states() + kStateNumbers - 1) / kStateNumbers), 1, between()};
  }
  // The second system's list only records positions.
  static constexpr NeighbourList::Kind kNoted = {.parts = 0};

  // Gathers targets and sources. Particles of another system count as ghosts: they are sources, never targets.
  void gather() {
    crowd_.own = own_.store->size();
    crowd_.own_ids = own_.store->ids();
    const Side& seen = between() ? side(1) : own_;
    sources_ = columns_of(read_, seen);
    const Ghosts* ghosts = seen.ghosts;
    if (!between()) {
      crowd_.ghosts = ghosts != nullptr ? ghosts->ids.size() : 0;
      crowd_.copied_ids = ghosts != nullptr ? ghosts->ids.data() : nullptr;
      for (std::size_t c = 0; c < 3; ++c) crowd_.at[c] = sources_[c];
      return;
    }
    const Store& store = *seen.store;
    scratch_.ids.clear();
    for (std::size_t i = 0; i < store.size(); ++i) scratch_.ids.push_back(store.ids()[i]);
    if (ghosts != nullptr) scratch_.ids.insert(scratch_.ids.end(), ghosts->ids.begin(), ghosts->ids.end());
    scratch_.copied.resize(std::max(scratch_.copied.size(), sources_.size()));
    for (std::size_t c = 0; c < sources_.size(); ++c) {
      std::vector<float>& all = scratch_.copied[c];
      all.resize(scratch_.ids.size());
      for (std::size_t i = 0; i < all.size(); ++i) all[i] = sources_[c].of(i, store.size());
      sources_[c] = {nullptr, all.data(), 0};
    }
    crowd_.ghosts = scratch_.ids.size();
    crowd_.copied_ids = scratch_.ids.data();
    for (std::size_t c = 0; c < 3; ++c)
      crowd_.at[c] = own_column(particles::position, static_cast<int>(c), sources_[c]);
  }

  Column own_column(int attribute, int component, const Column& others) const {
    return {own_.store->plane(attribute, component), others.ghosts,
            own_.store->uniform_value(attribute)[static_cast<std::size_t>(component)]};
  }

  // Lists pairs. Two particles are within reach if spheres with half of it as radius touch.
  void list() {
    list_.set_kind(kind());
    scratch_.radius.assign(padded(crowd_.size()), 0.5f * reach_);
    scratch_.column.resize(std::max(scratch_.column.size(), read_.size()));
    if (!own_.kept.holds) list_.sort(crowd_, reach_, own_.kept.skin, pool_);
    for (std::size_t c = 0; c < 3; ++c) arrange(c, crowd_.at[c]);
    if (!own_.kept.holds) list_.build(crowd_, placed(), *own_.store, own_.kept.law, now_, pool_);
    if (between() && side(1).kept.list != nullptr) note_others();
  }

  void note_others() {
    NeighbourList& noted = *side(1).kept.list;
    noted.set_kind(kNoted);
    Crowd others;
    others.own = side(1).store->size();
    others.own_ids = side(1).store->ids();
    for (std::size_t c = 0; c < 3; ++c) others.at[c] = {sources_[c].ghosts, nullptr, 0};
    if (!own_.kept.holds) noted.note(others, 0.5f * reach_, own_.kept.skin);
    noted.view(now_);
  }

  PlacedSpheres placed() const { return {{column(0), column(1), column(2)}, scratch_.radius.data()}; }

  const float* column(std::size_t number) const { return scratch_.column[number].data(); }

  void arrange(std::size_t number, const Column& from) {
    scratch_.column[number].resize(padded(crowd_.size()));
    list_.cells().arrange(crowd_, from, scratch_.column[number].data(), pool_);
  }

  // Returns the number of the leaf's column by place, or -1 if there is none.
  int place_of(const Leaf& leaf) const {
    for (std::size_t c = 0; c < read_.size(); ++c) {
      if (read_[c].attribute == leaf.attribute && read_[c].component == leaf.component) return static_cast<int>(c);
    }
    return -1;
  }

  LeafSource source_of(const Leaf& leaf) {
    using How = LeafSource::How;
    const int place = place_of(leaf);
    switch (leaf.of) {
      case Leaf::Of::other: return {How::other, 0, column(static_cast<std::size_t>(place)), 0};
      case Leaf::Of::distance:
      case Leaf::Of::normal: {
        shares_ = true;
        return {How::shared, leaf.of == Leaf::Of::normal ? 1 + leaf.component : 0, nullptr, 0};
      }
      case Leaf::Of::state: return {How::state, leaf.component, nullptr, 0};
      case Leaf::Of::own: break;
    }
    const bool by_place = place >= 0 && (!between() || place < 3);
    if (by_place) return {How::own_by_place, 0, column(static_cast<std::size_t>(place)), 0};
    if (const float* plane = own_.store->plane(leaf.attribute, leaf.component); plane != nullptr)
      return {How::own_by_index, 0, plane, 0};
    return {How::same, 0, nullptr, own_.store->value(leaf.attribute, leaf.component, 0)};
  }

  void find_results() {
    next_.assign(static_cast<std::size_t>(states()), -1);
    for (std::size_t k = 0; k < law_.results.size(); ++k) {
      const Result& result = law_.results[k];
      if (result.how == Result::How::state) {
        next_[static_cast<std::size_t>(result.component)] = formula_->results[k];
      } else {
        sums_.push_back(formula_->results[k]);
        summed_.push_back(result);
      }
    }
    scratch_.out.resize(std::max(scratch_.out.size(), sums_.size()));
    for (std::size_t s = 0; s < sums_.size(); ++s) scratch_.out[s].resize(padded(crowd_.size()));
  }

  void run(InteractionCounts& seen) {
    std::vector<float*> out;
    for (std::size_t s = 0; s < sums_.size(); ++s) out.push_back(scratch_.out[s].data());
    ScriptedTask task{.targets = list_.cells().view(crowd_.own),
                      .pairs = list_.view(now_),
                      .at = {column(0), column(1), column(2)},
                      .reach2 = reach_ * reach_,
                      .time = static_cast<float>(meeting_.step.time),
                      .now = now_,
                      .chosen = own_.chosen != nullptr ? own_.chosen->data() : nullptr,
                      .shares = shares_};
    task.leaves = leaves_.data(), task.leaf_count = leaves_.size();
    task.constants = formula_->constants.data(), task.constant_count = formula_->constants.size();
    task.steps = formula_->steps.data(), task.step_count = formula_->steps.size();
    task.sums = sums_.data(), task.sum_count = sums_.size();
    task.states = next_.data(), task.state_count = states();
    task.out = out.data();
    const std::vector<std::size_t> cuts = parts_of(list_.cells(), pool_);
    std::vector<KernelStats> sights(cuts.size() - 1);
    pool_.run(sights.size(), [&](std::size_t part, std::size_t) {
      const simd::FloatMode mode;
      const auto planes = static_cast<std::size_t>(formula_->planes);
      std::vector<float> memory((planes + kShared) * kFormulaPlane);
      std::vector<float*> plane(planes);
      for (std::size_t p = 0; p < planes; ++p) plane[p] = memory.data() + (kShared + p) * kFormulaPlane;
      for (std::size_t leaf = 0; leaf < leaves_.size(); ++leaf) {
        if (leaves_[leaf].how != LeafSource::How::shared) continue;
        plane[leaf] = memory.data() + static_cast<std::size_t>(leaves_[leaf].number) * kFormulaPlane;
      }
      ScriptedTask rows = task;
      rows.shared = memory.data();
      rows.plane = plane.data();
      rows.first_row = cuts[part];
      rows.last_row = cuts[part + 1];
      rows.stats = &sights[part];
      kernels().scripted(rows);
    });
    for (const KernelStats& stats : sights) seen.pairs += stats.pairs;
  }

  void apply() {
    std::vector<float*> to;
    for (const Result& result : summed_) to.push_back(own_.store->writable_plane(result.attribute, result.component));
    const std::vector<std::uint32_t>& order = list_.cells().order();
    const float dt = meeting_.step.dt;
    threads::over_ranges(pool_, order.size(), kRange, [&](std::size_t first, std::size_t last) {
      const simd::FloatMode mode;
      for (std::size_t k = first; k < last; ++k) {
        const std::uint32_t i = order[k];
        if (i >= crowd_.own || (own_.chosen != nullptr && (*own_.chosen)[i] == 0)) continue;
        for (std::size_t s = 0; s < summed_.size(); ++s) {
          const float sum = scratch_.out[s][k];
          switch (summed_[s].how) {
            case Result::How::rate: to[s][i] += sum * dt; break;
            case Result::How::change: to[s][i] += sum; break;
            default: to[s][i] = sum;
          }
        }
      }
    });
  }

  const PairLaw& law_ = std::get<PairLaw>(action().specifics);
  ScriptedMemory& scratch_ = meeting_.scratch->scripted;
  const Formula* formula_ = nullptr;
  const Side& own_ = side(0);
  const std::uint32_t now_ = meeting_.step.number;
  threads::Pool& pool_ = *meeting_.pool;
  float reach_ = 0;
  NeighbourList& list_ = own_.kept.list != nullptr ? *own_.kept.list : meeting_.scratch->party[0].list;
  const std::vector<Component> read_ = reads(seen_by(0));  // components of the columns by place, as read of sources
  std::vector<Column> sources_;  // the columns they are arranged from
  Crowd crowd_;
  std::vector<LeafSource> leaves_;
  bool shares_ = false;
  std::vector<std::uint16_t> sums_;
  std::vector<Result> summed_;
  std::vector<std::int32_t> next_;  // plane of the next value of each number of the state; -1: unchanged
};

}  // namespace

std::unique_ptr<PairAction> families::scripted(const Meeting& meeting) { return std::make_unique<Scripted>(meeting); }

}  // namespace motes::interactions
