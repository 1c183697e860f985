// Collects the particles of a range that must go: the dead, and those that left the region.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "actions/kernels.h"
#include "particles/store.h"
#include "program/program.h"

namespace motes::program {

/// Moves particles to the front of a range, where they will be removed together.
class FrontGatherer {
 public:
  FrontGatherer(const particles::Store& store, std::size_t first)
      : swapper_(store), next_(static_cast<std::uint32_t>(first)) {}

  /// Moves the dead and those that left to the front, from these positions in the lists on. No particle is in both
  /// lists.
  void gather(ListResult& outcome, std::size_t dead, std::size_t left) {
    while (dead < outcome.dead.size() || left < outcome.left.size()) {
      const bool dies =
          left == outcome.left.size() || (dead < outcome.dead.size() && outcome.dead[dead] < outcome.left[left]);
      std::uint32_t& particle = dies ? outcome.dead[dead++] : outcome.left[left++];
      // Indices ascend, so the particle at the front stays, or it is this one.
      if (particle != next_) swapper_.swap(particle, next_);
      particle = next_++;
    }
  }

 private:
  particles::Store::Swapper swapper_;
  std::uint32_t next_;
};

/// Collects blocks of a range in order. Usually no particle goes, so the members that each block reads are kept
/// together.
class Collector {
 public:
  /// Axes without a plane of positions are not tested.
  Collector(const particles::Store& store, const Region& region, ListResult& outcome)
      : collect_(actions::kernels().collect), outcome_(outcome) {
    for (const Slice& slice : region.slices()) {
      const float* x = store.plane(particles::position, slice.axis);
      if (x == nullptr) continue;
      bands_[size_++] = {x, slice.low, slice.high};
    }
  }

  /// From now on, also moves the collected particles to the front of the range that begins at particle `first`.
  void gather(const particles::Store& store, std::size_t first) { front_.emplace(store, first); }

  /// Returns the marks of a block's dead; at first, and after collect(), none is set.
  std::uint32_t* dead() { return marks_.data(); }

  /// Collects the dead and those that left from a block, which begins at particle `at`. Blocks come in ascending order.
  void collect(const actions::Block& block, std::size_t at) {
    for (std::size_t k = 0; k < size_; ++k) bands_[k].x += at - at_;
    at_ = at;
    std::size_t dead = 0, left = 0;
    collect_(block, bands_.data(), size_, static_cast<std::uint32_t>(at), dead_.data(), dead, left_.data(), left);
    if (dead + left != 0) add(dead, left);
    marks_.fill(0);
  }

 private:
  void add(std::size_t dead, std::size_t left) {
    const std::size_t dead_before = outcome_.dead.size(), left_before = outcome_.left.size();
    outcome_.dead.insert(outcome_.dead.end(), dead_.data(), dead_.data() + dead);
    outcome_.left.insert(outcome_.left.end(), left_.data(), left_.data() + left);
    if (front_) front_->gather(outcome_, dead_before, left_before);
  }

  std::array<std::uint32_t, particles::kBlockWords> marks_{};
  std::size_t size_ = 0;
  std::size_t at_ = 0;  // the particle that the bands' planes begin at
  std::array<actions::Band, 3> bands_{};
  decltype(actions::Kernels::collect) collect_;
  ListResult& outcome_;
  std::optional<FrontGatherer> front_;

  // Room for one more block's indices; the kernel returns how many it used.
  using Block = std::array<std::uint32_t, particles::kBlock + particles::kPadding>;
  Block dead_, left_;
};

}  // namespace motes::program
