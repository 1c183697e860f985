#include "driver/files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace motes::driver {
namespace {

std::runtime_error problem(const std::string& what, const std::string& path) {
  return std::runtime_error(what + " " + path + ": " + std::strerror(errno));
}

// A file descriptor that closes itself.
class Handle {
 public:
  explicit Handle(int number) : number_(number) {}
  ~Handle() {
    if (number_ >= 0) close(number_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  int operator*() const { return number_; }

 private:
  int number_;
};

void write_all(int file, std::span<const std::byte> content, const std::string& path) {
  while (!content.empty()) {
    const ssize_t written = write(file, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw problem("cannot write", path);
    content = content.subspan(static_cast<std::size_t>(written));
  }
  if (fsync(file) != 0) throw problem("cannot write", path);
}

}  // namespace

MappedFile::MappedFile(const std::string& path) {
  const Handle file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat facts{};
  if (*file < 0 || fstat(*file, &facts) != 0) throw problem("cannot read", path);
  if (!S_ISREG(facts.st_mode)) throw std::runtime_error("cannot read " + path + ": it is not a regular file");
  size_ = static_cast<std::size_t>(facts.st_size);
  if (size_ == 0) return;
  void* const data = mmap(nullptr, size_, PROT_READ, MAP_SHARED, *file, 0);
  if (data == MAP_FAILED) throw problem("cannot read", path);
  data_ = static_cast<const std::byte*>(data);
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) munmap(const_cast<std::byte*>(data_), size_);
}

void write_whole(const std::string& path, std::span<const std::byte> content) {
  const std::filesystem::path target(path);
  std::error_code error;
  if (target.has_parent_path()) std::filesystem::create_directories(target.parent_path(), error);
  if (error) throw std::runtime_error("cannot create " + target.parent_path().string() + ": " + error.message());
  std::filesystem::path hidden = ".";
  hidden += target.filename();
  hidden += ".XXXXXX";
  std::string draft = (target.parent_path() / hidden).string();
  const Handle file(mkostemp(draft.data(), O_CLOEXEC));
  if (*file < 0) throw problem("cannot write", path);
  try {
    write_all(*file, content, path);
    if (fchmod(*file, 0644) != 0 || rename(draft.c_str(), path.c_str()) != 0) throw problem("cannot write", path);
  } catch (...) {
    unlink(draft.c_str());
    throw;
  }
}

void write_ppm(const std::string& path, int width, int height, std::span<const unsigned char> pixels) {
  const std::string header = "P6\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  std::vector<std::byte> content(header.size() + pixels.size());
  std::memcpy(content.data(), header.data(), header.size());
  if (!pixels.empty()) std::memcpy(content.data() + header.size(), pixels.data(), pixels.size());
  write_whole(path, content);
}

}  // namespace motes::driver
