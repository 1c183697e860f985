#include "recording/scene.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "base/hash.h"
#include "domains/divide.h"
#include "image/checks.h"
#include "interactions/ties.h"
#include "meshes/assets.h"

namespace motes::recording {
namespace {

using base::Bytes;
using base::Reader;

// Like PNG's: a non-text byte, then a line end that a transfer in text mode would change.
constexpr std::array<char, 8> kMagic = {'\x89', 'm', 'o', 't', 'e', 's', '\r', '\n'};
constexpr std::uint32_t kSchema = 3;

struct Head {
  std::array<char, 8> magic = kMagic;
  std::uint32_t schema = kSchema;
  std::uint32_t reserved = 0;
  std::uint64_t bytes = 0;  // of the whole file
  base::Hash content;  // of everything that follows
  base::Hash layout;
};
static_assert(sizeof(Head) == 56);

// Returns a record with one of everything that it can hold.
Record sample() {
  shapes::Shape both = shapes::unite({shapes::Shape{}, shapes::Shape{}});
  const actions::Expression step = {{}};
  const std::vector<Given> state = {{particles::velocity, {}}};
  Source source;
  source.shape = both;
  source.before = {{}};
  source.integral = {0};
  source.state = state;
  actions::Action action{actions::Kind::set, {0}, {both}, step, {}, actions::Partner{}};
  const auto with = [&](actions::Specifics specifics) {
    action.specifics = std::move(specifics);
    return Item(action);
  };
  Spawn spawn;
  spawn.state = state;
  spawn.where = step;
  spawn.shapes = {both};
  Record record;
  SystemDefinition system;
  system.name = "one";
  system.attributes = {{"heat", 1, {}}};
  record.systems = {system};
  record.lists = {{source, Burst{both, 1, state}, Emit{1, {{particles::position, {0, 0, 0}}}, state},
                   with(actions::Assignment{0, {step}}), with(actions::ParticleLaw{{step}, {{}}}),
                   with(actions::PairLaw{{{}}, {step}, {{}}}), with(actions::TiedPairs{}), with(actions::Lookup{}),
                   with(actions::Grains{{{}}, 0}), with(actions::PerParticle{{step}}), Read{}, spawn,
                   Callback{"f", 0, step, {both}}, KeepCopies{}}};
  record.sprites = {{}};
  record.clumps = {{}};
  record.view.emplace();
  record.view->objects = {{both, {}}};
  record.view->lights = {{}};
  record.view->before.emplace();
  record.camera.emplace();
  return record;
}

// Returns a hash that differs if another version writes records or numbers its actions differently.
base::Hash layout() {
  Bytes bytes;
  write(sample(), bytes);
  for (int kind = 0; kind < actions::kKinds; ++kind) {
    const actions::Facts& facts = actions::facts(static_cast<actions::Kind>(kind));
    bytes.put_text(facts.name);
    for (const actions::Number& number : facts.numbers) {
      bytes.put_text(number.name);
      bytes.put(number.count);
    }
    bytes.put(facts.shapes);
    bytes.put(facts.ramp);
    bytes.put(facts.table);
  }
  for (const int count : {shapes::kKinds, shapes::kNumbers, expressions::kOps, int{particles::builtin_count}}) {
    bytes.put(count);
  }
  return base::hash(bytes.view());
}

Head read_head(std::span<const std::byte> bytes) {
  if (bytes.size() < kMagic.size() || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0) {
    throw std::runtime_error("is not a recorded scene");
  }
  if (bytes.size() < sizeof(Head)) throw std::runtime_error("is cut off within its header");
  const Head head = Reader(bytes).get<Head>();
  if (head.schema != kSchema) {
    throw std::runtime_error("is a scene of schema " + std::to_string(head.schema) + "; this version reads schema " +
                             std::to_string(kSchema));
  }
  if (head.reserved != 0) throw std::runtime_error("is damaged: a reserved field of its header is not 0");
  if (head.bytes > bytes.size()) {
    throw std::runtime_error("is cut off: " + std::to_string(bytes.size()) + " of " + std::to_string(head.bytes) +
                             " bytes are present");
  }
  if (head.bytes < bytes.size()) {
    throw std::runtime_error("is damaged: it is " + std::to_string(bytes.size() - head.bytes) + " bytes too long");
  }
  if (base::hash(bytes.subspan(sizeof(Head))) != head.content) {
    throw std::runtime_error("is damaged: its content does not match its hash");
  }
  return head;
}

void require(bool right, const std::string& what) {
  if (!right) throw std::runtime_error("not a recorded list: " + what);
}

constexpr int kMostSubsteps = 10000;  // as in World's argument

std::vector<particles::Schema> schemas_of(const Record& record) {
  std::vector<particles::Schema> schemas;
  for (const SystemDefinition& system : record.systems) schemas.push_back(schema_of(system));
  return schemas;
}

// Checks, before any frame runs, what the engine checks again when it gets the frames.
void check_items(const Record& record) {
  const std::vector<particles::Schema> schemas = schemas_of(record);
  for (std::size_t i = 0; i < record.lists.size(); ++i) {
    check(record.sprites[i], schemas[i]);
    for (const Item& item : record.lists[i]) {
      if (const auto* birth = std::get_if<Birth>(&item)) check(*birth, schemas[i]);
      if (const auto* action = std::get_if<actions::Action>(&item)) {
        actions::check(*action);
        actions::check(*action, schemas[i]);
      }
      if (const auto* spawn = std::get_if<Spawn>(&item)) {
        require(spawn->into >= 0 && static_cast<std::size_t>(spawn->into) < schemas.size(), "spawn must name a system");
        check(*spawn, schemas[i], schemas[static_cast<std::size_t>(spawn->into)]);
      }
      if (const auto* callback = std::get_if<Callback>(&item)) {
        actions::check_condition(callback->where, callback->shapes, schemas[i]);
      }
    }
  }
}

bool follows_an_earlier(const Record& record, const SystemDefinition& system) {
  if (system.domains_of == -1) return true;
  const auto own = &system - record.systems.data();
  if (system.domains_of < 0 || system.domains_of >= own) return false;
  const SystemDefinition& leader = record.systems[static_cast<std::size_t>(system.domains_of)];
  return leader.domains_of == -1 && leader.axes == system.axes && leader.space == system.space;
}

void check(const Record& record) {
  require(record.verb == Verb::render || record.verb == Verb::step, "a frame must be rendered or stepped");
  require(std::isfinite(record.dt) && record.dt > 0, "dt must be a positive number");
  require(record.substeps >= 1 && record.substeps <= kMostSubsteps, "substeps must be 1..10000");
  require(record.lists.size() == record.systems.size(), "there must be one list per system");
  require(record.sprites.size() == record.systems.size(), "there must be one sprite per system");
  require(record.clumps.size() == record.systems.size(), "there must be one template per system");
  for (const SystemDefinition& system : record.systems) {
    require(system.axes.valid(), "axes must be among x, y and z, or a curve");
    require(!system.axes.curve() || domains::has_ends(system.space, system.periods),
            "space must be bounded for a curve");
    require(follows_an_earlier(record, system), "domains_of must be an earlier system that has its own domains");
    const bool finite = system.space.kind == domains::Space::Kind::finite;
    require(system.periods.bits < 8 && system.periods == record.systems[0].periods,
            "all systems must be in the same periodic space");
    require(!finite || system.space.low < system.space.high, "the low end of space must be below its high end");
  }
  if (record.view) image::check(*record.view);
  check_items(record);
}

void add_meshes(const shapes::Shape& shape, std::set<meshes::AssetKey>& keys) {
  for (const meshes::AssetKey key : shapes::meshes_of(shape)) keys.insert(key);
}

void add_meshes(const std::vector<shapes::Shape>& list, std::set<meshes::AssetKey>& keys) {
  for (const shapes::Shape& shape : list) add_meshes(shape, keys);
}

void add_meshes(const std::vector<Given>& state, std::set<meshes::AssetKey>& keys) {
  for (const Given& given : state) {
    if (const auto* in = std::get_if<actions::distributions::InShape>(&given.distribution)) add_meshes(in->shape, keys);
  }
}

// Adds the meshes among an item's shapes.
void add_meshes(const Item& item, std::set<meshes::AssetKey>& keys) {
  if (const auto* birth = std::get_if<Birth>(&item)) {
    for (const meshes::AssetKey key : meshes_of(*birth)) keys.insert(key);
  }
  if (const auto* spawn = std::get_if<Spawn>(&item)) {
    add_meshes(spawn->state, keys);
    add_meshes(spawn->shapes, keys);
  }
  if (const auto* action = std::get_if<actions::Action>(&item)) add_meshes(action->shapes, keys);
  if (const auto* callback = std::get_if<Callback>(&item)) add_meshes(callback->shapes, keys);
}

// Returns the pictures and meshes that frames name.
std::set<meshes::AssetKey> assets_of(const std::vector<std::span<const std::byte>>& frames) {
  std::set<meshes::AssetKey> keys;
  for (const std::span<const std::byte> frame : frames) {
    Reader in(frame);
    const Record record = read(in);
    for (const image::Sprite& sprite : record.sprites) {
      keys.insert({sprite.asset(), sprite.picture_on_mesh()});
      if (sprite.sheet() != nullptr) add_meshes(sprite.sheet()->pick.shapes, keys);
    }
    for (const std::vector<Item>& list : record.lists) {
      for (const Item& item : list) add_meshes(item, keys);
    }
    if (!record.view) continue;
    for (const image::Solid& solid : record.view->objects) keys.insert({solid.mesh, solid.image, solid.finish_image});
    keys.insert(record.view->sky.picture);
  }
  keys.erase(0);
  return keys;
}

// Returns the keys, of ties or tables, that actions of frames name in a struct of their specifics.
template <class Part>
std::set<std::uint64_t> named_by(const std::vector<std::span<const std::byte>>& frames, std::uint64_t Part::* name) {
  std::set<std::uint64_t> keys;
  for (const std::span<const std::byte> frame : frames) {
    Reader in(frame);
    for (const std::vector<Item>& list : read(in).lists) {
      for (const Item& item : list) {
        const auto* action = std::get_if<actions::Action>(&item);
        const auto* part = action != nullptr ? std::get_if<Part>(&action->specifics) : nullptr;
        if (part != nullptr && part->*name != 0) keys.insert(part->*name);
      }
    }
  }
  return keys;
}

// Returns the templates of clumps that frames name.
std::set<std::uint64_t> clumps_of(const std::vector<std::span<const std::byte>>& frames) {
  std::set<std::uint64_t> keys;
  for (const std::span<const std::byte> frame : frames) {
    Reader in(frame);
    for (const actions::TableKey clump : read(in).clumps) keys.insert(clump);
  }
  keys.erase(0);
  return keys;
}

}  // namespace

const char* version() { return MOTES_VERSION; }

std::string Scene::fact(const std::string& name) const {
  const auto found = std::find_if(facts.begin(), facts.end(), [&](const auto& fact) { return fact.first == name; });
  return found == facts.end() ? "" : found->second;
}

void write(const Scene& scene, Bytes& out) {
  const std::size_t start = out.size();
  out.put(Head{});
  out.put_text(version());
  out.put(static_cast<std::uint32_t>(scene.facts.size()));
  for (const auto& [name, value] : scene.facts) {
    out.put_text(name);
    out.put_text(value);
  }
  out.put(static_cast<std::uint64_t>(scene.frames.size()));
  for (const std::span<const std::byte> frame : scene.frames) {
    out.put(static_cast<std::uint64_t>(frame.size()));
    out.put_raw(frame.data(), frame.size());
  }
  meshes::write_assets(assets_of(scene.frames), out);
  interactions::write_ties(named_by(scene.frames, &actions::TiedPairs::ties), out);
  std::set<std::uint64_t> tables = named_by(scene.frames, &actions::Lookup::table);
  tables.merge(named_by(scene.frames, &actions::Grains::clump));
  tables.merge(clumps_of(scene.frames));
  actions::write_tables(tables, out);
  Head head;
  head.bytes = out.size() - start;
  head.content = base::hash(out.view().subspan(start + sizeof(Head)));
  head.layout = layout();
  out.set(start, head);
}

Scene read_scene(std::span<const std::byte> bytes) {
  const Head head = read_head(bytes);
  Reader in(bytes.subspan(sizeof(Head)));
  Scene scene;
  scene.version = in.get_text();
  if (head.layout != layout()) {
    throw std::runtime_error("was recorded by motes " + scene.version + ", whose lists this version (" + version() +
                             ") cannot read: record it again");
  }
  for (auto left = in.get<std::uint32_t>(); left > 0; --left) {
    std::string name = in.get_text();
    scene.facts.emplace_back(std::move(name), in.get_text());
  }
  for (auto left = in.get<std::uint64_t>(); left > 0; --left) scene.frames.push_back(in.take(in.get<std::uint64_t>()));
  meshes::read_assets(in);
  interactions::read_ties(in);
  actions::read_tables(in);
  if (!in.done()) throw std::runtime_error("is damaged: there is data after its end");
  return scene;
}

Record read_frame(std::span<const std::byte> bytes) {
  Reader in(bytes);
  Record record = read(in);
  require(in.done(), "there is data after it");
  check(record);
  return record;
}

}  // namespace motes::recording
