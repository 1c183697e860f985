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

// A signal or a full disk is noticed between two of these.
constexpr std::size_t kPiece = std::size_t{8} << 20;

class File {
 public:
  explicit File(std::string path)
      : path_(std::move(path)), file_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (file_ < 0) fail("create");
  }
  ~File() {
    if (file_ >= 0) ::close(file_);
    if (!kept_) ::unlink(path_.c_str());
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(file_, bytes.data(), std::min(bytes.size(), kPiece));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail("write");
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
  }

  void become(const std::string& path) {
    if (::fsync(file_) != 0) fail("bring to disk");
    if (::close(std::exchange(file_, -1)) != 0) fail("close");
    if (std::rename(path_.c_str(), path.c_str()) != 0) fail("rename");
    kept_ = true;
  }

 private:
  [[noreturn]] void fail(const char* what) const {
    throw std::runtime_error(std::string("cannot ") + what + " " + path_ + ": " + std::strerror(errno));
  }

  std::string path_;
  int file_;
  bool kept_ = false;
};

}  // namespace

void write_whole(const std::string& path, std::span<const std::byte> head, std::span<const std::byte> rest) {
  File file(path + ".tmp");
  file.write(head);
  file.write(rest);
  file.become(path);
}

Writer::~Writer() { wait(); }

particles::Bytes& Writer::planes() {
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
  thread_ = std::thread([this, path = std::move(path), described = std::move(description)]() mutable {
    run(path, std::move(described));
  });
}

void Writer::run(const std::string& path, Description description) {
  std::string error;
  const std::uint64_t frame = description.frame;
  try {
    const particles::Bytes first = head(description, planes_.view());
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
