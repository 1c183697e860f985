// Laws that add up what each target gets from the sources within reach, by a kernel over a cell list. Families with
// more to do around the sweep derive from it.
#pragma once

#include <vector>

#include "interactions/overlap.h"
#include "interactions/pair_action.h"
#include "interactions/scratch.h"

namespace motes::interactions {

class Sweeping : public PairAction {
 public:
  explicit Sweeping(const Meeting& meeting) : PairAction(meeting) {}

  InteractionCounts act(const Agreement& agreed) override;

 protected:
  // What families add to the sweep, in this order. Each is called once per side or sweep.
  virtual void prepare(InteractionCounts&) {}
  virtual void describe(std::size_t s, Task& task) const;
  virtual void finish(InteractionCounts&) {}

  void gather(std::size_t s);
  const Cells& cells(std::size_t s) const { return party(s).cells; }
  Scratch::Party& party(std::size_t s) const { return meeting_.scratch->party[s]; }
  float radius_at(std::size_t s, std::size_t place) const {
    return radii() ? party(s).column[radius][place] : given_radius(action(), s == 1);
  }
  float overlaps() const;

  const Law& law_ = law_of(action());
  Extent extent_;
  float reach_ = 0;
  Crowd crowds_[2];

 private:
  void arrange_all(std::size_t s, const std::vector<Column>& columns);
  void arrange(std::size_t s, int to, const Column& column);
  void arrange_positive(std::size_t s, int to, const Column& column);
  void arrange_radii(std::size_t s, const Column& sizes);
  void arrange_masses(std::size_t s, const Column& masses);
  void look_ahead(std::size_t s, const std::vector<Column>& columns);
  bool radii() const;
  bool masses() const { return law_.inverse_masses && (!law_.uniform || extent_.masses > 0); }
  Spheres spheres(std::size_t s) const;
  void run(std::size_t s, InteractionCounts& seen);
  void run(std::size_t s, void (*kernel)(const Task&), std::size_t target_count, InteractionCounts& seen);
  void apply(std::size_t s) const;

  const std::vector<Component> changed_ = changed_by(action());
  Crowd now_[2];  // the same particles at their positions before the step
};

}  // namespace motes::interactions
