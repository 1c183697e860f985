#include "actions/tables.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/invalid_argument.h"
#include "base/registry.h"

namespace motes::actions {
namespace {

base::Registry<LookupTable>& tables() {
  static base::Registry<LookupTable> all("table");
  return all;
}

}  // namespace

void check(const LookupTable& table) {
  std::size_t count = table.width < 1 ? 0 : static_cast<std::size_t>(table.width);
  for (const std::int32_t n : table.size) {
    count = n < 1 || count > kMostValues ? 0 : count * static_cast<std::size_t>(n);
  }
  if (count == 0 || count > kMostValues || count != table.values.size()) {
    throw base::InvalidArgument("a table", "have 1.." + std::to_string(kMostValues) + " numbers that match its size",
                                std::to_string(table.values.size()));
  }
  if (!std::all_of(table.values.begin(), table.values.end(), [](float v) { return std::isfinite(v); })) {
    throw base::InvalidArgument("a table", "have finite numbers");
  }
}

TableKey keep(LookupTable table) { return tables().keep(std::move(table)); }

std::shared_ptr<const LookupTable> table(TableKey key) { return tables().get(key); }

void write_tables(const std::set<TableKey>& keys, base::Bytes& out) { tables().write(keys, out); }

void read_tables(base::Reader& in) { tables().read(in); }

}  // namespace motes::actions
