#include "engine/state/birth_history.h"

#include <algorithm>
#include <numeric>

namespace motes::engine {
namespace {

using particles::Store;
using recording::Birth;
using recording::BirthStep;

constexpr std::uint64_t kChunk = 1u << 16;  // particles to create at once
constexpr std::size_t kSources = 16;        // how many of the latest calls a new one is compared with

std::size_t bytes_of(const Birth& birth) {
  std::size_t bytes =
      sizeof birth + birth.state.size() * sizeof(recording::Given) + birth.before.size() * sizeof(shapes::Shape);
  for (const recording::Emitted& column : birth.columns) bytes += column.values.size() * sizeof(float);
  return bytes;
}

std::vector<std::uint32_t> by_id(const Store& store) {
  std::vector<std::uint32_t> order(store.size());
  std::iota(order.begin(), order.end(), 0u);
  const particles::Ids ids = store.ids();
  std::sort(order.begin(), order.end(), [ids](std::uint32_t a, std::uint32_t b) { return ids[a] < ids[b]; });
  return order;
}

// Returns the birth without its rate: rates may change from frame to frame, and particles do not depend on them.
Birth without_rate(Birth birth) {
  birth.rate = birth.scale = 0;
  birth.until.clear();
  birth.source = 0;
  return birth;
}

// Copies the *_b attributes of newborn particle `from` to living particle `to`.
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

// Returns the number of this call; a source that is the same in every frame keeps its number. Emitted arrays are never
// compared.
std::uint64_t BirthHistory::number_of(const Birth& birth, const BirthStep& moment) {
  const std::size_t first = calls_.size() > kSources ? calls_.size() - kSources : 0;
  for (std::size_t i = calls_.size(); birth.kind != Birth::Kind::emit && i > first; --i) {
    if (calls_[i - 1].moment == moment && calls_[i - 1].birth == birth) return forgotten_calls_ + i - 1;
  }
  calls_.push_back({birth, moment, bytes_of(birth)});
  call_bytes_ += calls_.back().bytes;
  return forgotten_calls_ + calls_.size() - 1;
}

void BirthHistory::add(const Birth& birth, std::uint64_t first_id, std::uint64_t count, const BirthStep& moment) {
  const bool emits = birth.kind == Birth::Kind::source;
  const std::uint64_t call = emits ? number_of(without_rate(birth), moment) : number_of(birth, moment);
  if (!stretches_.empty()) {
    IdRange& last = stretches_.back();
    if (last.call == call && last.first_id + last.count == first_id) {
      last.count += count;
      return;
    }
  }
  stretches_.push_back({first_id, count, call});
}

std::vector<std::uint64_t> BirthHistory::meshes() const {
  std::vector<std::uint64_t> keys;
  for (const Call& call : calls_) {
    const std::vector<std::uint64_t> its = recording::meshes_of(call.birth);
    keys.insert(keys.end(), its.begin(), its.end());
  }
  return keys;
}

std::size_t BirthHistory::bytes() const { return call_bytes_ + stretches_.size() * sizeof(IdRange); }

void BirthHistory::forget_before(std::uint64_t oldest) {
  std::erase_if(stretches_, [oldest](const IdRange& s) { return s.first_id + s.count <= oldest; });
  std::uint64_t needed = forgotten_calls_ + calls_.size();
  for (const IdRange& stretch : stretches_) needed = std::min(needed, stretch.call);
  const auto kept = calls_.begin() + static_cast<std::ptrdiff_t>(needed - forgotten_calls_);
  for (auto call = calls_.begin(); call != kept; ++call) call_bytes_ -= call->bytes;
  calls_.erase(calls_.begin(), kept);
  forgotten_calls_ = needed;
  pruned_bytes_ = bytes();
}

void BirthHistory::restore_copies(Store& store, particles::Key key) {
  const std::vector<std::uint32_t> order = by_id(store);
  auto next = order.begin();
  for (const IdRange& stretch : stretches_) {
    const Call& call = calls_[stretch.call - forgotten_calls_];
    recording::check(call.birth, store.schema());  // also prepares meshes that were restored with the history
    // An emit has arrays for the whole call; random births can be made in chunks.
    const std::uint64_t step = call.birth.kind == Birth::Kind::emit ? stretch.count : kChunk;
    for (std::uint64_t done = 0; done < stretch.count; done += step) {
      const std::uint64_t first = stretch.first_id + done;
      const std::uint64_t count = std::min(step, stretch.count - done);
      while (next != order.end() && store.ids()[*next] < first) ++next;
      if (next == order.end()) break;
      if (store.ids()[*next] >= first + count) continue;
      const Store newborn = recording::make(call.birth, store.schema(), key, first, count, call.moment, true);
      for (; next != order.end() && store.ids()[*next] < first + count; ++next) {
        copy_over(newborn, store.ids()[*next] - first, store, *next);
      }
    }
  }
  clear();
}

void BirthHistory::clear() { *this = BirthHistory(); }

}  // namespace motes::engine
