// Costs of work on a simulated machine, as read from files.
#include <string>

#include "engine/session/costs.h"
#include "support/check.h"

namespace motes::test_costs {
using actions::Action;
using actions::Kind;
using engine::Costs;
using engine::read_costs;

TEST(costs_are_read) {
  const Costs costs =
      read_costs("# a comment\n\nbirth = 3000 # its source\r\naction=7\n  action.move =1.5e3\ngap=0\ncopy=25\n");
  CHECK(costs.birth == 3000 && costs.gap == 0 && costs.copy == 25 && costs.draw == 0 && costs.messages.scale == 1);
  CHECK(costs.act[static_cast<std::size_t>(Kind::move)] == 1500);
  CHECK(costs.act[static_cast<std::size_t>(Kind::gravity)] == 7);
  CHECK(read_costs("") == Costs());
}

TEST(costs_of_a_list_are_those_of_its_actions) {
  const Costs costs = read_costs("action.move = 4\naction.gravity = 2\nbirth = 100\n");
  const std::vector<recording::Item> list = {actions::make(actions::numbers::gravity<>{.acceleration = {0, -9.81, 0}}),
                                             recording::Read{},
                                             actions::make(actions::numbers::move<>{.rotational = 1}),
                                             actions::make(actions::numbers::gravity<>{.acceleration = {0, 1, 0}})};
  CHECK(costs.of(list) == 8);
  CHECK(costs.of({}) == 0);
}

TEST(costs_that_are_wrong_are_refused_with_their_line) {
  const auto refusal = [](const std::string& text) -> std::string {
    try {
      read_costs(text);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  CHECK(refusal("draw = 1\nbirth") == "line 2: expected name = number, got 'birth'");
  CHECK(refusal("birth = -1") == "line 1: birth must be a number of nanoseconds >= 0, got '-1'");
  CHECK(refusal("\nbirth = nan").starts_with("line 2: birth must be a number"));
  CHECK(refusal("birth = 1 2").starts_with("line 1: birth must be a number"));
  CHECK(refusal("birth = 1\nbirth = 1") == "line 2: birth is given twice");
  CHECK(refusal("scale = 2") == "line 1: no cost is called scale");
  CHECK(refusal("action.fly = 2") == "line 1: no action is called 'fly'");
}

}  // namespace motes::test_costs
