// Memory that processes of one host share, to read from it instead of receiving messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace motes::comm {

class SharedMemory {
 public:
  /// Where other processes of this host find the memory. Sent as bytes.
  struct Address {
    std::uint64_t bytes = 0;  // 0: there is none
    std::int64_t process = 0;
    std::int64_t descriptor = 0;
    std::array<std::uint64_t, 2> key{};  // random: the receiver may know another process by this number
  };

  /// Makes zeroed memory, which is allocated only where it is written. Null if the system has no such memory or not
  /// enough.
  static std::shared_ptr<SharedMemory> make(std::size_t bytes);
  /// Opens another process's memory. Null if it is out of reach: another user's, another container's or another host's.
  static std::shared_ptr<SharedMemory> open(const Address& address);
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  ~SharedMemory();

  std::byte* data();
  std::size_t size() const { return address_.bytes; }
  const Address& address() const { return address_; }

 private:
  SharedMemory(int descriptor, const Address& address, void* mapped)
      : descriptor_(descriptor), address_(address), mapped_(mapped) {}
  static std::shared_ptr<SharedMemory> map(int descriptor, const Address& address);

  int descriptor_;
  Address address_;
  void* mapped_;  // a page with the key, then the memory
};

}  // namespace motes::comm
