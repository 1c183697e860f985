// Keeps the rows of an earlier run in a table of the log, for a run that continues it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace motes::jsonl {

/// Removes the rows of all frames from `first_frame` on, and a last line that was torn when the earlier run was killed.
/// The remaining rows are written to another file, which is synced and then renamed, so a second kill loses nothing.
/// Does nothing if the table does not exist. Throws LogError naming file and line, before anything is changed, if a row
/// is damaged or its length is not a multiple of `line_bytes`.
void keep_rows_before(std::uint64_t first_frame, const std::string& path, std::size_t line_bytes);

}  // namespace motes::jsonl
