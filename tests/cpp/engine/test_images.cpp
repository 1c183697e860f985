// Where the images of particles in periodic space are, and how far it is to them.
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "engine/act/images.h"
#include "support/check.h"

namespace motes::test_images {
namespace {

using domains::Box;
using engine::Images;
using particles::Period;
using particles::Periods;

constexpr float kInf = std::numeric_limits<float>::infinity();

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
  const Box box = Images(periods_of(5)).ends({{-kInf, -kInf, 3}, {4, kInf, kInf}});
  CHECK((box == Box{{0, -kInf, 3}, {4, kInf, 6}}));
  CHECK(Images(periods_of(0)).ends({}) == Box{});
  CHECK(Images(periods_of(5)).farthest_end() == 10);
}

TEST(images_are_near_across_the_ends) {
  const Images images(periods_of(1));
  const Box low{{0, -kInf, -kInf}, {1, kInf, kInf}};
  const Box middle{{4, -kInf, -kInf}, {5, kInf, kInf}};
  const Box high{{8, -kInf, -kInf}, {10, kInf, kInf}};
  CHECK(images.gap(low, high) == 0 && images.gap(high, low) == 0);
  CHECK(images.gap(low, middle) == 3 && images.gap(middle, high) == 3);
  CHECK(images.outside(low, {9.5f, 0, 0}) == 0.5);
  CHECK(images.outside(low, {0.5f, 99, 0}) == 0);
  CHECK(std::isinf(images.outside(low, {std::nanf(""), 0, 0})));
  CHECK(Images(periods_of(0)).gap(low, high) == 7);
}

TEST(images_refuse_what_reaches_too_far) {
  const auto match = actions::make(actions::numbers::match_velocity<>{});
  Images(periods_of(1)).check(match, 5);
  CHECK_THROWS(Images(periods_of(1)).check(match, 5.1f), std::invalid_argument);
  CHECK_THROWS(Images(periods_of(3)).check(match, 1.1f), std::invalid_argument);
  CHECK_THROWS(Images(periods_of(3)).check(match, kInf), std::invalid_argument);
  Images(periods_of(0)).check(match, kInf);
  actions::Action tie;
  tie.kind = actions::Kind::tie;
  Images(periods_of(1)).check(tie, kInf);  // goes to the nearest image
  const auto far = actions::make(actions::numbers::gravitate<>{.max_radius = 1, .cells = 1});
  CHECK_THROWS(Images(periods_of(1)).check(far, 1), std::invalid_argument);
}

}  // namespace
}  // namespace motes::test_images
