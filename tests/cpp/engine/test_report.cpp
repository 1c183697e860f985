// Reports and verdicts as bytes; rows of the log as lines.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "base/fields.h"
#include "engine/log/alarms.h"
#include "engine/log/log.h"
#include "engine/session/report.h"
#include "support/check.h"

namespace motes::test_report {
using namespace engine;

namespace {

Report rich_report() {
  Report report;
  report.failure = {Failure::Kind::compute, "gravity", "no memory"};
  report.failed_rank = 4;
  report.dissents.push_back({5, {}});
  report.dissents.back().record.put_text("a recorded list");
  report.systems.resize(2);
  report.systems[0].particles = 19;
  report.systems[0].events = {{{3, {}, {}}, {7, {}, {}}}};
  report.systems[1].digest.first = 99;
  report.flows = {{0, 1, 0, 1}, {0, 2, 0, 7}};
  report.tail.valid = true;
  report.tail.frame = 6;
  report.tail.times.act = 0.125;
  report.tail.exchanged_bytes = 100;
  report.tail.moved = 7;
  report.tail.drawings.tiles = {{3, {10, 20}, 7, 0.5f}};
  report.tail.image_sha256 = "abc";
  return report;
}

// Returns what one of several ranks reports about one system.
Report plain_report(std::uint64_t particles, std::uint64_t oldest, std::vector<std::uint64_t> parents) {
  Report report;
  report.systems.resize(1);
  report.systems[0].particles = particles;
  report.systems[0].digest.second = particles;
  report.systems[0].oldest = oldest;
  report.systems[0].events.resize(1);
  for (const std::uint64_t id : parents) report.systems[0].events[0].push_back({id, {}, {}});
  report.tail.valid = true;
  report.tail.times.act = static_cast<double>(particles);
  report.tail.exchanged_bytes = particles;
  report.tail.moved = particles;
  report.tail.children.resize(1);
  report.tail.children[0].second = 2 * particles;
  report.tail.drawings.records = 3 * particles;
  report.tail.drawings.sent = 4 * particles;
  report.tail.drawings.bytes = 5 * particles;
  return report;
}

Report failed_report(int rank, const std::string& text) {
  Report report;
  report.failure = {Failure::Kind::compute, "act", text};
  report.failed_rank = rank;
  return report;
}

struct Folder {
  std::filesystem::path path;
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "motes-unit-XXXXXX").string();
    path = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::string text(const std::string& file) const {
    const std::ifstream in(path / "log" / file);
    std::ostringstream all;
    all << in.rdbuf();
    return all.str();
  }
};

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST(report_survives_its_bytes) {
  const Report report = rich_report();
  base::Bytes bytes;
  write(report, bytes);
  base::Reader in(bytes.view());
  const Report other = read_report(in);
  CHECK(in.done());
  CHECK(other.failure.kind == Failure::Kind::compute && other.failure.action == "gravity" &&
        other.failure.text == "no memory" && other.failed_rank == 4);
  CHECK(other.dissents.size() == 1 && other.dissents[0].rank == 5);
  CHECK(other.dissents[0].record.size() == report.dissents[0].record.size());
  CHECK(other.systems.size() == 2 && other.systems[0].particles == 19 && other.systems[1].digest.first == 99);
  CHECK(other.systems[0].events.size() == 1 && other.systems[0].events[0][1].id == 7);
  CHECK(other.flows.size() == 2 && other.flows[1].to == 2 && other.flows[1].count == 7);
  CHECK(other.tail.valid && other.tail.frame == 6 && other.tail.times.act == 0.125);
  CHECK(other.tail.exchanged_bytes == 100 && other.tail.moved == 7 && other.tail.image_sha256 == "abc");
  CHECK(other.tail.drawings.tiles.size() == 1 &&
        other.tail.drawings.tiles[0].counts == report.tail.drawings.tiles[0].counts);
  CHECK(other.tail.drawings.tiles[0].rank == 7 && other.tail.drawings.tiles[0].seconds == 0.5f);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    base::Reader part(bytes.view().first(length));
    CHECK_THROWS(read_report(part), std::runtime_error);
  }
}

