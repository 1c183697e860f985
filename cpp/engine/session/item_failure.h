// Attributes a failure to one item of a system's list, so that errors can name the action and the script's line.
#pragma once

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "engine/session/report.h"
#include "recording/record.h"

namespace motes::engine {

/// An error, and the item of the list in which it occurred.
class ItemFailure : public std::runtime_error {
 public:
  ItemFailure(std::exception_ptr original, const std::string& text, std::string action, ItemPlace place)
      : std::runtime_error(text), original_(std::move(original)), action_(std::move(action)), place_(place) {}
  const std::exception_ptr& original() const { return original_; }
  const std::string& action() const { return action_; }
  ItemPlace place() const { return place_; }

 private:
  std::exception_ptr original_;
  std::string action_;
  ItemPlace place_;
};

/// Runs `work` for item `item` of a system's list; rethrows its exceptions as ItemFailure.
template <class Work>
void of_item(const std::vector<recording::Item>& list, std::size_t system, std::size_t item, const Work& work) {
  try {
    work();
  } catch (const std::exception& error) {
    const auto calls =
        std::count_if(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(item), recording::is_call);
    throw ItemFailure(std::current_exception(), error.what(), recording::name(list[item]),
                      {static_cast<std::int32_t>(system), static_cast<std::int32_t>(calls)});
  }
}

}  // namespace motes::engine
