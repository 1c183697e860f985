#include "engine/act/ghosts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace motes::engine {

using particles::Store;

namespace {

double interval_gap(double low, double high, double other_low, double other_high) {
  return std::max({0.0, low - other_high, other_low - high});
}

// Returns the mask bit of a column; columns from 31 on share the last bit.
std::uint32_t bit_of(std::size_t column) { return std::uint32_t{1} << std::min<std::size_t>(column, 31); }

}  // namespace

double gap(const domains::Box& a, const domains::Box& b) {
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c) most = std::max(most, interval_gap(a.low[c], a.high[c], b.low[c], b.high[c]));
  return most;
}

double outside(const domains::Box& box, const float (&x)[3]) {
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::isnan(x[c])) return std::numeric_limits<double>::infinity();
    most = std::max(most, interval_gap(box.low[c], box.high[c], x[c], x[c]));
  }
  return most;
}

bool within(const domains::BoxCover& cover, const float (&x)[3], double range) {
  if (!(outside(cover.around, x) <= range)) return false;
  const auto near = [&](const domains::Box& box) { return outside(box, x) <= range; };
  return std::any_of(cover.boxes.begin(), cover.boxes.end(), near);
}

void put_ghosts(const std::vector<interactions::Component>& read, const Store& store, const Chosen& chosen,
                base::Bytes& out) {
  out.put(static_cast<std::uint64_t>(chosen.size()));
  for (const std::uint32_t i : chosen.particles) out.put(store.ids()[i]);
  for (const interactions::Component c : read) {
    const float* plane = store.plane(c.attribute, c.component);
    const float value = store.uniform_value(c.attribute)[static_cast<std::size_t>(c.component)];
    for (const std::uint32_t i : chosen.particles) out.put(plane != nullptr ? plane[i] : value);
  }
  out.put_raw(chosen.images.data(), chosen.images.size());
}

std::uint64_t take_ghosts(base::Reader& in, std::size_t columns, bool images, interactions::Ghosts& ghosts) {
  const auto count = in.get<std::uint64_t>();
  ghosts.columns.resize(columns);
  for (std::uint64_t i = 0; i < count; ++i) ghosts.ids.push_back(in.get<std::uint64_t>());
  for (std::vector<float>& column : ghosts.columns) {
    for (std::uint64_t i = 0; i < count; ++i) column.push_back(in.get<float>());
  }
  for (std::uint64_t i = 0; images && i < count; ++i) ghosts.images.push_back(in.get<std::uint8_t>());
  return count;
}

void place_ghosts(const Images& images, interactions::Ghosts& ghosts) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t g = 0; g < ghosts.images.size(); ++g) {
      float& x = ghosts.columns[axis][g];
      x = images.at(ghosts.images[g], axis, x);
    }
  }
}

// Compares bits, so that a NaN which stays the same is not sent again, and -0 that becomes +0 is. Columns such as sizes
// and masses rarely change, which makes most refreshes shorter.
std::uint64_t put_changes(const std::vector<interactions::Component>& read, const Store& store, int target,
                          KeptGhosts& kept, base::Bytes& out) {
  const std::vector<std::uint32_t>& sent = kept.sent.at(target);
  std::vector<float>& last_sent = kept.last_sent[target];
  const bool first = last_sent.size() != sent.size() * read.size();
  last_sent.resize(sent.size() * read.size());
  std::uint32_t mask = 0;
  for (std::size_t c = 0; c < read.size(); ++c) {
    const float* plane = store.plane(read[c].attribute, read[c].component);
    const float value = store.uniform_value(read[c].attribute)[static_cast<std::size_t>(read[c].component)];
    float* const last = last_sent.data() + c * sent.size();
    bool changed = first;
    for (std::size_t k = 0; k < sent.size(); ++k) {
      const float now = plane != nullptr ? plane[sent[k]] : value;
      changed = changed || std::bit_cast<std::uint32_t>(now) != std::bit_cast<std::uint32_t>(last[k]);
      last[k] = now;
    }
    if (changed) mask |= bit_of(c);
  }
  out.put(mask);
  for (std::size_t c = 0; c < read.size(); ++c) {
    if ((mask & bit_of(c)) != 0) out.put_raw(last_sent.data() + c * sent.size(), sent.size() * sizeof(float));
  }
  return sent.size();
}

std::uint64_t take_changes(base::Reader& in, int source, const Images& images, KeptGhosts& kept) {
  const std::vector<std::uint32_t>& places = kept.received.at(source);
  const auto mask = in.get<std::uint32_t>();
  for (std::size_t c = 0; c < kept.ghosts.columns.size(); ++c) {
    if ((mask & bit_of(c)) == 0) continue;
    for (const std::uint32_t place : places) {
      const auto value = in.get<float>();
      const bool moves = c < 3 && images.any();  // position comes first
      kept.ghosts.columns[c][place] = moves ? images.at(kept.ghosts.images[place], c, value) : value;
    }
  }
  return places.size();
}

// The sender chose and sorted the particles before they were ghosts here, so the receiver can only find the order anew:
// by owner, id and image, as the sender did.
void find_owners(const domains::Domains& domains, KeptGhosts& kept) {
  const interactions::Ghosts& ghosts = kept.ghosts;
  kept.received.clear();
  for (std::uint32_t g = 0; g < ghosts.ids.size(); ++g) {
    const std::array<float, 3> at{ghosts.columns[0][g], ghosts.columns[1][g], ghosts.columns[2][g]};
    kept.received[domains.owner_of(at, ghosts.ids[g])].push_back(g);
  }
  for (auto& [owner, places] : kept.received) {
    std::sort(places.begin(), places.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (ghosts.ids[a] != ghosts.ids[b] || ghosts.images.empty()) return ghosts.ids[a] < ghosts.ids[b];
      return ghosts.images[a] < ghosts.images[b];
    });
  }
}

void sort_by_id(const Store& store, std::vector<std::uint32_t>& indices) {
  const particles::Ids ids = store.ids();
  std::stable_sort(indices.begin(), indices.end(), [&](std::uint32_t a, std::uint32_t b) { return ids[a] < ids[b]; });
}

}  // namespace motes::engine
