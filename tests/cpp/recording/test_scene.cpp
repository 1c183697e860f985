// The scene file: reading gives what was written, and nothing else is accepted as a scene.
#include <algorithm>
#include <climits>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "base/fields.h"
#include "base/hash.h"
#include "base/sha256.h"
#include "meshes/assets.h"
#include "program/program.h"
#include "recording/scene.h"
#include "recording/source_total.h"
#include "support/check.h"

namespace motes::test_scene {
using namespace program;
using namespace recording;
using base::Bytes;

namespace {

Record frame(std::uint64_t number) {
  Record r;
  r.verb = number % 2 == 0 ? Verb::render : Verb::step;
  r.frame = number;
  r.dt = 1.0 / 24;
  SystemDefinition snow;
  snow.name = "snow";
  snow.attributes = {{"heat", 1, {0.5f, 0, 0}}};
  r.systems = {snow};
  Emit emit;
  emit.count = 2;
  emit.columns = {{particles::position, {1, 2, 3, 4, 5, 6}}};
  const actions::Action gravity = actions::make(actions::numbers::gravity<>{.acceleration = {0, -9.8, 0}});
  Spawn spawn;
  spawn.state = {{particles::velocity, {}}};
  r.lists = {{emit, gravity, Read{}, spawn, actions::make(actions::numbers::move<>{.rotational = 1})}};
  r.sprites = {snow.sprite};
  r.clumps = {0};
  if (r.verb == Verb::render) {
    r.view.emplace();
    r.view->width = 64;
    r.view->height = 48;
    r.view->objects.push_back({shapes::Shape{shapes::Kind::plane, {0, 0, 0, 0, 1, 0}}, {1, 1, 1}});
  }
  return r;
}

Bytes scene_of(int frames) {
  std::vector<Bytes> lists(static_cast<std::size_t>(frames));
  Scene scene;
  scene.facts = {{"script", "snow.py"}, {"balancer", "Static()"}};
  for (std::size_t i = 0; i < lists.size(); ++i) {
    write(frame(i), lists[i]);
    scene.frames.push_back(lists[i].view());
  }
  Bytes bytes;
  write(scene, bytes);
  return bytes;
}

std::string complaint(std::span<const std::byte> bytes) {
  try {
    read_scene(bytes);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Bytes copy_of(const Bytes& bytes) {
  Bytes copy;
  copy.put_raw(bytes.data(), bytes.size());
  return copy;
}

// Sets the right hash, as if the file had been created like this, not damaged later.
void make_hash_right(Bytes& bytes) { bytes.set(24, base::hash(bytes.view().subspan(56))); }

std::uint64_t next(std::uint64_t& state) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return state >> 33;
}

// Runs a frame with few particles: what passes the checks must not crash.
void run(const Record& record) {
  for (std::size_t i = 0; i < record.systems.size(); ++i) {
    particles::Schema schema;
    for (const UserAttribute& a : record.systems[i].attributes) schema.add(a.name, a.width, a.initial);
    const particles::Key key = particles::system_key(record.seed, static_cast<std::uint32_t>(i));
    std::vector<actions::Action> actions;
    particles::Store all(schema);
    all.reserve(100);
    all.grow(20);
    for (const Item& item : record.lists[i]) {
      if (const auto* action = std::get_if<actions::Action>(&item)) actions.push_back(*action);
      const auto* birth = std::get_if<Birth>(&item);
      if (birth == nullptr) continue;
      recording::SourceTotal total;
      const std::uint64_t count = std::min<std::uint64_t>(births_in_step(*birth, record.dt, 0, 1, &total), 40);
      const particles::Store newborn = make(*birth, schema, key, 0, count, static_cast<float>(record.dt), true);
      CHECK(newborn.size() == count);
      CHECK(count == 0 || newborn.plane(particles::position, 0) != nullptr);
    }
    all.writable_plane(particles::position, 0);
    program::ListResult outcome;
    program::Program(actions).run(all, 0, 0, {record.frame, std::min(record.substeps, 3), record.dt, 0, 0}, key, {},
                                  outcome);
  }
}

}  // namespace

TEST(scene_comes_back) {
  const Bytes bytes = scene_of(3);
  const Scene scene = read_scene(bytes.view());
  CHECK(scene.version == version());
  CHECK(scene.fact("balancer") == "Static()" && scene.fact("script") == "snow.py" && scene.fact("none").empty());
  CHECK(scene.frames.size() == 3);
  for (std::size_t i = 0; i < scene.frames.size(); ++i) CHECK(read_frame(scene.frames[i]) == frame(i));
  CHECK(read_scene(scene_of(0).view()).frames.empty());
}

// A process that has never seen a mesh gets it from the file. Here the mesh in the file is replaced by another.
TEST(scene_brings_the_meshes_that_it_shows) {
  meshes::Mesh mesh{{0, 0, 0, 1, 0, 0, 0, 1, 0.5f}, {0, 1, 2}};
  Record record = frame(0);
  image::View view;
  view.width = 64;
  view.height = 36;
  view.camera.position = {0, 1, 8};
  view.objects.push_back({{}, {1, 1, 1}, meshes::keep(mesh)});
  record.view = view;
  Bytes list;
  write(record, list);
  Scene scene;
  scene.frames = {list.view()};
  Bytes file;
  write(scene, file);

  Bytes before, after;
  base::write_fields(mesh, before);
  mesh.vertices[8] = 0.25f;
  base::write_fields(mesh, after);
  base::Sha256 hash;
  hash.add("mesh");
  hash.add(after.view().first(after.size() - 4 * sizeof(std::uint64_t)));  // it has no colours, density, uv, normals
  const meshes::AssetKey key = std::stoull(hash.finish().substr(0, 16), nullptr, 16);
  const std::span<const std::byte> whole = file.view();
  const auto at = std::search(whole.begin(), whole.end(), before.data(), before.data() + before.size());
  CHECK(at != whole.end());
  std::memcpy(file.data() + (at - whole.begin()), after.data(), after.size());
  make_hash_right(file);
  CHECK(!meshes::has_mesh(key));
  read_scene(file.view());
  CHECK(meshes::has_mesh(key) && *meshes::mesh(key) == mesh);

  view.objects.back().mesh = 1234;  // kept nowhere
  record.view = view;
  Bytes unknown;
  write(record, unknown);
  scene.frames = {unknown.view()};
  CHECK_THROWS(write(scene, file), std::invalid_argument);
  CHECK_THROWS(read_frame(unknown.view()), std::invalid_argument);
}

TEST(scene_refuses_what_is_none) {
  const Bytes bytes = scene_of(2);
  CHECK(has(complaint({}), "is not a recorded scene"));
  Bytes text;
  text.put_text("#!/usr/bin/env python3");
  CHECK(has(complaint(text.view()), "is not a recorded scene"));
  for (std::size_t size = 8; size < bytes.size(); ++size) {
    CHECK(has(complaint(bytes.view().first(size)), "is cut off"));
  }
  Bytes longer = copy_of(bytes);
  longer.put('x');
  CHECK(has(complaint(longer.view()), "1 bytes too long"));
  Bytes newer = copy_of(bytes);
  newer.set(8, std::uint32_t{9});
  CHECK(has(complaint(newer.view()), "schema 9"));
  Bytes foreign = copy_of(bytes);
  foreign.set(40, std::uint64_t{1});
  CHECK(has(complaint(foreign.view()), "record it again"));
}

TEST(scene_notices_each_flipped_bit) {
  const Bytes bytes = scene_of(2);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    Bytes damaged = copy_of(bytes);
    damaged.set(at, bytes.view()[at] ^ std::byte{static_cast<unsigned char>(1u << at % 8)});
    CHECK(!complaint(damaged.view()).empty());
  }
}

// Crafted files: the hash is right, the content is not. They are refused or read as other values, never a crash.
TEST(scene_survives_wrong_content_under_a_right_hash) {
  const Bytes bytes = scene_of(2);
  std::uint64_t state = 20261121;
  int refused = 0;
  int ran = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    Bytes other = copy_of(bytes);
    for (std::uint64_t changes = 1 + next(state) % 4; changes > 0; --changes) {
      const std::size_t at = 56 + next(state) % (other.size() - 56);
      // Counts, kinds and attributes are small numbers.
      const bool small = next(state) % 2 == 0;
      other.set(at, static_cast<unsigned char>(next(state) % (small ? 20 : 256)));
    }
    make_hash_right(other);
    try {
      const Scene scene = read_scene(other.view());
      for (const auto list : scene.frames) {
        run(read_frame(list));
        ++ran;
      }
    } catch (const std::runtime_error&) {
      ++refused;
    } catch (const std::invalid_argument&) {
      ++refused;
    }
  }
  CHECK(refused > 100 && refused < 4000 && ran > 1000);
}

