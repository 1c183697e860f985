// A table of JSON lines on disk: flat objects, one schema per file.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace motes::jsonl {

/// The log cannot be written, or an earlier run's log cannot be continued; the text names the file.
class LogError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Syncs the directory of `path`, so that the names of its files are on disk, if the file system can do that.
void sync_directory_of(const std::string& path);

/// A JSON object of flat scalars, built field by field. Non-finite numbers become null; doubles and floats have a point
/// or an exponent, even if they are whole.
class JsonlRow {
 public:
  JsonlRow& field(const char* name, const std::string& value);
  JsonlRow& field(const char* name, std::uint64_t value);
  JsonlRow& field(const char* name, std::int64_t value);
  JsonlRow& field(const char* name, int value) { return field(name, static_cast<std::int64_t>(value)); }
  JsonlRow& field(const char* name, double value);
  JsonlRow& field(const char* name,
                  float value);  // shortest text that reads back as the same bits: several times faster
  JsonlRow& null(const char* name);
  std::string done() const { return text_ + "}"; }

 private:
  void start(const char* name);
  std::string text_ = "{";
};

/// All lines have the same length, a power of two, so that no line crosses a page: the system writes page by page, and
/// the log of a killed run is readable to its last complete line. Lines that belong together are written at once.
class JsonlTable {
 public:
  JsonlTable() = default;
  /// Whether a table without rows is an empty file or no file: other programs cannot read an empty one.
  enum class Empty : std::uint8_t { file, absent };
  /// Creates a file or, with `first_frame` above 0, continues behind the rows that an earlier run wrote for the frames
  /// before it (kept_rows.h). Throws LogError if it cannot.
  JsonlTable(std::string path, std::size_t line_bytes, std::uint64_t first_frame = 0, Empty empty = Empty::file);
  ~JsonlTable();
  JsonlTable(JsonlTable&& other) noexcept;
  JsonlTable& operator=(JsonlTable&& other) noexcept;

  void add(const JsonlRow& row);
  /// Writes the added rows. Throws LogError if the disk does not accept them, as does sync().
  void write();
  /// Writes the added rows and waits until all rows are on disk.
  void sync();

 private:
  void open(int more);

  std::string path_;
  std::string lines_;
  std::size_t line_bytes_ = 0;
  int file_ = -1;
};

}  // namespace motes::jsonl
