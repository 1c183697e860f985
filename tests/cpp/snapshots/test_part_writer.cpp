// Files of parts: what is written past the kernel's cache in whole pieces, and the rest.
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>

#include "snapshots/writer.h"
#include "support/check.h"

namespace motes::test_part_writer {
namespace {

using snapshots::kPiece;

std::vector<std::byte> numbers(std::size_t count) {
  std::vector<std::byte> bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(i * 2654435761u >> 13);
  return bytes;
}

std::string content_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Returns whether the file has these bytes, one after the other.
bool holds(const std::string& path, const std::vector<std::byte>& head, const std::vector<std::byte>& rest) {
  const std::string content = content_of(path);
  const std::span<const std::byte> bytes = std::as_bytes(std::span(content));
  return bytes.size() == head.size() + rest.size() && std::ranges::equal(bytes.first(head.size()), head) &&
         std::ranges::equal(bytes.subspan(head.size()), rest);
}

std::string fresh(const std::string& folder) {
  const std::string directory = folder + "/motes-part-writer-" + std::to_string(getpid());
  std::filesystem::remove_all(directory);
  std::filesystem::create_directories(directory);
  return directory;
}

}  // namespace

TEST(a_part_has_its_bytes_whatever_the_file_system_can_do) {
  const std::vector<std::byte> head = numbers(129);
  for (const std::string& folder : {std::filesystem::temp_directory_path().string(), std::string("/dev/shm")}) {
    if (!std::filesystem::is_directory(folder)) continue;
    const std::string directory = fresh(folder), path = directory + "/part";
    for (const std::size_t size : {std::size_t{0}, std::size_t{5}, kPiece - 129, kPiece, 2 * kPiece + 4099}) {
      const std::vector<std::byte> rest = numbers(size);
      snapshots::write_whole(path, head, rest);
      CHECK(holds(path, head, rest));
      CHECK(!std::filesystem::exists(path + ".tmp"));
    }
    std::filesystem::remove_all(directory);
  }
}

TEST(a_part_that_does_not_fit_leaves_the_one_before) {
  const std::string directory = fresh(std::filesystem::temp_directory_path().string()), path = directory + "/part";
  const std::vector<std::byte> head = numbers(40), small = numbers(100), large = numbers(3 * kPiece);
  snapshots::write_whole(path, head, small);
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  CHECK(getrlimit(RLIMIT_FSIZE, &limit) == 0);
  for (const rlim_t most : {rlim_t{1000}, rlim_t{kPiece}, rlim_t{2 * kPiece + 100}}) {
    rlimit tight = limit;
    tight.rlim_cur = most;
    CHECK(setrlimit(RLIMIT_FSIZE, &tight) == 0);
    CHECK_THROWS(snapshots::write_whole(path, head, large), std::runtime_error);
    CHECK(setrlimit(RLIMIT_FSIZE, &limit) == 0);
    CHECK(holds(path, head, small) && !std::filesystem::exists(path + ".tmp"));
  }
  std::signal(SIGXFSZ, before);
  std::filesystem::remove_all(directory);
}

TEST(a_part_is_not_written_through_a_link_that_somebody_planted) {
  const std::string directory = fresh(std::filesystem::temp_directory_path().string());
  const std::string victim = directory + "/victim", path = directory + "/part";
  std::ofstream(victim) << "precious";
  std::filesystem::create_symlink(victim, path + ".tmp");
  CHECK_THROWS(snapshots::write_whole(path, numbers(10), numbers(20)), std::exception);
  CHECK(content_of(victim) == "precious" && !std::filesystem::exists(path));
  std::filesystem::remove_all(directory);
}

}  // namespace motes::test_part_writer
