// SPDX-License-Identifier: MPL-2.0
// Memory limit of the process, and checks that reject a computation before it runs out of memory.
#pragma once

#include <string>

namespace batten {

/// Limits the memory of the whole process to `bytes` (option --memory of batten). 0, the default:
/// no limit other than the system's.
void set_memory_limit(double bytes);

/// Memory in bytes that this process may still allocate. Takes about 20 µs.
///
/// The value is the limit of set_memory_limit() minus the memory in use or, without such a limit,
/// the available memory that the system reports. A limit on the address space of the process
/// (RLIMIT_AS) is also respected. Infinity if no limit is set and the system does not report its
/// available memory.
double available_memory();

/// Address space in bytes that this process may still use, for libraries that reserve much more than
/// they use. Infinity without a limit (RLIMIT_AS, `ulimit -v`).
double available_addresses();

/// Throws MemoryError "WHAT needs 14 GB of memory, but only 6 GB are available" if `bytes` exceeds
/// available_memory().
void require_memory(double bytes, const std::string& what);

/// Formats a number of bytes for messages, for example "1.4 GB" (at most one decimal) or "300 MB".
std::string format_bytes(double bytes);

}  // namespace batten
