#include "engine/state/birth_history.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace motes::engine {
namespace {

using particles::Store;
using recording::Birth;
using recording::BirthStep;
using recording::Emit;
using recording::Source;

constexpr std::uint64_t kChunk = 1u << 16;  // particles to create at once
constexpr std::size_t kSources = 16;        // how many of the latest calls a new one is compared with

std::size_t bytes_of(const Birth& birth) {
  std::size_t bytes = sizeof birth + recording::state_of(birth).size() * sizeof(recording::Given);
  if (const auto* source = std::get_if<Source>(&birth)) bytes += source->before.size() * sizeof(shapes::Shape);
  if (const auto* emit = std::get_if<Emit>(&birth)) {
    for (const recording::Emitted& column : emit->columns) bytes += column.values.size() * sizeof(float);
  }
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
  if (auto* source = std::get_if<Source>(&birth)) {
    source->rate = source->scale = 0;
    source->integral.clear();
    source->number = 0;
  }
  return birth;
}

// Copies the *_b attributes of newborn particle `from` to living particle `to`.
void copy_over(const Store& newborn, std::size_t from, Store& living, std::size_t to) {
  for (const auto& [copy, original] : particles::kCopies) {
    for (int c = 0; c < 3; ++c) {
      const float* plane = newborn.plane(copy, c);
      living.writable_plane(copy, c)[to] =
          plane != nullptr ? plane[from] : newborn.uniform_value(copy)[static_cast<std::size_t>(c)];
    }
  }
}

}  // namespace

// Returns the number of this call; a source that is the same in every frame keeps its number. Emitted arrays are never
// compared.
std::uint64_t BirthHistory::number_of(Birth birth, const BirthStep& moment) {
  const std::size_t first = calls_.size() > kSources ? calls_.size() - kSources : 0;
  for (std::size_t i = calls_.size(); !std::holds_alternative<Emit>(birth) && i > first; --i) {
    if (calls_[i - 1].moment == moment && calls_[i - 1].birth == birth) return forgotten_calls_ + i - 1;
  }
  const std::size_t bytes = bytes_of(birth);
  calls_.push_back({std::move(birth), moment, bytes});
  call_bytes_ += calls_.back().bytes;
  return forgotten_calls_ + calls_.size() - 1;
}

void BirthHistory::add(const Birth& birth, std::uint64_t first_id, std::uint64_t count, const BirthStep& moment) {
  const std::uint64_t call = number_of(without_rate(birth), moment);
  if (!ranges_.empty()) {
    IdRange& last = ranges_.back();
    if (last.call == call && last.first_id + last.count == first_id) {
      last.count += count;
      return;
    }
  }
  ranges_.push_back({first_id, count, call});
}

std::vector<std::uint64_t> BirthHistory::meshes() const {
  std::vector<std::uint64_t> keys;
  for (const Call& call : calls_) {
    const std::vector<std::uint64_t> more = recording::meshes_of(call.birth);
    keys.insert(keys.end(), more.begin(), more.end());
  }
  return keys;
}

std::size_t BirthHistory::bytes() const { return call_bytes_ + ranges_.size() * sizeof(IdRange); }

void BirthHistory::forget_before(std::uint64_t oldest) {
  std::erase_if(ranges_, [oldest](const IdRange& s) { return s.first_id + s.count <= oldest; });
  std::uint64_t needed = forgotten_calls_ + calls_.size();
  for (const IdRange& range : ranges_) needed = std::min(needed, range.call);
  const auto first = calls_.begin() + static_cast<std::ptrdiff_t>(needed - forgotten_calls_);
  for (auto call = calls_.begin(); call != first; ++call) call_bytes_ -= call->bytes;
  calls_.erase(calls_.begin(), first);
  forgotten_calls_ = needed;
  pruned_bytes_ = bytes();
}

void BirthHistory::restore_copies(Store& store, particles::Key key) {
  const std::vector<std::uint32_t> order = by_id(store);
  auto next = order.begin();
  for (const IdRange& range : ranges_) {
    const Call& call = calls_[range.call - forgotten_calls_];
    recording::check(call.birth, store.schema());  // also prepares meshes that were restored with the history
    // An emit has arrays for the whole call; random births can be made in chunks.
    const std::uint64_t step = std::holds_alternative<Emit>(call.birth) ? range.count : kChunk;
    for (std::uint64_t done = 0; done < range.count; done += step) {
      const std::uint64_t first = range.first_id + done;
      const std::uint64_t count = std::min(step, range.count - done);
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
