// Readers of other libraries, run where a crash takes nothing with it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace batten {

/// Whether files of CAD libraries and of VTK are read in a child process, which dies alone when a
/// damaged file brings the library down. The batten program says yes. It is off in other programs
/// until they ask for it, since a process of many threads may not like to be copied: the child has
/// only the thread that reads. Of the whole process; set it before the first file is read.
void enable_sandboxed_read(bool yes);
bool is_sandboxed_read_enabled();

/// Runs `read` in a copy of this process, if is_sandboxed_read_enabled(), and returns the bytes that it
/// returned. The child may use processor time and memory in proportion to the size of `file`: 6 s +
/// 4 s a MB, four times as long by the clock, and 1 GB + 200 times the size; `times` as much time
/// where it does more than read. It writes nothing to the terminal. In the child, is_sandboxed_read_enabled()
/// is false.
///
/// Throws what `read` throws, as InputError; InputError "FILE: LIBRARY …" when the child died, by
/// which signal, or used up its time or memory; CancelledError when somebody stopped it. Costs 1 to
/// 10 ms, and 1 ms a MB that is returned.
std::string sandboxed_read(const std::filesystem::path& file, const std::string& library,
                           const std::function<std::string()>& read, int times = 1);

}  // namespace batten
