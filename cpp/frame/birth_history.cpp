#include "frame/birth_history.h"

#include <algorithm>
#include <numeric>

namespace motes::frame {
namespace {

using particles::Store;
using recording::Birth;

constexpr std::size_t kWorthLooking = std::size_t{1} << 20;  // bytes
constexpr std::uint64_t kChunk = 1u << 16;                   // particles made at once

std::size_t bytes_of(const Birth& birth) {
  std::size_t bytes = sizeof birth + birth.state.size() * sizeof(recording::Given);
  for (const recording::Emitted& column : birth.columns) bytes += column.values.size() * sizeof(float);
  return bytes;
}

std::vector<std::uint32_t> by_id(const Store& store) {
  std::vector<std::uint32_t> order(store.size());
  std::iota(order.begin(), order.end(), 0u);
  const std::uint64_t* ids = store.ids();
  std::sort(order.begin(), order.end(), [ids](std::uint32_t a, std::uint32_t b) { return ids[a] < ids[b]; });
  return order;
}

// The *_b values of particle `from` of newborn ones for particle `to` of the living.
void copy_over(const Store& newborn, std::size_t from, Store& living, std::size_t to) {
  for (const auto& [copy, original] : particles::kCopies) {
    for (int c = 0; c < 3; ++c) {
      const float* made = newborn.plane(copy, c);
      living.writable_plane(copy, c)[to] =
          made != nullptr ? made[from] : newborn.uniform_value(copy)[static_cast<std::size_t>(c)];
    }
  }
}

}  // namespace

void BirthHistory::add(const Birth& birth, std::uint64_t first_id, std::uint64_t count, float dt) {
  calls_.push_back({birth, first_id, count, dt});
  bytes_ += bytes_of(birth);
}

void BirthHistory::forget_dead(const Store& store) {
  if (bytes_ < kWorthLooking || bytes_ < 2 * bytes_kept_) return;
  const std::vector<std::uint32_t> order = by_id(store);
  const std::uint64_t* ids = store.ids();
  std::erase_if(calls_, [&](const Call& call) {
    const auto first = std::lower_bound(order.begin(), order.end(), call.first_id,
                                        [ids](std::uint32_t p, std::uint64_t id) { return ids[p] < id; });
    return first == order.end() || ids[*first] >= call.first_id + call.count;
  });
  bytes_ = 0;
  for (const Call& call : calls_) bytes_ += bytes_of(call.birth);
  bytes_kept_ = bytes_;
}

void BirthHistory::restore_copies(Store& store, particles::Key key) {
  const std::vector<std::uint32_t> order = by_id(store);
  auto next = order.begin();
  for (const Call& call : calls_) {
    // What was emitted has arrays for the whole call; what is drawn can be made in parts.
    const std::uint64_t step = call.birth.kind == Birth::Kind::emit ? call.count : kChunk;
    for (std::uint64_t done = 0; done < call.count; done += step) {
      const std::uint64_t first = call.first_id + done;
      const std::uint64_t count = std::min(step, call.count - done);
      while (next != order.end() && store.ids()[*next] < first) ++next;
      if (next == order.end()) break;
      if (store.ids()[*next] >= first + count) continue;
      const Store newborn = recording::make(call.birth, store.schema(), key, first, count, call.dt, true);
      for (; next != order.end() && store.ids()[*next] < first + count; ++next) {
        copy_over(newborn, store.ids()[*next] - first, store, *next);
      }
    }
  }
  calls_.clear();
  bytes_ = bytes_kept_ = 0;
}

}  // namespace motes::frame
