// Tables of the log that a later run continues: exactly the rows of earlier frames stay.
#include <unistd.h>
#include <cmath>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "engine/log/account.h"
#include "jsonl/table.h"
#include "support/check.h"

namespace motes::test_table {
using namespace engine;
using namespace jsonl;

namespace {

constexpr std::size_t kLine = 64;

// A new directory for each test, removed at its end.
struct Folder {
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "motes_table_XXXXXX").string();
    path = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string file() const { return (path / "load.jsonl").string(); }

  std::filesystem::path path;
};

JsonlRow row(std::uint64_t frame, const std::string& text = "") {
  return JsonlRow().field("frame", frame).field("text", text);
}

void write(JsonlTable& table, const std::vector<std::uint64_t>& frames) {
  for (const std::uint64_t frame : frames) table.add(row(frame));
  table.write();
}

std::string content(const std::string& path) {
  const std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

void put(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

std::string error_of(const std::string& path, std::uint64_t first) {
  try {
    const JsonlTable table(path, kLine, first);
  } catch (const LogError& error) {
    return error.what();
  }
  return "none";
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST(table_continued_is_the_uninterrupted_one) {
  const Folder folder, other;
  JsonlTable whole(other.file(), kLine);
  write(whole, {0, 0, 1, 1, 2, 2, 3, 3, 4, 4});
  for (const std::uint64_t first : {1, 2, 4, 5, 7}) {
    {
      JsonlTable before(folder.file(), kLine);
      write(before, {0, 0, 1, 1, 2, 2, 3, 3, 4});
      if (first > 4) write(before, {4});
    }
    JsonlTable after(folder.file(), kLine, first);
    for (std::uint64_t frame = first; frame <= 4; ++frame) write(after, {frame, frame});
    CHECK(content(folder.file()) == content(other.file()));
  }
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path), {}) == 1);
}

TEST(table_continued_drops_a_torn_line) {
  const Folder folder;
  for (std::size_t torn = 1; torn < kLine; ++torn) {
    {
      JsonlTable before(folder.file(), kLine);
      write(before, {0, 1, 2});
    }
    const std::string text = content(folder.file());
    put(folder.file(), text.substr(0, 2 * kLine + torn));
    {
      JsonlTable after(folder.file(), kLine, 9);
      write(after, {9});
    }
    CHECK(content(folder.file()).size() == 3 * kLine);
    CHECK(content(folder.file()).substr(0, 2 * kLine) == text.substr(0, 2 * kLine));
    CHECK(has(content(folder.file()).substr(2 * kLine), "{\"frame\":9,"));
  }
  // After a crash of the machine the end may be zeros.
  put(folder.file(), std::string(100, '\0'));
  const JsonlTable after(folder.file(), kLine, 9);
  CHECK(content(folder.file()).empty());
}

TEST(table_continued_after_a_kill_in_that_moment) {
  const Folder folder;
  {
    JsonlTable before(folder.file(), kLine);
    write(before, {0, 1, 2});
  }
  const std::string text = content(folder.file());
  put((folder.path / ".load.jsonl.tmp").string(), text + text + "half of");
  const JsonlTable after(folder.file(), kLine, 2);
  CHECK(content(folder.file()) == text.substr(0, 2 * kLine));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path), {}) == 1);
}

TEST(table_continued_without_rows) {
  const Folder folder;
  {
    JsonlTable after(folder.file(), kLine, 5);  // there is no file
    write(after, {5});
  }
  CHECK(content(folder.file()).size() == kLine);
  put(folder.file(), "");
  JsonlTable after(folder.file(), kLine, 5);
  CHECK(content(folder.file()).empty());
  write(after, {5});
  CHECK(content(folder.file()).size() == kLine);
}

