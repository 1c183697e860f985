#include "driver/run_file.h"

#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

#include <cstdio>

#include "comm/clock.h"
#include "comm/environment.h"
#include "driver/files.h"
#include "simd/isa.h"

namespace motes::driver {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) >= 0x20) {
      out += c;
    } else {
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\u%04x", static_cast<unsigned>(static_cast<unsigned char>(c)));
      out += escaped;
    }
  }
  return out + "\"";
}

std::string decimal(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.17g", value);
  return digits;
}

template <class List, class Text>
std::string listed(const List& list, const Text& text) {
  std::string out;
  for (const auto& value : list) out += (out.empty() ? "" : ", ") + text(value);
  return "[" + out + "]";
}

std::string machine() {
  utsname facts{};
  return uname(&facts) == 0 ? facts.machine : "unknown";
}

std::string ranks(const std::vector<std::string>& hosts, int threads) {
  int rank = 0;
  return listed(hosts, [&](const std::string& host) {
    return "{\"rank\": " + std::to_string(rank++) + ", \"host\": " + quoted(host) +
           ", \"threads\": " + std::to_string(threads) + "}";
  });
}

}  // namespace

void write_run(const std::string& directory, const RunFacts& facts) {
  const auto number = [](int value) { return std::to_string(value); };
  std::string text = "{";
  const auto field = [&](const std::string& name, const std::string& value) {
    text += (text.size() == 1 ? "\n " : ",\n ") + quoted(name) + ": " + value;
  };
  field("schema", "1");
  // A simulated run has no date, so that two runs write the same bytes.
  field("started_unix_s", comm::simulated() ? "0" : std::to_string(time(nullptr)));
  field("argv", listed(facts.argv, quoted));
  field("seed", std::to_string(facts.settings.seed));
  field("dt_s", decimal(facts.settings.dt));
  field("substeps", number(facts.settings.substeps));
  for (const char* name : {"recorded_from", "axis", "space"}) field(name, quoted(facts.scene->fact(name)));
  field("balancer", quoted(facts.settings.policy->name()));
  field("combine", quoted(facts.combine));
  field("fan_out", number(facts.settings.fan_out));
  field("scale", decimal(facts.settings.costs.messages.scale));
  field("clock", quoted("cpu"));
  field("manager", number(facts.cast.manager));
  field("image_generator", number(facts.cast.image_generator));
  field("calculators", listed(facts.cast.calculators, number));
  field("systems", listed(facts.systems, [](const auto& system) { return quoted(system.name); }));
  field("axes", listed(facts.systems, [](const auto& s) { return quoted(domains::name_of(s.axes)); }));
  field("ranks", ranks(facts.settings.log.hosts, facts.settings.threads));
  const std::string speeds =
      listed(facts.speeds, [](const auto& of) { return quoted(std::to_string(of.first)) + ": " + decimal(of.second); });
  field("speeds", "{" + speeds.substr(1, speeds.size() - 2) + "}");
  field("motes", quoted(recording::version()));
  field("recorded_by", quoted(facts.scene->version));
  field("mpi", quoted(comm::library_version()));
  field("simd", quoted(std::string(simd::name(simd::isa()))));
  field("machine", quoted(machine()));
  field("cores", std::to_string(sysconf(_SC_NPROCESSORS_ONLN)));
  text += "\n}\n";
  write_whole(directory + "/run.json", std::as_bytes(std::span(text)));
}

}  // namespace motes::driver
