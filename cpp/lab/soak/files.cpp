#include "lab/soak/files.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <vector>

#include "base/fields.h"
#include "engine/replay.h"
#include "jsonl/kept_rows.h"
#include "lab/soak/player.h"
#include "recording/scene.h"
#include "snapshots/part.h"

namespace motes::soak {
namespace {

using base::Bytes;

constexpr std::size_t kLine = 256;  // bytes of a table's row

Bytes copy_of(std::span<const std::byte> from) {
  Bytes bytes;
  bytes.put_raw(from.data(), from.size());
  return bytes;
}

bool same(std::span<const std::byte> a, std::span<const std::byte> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

// Intact files of an ordinary run.
struct Originals {
  Bytes scene, list, part, state;
  std::string table;
};

void with_engine(const std::function<void(engine::Engine&)>& use) {
  comm::Simulation simulation;
  simulation.ranks = 1;
  comm::simulate(simulation, [&](comm::SimulatedRank& self) {
    engine::Engine engine(std::make_unique<comm::Communicator>(self.transport(), comm::Watch{}), {}, settings({}, {}));
    use(engine);
  });
}

Originals make_originals() {
  Originals made;
  Film film;
  Disk disk;
  Accidents accidents;
  accidents.killed_at = 8;
  play({}, {}, accidents, film, &disk);
  Saved& saved = disk.checkpoints.rbegin()->second;
  made.part = std::move(saved.parts.begin()->second);
  made.state = std::move(saved.shared);
  with_engine([&](engine::Engine& engine) {
    define(engine, {});
    engine.keep_lists(true);
    engine.start();
    Story story;
    story.pictures = true;
    for (std::uint64_t frame = 0; frame < 3; ++frame) {
      record(engine, story, frame);
      engine.run_frame(view(story, {}, frame));
    }
    recording::Scene scene;
    for (const Bytes& list : engine.kept_lists()) scene.frames.push_back(list.view());
    recording::write(scene, made.scene);
    made.list = copy_of(engine.kept_lists()[1].view());
    engine.finish();
  });
  for (int frame = 0; frame < 12; ++frame) {
    std::string row = "{\"frame\":" + std::to_string(frame) + ",\"particles\":" + std::to_string(1000 * frame) + "}";
    row.resize(kLine - 1, ' ');
    made.table += row + "\n";
  }
  return made;
}

const Originals& originals() {
  thread_local const Originals made = make_originals();
  return made;
}

std::size_t somewhere(Random& random, const Bytes& bytes) { return random.below(bytes.size()); }

void hurt(Random& random, Bytes& bytes) {
  if (bytes.empty()) return;
  switch (random.below(6)) {
    case 0: bytes.resize(somewhere(random, bytes)); break;
    case 1: bytes.put(random.next()); break;
    case 2: {  // overwrites a stretch with another
      const std::size_t from = somewhere(random, bytes), to = somewhere(random, bytes);
      const std::size_t count = 1 + random.below(std::min(bytes.size() - std::max(from, to), std::size_t{64}));
      std::memmove(bytes.data() + to, bytes.data() + from, count);
      break;
    }
    case 3: {  // overwrites a number, perhaps a count
      const std::uint64_t numbers[] = {0, 1, UINT32_MAX, UINT64_MAX, random.next(), random.below(1000)};
      const std::size_t width = random.below(2) == 0 ? 4 : 8;
      if (bytes.size() < width) break;
      std::memcpy(bytes.data() + random.below(bytes.size() - width + 1), &numbers[random.below(6)], width);
      break;
    }
    default: bytes.data()[somewhere(random, bytes)] ^= std::byte{1} << random.below(8);
  }
}

Bytes damaged(Random& random, std::span<const std::byte> original) {
  Bytes bytes = copy_of(original);
  for (std::size_t times = 1 + random.below(3); times > 0; --times) hurt(random, bytes);
  return bytes;
}

// Returns whether `read` succeeds. A damaged file may only give these errors.
template <class Read>
bool could(const Read& read) {
  try {
    read();
    return true;
  } catch (const std::runtime_error&) {
    return false;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

// Reads a damaged scene, which has a fingerprint, and a damaged list, which has none: its content is checked and
// recorded.
void read_scene(Random& random, DamagedFile& file) {
  const Bytes scene = damaged(random, originals().scene.view());
  const Bytes list = damaged(random, originals().list.view());
  file.read = could([&] { recording::read_scene(scene.view()); });
  if (file.read && !same(scene.view(), originals().scene.view())) file.broken = "a damaged scene was read";
  could([&] {
    const recording::Record record = recording::read_frame(list.view());
    with_engine([&](engine::Engine& engine) { engine::record_again(engine, record); });
  });
}

void append_all(const snapshots::Opened& part) {
  threads::Pool pool(1, 16);
  const particles::Schema schema;
  for (std::size_t i = 0; i < part.description.systems.size(); ++i) {
    particles::Store store(schema);
    snapshots::append(part.description, part.planes, i, 0, part.description.systems[i].rows, store, pool);
  }
}

bool same(const snapshots::Opened& a, const snapshots::Opened& b) {
  Bytes first, second;
  base::write_fields(a.description, first);
  base::write_fields(b.description, second);
  return same(first.view(), second.view()) && same(a.planes, b.planes);
}

void read_part(Random& random, DamagedFile& file) {
  const Bytes part = damaged(random, originals().part.view());
  const snapshots::Opened then = snapshots::open(originals().part.view(), true);
  file.read = could([&] {
    if (!same(then, snapshots::open(part.view(), true))) file.broken = "a damaged part was read";
  });
  could([&] { append_all(snapshots::open(part.view(), false)); });
}

void read_state(Random& random, DamagedFile& file) {
  const Bytes state = damaged(random, originals().state.view());
  with_engine([&](engine::Engine& engine) {
    define(engine, {});
    file.read = could([&] { engine.restore_state(state.view(), std::vector<engine::Sample>(2)); });
  });
}

std::string content_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void read_table(Random& random, const std::string& directory, DamagedFile& file) {
  const Bytes table = damaged(random, std::as_bytes(std::span(originals().table)));
  const std::string path = directory + "/table.jsonl";
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(table.data()), static_cast<std::streamsize>(table.size()));
  const std::string before = content_of(path);
  const std::uint64_t first = random.below(14);
  file.read = could([&] { jsonl::keep_rows_before(first, path, kLine); });
  const std::string now = content_of(path);
  if (file.read && now.size() % kLine != 0) file.broken = "a table has half a row";
  if (!file.read && now != before) file.broken = "an unreadable table was changed";
}

}  // namespace

DamagedFile damaged_file(std::uint64_t seed, const std::string& directory) {
  Random random(seed * 2 + 1);
  DamagedFile file;
  file.kind = static_cast<DamagedFile::Kind>(random.below(4));
  switch (file.kind) {
    case DamagedFile::Kind::scene: read_scene(random, file); break;
    case DamagedFile::Kind::part: read_part(random, file); break;
    case DamagedFile::Kind::state: read_state(random, file); break;
    case DamagedFile::Kind::table: read_table(random, directory, file); break;
  }
  return file;
}

}  // namespace motes::soak
