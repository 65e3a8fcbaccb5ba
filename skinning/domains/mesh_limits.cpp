#include "batten/skinning/domains/mesh_limits.h"

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
void require_affordable(const std::string& means, double triangles, double edge_length,
                        const Bytes& bytes) {
  const double needed = bytes(triangles), left = available_memory();
  if (!(needed > left)) return;
  double affordable = triangles;
  while (affordable > 16 && bytes(affordable) > 0.5 * left) affordable /= 1.2;
  throw InputError(means + ", which need " + format_bytes(needed) + " of memory, and " +
                   format_bytes(std::max(left, 0.0)) + " are there; edge_length = " +
                   format_number(edge_length * std::sqrt(triangles / affordable)) + " needs " +
                   format_bytes(bytes(affordable)));
}

std::string mesh_description(double edge_length, const std::string& what, double size,
                             double triangles) {
  return "edge_length = " + format_number(edge_length) + " on " + what + " of size " +
         format_number(size) + " means about " + format_number(triangles) + " triangles";
}

}  // namespace

void require_mesh_size(double triangles, double edge_length, double size, const std::string& what) {
  const std::string means = mesh_description(edge_length, what, size, triangles);
  if (!(triangles <= kMaxTriangles))
    throw InputError(means + "; at most " + format_number(kMaxTriangles) +
                     " are allowed (is the unit right?)");
  require_affordable(means, triangles, edge_length, bytes_for_triangles);
}

void require_model_size(double triangles, double edge_length, double size) {
  require_affordable(mesh_description(edge_length, "all regions of a network", size, triangles),
                     triangles, edge_length, [](double n) { return 70e6 + 2000 * n; });
}

double max_refined_triangles(double edge_length, double size) {
  constexpr double usual = 50'000, times = 10;
  return std::clamp(times * (size / edge_length) * (size / edge_length), usual, kMaxTriangles);
}

void require_tolerance(double tolerance, double size) {
  constexpr double min_fraction = 1e-9;
  if (tolerance >= min_fraction * size) return;
  throw InputError("tolerance = " + format_number(tolerance) + " is too small for a size of " +
                   format_number(size) + ": expected " + format_number(min_fraction * size) +
                   " or more, to which shapes are computed (is the unit right?)");
}

}  // namespace batten
