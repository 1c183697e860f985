// Memory that the processes of one host share.
#include <cstring>
#include <memory>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "comm/shared_memory.h"
#include "support/check.h"

namespace motes::test_shared_memory {
using comm::SharedMemory;
using Address = SharedMemory::Address;

namespace {

constexpr std::size_t kBytes = 100'000;

}  // namespace

TEST(what_another_process_writes_to_shared_memory_is_there) {
  const auto memory = SharedMemory::make(kBytes);
  CHECK(memory && memory->size() == kBytes);
  for (std::size_t i = 0; i < kBytes; ++i) CHECK(memory->data()[i] == std::byte{0});
  const Address address = memory->address();
  const pid_t child = ::fork();
  if (child == 0) {
    const auto found = SharedMemory::open(address);
    if (!found || found->data() == memory->data() || found->size() != kBytes) ::_exit(1);
    std::memset(found->data(), 7, kBytes);
    ::_exit(0);
  }
  int status = -1;
  CHECK(::waitpid(child, &status, 0) == child && status == 0);
  for (std::size_t i = 0; i < kBytes; ++i) CHECK(memory->data()[i] == std::byte{7});
}

TEST(shared_memory_stays_while_anybody_has_it) {
  auto memory = SharedMemory::make(kBytes);
  const Address address = memory->address();
  const auto found = SharedMemory::open(address);
  memory->data()[kBytes - 1] = std::byte{3};
  memory.reset();
  CHECK(found && found->data()[kBytes - 1] == std::byte{3});
  found->data()[0] = std::byte{4};
  CHECK(SharedMemory::open(address) == nullptr);  // its creator is gone
}

TEST(memory_that_is_not_the_one_meant_is_not_opened) {
  const auto memory = SharedMemory::make(kBytes), other = SharedMemory::make(kBytes);
  Address wrong_key = memory->address(), wrong_size = wrong_key, nobody = wrong_key, closed = wrong_key,
          another = wrong_key, terminal = wrong_key;
  wrong_key.key[1] ^= 1;
  wrong_size.bytes += 1;
  nobody.process = -1;
  closed.descriptor = 100'000;
  another.descriptor = other->address().descriptor;
  terminal.descriptor = 0;  // whatever standard input is
  for (const Address& address : {wrong_key, wrong_size, nobody, closed, another, terminal, Address{}}) {
    CHECK(SharedMemory::open(address) == nullptr);
  }
  CHECK(SharedMemory::open(memory->address()) != nullptr);
}

TEST(shared_memory_larger_than_the_system_gives_is_none) {
  CHECK(SharedMemory::make(std::size_t{1} << 60) == nullptr);
  rlimit limit{};
  CHECK(::getrlimit(RLIMIT_FSIZE, &limit) == 0);
  const rlimit small{kBytes, limit.rlim_max};
  CHECK(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  CHECK(SharedMemory::make(kBytes) == nullptr);  // a signal would end the process
  CHECK(SharedMemory::make(kBytes / 2) != nullptr);
  CHECK(::setrlimit(RLIMIT_FSIZE, &limit) == 0);
}

}  // namespace motes::test_shared_memory
