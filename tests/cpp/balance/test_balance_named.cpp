// Policies by name: the name that a policy gives itself creates the same policy again.
#include <string>

#include "balance/named.h"
#include "support/check.h"

namespace motes::test_balance_named {
using balance::policy_named;

TEST(balance_named_comes_back) {
  for (const std::string text : {
           "Static()",
           "Pairwise(threshold=0.25, min_particles=7, smoothing=0.5)",
           "Pairwise(threshold=0.1, powers=[1, 2.5], min_particles=64, smoothing=0.5)",
           "Pairwise(threshold=0, min_particles=0, smoothing=1, over=\"all\")",
           "Diffusive(threshold=0.02, rate=0.4, min_particles=3, smoothing=0.125)",
           "Diffusive(threshold=0.02, rate=0.4, min_particles=3, manager=False, smoothing=0.125, over=\"all\")",
           "PrefixCuts(threshold=2.5, min_particles=64, smoothing=0.5, over=\"all\")",
           "PrefixCuts(threshold=0.1, powers=[1, 0.55, 2e-05], min_particles=1, smoothing=0.75)",
           "Bisection(threshold=0.05, min_particles=8, smoothing=0.5, over=\"all\")",
           "CostAware(move_cost=0.3, horizon=50, min_particles=64, smoothing=0.5)",
           "Greedy(threshold=0.2, min_particles=1, smoothing=0.25)",
           "Proportional(powers=[1, 0, 3], threshold=0.05, min_particles=64, over=\"all\")",
       }) {
    CHECK(policy_named(text)->name() == text);
  }
}

TEST(balance_named_fills_in_what_is_left_out) {
  CHECK(policy_named("Static")->name() == "Static()");
  CHECK(policy_named(" Pairwise ( ) ")->name() == "Pairwise(threshold=0.1, min_particles=64, smoothing=0.5)");
  CHECK(policy_named("Pairwise(over='all',threshold=0.5)")->over_all);
  CHECK(policy_named("Proportional(powers=[1,2])")->name() ==
        "Proportional(powers=[1, 2], threshold=0.05, min_particles=64)");
}

TEST(balance_named_refuses) {
  for (const std::string text : {
           "",
           "Own()",
           "Own: <balancer>",
           "pairwise",
           "Pairwise(",
           "Pairwise)",
           "Pairwise(0.1)",
           "Pairwise() x",
           "Pairwise(threshold=)",
           "Pairwise(threshold=1.5)",
           "Pairwise(threshold=x)",
           "Pairwise(threshold=-0.1)",
           "Pairwise(threshold=nan)",
           "Pairwise(threshold=0.1 2)",
           "Pairwise(min_particles=-1)",
           "Pairwise(min_particles=1.5)",
           "Pairwise(rate=0.5)",
           "Pairwise(over=\"none\")",
           "Static(threshold=0.1)",
           "Diffusive(rate=2)",
           "Diffusive(manager=no)",
           "Proportional()",
           "Proportional(powers=[])",
           "Proportional(powers=1)",
           "Proportional(powers=[1, x])",
           "Proportional(powers=[1, 2], smoothing=0.5)",
       }) {
    CHECK_THROWS(policy_named(text), std::invalid_argument);
  }
}

}  // namespace motes::test_balance_named
