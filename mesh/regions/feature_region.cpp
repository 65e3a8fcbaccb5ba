#include "batten/mesh/regions/feature_region.h"

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/mesh/selection.h"

namespace batten {

std::vector<std::vector<int>> components_of_mask(const TriangleMesh& mesh,
                                                 const std::vector<char>& mask) {
  const int n = mesh.vertex_count();
  if (isize(mask) != n)
    throw InputError("the mask has " + std::to_string(mask.size()) +
                     " marks, expected one for each of " + std::to_string(n) + " vertices");
  std::vector<std::vector<int>> components;
  std::vector<char> seen(n, 0);
  for (int seed = 0; seed < n; ++seed) {
    if (!mask[seed] || seen[seed]) continue;
    std::vector<int> component = {seed};
    seen[seed] = 1;
    for (size_t k = 0; k < component.size(); ++k)
      for (const int v : mesh.topology().neighbours(component[k]))
        if (mask[v] && !seen[v]) {
          seen[v] = 1;
          component.push_back(v);
        }
    std::sort(component.begin(), component.end());
    components.push_back(std::move(component));
  }
  return components;
}

std::vector<int> faces_of(const TriangleMesh& mesh, const FeatureRegion& region) {
  const std::string name = "region '" + region.name + "'";
  const auto in_range = [&](const std::vector<int>& numbers, const char* what, int count) {
    for (const int i : numbers)
      if (i < 0 || i >= count)
        throw InputError(name + " names " + what + " " + std::to_string(i) + " of " +
                         std::to_string(count));
  };
  in_range(region.faces, "triangle", mesh.triangle_count());
  if (region.faces.empty()) in_range(region.vertices, "vertex", mesh.vertex_count());
  std::vector<int> faces =
      region.faces.empty() ? triangles_touching(mesh.topology(), region.vertices) : region.faces;
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  if (faces.empty()) throw InputError(name + " has no triangles, expected at least one");
  return faces;
}

}  // namespace batten
