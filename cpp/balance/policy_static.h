// Cuts stay where they are: the paper's static balancing.
#pragma once

#include "balance/policy.h"

namespace motes::balance {

class Static : public Policy {
 public:
  const char* kind() const override { return "Static"; }
  Plan plan(const LoadTable&) const override { return {}; }
  bool moves() const override { return false; }
};

}  // namespace motes::balance
