#include "jsonl/kept_rows.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "jsonl/table.h"

namespace motes::jsonl {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

[[noreturn]] void fail(const std::string& what, const std::string& path) {
  throw LogError("log: " + what + " " + path + ": " + std::strerror(errno));
}

class File {
 public:
  File(std::string path, int flags) : path_(std::move(path)), file_(::open(path_.c_str(), flags | O_CLOEXEC, 0644)) {}
  ~File() {
    if (file_ >= 0) ::close(file_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  bool is_open() const { return file_ >= 0; }

  std::size_t read(char* into, std::size_t bytes) {
    const ssize_t count = ::read(file_, into, bytes);
    if (count < 0) fail("cannot read", path_);
    return static_cast<std::size_t>(count);
  }
  void write(std::string_view text) {
    while (!text.empty()) {
      const ssize_t count = ::write(file_, text.data(), text.size());
      if (count < 0) fail("cannot write", path_);
      text.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  void sync() {
    if (::fsync(file_) != 0) fail("cannot write", path_);
  }

 private:
  std::string path_;
  int file_;
};

// Returns the frame of a row, its first field; none if the line is not a row.
std::optional<std::uint64_t> frame_of(std::string_view line) {
  constexpr std::string_view kStart = "{\"frame\":";
  const std::size_t end = line.find_last_not_of(' ');
  if (!line.starts_with(kStart) || end == std::string_view::npos || line[end] != '}') return std::nullopt;
  std::uint64_t frame = 0;
  const char* last = line.data() + line.size();
  const auto [stopped, error] = std::from_chars(line.data() + kStart.size(), last, frame);
  const bool ends = stopped != last && (*stopped == ',' || *stopped == '}');
  if (error != std::errc() || !ends || line.find('\0') != std::string_view::npos) return std::nullopt;
  return frame;
}

class Sieve {
 public:
  Sieve(std::uint64_t first_frame, const std::string& path, std::size_t line_bytes)
      : first_frame_(first_frame), path_(path), line_bytes_(line_bytes) {}

  // Returns those of the text's whole lines that stay; keeps an incomplete line until more text comes.
  std::string_view take(std::string_view text) {
    kept_.clear();
    waiting_ += text;
    std::size_t begin = 0;
    for (std::size_t end; (end = waiting_.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const auto line = std::string_view(waiting_).substr(begin, end + 1 - begin);
      if (stays(line)) kept_ += line;
    }
    waiting_.erase(0, begin);
    return kept_;
  }

 private:
  bool stays(std::string_view line) {
    ++number_;
    if (line.size() % line_bytes_ != 0) {
      damaged("it has " + std::to_string(line.size()) + " bytes, not a multiple of " + std::to_string(line_bytes_));
    }
    line.remove_suffix(1);
    const std::optional<std::uint64_t> frame = frame_of(line);
    if (!frame) damaged("it is not a JSON object that begins with a frame");
    return *frame < first_frame_;
  }

  [[noreturn]] void damaged(const std::string& why) const {
    throw LogError("log: " + path_ + ", line " + std::to_string(number_) + ": damaged row: " + why);
  }

  std::uint64_t first_frame_;
  const std::string& path_;
  std::size_t line_bytes_;
  std::string waiting_, kept_;
  std::uint64_t number_ = 0;
};

void sieve(File& from, File& to, Sieve& sieve) {
  std::vector<char> chunk(kChunkBytes);
  while (const std::size_t count = from.read(chunk.data(), chunk.size())) to.write(sieve.take({chunk.data(), count}));
}

}  // namespace

void keep_rows_before(std::uint64_t first_frame, const std::string& path, std::size_t line_bytes) {
  File table(path, O_RDONLY);
  if (!table.is_open()) {
    if (errno == ENOENT) return;
    fail("cannot read", path);
  }
  const std::size_t name = path.rfind('/') + 1;
  const std::string draft = path.substr(0, name) + "." + path.substr(name) + ".tmp";
  try {
    File kept(draft, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW);
    if (!kept.is_open()) fail("cannot write", draft);
    Sieve rows(first_frame, path, line_bytes);
    sieve(table, kept, rows);
    kept.sync();
    if (std::rename(draft.c_str(), path.c_str()) != 0) fail("cannot rename to", path);
  } catch (...) {
    unlink(draft.c_str());
    throw;
  }
  sync_directory_of(path);
}

}  // namespace motes::jsonl
