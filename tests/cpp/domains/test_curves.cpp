// Curves through cells, and domains that are stretches of them, compared with the cells one by one.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <set>
#include <stdexcept>

#include "domains/curve.h"
#include "domains/divide.h"
#include "domains/test_domains_boxes.h"
#include "support/check.h"
#include "support/isas.h"

namespace motes::test_curves {
using domains::Box;
using domains::BoxCover;
using domains::Curve;
using domains::Cut;
using domains::Domains;
using domains::kHilbert;
using domains::kMorton;
using domains::Room;
using domains_test::holds;
using domains_test::kInf;
using domains_test::kNaN;
using domains_test::Place;

namespace {

constexpr Room kUnits{{0, 0, 0}, {256, 256, 256}};  // cells are 1 m wide
constexpr Room kUneven{{-3.2, -1e-3, 100}, {0.8, 2.5, 1000}};

// Returns the cell with this number, in the room of units.
Curve::Cell cell_at(const Curve& curve, std::uint32_t number) {
  const BoxCover cover = curve.cover(number, number + 1);
  CHECK(cover.boxes.size() == 1 && cover.whole == 1);
  Curve::Cell cell{};
  for (std::size_t a = 0; a < 3; ++a) {
    const float low = cover.boxes[0].low[a];
    cell[a] = low == -kInf ? 0 : static_cast<std::uint32_t>(low);
    CHECK(cover.boxes[0].high[a] == (cell[a] == 255 ? kInf : static_cast<float>(cell[a] + 1)));
  }
  return cell;
}

int steps_between(const Curve::Cell& a, const Curve::Cell& b) {
  int steps = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) steps += std::abs(static_cast<int>(a[axis]) - static_cast<int>(b[axis]));
  return steps;
}

// Returns a place in a room or around it, often on the faces of cells or next to them.
Place random_place(const Room& room, test::Dice& dice) {
  Place p{};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto low = static_cast<float>(room.low[a]), side = static_cast<float>(room.high[a] - room.low[a]);
    const float near = low + side * dice.between(-0.1f, 1.1f);
    const float face = low + side * static_cast<float>(dice.below(257)) / 256;
    const float choice[] = {near, face, std::nextafter(face, -kInf), std::nextafter(face, kInf), near, near};
    p[a] = dice.below(60) == 0 ? -kInf : dice.below(60) == 0 ? kInf : choice[dice.below(6)];
  }
  return p;
}

Domains random_stretches(int count, std::shared_ptr<const Curve> curve, test::Dice& dice) {
  std::vector<float> cuts;
  const float wide = dice.below(2) == 0 ? 1.0f : 1e-5f;  // small: stretches of a few cells each
  for (int i = 1; i < count; ++i) cuts.push_back(0.5f + wide * dice.between(-0.5f, 0.5f));
  std::sort(cuts.begin(), cuts.end());
  return {std::move(cuts), std::move(curve)};
}

}  // namespace

TEST(curves_visit_each_block_once_and_hilbert_goes_from_face_to_face) {
  for (const int axis : {kMorton, kHilbert}) {
    const Curve curve(axis, kUnits);
    std::vector<Curve::Cell> blocks(Curve::kBlocks);
    std::set<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < Curve::kBlocks; ++i) {
      const Curve::Cell block{i % 16, i / 16 % 16, i / 256};
      const std::uint32_t number = curve.block_of({16 * block[0] + 3, 16 * block[1] + 15, 16 * block[2]});
      CHECK(numbers.insert(number).second && number < Curve::kBlocks);
      blocks[number] = block;
    }
    for (std::size_t i = 1; axis == kHilbert && i < blocks.size(); ++i) {
      CHECK(steps_between(blocks[i - 1], blocks[i]) == 1);
    }
  }
}