TEST(table_continued_keeps_long_lines_and_large_files) {
  const Folder folder;
  std::string expected;
  {
    JsonlTable before(folder.file(), kLine);
    for (std::uint64_t frame = 0; frame < 60'000; ++frame) {
      before.add(row(frame, std::string(frame % 100, 'x')));
      if (frame == 41'233) {
        before.write();
        expected = content(folder.file());
      }
    }
    before.write();
  }
  const JsonlTable after(folder.file(), kLine, 41'234);
  CHECK(expected.size() > (std::size_t{2} << 20));
  CHECK(content(folder.file()) == expected);
}

TEST(table_continued_names_a_damaged_line) {
  const Folder folder;
  {
    JsonlTable before(folder.file(), kLine);
    write(before, {0, 1, 2, 3});
  }
  const std::string text = content(folder.file());
  const auto damaged = [&](std::size_t at, const std::string& with) {
    std::string other = text;
    other.replace(at, with.size(), with);
    put(folder.file(), other);
    const std::string error = error_of(folder.file(), 2);
    CHECK(content(folder.file()) == other);  // nothing was changed
    return error;
  };
  for (const char* with :
       {R"(["frame":)", R"({"image":)", R"({"frame":x)", R"({"frame":-1)", R"({"frame":")", R"({"frame":1 )"}) {
    const std::string error = damaged(kLine, with);
    CHECK(has(error, folder.file() + ", line 2: damaged row: "));
  }
  CHECK(has(damaged(2 * kLine + 20, std::string(1, '\0')), "line 3: damaged row"));
  CHECK(has(damaged(2 * kLine + 30, "\n"), "line 3: damaged row: it has 31 bytes, not a multiple of 64"));
  std::string shorter = text;
  shorter.erase(kLine + 50, 1);
  put(folder.file(), shorter);
  CHECK(has(error_of(folder.file(), 2), "line 2: damaged row: it has 63 bytes"));
}

TEST(table_that_cannot_be_continued_stays) {
  const Folder folder;
  std::filesystem::create_directory(folder.file());
  CHECK(has(error_of(folder.file(), 2), "log: cannot read " + folder.file()));
  CHECK(has(error_of("/dev/null/load.jsonl", 2), "log: cannot read /dev/null/load.jsonl"));
  CHECK(has(error_of("/dev/null/load.jsonl", 0), "log: cannot write /dev/null/load.jsonl"));
}

TEST(log_continued_says_so_and_keeps_its_start) {
  const Folder folder;
  const auto frame_row = [](std::uint64_t frame) {
    FrameRow row;
    row.frame = frame;
    row.load.resize(2);
    for (LoadRow& load : row.load) load.system = "snow";
    return row;
  };
  Logging logging;
  logging.directory = folder.path.string();
  logging.hosts = {"one", "two"};
  {
    Account account;
    account.open_log(logging);
    for (std::uint64_t frame = 0; frame < 5; ++frame) account.log()->add(frame_row(frame));
    account.log()->event("crowded", 2, "kept");
    account.log()->event("crowded", 3, "dropped");
    account.log()->event("end", 5, "");
  }
  logging.continued_from = 3;
  logging.hosts = {"one"};
  Account account;
  account.open_log(logging);
  account.log()->add(frame_row(3));
  account.secure_rows();
  const std::string events = content(folder.path / "events.jsonl");
  CHECK(events.size() == 3 * 256);
  CHECK(has(events, "{\"frame\":0,\"kind\":\"start\""));
  CHECK(has(events, "kept") && !has(events, "dropped") && !has(events, "end"));
  CHECK(has(events, "{\"frame\":3,\"kind\":\"continued\",\"text\":\"from the checkpoint of frame 3 on 1 rank\"}"));
  CHECK(content(folder.path / "frames.jsonl").size() == 4 * 1024);
  CHECK(content(folder.path / "load.jsonl").size() == 4 * 2 * 512);
  CHECK(content(folder.path / "density.jsonl").size() == 4 * 2 * 512);
}

TEST(a_table_is_not_written_through_a_link_that_somebody_planted) {
  const Folder folder;
  const std::string victim = (folder.path / "victim").string();
  put(victim, "precious");
  std::filesystem::create_symlink(victim, folder.file());
  CHECK(has(error_of(folder.file(), 0), "cannot write " + folder.file()));
  std::filesystem::remove(folder.file());
  {
    JsonlTable table(folder.file(), kLine);
    write(table, {0, 1, 2});
  }
  std::filesystem::create_symlink(victim, folder.path / ".load.jsonl.tmp");
  CHECK(has(error_of(folder.file(), 2), "cannot write"));
  CHECK(content(victim) == "precious");
}

TEST(floats_are_floats_to_every_reader) {
  JsonlRow row;
  row.field("a", 0.0).field("b", 3.0f).field("c", -2.0).field("d", 0.5f).field("e", 1e20).field("f", 123456789.0);
  row.field("g", std::uint64_t{3}).field("h", std::nan("")).field("i", -0.0f).field("j", 1e-7f);
  CHECK(row.done() ==
        R"({"a":0.0,"b":3.0,"c":-2.0,"d":0.5,"e":1e+20,"f":123456789.0,"g":3,"h":null,"i":-0.0,"j":1e-07})");
}

TEST(a_table_without_rows_is_no_file_if_wanted) {
  const Folder folder;
  const auto exists = [&] { return std::filesystem::exists(folder.file()); };
  {
    put(folder.file(), "of an earlier run\n");
    JsonlTable table(folder.file(), kLine, 0, JsonlTable::Empty::absent);
    table.write();
    table.sync();
    CHECK(!exists());
    write(table, {0, 3});
    CHECK(exists());
    write(table, {4});
  }
  CHECK(content(folder.file()).size() == 3 * kLine);
  {
    JsonlTable table(folder.file(), kLine, 3, JsonlTable::Empty::absent);
    write(table, {3});
    CHECK(content(folder.file()).size() == 2 * kLine);
  }
  JsonlTable table(folder.file(), kLine, 0, JsonlTable::Empty::absent);
  put(folder.file(), "of somebody else\n");
  table.add(row(0));
  bool refused = false;
  try {
    table.write();
  } catch (const LogError&) {
    refused = true;
  }
  CHECK(refused);
}

}  // namespace motes::test_table
