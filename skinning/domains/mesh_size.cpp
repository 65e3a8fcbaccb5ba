#include "batten/skinning/domains/mesh_size.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/memory.h"

namespace batten {

double bytes_for_triangles(double triangles) {
  return 70e6 + 500 * triangles * std::log2(std::max(triangles, 2.0));
}

void require_mesh_size(double triangles, double edge, double size, const std::string& what) {
  const std::string means = "edge_length = " + number(edge) + " on " + what + " of size " +
                            number(size) + " means about " + number(triangles) + " triangles";
  if (!(triangles <= most_triangles))
    throw InputError(means + "; at most " + number(most_triangles) +
                     " are allowed (is the unit right?)");
  const double needed = bytes_for_triangles(triangles), left = memory_left();
  if (needed <= left) return;
  double affordable = triangles;
  while (affordable > 16 && bytes_for_triangles(affordable) > 0.5 * left) affordable /= 1.2;
  throw InputError(means + ", which need " + bytes_in_words(needed) + " of memory, and " +
                   bytes_in_words(std::max(left, 0.0)) +
                   " are there; edge_length = " + number(edge * std::sqrt(triangles / affordable)) +
                   " needs " + bytes_in_words(bytes_for_triangles(affordable)));
}

}  // namespace batten