TEST(cells_follow_each_other_along_the_curve) {
  test::Dice dice(61);
  for (const int axis : {kMorton, kHilbert}) {
    const Curve curve(axis, kUnits);
    for (int walk = 0; walk < 20; ++walk) {
      const auto first = static_cast<std::uint32_t>(dice.below(Curve::kCells - 200));
      Curve::Cell before{};
      for (std::uint32_t number = first; number < first + 100; ++number) {
        const Curve::Cell cell = cell_at(curve, number);
        CHECK(curve.number_of(cell) == number && curve.block_of(cell) == number / Curve::kInBlock);
        if (axis == kHilbert && number > first) CHECK(steps_between(before, cell) == 1);
        before = cell;
      }
    }
    CHECK(curve.number_of({0, 0, 0}) == 0);
  }
  const Curve morton(kMorton, kUnits);
  CHECK(morton.number_of({1, 0, 0}) == 1 && morton.number_of({0, 1, 0}) == 2 && morton.number_of({0, 0, 1}) == 4);
  CHECK(morton.number_of({255, 255, 255}) == Curve::kCells - 1);
}

TEST(covers_hold_what_belongs_to_a_domain) {
  test::Dice dice(62);
  for (int round = 0; round < 120; ++round) {
    const Room room = round % 2 == 0 ? kUnits : kUneven;
    const auto curve = std::make_shared<const Curve>(round % 3 == 0 ? kMorton : kHilbert, room);
    const Domains d = random_stretches(1 + static_cast<int>(dice.below(12)), curve, dice);
    std::vector<BoxCover> covers;
    for (int c = 0; c < d.count(); ++c) {
      covers.push_back(d.cover(c));
      CHECK(!covers.back().boxes.empty() && covers.back().boxes.size() <= 64);
      CHECK(d.box(c) == Box{});
    }
    for (int i = 0; i < 200; ++i) {
      const Place p = random_place(room, dice);
      const int owner = d.owner_of(p, 0);
      const float along = Curve::place_of(curve->number_of(curve->cell_of(p[0], p[1], p[2])));
      CHECK(along >= d.low(owner) && along < d.high(owner));
      for (int c = 0; c < d.count(); ++c) {
        const BoxCover& cover = covers[static_cast<std::size_t>(c)];
        const auto holder = std::find_if(cover.boxes.begin(), cover.boxes.end(), [&](auto& b) { return holds(b, p); });
        const bool finite = std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
        if (c == owner && finite) CHECK(holder != cover.boxes.end() && holds(cover.around, p));
        if (c != owner) CHECK(static_cast<std::size_t>(holder - cover.boxes.begin()) >= cover.whole);
      }
    }
  }
}

TEST(covers_are_not_much_larger_than_a_domain) {
  test::Dice dice(63);
  const Curve curve(kHilbert, kUnits);
  for (int round = 0; round < 100; ++round) {
    const auto length = static_cast<std::uint32_t>(1000 + dice.below(Curve::kCells / 4));
    const auto first = static_cast<std::uint32_t>(dice.below(Curve::kCells - length));
    const BoxCover cover = curve.cover(first, first + length);
    double volume = 0;
    for (const Box& box : cover.boxes) {
      double of_box = 1;
      for (std::size_t a = 0; a < 3; ++a) {
        of_box *= static_cast<double>(std::min(box.high[a], 256.0f) - std::max(box.low[a], 0.0f));
      }
      volume += of_box;
    }
    CHECK(volume >= length && volume < 1.5 * length);
  }
}

TEST(many_have_the_owners_along_a_curve_that_each_has) {
  test::Dice dice(64);
  for (int round = 0; round < 40; ++round) {
    const auto curve = std::make_shared<const Curve>(round % 2 == 0 ? kMorton : kHilbert, kUneven);
    const Domains d = random_stretches(1 + static_cast<int>(dice.below(70)), curve, dice);
    const std::size_t n = dice.below(100);
    std::array<std::vector<float>, 3> planes;
    for (std::size_t p = 0; p < n; ++p) {
      const Place place = random_place(kUneven, dice);
      for (std::size_t a = 0; a < 3; ++a) planes[a].push_back(dice.below(40) == 0 ? kNaN : place[a]);
    }
    std::vector<std::uint32_t> owners(n);
    d.owners_of({{planes[0].data(), planes[1].data(), planes[2].data()}, {}, n}, owners.data());
    for (std::size_t p = 0; p < n; ++p) {
      const Place place{planes[0][p], planes[1][p], planes[2][p]};
      CHECK(static_cast<int>(owners[p]) == d.owner_of(place, 7));
      const bool nowhere = std::isnan(place[0]) || std::isnan(place[1]) || std::isnan(place[2]);
      if (nowhere) CHECK(static_cast<int>(owners[p]) == d.count() - 1);
    }
  }
}

