#include "engine/session/costs.h"

#include <charconv>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>

namespace motes::engine {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// The value of a name, and the number of its line.
struct Entry {
  double value = 0;
  int line = 0;
};

[[noreturn]] void refuse(int line, const std::string& what) {
  throw std::invalid_argument("line " + std::to_string(line) + ": " + what);
}

std::map<std::string, Entry> entries(const std::string& text) {
  std::map<std::string, Entry> by_name;
  std::istringstream in(text);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) refuse(number, "expected name = number, got '" + line + "'");
    const std::string name = trimmed(line.substr(0, equals));
    const std::string value = trimmed(line.substr(equals + 1));
    Entry entry{0, number};
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), entry.value);
    const bool whole = error == std::errc() && end == value.data() + value.size();
    if (!whole || !std::isfinite(entry.value) || entry.value < 0) {
      refuse(number, name + " must be a number of nanoseconds >= 0, got '" + value + "'");
    }
    if (!by_name.emplace(name, entry).second) refuse(number, name + " is given twice");
  }
  return by_name;
}

}  // namespace

double Costs::of(const std::vector<recording::Item>& list) const {
  double sum = 0;
  for (const recording::Item& item : list) {
    if (const auto* action = std::get_if<actions::Action>(&item)) sum += act[static_cast<std::size_t>(action->kind)];
  }
  return sum;
}

Costs read_costs(const std::string& text) {
  Costs costs;
  const std::map<std::string, double*> fields = {{"birth", &costs.birth},
                                                 {"newborn", &costs.newborn},
                                                 {"share", &costs.share},
                                                 {"forward", &costs.forward},
                                                 {"make", &costs.make},
                                                 {"leave", &costs.leave},
                                                 {"gap", &costs.gap},
                                                 {"arrive", &costs.arrive},
                                                 {"copy", &costs.copy},
                                                 {"select", &costs.select},
                                                 {"record", &costs.record},
                                                 {"collect", &costs.collect},
                                                 {"draw", &costs.draw},
                                                 {"picture", &costs.picture},
                                                 {"report", &costs.report},
                                                 {"report_byte", &costs.report_byte},
                                                 {"message", &costs.messages.message},
                                                 {"byte", &costs.messages.byte}};
  const std::map<std::string, Entry> by_name = entries(text);
  if (const auto all = by_name.find("action"); all != by_name.end()) costs.act.fill(all->second.value);
  for (const auto& [name, entry] : by_name) {
    if (name == "action") continue;
    if (const auto field = fields.find(name); field != fields.end()) {
      *field->second = entry.value;
    } else if (name.starts_with("action.")) {
      try {
        costs.act[static_cast<std::size_t>(actions::kind_of(name.substr(7)))] = entry.value;
      } catch (const std::invalid_argument& error) {
        refuse(entry.line, error.what());
      }
    } else {
      refuse(entry.line, "no cost is called " + name);
    }
  }
  return costs;
}

}  // namespace motes::engine
