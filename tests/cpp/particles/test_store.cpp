// The store of particles compared with a simple model: a map from id to values.
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <vector>

#include "base/memory.h"
#include "particles/digest.h"
#include "particles/store.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_store {
namespace {

using namespace particles;

using Values = std::vector<float>;  // all components, and what it remembers of its contacts
using Model = std::map<std::uint64_t, Values>;

Schema schema_of_test() {
  Schema schema;
  schema.add("heat", 1, {0.5f, 0, 0});
  schema.add("wind", 3, {1, 2, 3});
  return schema;
}

Values values_of(const Store& store, std::size_t i) {
  Values values;
  for (int a = 0; a < store.schema().size(); ++a) {
    for (int c = 0; c < store.schema()[a].width; ++c) {
      const float* plane = store.plane(a, c);
      values.push_back(plane != nullptr ? plane[i] : store.uniform_value(a)[static_cast<std::size_t>(c)]);
    }
  }
  for (const Touch& touch : store.touches(i)) {
    values.push_back(static_cast<float>(touch.id));
    values.insert(values.end(), touch.slid, touch.slid + 3);
    values.insert(values.end(), touch.rolled, touch.rolled + 3);
  }
  return values;
}

Model model_of(const Store& store) {
  Model model;
  for (std::size_t i = 0; i < store.size(); ++i) model[store.ids()[i]] = values_of(store, i);
  return model;
}

// Adds particles, with some columns written and others not.
void add(Store& store, Model& model, std::size_t count, std::uint64_t& next_id, test::Dice& dice) {
  const std::size_t first = store.grow(count);
  for (std::size_t i = first; i < store.size(); ++i) store.set_id(i, next_id++);
  for (int a = 0; a < store.schema().size(); ++a) {
    if (store.uniform(a) && dice.below(4) != 0) continue;
    for (int c = 0; c < store.schema()[a].width; ++c) {
      float* plane = store.writable_plane(a, c);
      for (std::size_t i = first; i < store.size(); ++i) plane[i] = dice.between(-1, 1);
    }
  }
  if (store.remembers() || dice.below(6) == 0) {
    for (std::size_t i = first; i < store.size(); ++i) {
      CHECK(store.touches(i).empty());
      std::vector<Touch> touches(dice.below(dice.coin() ? 3 : 40));
      for (Touch& touch : touches) {
        const float x = dice.between(-1, 1);
        touch = {dice.word() % 1000, 1, 2, {x, 2 * x, 0.5f}, {-x, x, 1}};
      }
      store.set_touches(i, touches);
    }
  }
  for (std::size_t i = first; i < store.size(); ++i) model[store.ids()[i]] = values_of(store, i);
}

std::vector<std::uint32_t> some(std::size_t size, test::Dice& dice) {
  std::vector<std::uint32_t> indices;
  const std::size_t one_in = 1 + dice.below(9);
  for (std::uint32_t i = 0; i < size; ++i) {
    if (dice.below(one_in) == 0) indices.push_back(i);
  }
  return indices;
}

void write_one(Store& store, Model& model, test::Dice& dice) {
  const int a = static_cast<int>(dice.below(static_cast<std::size_t>(store.schema().size())));
  const std::size_t i = dice.below(store.size());
  store.writable_plane(a, 0)[i] = dice.between(5, 6);
  model[store.ids()[i]] = values_of(store, i);
}

}  // namespace

TEST(store_follows_a_simple_model) {
  const Schema schema = schema_of_test();
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    test::Dice dice(seed);
    Store store(schema), other(schema);
    Model model, other_model;
    std::uint64_t next_id = dice.coin() ? 0 : (std::uint64_t{1} << 32) - dice.below(3000);
    for (int round = 0; round < 40; ++round) {
      const std::size_t choice = dice.below(5);
      if (choice <= 1) add(store, model, dice.below(choice == 0 ? 700 : 5), next_id, dice);
      if (choice == 2 && store.size() > 0) write_one(store, model, dice);
      if (choice >= 3) {
        const auto indices = some(store.size(), dice);
        if (choice == 4) {  // they move to the other store
          base::Bytes bytes;
          store.pack(indices, bytes);
          base::Reader in(bytes.view());
          other.unpack(in);
          CHECK(in.done());
          for (const std::uint32_t i : indices) other_model[store.ids()[i]] = values_of(store, i);
        }
        for (const std::uint32_t i : indices) model.erase(store.ids()[i]);
        store.remove(indices);
      }
      CHECK(store.size() == model.size());
      CHECK(model_of(store) == model);
      CHECK(model_of(other) == other_model);
    }
  }
}

