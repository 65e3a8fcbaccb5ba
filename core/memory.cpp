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

std::atomic<double> stated = 0;

constexpr double kEndless = std::numeric_limits<double>::infinity();

#if defined(__unix__)
// Bytes behind a word of a file of "Word:   123 kB"; endless where it is not there.
double kilobytes(const char* file, const std::string& word) {
  std::ifstream in(file);
  for (std::string found; in >> found;)
    if (double value = 0; found == word && in >> value) return 1024 * value;
  return kEndless;
}
#endif

}  // namespace

void limit_memory(double bytes) { stated = bytes; }

double memory_left() {
#if defined(__unix__)
  const double limit = stated;
  double left = kilobytes("/proc/meminfo", "MemAvailable:");
  if (limit > 0) left = limit - kilobytes("/proc/self/status", "VmRSS:");
  rlimit addresses{};
  if (::getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur != RLIM_INFINITY)
    left = std::min(
        left, static_cast<double>(addresses.rlim_cur) - kilobytes("/proc/self/status", "VmSize:"));
  return left;
#else
  return stated > 0 ? static_cast<double>(stated) : kEndless;
#endif
}

void require_memory(double bytes, const std::string& what) {
  const double left = memory_left();
  if (bytes > left)
    throw InputError(what + " needs " + bytes_in_words(bytes) + " of memory, and " +
                     bytes_in_words(std::max(left, 0.0)) + " are there");
}

std::string bytes_in_words(double bytes) {
  constexpr double giga = 1e9, mega = 1e6;
  return bytes >= 0.95 * giga ? number(std::round(10 * bytes / giga) / 10) + " GB"
                              : number(std::round(bytes / mega)) + " MB";
}

}  // namespace batten
