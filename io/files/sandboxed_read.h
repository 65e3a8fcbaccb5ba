// Runs readers of third-party libraries in a child process, so that a crash does not affect the
// program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace batten {

/// Sets whether CAD and VTK files are read in a child process, which alone dies if a damaged file
/// crashes the library. The `batten` program enables this. By default it is off, because forking a
/// process with many threads may be unsafe: the child has only the reading thread. The setting
/// applies to the whole process; set it before the first file is read.
void enable_sandboxed_read(bool yes);
bool is_sandboxed_read_enabled();

/// Runs `read` in a forked child process and returns the bytes that it returned. If
/// is_sandboxed_read_enabled() is false, it calls `read` directly. Limits of the child, by the size
/// of `file`: processor time 6 s + 4 s per MB, four times that in elapsed time, and memory 1 GB +
/// 200 times the size. `times` multiplies the time limits, if `read` does more than reading. The
/// child writes nothing to the terminal. In the child, is_sandboxed_read_enabled() is false.
///
/// Throws what `read` throws, as InputError if it is one, otherwise as InputError "FILE: LIBRARY
/// …". Throws the latter also if the child died (with the signal) or exceeded its time or memory.
/// Throws CancelledError if the child was interrupted. Costs 1 to 10 ms, and 1 ms per MB returned.
std::string sandboxed_read(const std::filesystem::path& file, const std::string& library,
                           const std::function<std::string()>& read, int times = 1);

}  // namespace batten
