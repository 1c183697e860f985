#include "snapshots/writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace motes::snapshots {
namespace {

static_assert(kPiece >= base::kLargeMemory, "what goes past the kernel's cache must be aligned");

// A file that bypasses the kernel's page cache, in whole pieces, if the file system allows it: filling the cache with
// data that nobody will read costs several times the CPU time of writing and evicts what others need.
class File {
 public:
  explicit File(std::string path)
      : path_(std::move(path)),
        file_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666)) {
    if (file_ < 0) fail("create");
  }
  ~File() {
    if (file_ >= 0) ::close(file_);
    if (!kept_) ::unlink(path_.c_str());
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void write(std::span<const std::byte> bytes) {
    piece_.reserve(kPiece);  // aligned, because it is large
    while (!bytes.empty()) {
      const std::size_t count = std::min(bytes.size(), kPiece - piece_.size());
      piece_.put_raw(bytes.data(), count);
      bytes = bytes.subspan(count);
      if (piece_.size() == kPiece) write_piece(true);
    }
  }

  void become(const std::string& path) {
    write_piece(false);
    if (::fsync(file_) != 0) fail("sync");
    if (::close(std::exchange(file_, -1)) != 0) fail("close");
    if (std::rename(path_.c_str(), path.c_str()) != 0) fail("rename");
    kept_ = true;
  }

 private:
  void write_piece(bool whole) {
    bool direct = whole && go_direct(true);
    for (std::span<const std::byte> rest = piece_.view(); !rest.empty();) {
      const ssize_t count = ::write(file_, rest.data(), rest.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0 && !(direct && errno == EINVAL)) fail("write");
      if (count > 0) rest = rest.subspan(static_cast<std::size_t>(count));
      if (!rest.empty()) direct = go_direct(false);  // the rest is not a whole page, or the file system refuses
    }
    if (direct) go_direct(false);
    piece_.clear();
  }

  // Switches direct I/O on or off, and returns whether it is on.
  bool go_direct([[maybe_unused]] bool on) const {
#ifdef O_DIRECT
    const int flags = ::fcntl(file_, F_GETFL);
    const int wanted = on ? flags | O_DIRECT : flags & ~O_DIRECT;
    return flags >= 0 && ::fcntl(file_, F_SETFL, wanted) == 0 && on;
#else
    return false;
#endif
  }

  [[noreturn]] void fail(const char* what) const {
    throw std::runtime_error(std::string("cannot ") + what + " " + path_ + ": " + std::strerror(errno));
  }

  std::string path_;
  int file_;
  bool kept_ = false;
  base::Bytes piece_;
};

}  // namespace

void write_whole(const std::string& path, std::span<const std::byte> head, std::span<const std::byte> rest) {
  File file(path + ".tmp");
  file.write(head);
  file.write(rest);
  file.become(path);
}

Writer::~Writer() { wait(); }

base::Bytes& Writer::planes() {
  wait();
  planes_.clear();
  return planes_;
}

void Writer::write(std::string path, Description description) {
  wait();
  {
    const std::scoped_lock lock(mutex_);
    busy_ = true;
  }
  try {
    thread_ = std::thread([this, path = std::move(path), described = std::move(description)]() mutable {
      run(path, std::move(described));
    });
  } catch (...) {
    const std::scoped_lock lock(mutex_);
    busy_ = false;  // or others would wait for this part forever
    throw;
  }
}

void Writer::run(const std::string& path, Description description) {
  std::string error;
  const std::uint64_t frame = description.frame;
  try {
    const base::Bytes first = head(description, planes_.view());
    write_whole(path, first.view(), planes_.view());
  } catch (const std::exception& failure) {
    error = failure.what();
  }
  const std::scoped_lock lock(mutex_);
  busy_ = false;
  if (error.empty()) outcome_.written = frame;
  outcome_.error = std::move(error);
}

void Writer::wait() {
  if (thread_.joinable()) thread_.join();
}

bool Writer::busy() const {
  const std::scoped_lock lock(mutex_);
  return busy_;
}

Writer::Outcome Writer::outcome() const {
  const std::scoped_lock lock(mutex_);
  return outcome_;
}

}  // namespace motes::snapshots
