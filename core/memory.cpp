// SPDX-License-Identifier: MPL-2.0
#include "batten/core/memory.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#if defined(__unix__)
#include <sys/resource.h>
#include <unistd.h>
#endif

#include "batten/core/errors.h"

namespace batten {
namespace {

std::atomic<double> memory_limit = 0;

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

#if defined(__unix__)
// Value, in bytes, of a field in a file with lines of the form "Field: 123 kB"; infinite if the
// field is missing.
double kilobytes(const char* file, const std::string& field) {
  std::ifstream in(file);
  for (std::string found; in >> found;)
    if (double value = 0; found == field && in >> value) return 1024 * value;
  return kUnlimited;
}
#endif

}  // namespace

void set_memory_limit(double bytes) { memory_limit = bytes; }

double available_addresses() {
#if defined(__unix__)
  rlimit addresses{};
  if (::getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur != RLIM_INFINITY)
    return static_cast<double>(addresses.rlim_cur) - kilobytes("/proc/self/status", "VmSize:");
#endif
  return kUnlimited;
}

double available_memory() {
#if defined(__unix__)
  const double limit = memory_limit;
  double available = kilobytes("/proc/meminfo", "MemAvailable:");
  if (limit > 0) available = limit - kilobytes("/proc/self/status", "VmRSS:");
  return std::min(available, available_addresses());
#else
  return memory_limit > 0 ? static_cast<double>(memory_limit) : kUnlimited;
#endif
}

void require_memory(double bytes, const std::string& what) {
  const double available = available_memory();
  if (bytes > available)
    throw MemoryError(what + " needs " + format_bytes(bytes) + " of memory, but only " +
                      format_bytes(std::max(available, 0.0)) + " are available");
}

std::string format_bytes(double bytes) {
  constexpr double giga = 1e9, mega = 1e6;
  return bytes >= 0.95 * giga ? format_number(std::round(10 * bytes / giga) / 10) + " GB"
                              : format_number(std::round(bytes / mega)) + " MB";
}

}  // namespace batten