TEST(scene_frame_holds_what_scripts_may_say) {
  const auto refused = [](const auto& change) {
    Record record = frame(0);
    change(record);
    Bytes bytes;
    write(record, bytes);
    try {
      read_frame(bytes.view());
    } catch (const std::exception&) {
      return true;
    }
    return false;
  };
  CHECK(!refused([](Record&) {}));
  CHECK(refused([](Record& r) { r.verb = Verb::digest; }));
  CHECK(refused([](Record& r) { r.dt = 0; }));
  CHECK(refused([](Record& r) { r.substeps = 0; }));
  CHECK(refused([](Record& r) { r.substeps = 10001; }));
  CHECK(refused([](Record& r) { r.systems[0].axes = {8}; }));
  CHECK(refused([](Record& r) { r.systems[0].space = {domains::Space::Kind::finite, 1, 1}; }));
  CHECK(refused([](Record& r) { r.lists.clear(); }));
  CHECK(refused([](Record& r) { r.sprites.clear(); }));
  CHECK(refused([](Record& r) { r.clumps.clear(); }));
  CHECK(refused([](Record& r) { r.sprites[0].pixels = 513; }));
  CHECK(refused([](Record& r) { r.view->width = 0; }));
  const auto emit = [](Record& r) -> Emit& { return std::get<Emit>(std::get<Birth>(r.lists[0][0])); };
  const auto spawn = [](Record& r) -> Spawn& { return std::get<Spawn>(r.lists[0][3]); };
  for (const int attribute : {-1, int{particles::builtin_count} + 1, 64, INT_MAX, INT_MIN}) {
    CHECK(refused([&](Record& r) { emit(r).state = {{attribute, {}}}; }));
    CHECK(refused([&](Record& r) { emit(r).columns.push_back({attribute, {1, 2}}); }));
    CHECK(refused([&](Record& r) { spawn(r).state = {{attribute, {}}}; }));
  }
  CHECK(!refused([&](Record& r) { emit(r).state = {{particles::builtin_count, {}}}; }));  // a user attribute
  CHECK(refused([&](Record& r) { emit(r).columns.clear(); }));
  CHECK(refused([&](Record& r) { emit(r).columns[0].attribute = particles::velocity; }));
  CHECK(refused([&](Record& r) { emit(r).columns[0].values.pop_back(); }));
  CHECK(refused([&](Record& r) { spawn(r).into = 1; }));
  CHECK(refused([&](Record& r) { std::get<actions::Action>(r.lists[0][1]).numbers.clear(); }));
  CHECK(refused([](Record& r) { r.lists[0].emplace_back(Callback{"f", 0, {{actions::Op::column, 99, 0}}, {}}); }));
}

}  // namespace motes::test_scene
