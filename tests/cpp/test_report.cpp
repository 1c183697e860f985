// Reports and verdicts as bytes; rows of the log as lines.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "check.h"
#include "frame/log.h"
#include "frame/report.h"

using namespace motes;
using namespace motes::frame;

namespace {

Report rich_report() {
  Report report;
  report.failure = {Failure::Kind::compute, "gravity", "no memory"};
  report.record.put_text("a recorded list");
  report.systems.resize(2);
  report.systems[0].at_start = 10;
  report.systems[0].created = 5;
  report.systems[0].killed = 3;
  report.systems[0].kept = 11;
  report.systems[0].compute_s = 0.25;
  report.systems[0].sent = {{1, 1}, {2, 7}};
  report.systems[1].digest.first = 99;
  report.tail.valid = true;
  report.tail.frame = 6;
  report.tail.times.act = 0.125;
  report.tail.bytes_sent = {100, 0};
  report.tail.image_sha256 = "abc";
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
  particles::Bytes bytes;
  write(report, bytes);
  particles::Reader in(bytes.view());
  Report other = rich_report();  // overwrites one that holds more than the bytes do
  other.systems.resize(9);
  other.tail.density.resize(9);
  read(in, other);
  CHECK(in.done());
  CHECK(other.failure.kind == Failure::Kind::compute && other.failure.action == "gravity" &&
        other.failure.text == "no memory");
  CHECK(other.record.size() == report.record.size());
  CHECK(other.systems.size() == 2 && other.systems[0].sent.size() == 2 && other.systems[0].sent[1].count == 7);
  CHECK(other.systems[0].at_start == 10 && other.systems[0].kept == 11 && other.systems[0].compute_s == 0.25);
  CHECK(other.systems[1].digest.first == 99);
  CHECK(other.tail.valid && other.tail.frame == 6 && other.tail.times.act == 0.125);
  CHECK(other.tail.bytes_sent == report.tail.bytes_sent && other.tail.image_sha256 == "abc");
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    particles::Reader part(bytes.view().first(length));
    CHECK_THROWS(read(part, other), std::runtime_error);
  }
}

TEST(verdict_survives_its_bytes) {
  Verdict verdict;
  verdict.failure = {Failure::Kind::mismatch, "step", "text"};
  verdict.failed_rank = 2;
  verdict.ranks = {2, 3};
  verdict.alive = {5, 6};
  verdict.digests.resize(2);
  verdict.digests[1].second = 4;
  particles::Bytes bytes;
  write(verdict, bytes);
  particles::Reader in(bytes.view());
  const Verdict other = read_verdict(in);
  CHECK(in.done());
  CHECK(other.failed_rank == 2 && other.ranks == verdict.ranks);
  CHECK(other.alive == verdict.alive && other.digests == verdict.digests && other.failure.text == "text");
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    particles::Reader part(bytes.view().first(length));
    CHECK_THROWS(read_verdict(part), std::runtime_error);
  }
}

TEST(orders_survive_their_bytes) {
  Orders orders;
  orders.sources = {1, 7};
  particles::Bytes bytes;
  write(orders, bytes);
  particles::Reader in(bytes.view());
  const Orders other = read_orders(in);
  CHECK(in.done() && other.sources == orders.sources);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    particles::Reader part(bytes.view().first(length));
    CHECK_THROWS(read_orders(part), std::runtime_error);
  }
}

TEST(inquiries_survive_their_bytes) {
  Inquiry inquiry;
  inquiry.requests = {{2, Request::Kind::give_right, 30}};
  inquiry.partners = {4};
  particles::Bytes bytes;
  write(inquiry, bytes);
  particles::Reader in(bytes.view());
  const Inquiry other = read_inquiry(in);
  CHECK(in.done() && other.partners == inquiry.partners && other.requests.size() == 1);
  CHECK(other.requests[0].system == 2 && other.requests[0].kind == Request::Kind::give_right);
  CHECK(other.requests[0].count == 30);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    particles::Reader part(bytes.view().first(length));
    CHECK_THROWS(read_inquiry(part), std::runtime_error);
  }
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
    load.domain_lo = -std::numeric_limits<float>::infinity();
    load.domain_hi = 0.1f;
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
