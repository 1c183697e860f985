// Memory of a store's planes: which planes share large memory, and for how long.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "base/memory.h"
#include "particles/plane_memory.h"
#include "particles/store.h"
#include "support/check.h"

namespace motes::test_plane_memory {
using namespace particles;

namespace {

constexpr std::size_t kHuge = std::size_t{2} << 20;

using Piece = std::shared_ptr<std::byte[]>;

std::uintptr_t place_of(const void* memory) { return reinterpret_cast<std::uintptr_t>(memory); }

bool begins_huge_page(const Piece& piece) { return place_of(piece.get()) % kHuge == 0; }

}  // namespace

TEST(pieces_of_plane_memory_do_not_overlap_and_outlive_it) {
  std::vector<std::pair<Piece, std::size_t>> pieces;
  {
    PlaneMemory memory(base::kLargeMemory);
    for (const std::size_t bytes :
         {std::size_t{64}, base::kLargeMemory / 2, std::size_t{5000}, base::kLargeMemory / 2 + 1,
          3 * base::kLargeMemory, std::size_t{4096}, std::size_t{1}, kHuge}) {
      pieces.emplace_back(memory.take(bytes), bytes);
      std::memset(pieces.back().first.get(), static_cast<int>(pieces.size()), bytes);
    }
  }
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto& [piece, bytes] = pieces[i];
    CHECK(place_of(piece.get()) % 64 == 0);
    for (std::size_t k = 0; k < bytes; ++k) {
      if (piece.get()[k] != static_cast<std::byte>(i + 1)) return check::fail(__FILE__, __LINE__, "overwritten");
    }
  }
}

TEST(planes_of_one_store_share_huge_pages) {
  const Schema schema;
  for (const std::size_t capacity : {60'000u, 100'000u, 200'000u}) {
    Store store(schema);
    for (const int attribute : {position, velocity, age}) {
      for (int c = 0; c < schema[attribute].width; ++c) store.writable_plane(attribute, c);
    }
    store.reserve(capacity);
    std::uintptr_t first = UINTPTR_MAX, last = 0;
    const auto note = [&](const void* plane) {
      first = std::min(first, place_of(plane));
      last = std::max(last, place_of(plane) + capacity * sizeof(float));
    };
    for (const int attribute : {position, velocity, age}) {
      for (int c = 0; c < schema[attribute].width; ++c) note(store.plane(attribute, c));
    }
    note(store.ids().lower);
    CHECK(last - first < store.memory_bytes() + 8 * 2 * base::kPage);
    CHECK(first % kHuge < 2 * base::kPage);
  }
}

TEST(memory_with_more_left_goes_on_dealing_out) {
  PlaneMemory memory(2 * kHuge);
  const Piece first = memory.take(kHuge);
  CHECK(begins_huge_page(first));
  const Piece large = memory.take(3 * kHuge);  // too large for what is left, which stays
  CHECK(begins_huge_page(large));
  const Piece second = memory.take(kHuge);
  CHECK(second.get() == first.get() + kHuge);
  CHECK(begins_huge_page(memory.take(base::kLargeMemory / 2)));  // nothing is left: what comes next shares this one
}

TEST(small_stores_take_no_huge_pages) {
  PlaneMemory memory(base::kLargeMemory / 2 - 1);
  const Piece one = memory.take(100), other = memory.take(100);
  CHECK(!begins_huge_page(one) || !begins_huge_page(other));
}

TEST(a_copy_of_plane_memory_deals_out_memory_of_its_own) {
  PlaneMemory memory(kHuge);
  PlaneMemory copy = memory;
  const Piece one = memory.take(base::kLargeMemory), other = copy.take(base::kLargeMemory);
  CHECK(one.get() + base::kLargeMemory <= other.get() || other.get() + base::kLargeMemory <= one.get());
  PlaneMemory moved = std::move(memory);
  CHECK(moved.take(4096).get() == one.get() + base::kLargeMemory);
}

}  // namespace motes::test_plane_memory
