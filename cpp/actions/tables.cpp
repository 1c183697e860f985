#include "actions/tables.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>

#include "base/fields.h"
#include "base/invalid_argument.h"

namespace motes::actions {
namespace {

// SplitMix64's finaliser over the content (Steele, Lea, Flood 2014).
class Fingerprint {
 public:
  void add(std::uint64_t word) {
    hash_ = (hash_ ^ word) * 0xbf58476d1ce4e5b9u;
    hash_ = (hash_ ^ (hash_ >> 27)) * 0x94d049bb133111ebu;
    hash_ ^= hash_ >> 31;
  }
  TableKey key() const { return hash_ == 0 ? 1 : hash_; }

 private:
  std::uint64_t hash_ = 0x9e3779b97f4a7c15u;
};

TableKey fingerprint(const Table& table) {
  Fingerprint found;
  for (const std::int32_t n : table.size) found.add(static_cast<std::uint64_t>(n));
  found.add(static_cast<std::uint64_t>(table.width));
  for (std::size_t at = 0; at < table.values.size(); at += 2) {
    std::uint64_t word = 0;
    std::memcpy(&word, &table.values[at], std::min<std::size_t>(2, table.values.size() - at) * sizeof(float));
    found.add(word);
  }
  return found.key();
}

std::mutex& lock() {
  static std::mutex mutex;
  return mutex;
}

std::map<TableKey, std::shared_ptr<const Table>>& all() {
  static std::map<TableKey, std::shared_ptr<const Table>> kept;
  return kept;
}

}  // namespace

void check(const Table& table) {
  std::size_t count = table.width < 1 ? 0 : static_cast<std::size_t>(table.width);
  for (const std::int32_t n : table.size) {
    count = n < 1 || count > kMostValues ? 0 : count * static_cast<std::size_t>(n);
  }
  if (count == 0 || count > kMostValues || count != table.values.size()) {
    throw base::InvalidArgument("a table",
                                "have 1.." + std::to_string(kMostValues) + " numbers, as many as its size says",
                                std::to_string(table.values.size()));
  }
  if (!std::all_of(table.values.begin(), table.values.end(), [](float v) { return std::isfinite(v); })) {
    throw base::InvalidArgument("a table", "have finite numbers");
  }
}

TableKey keep(Table table) {
  check(table);
  const TableKey key = fingerprint(table);
  const std::scoped_lock held(lock());
  std::shared_ptr<const Table>& kept = all()[key];
  if (kept == nullptr) {
    kept = std::make_shared<const Table>(std::move(table));
  } else if (!(*kept == table)) {
    throw std::runtime_error("two different tables have the same key: change one of them");
  }
  return key;
}

std::shared_ptr<const Table> table(TableKey key) {
  const std::scoped_lock held(lock());
  const auto found = all().find(key);
  if (found == all().end()) throw std::invalid_argument("no table has the key " + std::to_string(key));
  return found->second;
}

void write_tables(const std::set<TableKey>& keys, base::Bytes& out) {
  out.put(static_cast<std::uint32_t>(keys.size()));
  for (const TableKey key : keys) base::write_fields(*table(key), out);
}

void read_tables(base::Reader& in) {
  for (auto left = in.get<std::uint32_t>(); left > 0; --left) {
    Table read;
    base::read_fields(in, read);
    try {
      keep(std::move(read));
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(std::string("damaged bytes: ") + error.what());
    }
  }
}

}  // namespace motes::actions