TEST(joined_reports_are_sums) {
  Report all;  // a rank that does not calculate
  all.tail.valid = true;
  join(all, plain_report(10, 7, {4, 9}));
  join(all, plain_report(3, 5, {1, 6, 12}));
  CHECK(all.systems.size() == 1 && all.systems[0].particles == 13 && all.systems[0].oldest == 5);
  CHECK(all.systems[0].digest.second == 13);
  std::vector<std::uint64_t> parents;
  for (const recording::Event& event : all.systems[0].events[0]) parents.push_back(event.id);
  CHECK(parents == std::vector<std::uint64_t>({1, 4, 6, 9, 12}));
  CHECK(all.tail.times.act == 10 && all.tail.exchanged_bytes == 13 && all.tail.moved == 13);
  CHECK(all.tail.children.size() == 1 && all.tail.children[0].second == 2 * 13);
  const Drawings& drawings = all.tail.drawings;
  CHECK(drawings.records == 3 * 13 && drawings.sent == 4 * 13 && drawings.bytes == 5 * 13);
  Report later = plain_report(1, 1, {});
  later.tail.frame = 1;
  CHECK_THROWS(join(all, std::move(later)), std::runtime_error);
  Report more = plain_report(1, 1, {});
  more.systems.resize(2);
  CHECK_THROWS(join(all, std::move(more)), std::runtime_error);
}

TEST(the_lowest_rank_that_failed_is_told_in_any_order) {
  for (const bool first : {false, true}) {
    Report all = first ? failed_report(9, "nine") : plain_report(10, 7, {});
    join(all, failed_report(4, "four"));
    join(all, plain_report(3, 5, {}));
    join(all, failed_report(6, "six"));
    CHECK(all.failed() && all.failed_rank == 4 && all.failure.text == "four");
    Report dissenter;
    dissenter.dissents.push_back({2, {}});
    join(all, std::move(dissenter));
    CHECK(all.dissents.size() == 1 && all.dissents[0].rank == 2);
  }
}

TEST(judgement_survives_its_bytes) {
  Judgement judgement;
  Verdict& verdict = judgement.verdict;
  verdict.failure = {Failure::Kind::mismatch, "step", "text"};
  verdict.failed_rank = 2;
  verdict.ranks = {2, 3};
  verdict.alive = {5, 6};
  verdict.digests.resize(2);
  verdict.digests[1].second = 4;
  judgement.transfers = {{1, 7}};
  judgement.parents.resize(1);
  judgement.parents[0].owner = 3;
  judgement.parents[0].parent.first = 12;
  base::Bytes bytes;
  write(judgement, bytes);
  base::Reader in(bytes.view());
  const Judgement other = read_judgement(in);
  CHECK(in.done());
  CHECK(other.verdict.failed_rank == 2 && other.verdict.ranks == verdict.ranks);
  CHECK(other.verdict.alive == verdict.alive && other.verdict.digests == verdict.digests &&
        other.verdict.failure.text == "text");
  CHECK(other.transfers == judgement.transfers);
  CHECK(other.parents.size() == 1 && other.parents[0].owner == 3 && other.parents[0].parent.first == 12);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    base::Reader part(bytes.view().first(length));
    CHECK_THROWS(read_judgement(part), std::runtime_error);
  }
}

TEST(inquiries_survive_their_bytes) {
  Inquiry inquiry;
  inquiry.requests = {{2, Request::Kind::give_right, 30}};
  inquiry.partners = {4};
  base::Bytes bytes;
  write(inquiry, bytes);
  base::Reader in(bytes.view());
  const Inquiry other = read_inquiry(in);
  CHECK(in.done() && other.partners == inquiry.partners && other.requests.size() == 1);
  CHECK(other.requests[0].system == 2 && other.requests[0].kind == Request::Kind::give_right);
  CHECK(other.requests[0].count == 30);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    base::Reader part(bytes.view().first(length));
    CHECK_THROWS(read_inquiry(part), std::runtime_error);
  }
}

TEST(alarms_survive_their_bytes_and_stay_silent) {
  const auto crowded = Strain{Alarms::kCrowded, 0, 0};
  const auto deep = Strain{0, 2 * Alarms::kDeep, 0};
  Alarms before;
  CHECK(before.look(1, "sand", crowded, 2, 0.5).size() == 1);
  for (int frame = 1; frame < Alarms::kPatience; ++frame) CHECK(before.look(0, "snow", deep, 2, 0.5).empty());
  base::Bytes bytes;
  base::write_fields(before, bytes);
  base::Reader in(bytes.view());
  Alarms after;
  base::read_fields(in, after);
  CHECK(in.left() == 0);
  CHECK(after.look(1, "sand", crowded, 2, 0.5).empty());
  CHECK(after.look(0, "snow", crowded, 2, 0.5).size() == 1);
  CHECK(before.look(0, "snow", deep, 2, 0.5).size() == 1);
  base::Reader again(bytes.view());
  base::read_fields(again, after);
  CHECK(after.look(0, "snow", deep, 2, 0.5).size() == 1);  // patience ends in the same frame
}

