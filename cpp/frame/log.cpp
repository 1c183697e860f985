#include "frame/log.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace motes::frame {
namespace {

constexpr std::size_t kPad = 256;  // divides a page, so a padded line never crosses one

// A JSON object of flat scalars, built field by field.
class Row {
 public:
  Row& field(const char* name, const std::string& value) {
    start(name);
    text_ += '"';
    for (const char c : value) {
      if (c == '"' || c == '\\') text_ += '\\';
      if (static_cast<unsigned char>(c) >= 0x20) {
        text_ += c;
      } else {
        char escaped[8];
        std::snprintf(escaped, sizeof escaped, "\\u%04x", static_cast<unsigned>(static_cast<unsigned char>(c)));
        text_ += escaped;
      }
    }
    text_ += '"';
    return *this;
  }
  Row& field(const char* name, std::uint64_t value) {
    start(name);
    text_ += std::to_string(value);
    return *this;
  }
  Row& field(const char* name, int value) {
    start(name);
    text_ += std::to_string(value);
    return *this;
  }
  Row& field(const char* name, double value) {
    start(name);
    char digits[32] = "null";
    if (std::isfinite(value)) std::snprintf(digits, sizeof digits, "%.9g", value);
    text_ += digits;
    return *this;
  }
  std::string done() const { return text_ + "}"; }

 private:
  void start(const char* name) {
    text_ += text_.size() == 1 ? "\"" : ",\"";
    text_ += name;
    text_ += "\":";
  }
  std::string text_ = "{";
};

int open_table(const std::string& path) {
  const int file = open(path.c_str(), O_CREAT | O_WRONLY | O_TRUNC | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) throw std::runtime_error("log: cannot write " + path + ": " + std::strerror(errno));
  return file;
}

std::string line_of(const FrameRow& row) {
  Row line;
  line.field("frame", row.frame).field("time", row.time).field("particles", row.particles);
  line.field("exchanged", row.exchanged).field("exchanged_bytes", row.exchanged_bytes).field("dropped", row.dropped);
  line.field("imbalance", row.imbalance).field("slowest_rank", row.slowest_rank);
  line.field("t_frame_s", row.times.frame).field("t_create_s", row.times.create).field("t_act_s", row.times.act);
  line.field("t_report_s", row.times.report).field("t_exchange_s", row.times.exchange);
  line.field("t_balance_s", row.times.balance).field("t_render_s", row.times.render);
  if (!row.image_sha256.empty()) line.field("image_sha256", row.image_sha256);
  if (!row.particles_digest.empty()) line.field("particles_digest", row.particles_digest);
  return line.done();
}

std::string line_of(const FrameRow& frame, const LoadRow& row, const std::string& host) {
  Row line;
  line.field("frame", frame.frame).field("system", row.system).field("rank", row.rank).field("host", host);
  line.field("n_start", row.n_start)
      .field("n_end", row.n_end)
      .field("created", row.created)
      .field("killed", row.killed);
  line.field("sent", row.sent).field("received", row.received).field("bytes_sent", row.bytes_sent);
  line.field("t_compute_s", row.compute_s).field("t_rescaled_s", row.rescaled_s);
  line.field("t_exchange_s", row.exchange_s).field("t_wait_s", row.wait_s).field("t_image_s", row.image_s);
  line.field("domain_lo", row.domain_lo).field("domain_hi", row.domain_hi).field("speed", row.speed);
  return line.done();
}

}  // namespace

Log::Log(std::string directory, std::vector<std::string> hosts)
    : directory_(std::move(directory)), hosts_(std::move(hosts)) {
  std::error_code error;
  std::filesystem::create_directories(directory_, error);
  if (error) throw std::runtime_error("log: cannot make " + directory_ + ": " + error.message());
  frames_ = open_table(directory_ + "/frames.jsonl");
  load_ = open_table(directory_ + "/load.jsonl");
  events_ = open_table(directory_ + "/events.jsonl");
}

Log::~Log() {
  for (const int file : {frames_, load_, events_}) {
    if (file >= 0) close(file);
  }
}

void Log::add(const FrameRow& row) {
  write_line(frames_, line_of(row));
  for (const LoadRow& load : row.load) {
    const auto rank = static_cast<std::size_t>(load.rank);
    write_line(load_, line_of(row, load, rank < hosts_.size() ? hosts_[rank] : ""));
  }
}

void Log::event(const std::string& kind, std::uint64_t frame, const std::string& text) {
  write_line(events_, Row().field("frame", frame).field("kind", kind).field("text", text).done());
}

void Log::write_line(int file, std::string line) {
  const std::size_t padded = (line.size() + 1 + kPad - 1) / kPad * kPad;
  line.resize(padded - 1, ' ');
  line.push_back('\n');
  const ssize_t written = ::write(file, line.data(), line.size());
  if (written != static_cast<ssize_t>(line.size())) {
    throw std::runtime_error("log: cannot write to " + directory_ + ": " + std::strerror(errno));
  }
}

}  // namespace motes::frame
