// The recorded list as bytes: reading gives what was written, and every field changes the hash.
#include <functional>
#include <string>
#include <vector>

#include "base/hash.h"
#include "recording/record.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_record {
using namespace recording;

namespace {

shapes::Shape a_shape(shapes::Kind kind) {
  shapes::Shape s;
  s.kind = kind;
  for (int i = 0; i < shapes::kNumbers; ++i) s.number[i] = 0.5f + static_cast<float>(i);
  return s;
}

Record rich_record() {
  Record r;
  r.verb = Verb::render;
  r.frame = 7;
  r.seed = 0xdeadbeefcafef00d;
  r.dt = 1.0 / 24;
  r.substeps = 3;
  SystemDefinition snow;
  snow.name = "snow";
  snow.capacity = 1000;
  snow.axes = {4};
  snow.space = {domains::Space::Kind::finite, -4.5, 4.5};
  snow.sprite.pixels = 7;
  snow.attributes = {{"heat", 1, {0.5f, 0, 0}}, {"wind", 3, {1, 2, 3}}};
  SystemDefinition rain;
  rain.name = "rain \"x\"\n";
  r.systems = {snow, rain};
  Source source;
  source.shape = a_shape(shapes::Kind::box);
  source.rate = 123.5;
  source.jitter = true;
  source.state = {{particles::velocity, actions::distributions::InShape{a_shape(shapes::Kind::sphere)}}};
  Emit emit;
  emit.count = 2;
  emit.columns = {{particles::position, {1, 2, 3, 4, 5, 6}}};
  const actions::Action gravity = actions::make(actions::numbers::gravity<>{.acceleration = {0, -9.8, 0}});
  const actions::Action bounce{actions::Kind::bounce, {0.5, 0.1, 0}, {a_shape(shapes::Kind::plane)}};
  const actions::Action move = actions::make(actions::numbers::move<>{.rotational = 1});
  r.lists = {{source, gravity, Read{}, bounce, move}, {emit, move}};
  r.sprites = {snow.sprite, rain.sprite};
  r.clumps = {0, 0};
  image::View view;
  view.width = 64;
  view.height = 48;
  view.objects.push_back({a_shape(shapes::Kind::sphere), {1, 0.5f, 0}});
  r.view = view;
  r.argument = "argument";
  return r;
}

base::Bytes bytes_of(const Record& record) {
  base::Bytes bytes;
  write(record, bytes);
  return bytes;
}

// Returns every way to change one thing in the record.
std::vector<std::function<void(Record&)>> changes() {
  const auto source = [](Record& r) -> Source& { return std::get<Source>(std::get<Birth>(r.lists[0][0])); };
  const auto emit = [](Record& r) -> Emit& { return std::get<Emit>(std::get<Birth>(r.lists[1][0])); };
  const auto action = [](Record& r, std::size_t at) -> actions::Action& {
    return std::get<actions::Action>(r.lists[0][at]);
  };
  return {
      [](Record& r) { r.verb = Verb::step; },
      [](Record& r) { r.frame = 8; },
      [](Record& r) { r.seed ^= 1u; },
      [](Record& r) { r.dt = 1.0 / 25; },
      [](Record& r) { r.substeps = 2; },
      [](Record& r) { r.systems[0].name = "Snow"; },
      [](Record& r) { r.systems[0].capacity = 1001; },
      [](Record& r) { r.systems[0].axes = {2}; },
      [](Record& r) { r.systems[0].space.low = -4.4; },
      [](Record& r) { r.systems[0].space.kind = domains::Space::Kind::fit; },
      [](Record& r) { r.systems[0].attributes[1].initial[2] = 4; },
      [](Record& r) { r.systems[0].attributes.pop_back(); },
      [](Record& r) { r.systems[1].sprite.look = image::Sprite::Kind::point; },
      [](Record& r) { r.lists[0].pop_back(); },
      [](Record& r) { r.lists[1].emplace_back(Read{}); },
      [](Record& r) { std::swap(r.lists[0][1], r.lists[0][3]); },
      [=](Record& r) { source(r).rate += 1; },
      [=](Record& r) { source(r).jitter = false; },
      [=](Record& r) { r.lists[0][0] = Burst{source(r).shape, 0, source(r).state}; },
      [=](Record& r) { source(r).shape.number[5] += 1; },
      [=](Record& r) { source(r).shape.kind = shapes::Kind::line; },
      [=](Record& r) { source(r).state[0].attribute = particles::color; },
      [=](Record& r) { source(r).state[0].distribution = actions::distributions::Normal{}; },
      [=](Record& r) {
        std::get<actions::distributions::InShape>(source(r).state[0].distribution).shape.number[3] = 9;
      },
      [=](Record& r) { emit(r).columns[0].values[4] = 0; },
      [=](Record& r) { emit(r).count = 3; },
      [=](Record& r) { action(r, 1).numbers[1] = -9.81; },
      [=](Record& r) { action(r, 3).shapes[0].number[0] = 9; },
      [=](Record& r) { action(r, 4).kind = actions::Kind::kill_expired; },
      [](Record& r) { r.sprites[0].pixels = 3; },
      [](Record& r) { r.clumps[1] = 7; },
      [](Record& r) { r.view.reset(); },
      [](Record& r) { r.view->camera.position[2] = 2; },
      [](Record& r) { r.view->camera.near = 0.2; },
      [](Record& r) { r.view->background[1] = 0.5f; },
      [](Record& r) { r.view->exposure = 2; },
      [](Record& r) { r.view->objects[0].color[0] = 0; },
      [](Record& r) { r.view->objects[0].mesh = 1; },
      [](Record& r) { r.view->objects[0].light = 1; },
      [](Record& r) { r.view->sun[0] = 1; },
      [](Record& r) { r.view->lights.push_back({}); },
      [](Record& r) { r.view->path = image::View::Path::tiles; },
      [](Record& r) { r.view->shutter = 0.5f; },
      [](Record& r) { r.view->bloom = 0.5f; },
      [](Record& r) { r.view->smooth = false; },
      [](Record& r) { r.view->layers = image::kDepthLayer; },
      [](Record& r) { r.view->before.emplace(); },
      [](Record& r) { r.sprites[0].blend = image::Sprite::Blend::alpha; },
      [](Record& r) { r.sprites[0].of_height = 0.5f; },
      [](Record& r) { r.sprites[0].softness = 1; },
      [](Record& r) { r.sprites[0].look = image::ImageSprite{{1}}; },
      [](Record& r) { r.argument += '!'; },
  };
}

}  // namespace

