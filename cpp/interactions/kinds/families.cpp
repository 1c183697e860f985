#include "interactions/kinds/families.h"

namespace motes::interactions {

std::unique_ptr<PairAction> begin(const Meeting& meeting) {
  using Begin = std::unique_ptr<PairAction> (*)(const Meeting&);
  static constexpr Begin kFamilies[] = {
#define MOTES_ACTION(...) nullptr,
#define MOTES_INTERACTION(name, family, ...) families::family,
#include "actions/list.inc"
#undef MOTES_INTERACTION
#undef MOTES_ACTION
  };
  return kFamilies[static_cast<std::size_t>(meeting.sides[0].action->kind)](meeting);
}

}  // namespace motes::interactions