TEST(what_lies_outside_of_the_room_is_in_the_nearest_cell) {
  const Curve curve(kHilbert, kUneven);
  CHECK(curve.cell_of(-99, 0.5f, 1e9f) == curve.cell_of(-3.2f, 0.5f, 999.99f));
  CHECK((curve.cell_of(-kInf, kInf, kNaN) == Curve::Cell{0, 255, 0}));
  CHECK((curve.cell_of(-3.2f, -1e-3f, 100) == Curve::Cell{0, 0, 0}));
  CHECK((curve.cell_of(0.8f, 2.5f, 1000) == Curve::Cell{255, 255, 255}));
  CHECK(curve.farthest_end() == 1000);
}

TEST(stretches_of_a_curve_are_cut_like_slabs) {
  const Domains parts = domains::equal_parts({1u << kHilbert}, kUnits, 4);
  CHECK(parts.cuts() == std::vector<float>({0.25f, 0.5f, 0.75f}) && parts.axis() == kHilbert);
  CHECK(parts.halved() == kHilbert && parts.curve() != nullptr && parts.farthest_face() == 256);
  const Domains moved = parts.with({0.1f, 0.5f, 0.5f});
  CHECK(moved.curve() == parts.curve() && moved != parts && moved.with(parts.cuts()) == parts);
  CHECK(Domains::of(parts.tree(), parts.curve()) == parts);
  CHECK(domains::equal_parts({1u << kHilbert}, kUnits, 4) == parts);
  CHECK(domains::equal_parts({1u << kHilbert}, kUneven, 4) != parts);
  CHECK(domains::equal_parts({1u << kMorton}, kUnits, 4) != parts);
  CHECK(Domains::of({}, parts.curve()).owner_of({1, 2, 3}, 0) == 0);
  CHECK_THROWS(parts.with({0.5f, 0.4f, 0.6f}), std::invalid_argument);
  CHECK_THROWS(parts.with({kNaN, 0.4f, 0.6f}), std::invalid_argument);
  test::Dice dice(65);
  std::array<std::vector<float>, 3> planes;
  for (int p = 0; p < 3000; ++p) {
    for (auto& plane : planes) plane.push_back(dice.between(0, 256) * dice.between(0, 1));
  }
  const domains::Places places{{planes[0].data(), planes[1].data(), planes[2].data()}, {}, 3000};
  const Domains even = domains::quantiles(parts.curve(), places, 3);
  std::vector<std::uint32_t> owners(3000);
  even.owners_of(places, owners.data());
  for (const std::uint32_t c : {0u, 1u, 2u}) CHECK(std::abs(std::count(owners.begin(), owners.end(), c) - 1000) < 30);
}

TEST(a_curve_needs_a_room_with_ends) {
  CHECK_THROWS(Curve(kHilbert, {{0, 0, 0}, {1, 0, 1}}), std::invalid_argument);
  CHECK_THROWS(Curve(kMorton, {{1e9, 0, 0}, {1e9 + 1, 1, 1}}), std::invalid_argument);  // smaller than one float32
  CHECK_THROWS(Curve(kMorton, {{0, 0, 0}, {1, kInf, 1}}), std::invalid_argument);
  CHECK(!domains::has_ends({}, {}));
  CHECK(domains::has_ends({domains::Space::Kind::finite, 0, 1}, {}));
  CHECK(domains::axes_of("hilbert").curve() && domains::axes_of("morton").row() && !domains::axes_of("id").row());
  for (const char* name : {"x", "xz", "xyz", "id", "hilbert", "morton"}) {
    CHECK(domains::name_of(domains::axes_of(name)) == name);
  }
}

}  // namespace motes::test_curves
