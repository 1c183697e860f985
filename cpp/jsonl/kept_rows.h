// What a run that goes on after another one keeps of a table of its log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace motes::jsonl {

/// Removes the rows of all frames from `first_frame` on, and a last line that was torn when the earlier run was killed.
/// What stays is written aside, brought to the disk and given the table's name: a second kill loses nothing. A table
/// that does not exist stays so. Throws LogError, naming file and line, for a row that is damaged or whose length is no
/// multiple of `line_bytes`, before anything is changed.
void keep_rows_before(std::uint64_t first_frame, const std::string& path, std::size_t line_bytes);

}  // namespace motes::jsonl
