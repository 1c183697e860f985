// Damaged scenes, checkpoints and tables: see soak/files.h.
#include <filesystem>
#include <string>

#include "lab/soak/files.h"
#include "support/check.h"

namespace motes::test_damaged_files {
TEST(a_damaged_file_is_refused_or_read_rightly) {
  const std::string directory = std::filesystem::temp_directory_path() / "motes-damaged-files";
  std::filesystem::create_directories(directory);
  int kinds[4] = {};
  int read = 0;
  for (std::uint64_t seed = 0; seed < 1200; ++seed) {
    const soak::DamagedFile file = soak::damaged_file(seed, directory);
    if (!file.broken.empty()) check::fail(__FILE__, __LINE__, "seed " + std::to_string(seed) + ": " + file.broken);
    ++kinds[static_cast<int>(file.kind)];
    read += file.read ? 1 : 0;
  }
  std::filesystem::remove_all(directory);
  for (const int count : kinds) CHECK(count > 200);
  CHECK(read > 40 && read < 600);
}

}  // namespace motes::test_damaged_files