TEST(store_keeps_uniform_columns_out_of_memory) {
  const Schema schema = schema_of_test();
  Store store(schema);
  store.set_uniform(velocity, {1, 2, 3});
  store.grow(1000);
  const std::size_t ids_alone = store.memory_bytes();
  CHECK(store.uniform(velocity) && store.uniform_value(velocity)[1] == 2);
  CHECK(ids_alone < 1000 * 8 * 2);
  CHECK_THROWS(store.set_uniform(velocity, {}), std::logic_error);
  store.writable_plane(velocity, 2)[7] = 9;
  CHECK(!store.uniform(velocity));
  CHECK(store.plane(velocity, 2)[7] == 9 && store.plane(velocity, 2)[8] == 3 && store.plane(velocity, 0)[999] == 1);
  CHECK(store.memory_bytes() == ids_alone + ids_alone * 3);
  CHECK(store.plane(color, 0) == nullptr);
}

// Columns that begin at the same place of a page share sets of the caches: a step then takes up to twice as long.
TEST(columns_of_a_large_store_begin_at_different_places_of_a_page) {
  const Schema schema = schema_of_test();
  for (const std::size_t capacity : {20'000u, 2'097'136u, 3'201'008u}) {
    Store store(schema);
    store.reserve(capacity);
    std::vector<std::uintptr_t> places;
    const auto note = [&](const void* column) {
      const auto place = reinterpret_cast<std::uintptr_t>(column);
      CHECK(place % 64 == 0);
      places.push_back(place % 4096);
    };
    for (const int attribute : {position, velocity}) {
      for (int c = 0; c < 3; ++c) note(store.writable_plane(attribute, c));
      CHECK(store.plane_stride() >= capacity + kPadding);
    }
    note(store.ids().lower);
    if (capacity * sizeof(float) < base::kLargeMemory) continue;  // small memory begins anywhere
    std::ranges::sort(places);
    CHECK(std::ranges::adjacent_find(places) == places.end());
  }
}

TEST(upper_halves_of_ids_take_memory_where_there_are_some) {
  const Schema schema;
  Store store(schema), other(schema);
  store.grow(300);
  for (std::size_t i = 0; i < 300; ++i) store.set_id(i, UINT32_MAX - i);
  const std::size_t without = store.memory_bytes(), message = store.packed_bytes(3);
  CHECK(store.ids().upper == nullptr);
  store.set_id(299, std::uint64_t{7} << 32);
  CHECK(store.memory_bytes() == 2 * without && store.packed_bytes(3) == message + 3 * sizeof(std::uint32_t));
  CHECK(store.ids()[299] == std::uint64_t{7} << 32 && store.ids()[298] == UINT32_MAX - 298 &&
        store.ids()[0] == UINT32_MAX);
  store.grow(1);
  CHECK(store.ids().upper[300] == 0);
  other.grow(2);
  other.set_ids(0, std::vector<std::uint64_t>{4, 5});
  other.append(store, {299, 0});
  CHECK(other.ids()[0] == 4 && other.ids()[1] == 5);
  CHECK(other.ids()[2] == std::uint64_t{7} << 32 && other.ids()[3] == UINT32_MAX);
  store.append(other, {1});  // from a store that never had any
  CHECK(store.ids()[301] == 5);
}

TEST(store_takes_over_uniform_values_and_materialises_others) {
  const Schema schema = schema_of_test();
  Store red(schema), blue(schema), both(schema);
  red.set_uniform(color, {1, 0, 0});
  blue.set_uniform(color, {0, 0, 1});
  for (Store* store : {&red, &blue}) {
    store->grow(2);
    for (std::size_t i = 0; i < 2; ++i) store->set_id(i, (store == &red ? 0 : 10) + i);
  }
  const std::vector<std::uint32_t> two{0, 1};
  const auto bring = [&](const Store& from) {
    base::Bytes bytes;
    from.pack(two, bytes);
    base::Reader in(bytes.view());
    both.unpack(in);
  };
  bring(red);
  CHECK(both.uniform(color) && both.uniform_value(color)[0] == 1);
  bring(red);
  CHECK(both.uniform(color));
  bring(blue);
  CHECK(!both.uniform(color));
  CHECK(both.plane(color, 0)[3] == 1 && both.plane(color, 0)[4] == 0 && both.plane(color, 2)[5] == 1);
  CHECK(both.uniform(velocity));
}

TEST(store_appends_all_of_another_as_it_appends_its_particles_by_number) {
  const Schema schema = schema_of_test();
  // Attributes without planes, with the same value and with another; upper halves of ids; touches.
  for (unsigned form = 0; form < 32; ++form) {
    const auto filled = [&](std::size_t count, std::uint64_t first, bool planes, bool far, bool touches) {
      Store store(schema);
      if (!planes) store.set_uniform(color, {first == 0 ? 1.0f : 0.5f, 0, 0});
      store.grow(count);
      for (std::size_t i = 0; i < count; ++i) store.set_id(i, first + i + (far ? std::uint64_t{1} << 33 : 0));
      for (std::size_t i = 0; planes && i < count; ++i)
        store.writable_plane(color, 1)[i] = static_cast<float>(i + first);
      for (std::size_t i = 0; touches && i < count; ++i) store.set_touches(i, {});
      return store;
    };
    const bool alike = (form & 8u) != 0;
    const Store from = filled(5, alike ? 0 : 100, (form & 1u) != 0, (form & 2u) != 0, (form & 4u) != 0);
    Store whole = filled(3, 0, (form & 16u) != 0, false, false),
          by_number = filled(3, 0, (form & 16u) != 0, false, false);
    whole.append(from);
    by_number.append(from, {0, 1, 2, 3, 4});
    whole.append(Store(schema));
    CHECK(whole.size() == 8 && digest(whole) == digest(by_number));
    CHECK(whole.uniform(color) == by_number.uniform(color) && whole.memory_bytes() == by_number.memory_bytes());
  }
}

TEST(store_refuses_bytes_that_end_too_early) {
  const Schema schema = schema_of_test();
  Store store(schema);
  store.grow(3);
  store.writable_plane(position, 0);
  const std::vector<std::uint32_t> all{0, 1, 2};
  base::Bytes bytes;
  store.pack(all, bytes);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    Store into(schema);
    base::Reader in(bytes.view().first(length));
    CHECK_THROWS(into.unpack(in), std::runtime_error);
  }
}

