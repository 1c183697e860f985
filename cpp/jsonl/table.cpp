#include "jsonl/table.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "jsonl/kept_rows.h"

namespace motes::jsonl {
namespace {

template <class... Arguments>
void append(std::string& text, Arguments... arguments) {
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, arguments...);
  text.append(digits, error == std::errc() ? end : digits);
}

// Appends a finite number that every reader takes for a float: without a point or an exponent, readers that infer a
// column's type from its first rows take it for a column of integers, and fail or round later.
template <class... Arguments>
void append_float(std::string& text, Arguments... arguments) {
  const std::size_t start = text.size();
  append(text, arguments...);
  if (text.find_first_of(".e", start) == std::string::npos) text += ".0";
}

}  // namespace

void JsonlRow::start(const char* name) {
  text_ += text_.size() == 1 ? "\"" : ",\"";
  text_ += name;
  text_ += "\":";
}

JsonlRow& JsonlRow::field(const char* name, const std::string& value) {
  start(name);
  text_ += '"';
  for (const char c : value) {
    if (c == '"' || c == '\\') text_ += '\\';
    if (static_cast<unsigned char>(c) >= 0x20) {
      text_ += c;
    } else {
      constexpr const char* kHex = "0123456789abcdef";
      text_ += "\\u00";
      text_ += kHex[static_cast<unsigned char>(c) >> 4];
      text_ += kHex[static_cast<unsigned char>(c) & 15];
    }
  }
  text_ += '"';
  return *this;
}

JsonlRow& JsonlRow::field(const char* name, std::uint64_t value) {
  start(name);
  append(text_, value);
  return *this;
}

JsonlRow& JsonlRow::field(const char* name, std::int64_t value) {
  start(name);
  append(text_, value);
  return *this;
}

JsonlRow& JsonlRow::field(const char* name, double value) {
  if (!std::isfinite(value)) return null(name);
  start(name);
  append_float(text_, value, std::chars_format::general, 9);
  return *this;
}

JsonlRow& JsonlRow::field(const char* name, float value) {
  if (!std::isfinite(value)) return null(name);
  start(name);
  append_float(text_, value);
  return *this;
}

JsonlRow& JsonlRow::null(const char* name) {
  start(name);
  text_ += "null";
  return *this;
}

void sync_directory_of(const std::string& path) {
  const std::size_t name = path.rfind('/');
  const int directory =
      ::open(name == std::string::npos ? "." : path.substr(0, name + 1).c_str(), O_RDONLY | O_CLOEXEC);
  if (directory < 0) return;
  ::fsync(directory);
  ::close(directory);
}

JsonlTable::JsonlTable(std::string path, std::size_t line_bytes, std::uint64_t first_frame, Empty empty)
    : path_(std::move(path)), line_bytes_(line_bytes) {
  if (first_frame > 0) keep_rows_before(first_frame, path_, line_bytes);
  open(first_frame > 0 ? 0 : O_TRUNC);
  if (empty == Empty::absent && ::lseek(file_, 0, SEEK_END) == 0) {
    ::close(std::exchange(file_, -1));
    ::unlink(path_.c_str());
  }
}

void JsonlTable::open(int more) {
  file_ = ::open(path_.c_str(), O_CREAT | O_WRONLY | more | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (file_ < 0) throw LogError("log: cannot write " + path_ + ": " + std::strerror(errno));
}

JsonlTable::~JsonlTable() {
  if (file_ >= 0) ::close(file_);
}

JsonlTable::JsonlTable(JsonlTable&& other) noexcept { *this = std::move(other); }

JsonlTable& JsonlTable::operator=(JsonlTable&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(lines_, other.lines_);
  std::swap(line_bytes_, other.line_bytes_);
  std::swap(file_, other.file_);
  return *this;
}

void JsonlTable::add(const JsonlRow& row) {
  std::string line = row.done();
  // Only very long names of systems or hosts need more than one unit; such a line may cross a page.
  const std::size_t padded = (line.size() + 1 + line_bytes_ - 1) / line_bytes_ * line_bytes_;
  line.resize(padded - 1, ' ');
  lines_ += line;
  lines_ += '\n';
}

void JsonlTable::write() {
  if (lines_.empty()) return;
  if (file_ < 0) open(O_EXCL);
  const ssize_t written = ::write(file_, lines_.data(), lines_.size());
  const bool whole = written == static_cast<ssize_t>(lines_.size());
  lines_.clear();
  if (!whole) throw LogError("log: cannot write to " + path_ + ": " + std::strerror(errno));
}

void JsonlTable::sync() {
  write();
  if (file_ >= 0 && fsync(file_) != 0 && errno != EINVAL && errno != EROFS) {  // not a file on a disk
    throw LogError("log: cannot write to " + path_ + ": " + std::strerror(errno));
  }
}

}  // namespace motes::jsonl
