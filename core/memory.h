// How much memory a computation may ask for, so that it can say no before it starts.
#pragma once

#include <string>

namespace batten {

/// States the memory that this process may have, bytes; 0: what the system has. Of the whole
/// process: batten's --memory.
void set_memory_limit(double bytes);

/// Bytes that may still be asked for: of what set_memory_limit() stated, or that the system says are
/// available, less than a limit of the process on its addresses where it has one. Infinite where
/// the system does not tell. 20 µs.
double available_memory();

/// Throws InputError "WHAT needs 14 GB of memory, and 6 GB are there" where that is so.
void require_memory(double bytes, const std::string& what);

/// Whole bytes in words: "14 GB", "300 MB".
std::string format_bytes(double bytes);

}  // namespace batten
