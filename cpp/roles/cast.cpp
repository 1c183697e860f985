#include "roles/cast.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "base/invalid_argument.h"

namespace motes::roles {
namespace {

void check_rank(const std::string& role, int rank, int size) {
  if (rank >= 0 && rank < size) return;
  throw base::InvalidArgument(role, "be a rank 0.." + std::to_string(size - 1), std::to_string(rank), "roles");
}

}  // namespace

int Cast::calculator_of(int rank) const {
  // Usually calculators have consecutive ranks: no search is needed, even with thousands of ranks.
  const int guess = calculators.empty() ? -1 : rank - calculators.front();
  if (guess >= 0 && guess < static_cast<int>(calculators.size()) &&
      calculators[static_cast<std::size_t>(guess)] == rank) {
    return guess;
  }
  const auto found = std::find(calculators.begin(), calculators.end(), rank);
  return found == calculators.end() ? -1 : static_cast<int>(found - calculators.begin());
}

std::string Cast::describe(int rank) const {
  std::string text;
  const auto add = [&](const std::string& role) { text += (text.empty() ? "" : ", ") + role; };
  if (rank == image_generator) add("image generator");
  if (rank == manager) add("manager");
  if (calculator_of(rank) >= 0) add("calculator " + std::to_string(calculator_of(rank)));
  return text.empty() ? "spectator" : text;
}

Cast cast_auto(int size) {
  if (size == 1) return {};
  if (size == 2) return {0, 0, {1}};
  Cast cast{1, 0, {}};
  for (int rank = 2; rank < size; ++rank) cast.calculators.push_back(rank);
  return cast;
}

Cast cast_managing(int size) {
  Cast cast = cast_auto(size);
  if (cast.manager != cast.image_generator) cast.calculators.insert(cast.calculators.begin(), cast.manager);
  return cast;
}

Cast cast_shared(int size) {
  Cast cast{0, 0, {}};
  for (int rank = 0; rank < size; ++rank) cast.calculators.push_back(rank);
  return cast;
}

Cast cast_left(const Cast& cast, const std::vector<int>& survivors) {
  const auto now = [&](int then) {
    const auto found = std::lower_bound(survivors.begin(), survivors.end(), then);
    return found == survivors.end() || *found != then ? -1 : static_cast<int>(found - survivors.begin());
  };
  Cast left{now(cast.manager), now(cast.image_generator), {}};
  for (const int rank : cast.calculators) {
    if (now(rank) >= 0) left.calculators.push_back(now(rank));
  }
  if (left.calculators.empty()) {
    left.calculators.resize(survivors.size());
    std::iota(left.calculators.begin(), left.calculators.end(), 0);
  }
  const int stand_in = std::max(left.manager, left.image_generator);
  for (int* role : {&left.manager, &left.image_generator}) {
    if (*role < 0) *role = stand_in >= 0 ? stand_in : left.calculators.front();
  }
  return left;
}

void check(const Cast& cast, int size) {
  check_rank("manager", cast.manager, size);
  check_rank("image_generator", cast.image_generator, size);
  if (cast.calculators.empty()) throw base::InvalidArgument("calculators", "name at least one rank", "", "roles");
  std::vector<int> sorted = cast.calculators;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    check_rank("calculators", sorted[i], size);
    if (i > 0 && sorted[i] == sorted[i - 1]) {
      throw std::invalid_argument("roles: calculators lists rank " + std::to_string(sorted[i]) + " twice");
    }
  }
}

}  // namespace motes::roles
