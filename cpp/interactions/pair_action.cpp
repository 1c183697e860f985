#include "interactions/pair_action.h"

namespace motes::interactions {

std::vector<Column> columns_of(const std::vector<Component>& read, const Side& side) {
  std::vector<Column> columns;
  for (const Component c : read) {
    Column column;
    column.own = side.store->plane(c.attribute, c.component);
    column.value = side.store->uniform_value(c.attribute)[static_cast<std::size_t>(c.component)];
    if (side.ghosts != nullptr && !side.ghosts->ids.empty())
      column.ghosts = side.ghosts->columns[columns.size()].data();
    columns.push_back(column);
  }
  return columns;
}

Crowd crowd_of(const Side& side, const std::vector<Column>& columns) {
  Crowd crowd;
  for (std::size_t c = 0; c < 3; ++c) crowd.at[c] = columns[c];
  crowd.own = side.store->size();
  crowd.own_ids = side.store->ids();
  if (side.ghosts != nullptr) {
    crowd.ghosts = side.ghosts->ids.size();
    crowd.copied_ids = side.ghosts->ids.data();
  }
  return crowd;
}

std::vector<Component> PairAction::reads(std::size_t side) const { return read_by(action(side)); }

std::vector<std::uint32_t> PairAction::sources(std::size_t, std::vector<std::uint32_t> particles) const {
  return particles;
}

Agreement PairAction::own() {
  Agreement own;
  for (std::size_t s = 0; s < meeting_.count; ++s)
    own.extent.widen(extent_of(action(s), *side(s).store, meeting_.step.dt, s == 1, *meeting_.pool));
  return own;
}

float PairAction::reach(const Agreement& agreed) const { return reach_of(action(), agreed.extent); }

double PairAction::range(const Agreement& agreed) const { return range_of(action(), agreed.extent); }

bool list_holds(const Side& side, const NeighbourList::Kind& kind, const Radii& radii, const Meeting& meeting,
                const particles::Periods& periods) {
  Side own = side;
  own.ghosts = nullptr;
  side.kept.list->set_kind(kind);
  return side.kept.list->holds(crowd_of(own, columns_of(components_of(1u << particles::position), own)), radii,
                               meeting.step.number, *meeting.pool, periods);
}

}  // namespace motes::interactions
