#include "batten/skinning/domains/mesh_size.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/memory.h"

namespace batten {

double bytes_for_triangles(double triangles) {
  return 70e6 + 500 * triangles * std::log2(std::max(triangles, 2.0));
}

namespace {

// `bytes`: of so many triangles.
template <class Bytes>
void require_affordable(const std::string& means, double triangles, double edge,
                        const Bytes& bytes) {
  const double needed = bytes(triangles), left = memory_left();
  if (!(needed > left)) return;
  double affordable = triangles;
  while (affordable > 16 && bytes(affordable) > 0.5 * left) affordable /= 1.2;
  throw InputError(means + ", which need " + bytes_in_words(needed) + " of memory, and " +
                   bytes_in_words(std::max(left, 0.0)) +
                   " are there; edge_length = " + number(edge * std::sqrt(triangles / affordable)) +
                   " needs " + bytes_in_words(bytes(affordable)));
}

std::string in_words(double edge, const std::string& what, double size, double triangles) {
  return "edge_length = " + number(edge) + " on " + what + " of size " + number(size) +
         " means about " + number(triangles) + " triangles";
}

}  // namespace

void require_mesh_size(double triangles, double edge, double size, const std::string& what) {
  const std::string means = in_words(edge, what, size, triangles);
  if (!(triangles <= most_triangles))
    throw InputError(means + "; at most " + number(most_triangles) +
                     " are allowed (is the unit right?)");
  require_affordable(means, triangles, edge, bytes_for_triangles);
}

void require_model_size(double triangles, double edge, double size) {
  require_affordable(in_words(edge, "all regions of a network", size, triangles), triangles, edge,
                     [](double n) { return 70e6 + 2000 * n; });
}

double most_when_halved(double edge, double size) {
  constexpr double usual = 50'000, times = 10;
  return std::clamp(times * (size / edge) * (size / edge), usual, most_triangles);
}

void require_tolerance(double tolerance, double size) {
  constexpr double least_share = 1e-9;
  if (tolerance >= least_share * size) return;
  throw InputError("tolerance = " + number(tolerance) + " is too small for a size of " +
                   number(size) + ": expected " + number(least_share * size) +
                   " or more, to which shapes are computed (is the unit right?)");
}

}  // namespace batten
