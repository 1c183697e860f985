// Tables of actions: equal content has one key, files contain tables, and invalid tables are refused.
#include <limits>
#include <set>
#include <stdexcept>

#include "actions/action.h"
#include "actions/tables.h"
#include "base/fields.h"
#include "support/check.h"

namespace motes::test_tables {
using actions::LookupTable;

namespace {

LookupTable small(float first) { return {{2, 1, 2}, 3, {first, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}}; }

template <class Error, class Call>
bool refused(const Call& call) {
  try {
    call();
  } catch (const Error&) {
    return true;
  }
  return false;
}

}  // namespace

TEST(tables_of_equal_content_have_one_key) {
  const actions::TableKey key = actions::keep(small(0));
  CHECK(key != 0 && actions::keep(small(0)) == key && *actions::table(key) == small(0));
  CHECK(actions::keep(small(0.5f)) != key);
  LookupTable turned = small(0);
  turned.size = {1, 2, 2};
  CHECK(actions::keep(turned) != key);
  turned.size = {2, 2, 3};
  turned.width = 1;
  CHECK(actions::keep(turned) != key);
}

TEST(wrong_tables_are_refused) {
  const auto wrong = [](auto change) {
    LookupTable table = small(0);
    change(table);
    return refused<std::invalid_argument>([&] { actions::keep(table); });
  };
  CHECK(!wrong([](LookupTable&) {}));
  CHECK(wrong([](LookupTable& t) { t.values.pop_back(); }));
  CHECK(wrong([](LookupTable& t) { t.size[1] = 0; }));
  CHECK(wrong([](LookupTable& t) { t.size = {-2, -1, 2}; }));
  CHECK(wrong([](LookupTable& t) { t.size = {1 << 30, 1 << 30, 1 << 30}; }));
  CHECK(wrong([](LookupTable& t) { t.width = 0; }));
  CHECK(wrong([](LookupTable& t) { t.values[3] = std::numeric_limits<float>::quiet_NaN(); }));
  CHECK(refused<std::invalid_argument>([] { actions::table(12345); }));
}

TEST(files_carry_tables) {
  const actions::TableKey key = actions::keep(small(-3));
  base::Bytes bytes;
  actions::write_tables({key}, bytes);
  base::Reader in(bytes.view());
  actions::read_tables(in);
  CHECK(in.done() && *actions::table(key) == small(-3));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    base::Reader part(bytes.view().first(length));
    CHECK(refused<std::runtime_error>([&] { actions::read_tables(part); }));
  }
  LookupTable damaged = small(-3);
  damaged.width = 4;
  base::Bytes wrong;
  wrong.put(std::uint32_t{1});
  base::write_fields(damaged, wrong);
  base::Reader reader(wrong.view());
  CHECK(refused<std::runtime_error>([&] { actions::read_tables(reader); }));
}

TEST(actions_must_have_the_table_that_they_read) {
  const actions::TableKey three = actions::keep(small(7));
  actions::Action field = actions::make(actions::numbers::field<>{.high = {1, 1, 1}, .strength = 1, .drag = -1});
  field.specifics = actions::Lookup{three};
  CHECK(!refused<std::invalid_argument>([&] { actions::check(field); }));
  field.specifics = actions::Lookup{};
  CHECK(refused<std::invalid_argument>([&] { actions::check(field); }));
  field.specifics = actions::NumbersAlone{};
  CHECK(refused<std::invalid_argument>([&] { actions::check(field); }));
  actions::Action path =
      actions::make(actions::numbers::follow_path<>{.speed = 1, .strength = 1, .look_ahead = 1, .radius = 1});
  path.specifics = actions::Lookup{three};
  CHECK(refused<std::invalid_argument>([&] { actions::check(path); }));
  actions::Action move = actions::make(actions::numbers::move<>{.rotational = 1});
  move.specifics = actions::Lookup{three};
  CHECK(refused<std::invalid_argument>([&] { actions::check(move); }));
}

}  // namespace motes::test_tables
