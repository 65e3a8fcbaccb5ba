// Memory limit of the process, and checks that reject a computation before it runs out of memory.
#pragma once

#include <string>

namespace batten {

/// Limits the memory of the whole process to `bytes` (option --memory of batten). 0, the default:
/// no limit other than the system's.
void set_memory_limit(double bytes);

/// Memory in bytes that this process may still allocate. Takes about 20 µs.
///
/// This is the limit of set_memory_limit() minus the memory in use, or, without such a limit, what
/// the system reports as available. A limit on the address space of the process (RLIMIT_AS) is
/// respected too. Infinite if the system reports nothing.
double available_memory();

/// Throws InputError "WHAT needs 14 GB of memory, but only 6 GB are available" if `bytes` exceeds
/// available_memory().
void require_memory(double bytes, const std::string& what);

/// Formats a number of bytes for messages: "14 GB" (one decimal at most), "300 MB".
std::string format_bytes(double bytes);

}  // namespace batten
