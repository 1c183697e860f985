// Where the images of particles in periodic space are, and how far away they are.
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "engine/act/ghosts.h"
#include "engine/act/images.h"
#include "interactions/kinds/families.h"
#include "interactions/scratch.h"
#include "support/check.h"

namespace motes::test_images {
namespace {

using domains::Box;
using domains::BoxCover;
using engine::Images;
using particles::Period;
using particles::Periods;

constexpr float kInf = std::numeric_limits<float>::infinity();

BoxCover of(const Box& box) { return {{box}, 1, box}; }

Periods periods_of(std::uint8_t bits) { return {bits, {Period{0, 10}, Period{-1, 1}, Period{2, 6}}}; }

TEST(images_are_at_all_places_around) {
  CHECK(Images(periods_of(0)).count() == 1 && !Images(periods_of(0)).any());
  CHECK(Images(periods_of(2)).count() == 3);
  CHECK(Images(periods_of(5)).count() == 9);
  const Images images(periods_of(7));
  CHECK(images.count() == 27);
  std::set<std::array<float, 3>> places;
  for (std::uint8_t n = 0; n < images.count(); ++n) {
    places.insert({images.at(n, 0, 5), images.at(n, 1, 0), images.at(n, 2, 4)});
  }
  CHECK(places.size() == 27);
  CHECK(places.contains({-5, 2, 8}) && places.contains({15, -2, 0}));
  CHECK(images.at(0, 0, 5) == 5 && images.at(0, 1, 0.5f) == 0.5f && images.at(0, 2, 3) == 3);
}

TEST(images_end_domains_where_space_ends) {
  const BoxCover cover = Images(periods_of(5)).ends(of({{-kInf, -kInf, 3}, {4, kInf, kInf}}));
  const Box ends{{0, -kInf, 3}, {4, kInf, 6}};
  CHECK(cover.boxes == std::vector<Box>{ends} && cover.around == ends && cover.whole == 1);
  CHECK(Images(periods_of(0)).ends(of({})).around == Box{});
  CHECK(Images(periods_of(5)).farthest_end() == 10);
}

TEST(images_are_near_across_the_ends) {
  const Images images(periods_of(1));
  const BoxCover low = of({{0, -kInf, -kInf}, {1, kInf, kInf}});
  const BoxCover middle = of({{4, -kInf, -kInf}, {5, kInf, kInf}});
  const BoxCover high = of({{8, -kInf, -kInf}, {10, kInf, kInf}});
  CHECK(images.within(low, high, 0) && images.within(high, low, 0));
  CHECK(images.within(low, middle, 3) && !images.within(low, middle, 2.9) && images.within(middle, high, 3));
  CHECK(images.outside(low, {9.5f, 0, 0}) == 0.5);
  CHECK(images.outside(low, {0.5f, 99, 0}) == 0);
  CHECK(std::isinf(images.outside(low, {std::nanf(""), 0, 0})));
  CHECK(Images(periods_of(0)).within(low, high, 7) && !Images(periods_of(0)).within(low, high, 6.9));
}

TEST(domains_of_several_boxes_are_as_near_as_the_nearest) {
  const Images images(periods_of(0));
  const Box left{{0, 0, 0}, {1, 1, 1}}, right{{9, 9, 9}, {10, 10, 10}}, other{{6, 0, 0}, {7, 1, 1}};
  const BoxCover both{{left, right}, 2, {{0, 0, 0}, {10, 10, 10}}};
  CHECK(!images.within(both, of(other), 4.9) && images.within(both, of(other), 5));  // though their hull contains it
  CHECK(images.outside(both, {5, 5, 5}) == 4 && images.outside(both, {9.5f, 9.5f, 12}) == 2);
  CHECK(engine::within(both, {5, 5, 5}, 4) && !engine::within(both, {5, 5, 5}, 3.9));
  CHECK(engine::within(both, {2, 0, 0}, 1) && engine::within(both, {8, 9, 9}, 1));  // near only one of them
}

TEST(images_refuse_what_reaches_too_far) {
  const auto check = [](std::uint8_t periods, const actions::Action& action, float reach) {
    const Periods space = periods_of(periods);
    interactions::Scratch scratch;
    interactions::Meeting meeting;
    meeting.sides[0].action = &action;
    meeting.periods = &space;
    meeting.scratch = &scratch;
    Images(space).check(*interactions::begin(meeting), reach);
  };
  const auto match = actions::make(actions::numbers::match_velocity<>{});
  check(1, match, 5);
  CHECK_THROWS(check(1, match, 5.1f), std::invalid_argument);
  CHECK_THROWS(check(3, match, 1.1f), std::invalid_argument);
  CHECK_THROWS(check(3, match, kInf), std::invalid_argument);
  check(0, match, kInf);
  actions::Action tie = actions::make(actions::numbers::tie<>{});
  interactions::Ties pair;
  pair.ends = {1, 2};
  pair.lengths = {1};
  pair.kinds = {0};
  tie.specifics = actions::TiedPairs{interactions::keep(pair)};
  check(1, tie, kInf);  // goes to the nearest image
  const auto far = actions::make(actions::numbers::gravitate<>{.max_radius = 1, .cells = 1});
  CHECK_THROWS(check(1, far, 1), std::invalid_argument);
}

}  // namespace
}  // namespace motes::test_images