TEST(numbers_of_an_action_have_names) {
  namespace numbers = actions::numbers;
  const actions::Action tied = actions::make(numbers::tie<>{.shear = 2, .break_at = 3});
  CHECK(tied.kind == actions::Kind::tie && tied.numbers == (std::vector<double>{0, 2, 0, 0, 3, 0}));
  CHECK(actions::numbers_of<numbers::tie>(tied).break_at == 3);
  const actions::Action air = actions::make(numbers::wind<>{.velocity = {1, 2, 3}, .drag = 4});
  CHECK(air.numbers == (std::vector<double>{1, 2, 3, 4}));
  const auto given = actions::numbers_of<numbers::wind, float>(air);
  CHECK(given.velocity[2] == 3.0f && given.drag == 4.0f);
  CHECK(actions::make(numbers::kill_expired<>{}).numbers.empty());
  CHECK_THROWS(actions::numbers_of<numbers::gravity>(air), std::logic_error);
  CHECK_THROWS(actions::numbers_of<numbers::move>(actions::Action{}), std::logic_error);
}

TEST(record_survives_its_bytes) {
  const Record record = rich_record();
  const base::Bytes bytes = bytes_of(record);
  base::Reader in(bytes.view());
  CHECK(read(in) == record);
  CHECK(in.done());
  const Record empty;
  const base::Bytes few = bytes_of(empty);
  base::Reader in_few(few.view());
  CHECK(read(in_few) == empty);
}

TEST(record_refuses_truncated_bytes) {
  const base::Bytes bytes = bytes_of(rich_record());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    base::Reader in(bytes.view().first(length));
    CHECK_THROWS(read(in), std::runtime_error);
  }
}

// Garbage is refused, or read as a record that can be described: never a crash, never an endless allocation.
TEST(record_survives_garbage) {
  const Record good = rich_record();
  test::Dice dice(8);
  int refused = 0;
  for (int round = 0; round < 20000; ++round) {
    base::Bytes bytes = bytes_of(good);
    const std::size_t damages = 1 + dice.below(3);
    for (std::size_t i = 0; i < damages; ++i) {
      bytes.data()[dice.below(bytes.size())] = static_cast<std::byte>(dice.word());
    }
    base::Reader in(bytes.view());
    try {
      const Record other = read(in);
      (void)first_difference(other, good);
    } catch (const std::runtime_error&) {
      ++refused;
    }
  }
  CHECK(refused > 0 && refused < 20000);  // damage to a number gives another record, not an invalid one
}

TEST(record_hash_changes_with_every_field) {
  const Record record = rich_record();
  const base::Bytes bytes = bytes_of(record);
  std::vector<base::Hash> seen{base::hash(bytes.view())};
  CHECK(base::hash(bytes_of(record).view()) == seen[0]);
  for (const auto& change : changes()) {
    Record other = record;
    change(other);
    CHECK(!(other == record));
    const base::Bytes changed = bytes_of(other);
    base::Reader in(changed.view());
    CHECK(read(in) == other);
    const base::Hash found = base::hash(changed.view());
    for (const base::Hash& known : seen) CHECK(!(found == known));
    seen.push_back(found);
  }
}

TEST(first_difference_names_the_place) {
  const Record record = rich_record();
  CHECK(first_difference(record, record) == "no difference in value");
  for (const auto& change : changes()) {
    Record other = record;
    change(other);
    CHECK(first_difference(other, record) != "no difference in value");
  }
  const auto told = [&](const std::function<void(Record&)>& change) {
    Record other = record;
    change(other);
    return first_difference(other, record);
  };
  CHECK(told([](Record& r) { r.verb = Verb::digest; }) == "digest here, render there");
  CHECK(told([](Record& r) { r.frame = 9; }) == "frame 9 here, 7 there");
  CHECK(told([](Record& r) { r.systems.pop_back(); }) == "1 systems here, 2 there");
  CHECK(told([](Record& r) { r.systems[0].axes = {1}; }) == "system 'snow' is defined differently");
  CHECK(told([](Record& r) { std::get<actions::Action>(r.lists[0][1]).numbers[0] = 1; }) ==
        "system 'snow', call 2: gravity with different arguments");
  CHECK(told([](Record& r) { r.lists[0].pop_back(); }) == "system 'snow', call 5: nothing here, move there");
  CHECK(told([](Record& r) { r.lists[0].erase(r.lists[0].begin()); }) ==
        "system 'snow', call 1: gravity here, source there");
  CHECK(told([](Record& r) { r.lists[0][2] = actions::make(actions::numbers::kill_expired<>{}); }) ==
        "system 'snow', call 3: kill_expired here, local there");
}

}  // namespace motes::test_record
