// A table of JSON lines on disk: flat objects, one schema per file.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace motes::frame {

/// A JSON object of flat scalars, built field by field. Numbers that are not finite become null.
class Row {
 public:
  Row& field(const char* name, const std::string& value);
  Row& field(const char* name, std::uint64_t value);
  Row& field(const char* name, std::int64_t value);
  Row& field(const char* name, int value) { return field(name, static_cast<std::int64_t>(value)); }
  Row& field(const char* name, double value);
  Row& field(const char* name, float value);  // the shortest text that gives these bits again: several times faster
  Row& null(const char* name);
  std::string done() const { return text_ + "}"; }

 private:
  void start(const char* name);
  std::string text_ = "{";
};

/// All lines have the same length, a power of two, so that no line crosses a page: the system writes page by page, and
/// the log of a killed run is readable to its last complete line. Lines that belong together go in one write.
class Table {
 public:
  Table() = default;
  /// Throws std::runtime_error, naming the path, where it cannot make an empty file.
  Table(std::string path, std::size_t line_bytes);
  ~Table();
  Table(Table&& other) noexcept;
  Table& operator=(Table&& other) noexcept;

  void add(const Row& row);
  /// Throws std::runtime_error where the disk does not accept it.
  void write();

 private:
  std::string path_;
  std::string lines_;
  std::size_t line_bytes_ = 0;
  int file_ = -1;
};

}  // namespace motes::frame
