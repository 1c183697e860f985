#include "snapshots/file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace motes::snapshots {

PartFile::PartFile(const std::string& path, bool sums) {
  const auto fail = [&](const char* what) {
    throw std::runtime_error(std::string("cannot ") + what + " " + path + ": " + std::strerror(errno));
  };
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail("open");
  struct stat status{};
  if (::fstat(file, &status) != 0 || status.st_size <= 0) {
    ::close(file);
    throw std::runtime_error(path + ": damaged checkpoint: the file is empty");
  }
  bytes_ = static_cast<std::size_t>(status.st_size);
  memory_ = ::mmap(nullptr, bytes_, PROT_READ, MAP_PRIVATE, file, 0);
  ::close(file);
  if (memory_ == MAP_FAILED) fail("read");
  try {
    opened_ = open({static_cast<const std::byte*>(memory_), bytes_}, sums);
  } catch (const std::exception& error) {
    ::munmap(memory_, bytes_);
    throw std::runtime_error(path + ": " + error.what());
  }
}

PartFile::~PartFile() { ::munmap(memory_, bytes_); }

}  // namespace motes::snapshots
