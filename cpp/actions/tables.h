// Immutable tables of numbers that actions read. A fingerprint of its content identifies a table, so recorded lists
// contain only the fingerprint. All ranks know all tables.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <vector>

#include "base/bytes.h"

namespace motes::actions {

struct LookupTable {
  std::array<std::int32_t, 3> size{};  // entries along each axis; the last one varies fastest
  std::int32_t width = 0;  // numbers per entry
  std::vector<float> values;

  bool operator==(const LookupTable&) const = default;
};

template <class Visitor>
constexpr void fields(Visitor& visit, LookupTable& table) {
  visit(table.size, table.width, table.values);
}

/// See base/registry.h.
using TableKey = std::uint64_t;

/// The maximum number of values in a table: 512 MB.
inline constexpr std::size_t kMostValues = std::size_t{1} << 27;

/// Checks a table. Throws std::invalid_argument naming what is wrong.
void check(const LookupTable& table);

/// Checks the table and keeps it until the process ends. Equal tables are kept once. Thread-safe, like the functions
/// below.
TableKey keep(LookupTable table);

/// Returns a kept table. Throws std::invalid_argument if this process does not keep it.
std::shared_ptr<const LookupTable> table(TableKey key);

/// Writes the content of kept tables as bytes, for files.
void write_tables(const std::set<TableKey>& keys, base::Bytes& out);
/// Keeps the tables that write_tables() wrote. Throws std::runtime_error if the bytes are damaged.
void read_tables(base::Reader& in);

}  // namespace motes::actions
