#include "comm/shared_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <random>
#include <string>
#include <string_view>
#include <utility>

#include "base/memory.h"

namespace motes::comm {
namespace {

using base::kPage;

constexpr auto kKeyBytes = static_cast<ssize_t>(sizeof(SharedMemory::Address::key));

// An open file that is closed at the end of its scope unless it is released.
class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  int get() const { return descriptor_; }
  int release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_;
};

// The beginning of the link target of an open memory file in /proc.
constexpr std::string_view kLink = "/memfd:motes";

// Makes a file in memory without a name, which exists as long as a process has it open or mapped.
int make_file() {
#if defined(__linux__)
  return ::memfd_create("motes", MFD_CLOEXEC);
#else
  return -1;
#endif
}

// Returns whether files may have this size: beyond its limit, a process gets a signal that ends it.
bool files_may_have(std::size_t bytes) {
  rlimit limit{};
  return ::getrlimit(RLIMIT_FSIZE, &limit) == 0 && (limit.rlim_cur == RLIM_INFINITY || bytes <= limit.rlim_cur);
}

// Returns whether this is a link to a memory file: opening something else of that process, such as a device, might have
// side effects.
bool links_to_memory(const std::string& path) {
  char to[kLink.size()];
  return ::readlink(path.c_str(), to, sizeof to) == static_cast<ssize_t>(sizeof to) &&
         std::string_view(to, sizeof to) == kLink;
}

}  // namespace

std::shared_ptr<SharedMemory> SharedMemory::make(std::size_t bytes) {
  if (!files_may_have(kPage + bytes)) return nullptr;
  File file(make_file());
  if (file.get() < 0 || ::ftruncate(file.get(), static_cast<off_t>(kPage + bytes)) != 0) return nullptr;
  std::random_device random;
  Address address{.bytes = bytes, .process = ::getpid(), .descriptor = file.get(), .key = {}};
  for (std::uint64_t& part : address.key) part = (std::uint64_t{random()} << 32) | random();
  if (::pwrite(file.get(), address.key.data(), sizeof address.key, 0) != kKeyBytes) return nullptr;
  return map(file.release(), address);
}

// Opens the file by its link in /proc, where Linux shows the open files of a process to its user's other processes.
std::shared_ptr<SharedMemory> SharedMemory::open(const Address& address) {
  const std::string path = "/proc/" + std::to_string(address.process) + "/fd/" + std::to_string(address.descriptor);
  if (!links_to_memory(path)) return nullptr;
  File file(::open(path.c_str(), O_RDWR | O_CLOEXEC));
  struct stat found{};
  if (file.get() < 0 || ::fstat(file.get(), &found) != 0) return nullptr;
  if (static_cast<std::uint64_t>(found.st_size) != kPage + address.bytes) return nullptr;
  Address read = address;
  if (::pread(file.get(), read.key.data(), sizeof read.key, 0) != kKeyBytes || read.key != address.key) return nullptr;
  return map(file.release(), address);
}

std::shared_ptr<SharedMemory> SharedMemory::map(int descriptor, const Address& address) {
  void* mapped = ::mmap(nullptr, kPage + address.bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (mapped == MAP_FAILED) {
    ::close(descriptor);
    return nullptr;
  }
  return std::shared_ptr<SharedMemory>(new SharedMemory(descriptor, address, mapped));
}

SharedMemory::~SharedMemory() {
  ::munmap(mapped_, kPage + address_.bytes);
  ::close(descriptor_);
}

std::byte* SharedMemory::data() { return static_cast<std::byte*>(mapped_) + kPage; }

}  // namespace motes::comm