TEST(schema_checks_names_and_widths) {
  Schema schema;
  CHECK(schema.find("velocity") == velocity && schema.find("heat") == -1);
  CHECK(schema.add("heat", 1, {}) == builtin_count);
  CHECK_THROWS(schema.add("heat", 1, {}), std::invalid_argument);
  CHECK_THROWS(schema.add("id", 1, {}), std::invalid_argument);
  CHECK_THROWS(schema.add("", 1, {}), std::invalid_argument);
  CHECK_THROWS(schema.add("two words", 1, {}), std::invalid_argument);
  CHECK_THROWS(schema.add("pair", 2, {}), std::invalid_argument);
}

TEST(digest_knows_neither_order_nor_place) {
  const Schema schema = schema_of_test();
  for (std::uint64_t seed = 100; seed < 130; ++seed) {
    test::Dice dice(seed);
    Store store(schema);
    Model model;
    std::uint64_t next_id = seed << 33;
    add(store, model, 1 + dice.below(1500), next_id, dice);
    const Digest whole = digest(store);
    // Split into parts, in another order, with written and unwritten columns.
    std::vector<Store> parts(3, Store(schema));
    std::vector<std::vector<std::uint32_t>> indices(3);
    for (auto i = static_cast<std::uint32_t>(store.size()); i-- > 0;) indices[dice.below(3)].push_back(i);
    Digest sum;
    for (std::size_t p = 0; p < 3; ++p) {
      base::Bytes bytes;
      store.pack(indices[p], bytes);
      base::Reader in(bytes.view());
      parts[p].unpack(in);
      for (int a = 0; parts[p].size() > 0 && a < schema.size(); ++a) {
        if (dice.coin()) parts[p].writable_plane(a, 0);
      }
      sum += digest(parts[p]);
    }
    CHECK(sum == whole);
    auto chosen = some(store.size(), dice);
    Digest rest = whole;
    rest -= digest(store, chosen);
    store.remove(chosen);
    CHECK(rest == digest(store));
  }
}

TEST(who_holds_planes_changes_no_particle_after_the_store_has_parted_from_them) {
  const Schema schema = schema_of_test();
  Store store(schema);
  store.grow(700);
  for (std::size_t i = 0; i < store.size(); ++i) store.set_id(i, i);
  for (int a = 0; a < schema.size(); a += 2) {
    for (int c = 0; c < schema[a].width; ++c) {
      float* plane = store.writable_plane(a, c);
      for (std::size_t i = 0; i < store.size(); ++i) plane[i] = static_cast<float>(i) + 0.25f * static_cast<float>(c);
    }
  }
  const Digest before = digest(store);
  const float* others = store.plane(2, 0);
  const std::shared_ptr<float[]> held = store.planes(0);
  store.part_from_holders();
  CHECK(digest(store) == before);
  CHECK(store.plane(2, 0) == others);  // no other store held these
  CHECK(store.plane(0, 0) != held.get());
  held[5] = 99;
  CHECK(digest(store) == before);
  CHECK(store.uniform(1));
  store.grow(5000);  // planes of the new memory still move together
  CHECK(store.plane(0, 2)[699] == 699.5f);
}

TEST(digest_sees_every_column_and_id) {
  const Schema schema = schema_of_test();
  Store store(schema);
  store.grow(3);
  for (std::size_t i = 0; i < 3; ++i) store.set_id(i, i);
  std::vector<std::string> seen{digest(store).text()};
  for (int a = 0; a < schema.size(); ++a) {
    for (int c = 0; c < schema[a].width; ++c) {
      float& value = store.writable_plane(a, c)[1];
      value = -value - 1;
      seen.push_back(digest(store).text());
    }
  }
  store.set_id(0, 99);
  seen.push_back(digest(store).text());
  std::sort(seen.begin(), seen.end());
  CHECK(std::adjacent_find(seen.begin(), seen.end()) == seen.end());
  CHECK(seen[0].size() == 48);
  const Digest one = digest(store), none;
  const std::array<Digest, 2> order{one, none}, reverse{none, one};
  CHECK(!(combine(order) == combine(reverse)));
}

}  // namespace motes::test_store
