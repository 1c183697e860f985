// render: lets the threads of a rank write tiles into one message.
#pragma once

#include <algorithm>
#include <vector>

#include "base/bytes.h"
#include "threads/pool.h"

namespace motes::engine {

/// Calls put(slot, worker, bytes) for slots first .. end - 1 on all threads; appends the bytes in the order of slots.
template <class Put>
void put_slots(threads::Pool& pool, int first, int end, base::Bytes& out, const Put& put) {
  if (pool.threads() == 1) {
    for (int slot = first; slot < end; ++slot) {
      put(slot, 0, out);
      pool.pause();
    }
    return;
  }
  constexpr int kSlots = 8;  // slots per task of a thread
  std::vector<base::Bytes> parts(static_cast<std::size_t>((end - first + kSlots - 1) / kSlots));
  pool.run(parts.size(), [&](std::size_t part, std::size_t worker) {
    const int begin = first + static_cast<int>(part) * kSlots;
    for (int slot = begin; slot < std::min(end, begin + kSlots); ++slot) put(slot, worker, parts[part]);
  });
  for (const base::Bytes& part : parts) out.put_raw(part.data(), part.size());
}

}  // namespace motes::engine