TEST(alarms_say_once_that_a_balancer_is_slow) {
  Alarms quick, slow;
  const auto said = [](Alarms& alarms, int plans, double decided_s) {
    std::string texts;
    for (int i = 0; i < plans; ++i) {
      for (const Alarm& alarm : alarms.look_at_balancer("Mine()", decided_s, 0.04)) texts += alarm.text;
    }
    return texts;
  };
  CHECK(said(quick, 3 * Alarms::kTrials, 0.003).empty());
  CHECK(said(slow, Alarms::kTrials - 1, 0.02).empty());
  CHECK(said(slow, 1, 0.02).starts_with("balancer Mine(): its decide takes 20 ms of a frame's 40 ms"));
  base::Bytes bytes;
  base::write_fields(slow, bytes);
  base::Reader in(bytes.view());
  base::read_fields(in, quick);
  CHECK(said(slow, 3 * Alarms::kTrials, 0.02).empty());
  CHECK(said(quick, 3 * Alarms::kTrials, 0.02).empty());
}

TEST(alarms_say_what_no_picture_shows_and_wait_for_what_may_come_into_it) {
  using enum Sighted;
  const auto said = [](std::initializer_list<Sighted> pictures, bool ends = true) {
    Alarms alarms;
    std::string texts;
    for (const Sighted sighted : pictures) {
      for (const Alarm& alarm : alarms.look_at_picture(1, "snow", sighted, false)) texts += alarm.text;
    }
    if (ends) {
      for (const Alarm& alarm : alarms.look_at_picture(1, "snow", unknown, true)) texts += alarm.text;
    }
    const auto has = [&](const char* part) { return texts.find(part) != std::string::npos; };
    return has("behind") ? "behind" : has("outside") ? "outside" : "";
  };
  CHECK(said({behind, behind}, false) == std::string("behind"));
  CHECK(said({beside, unknown, unknown}, false) == std::string());
  CHECK(said({beside, unknown, beside}, false) == std::string("outside"));
  CHECK(said({beside, unknown}) == std::string("outside"));
  CHECK(said({beside, inside, beside, beside, behind}) == std::string());
  CHECK(said({unknown, unknown}) == std::string());
  Alarms two;
  CHECK(two.look_at_picture(0, "rain", inside, false).empty() && two.look_at_picture(1, "snow", beside, false).empty());
  CHECK(two.look_at_picture(1, "snow", unknown, true).empty());  // a short film, and another system is in it
}

TEST(log_rows_are_padded_lines) {
  const Folder folder;
  {
    Log log((folder.path / "log").string(), {"host one", "host two"});
    FrameRow row;
    row.particles = 12;
    row.imbalance = std::numeric_limits<double>::quiet_NaN();
    LoadRow load;
    load.system = "snow \"1\" \\ \n\t\x01 \xc3\xa9";
    load.rank = 1;
    load.domain.low[0] = -std::numeric_limits<float>::infinity();
    load.domain.high[0] = 0.1f;
    row.load = {load, load};
    for (int i = 0; i < 3; ++i) log.add(row);
    log.event("births_dropped", 2, std::string(600, 'x'));
  }
  for (const std::string file : {"frames.jsonl", "load.jsonl", "events.jsonl"}) {
    const std::string text = folder.text(file);
    CHECK(!text.empty() && text.size() % 256 == 0 && text.back() == '\n');
    std::size_t begin = 0;
    for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
      const std::string line = text.substr(begin, end - begin);
      CHECK((line.size() + 1) % 256 == 0 && line.front() == '{');
      CHECK(line.find_last_not_of(' ') == line.rfind('}'));
      begin = end + 1;
    }
  }
  const std::string load = folder.text("load.jsonl");
  CHECK(load.size() == 6 * 512 || load.size() == 6 * 256);
  CHECK(holds(load, R"("system":"snow \"1\" \\ \u000a\u0009\u0001 )"));
  CHECK(holds(load, R"("host":"host two")"));
  CHECK(holds(load, R"("domain_lo":null,"domain_hi":0.1)"));
  CHECK(holds(folder.text("frames.jsonl"), R"("imbalance":null)"));
}

TEST(log_says_where_it_cannot_write) {
  try {
    const Log log("/dev/null/log", {});
    check::fail(__FILE__, __LINE__, "a log inside a file");
  } catch (const std::runtime_error& error) {
    CHECK(holds(error.what(), "/dev/null/log"));
  }
}

}  // namespace motes::test_report
