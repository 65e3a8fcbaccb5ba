#include "batten/fem/nested_dissection.h"

#include <algorithm>

#include "batten/core/box.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

class Dissection {
 public:
  explicit Dissection(const ParametricMesh& mesh)
      : mesh_(mesh),
        dofs_(mesh),
        triangles_(mesh.triangle_count()),
        centre_(mesh.triangle_count()),
        seen_(mesh.vertex_count() + mesh.edge_count(), 0),
        side_(seen_.size(), 0),
        half_(mesh.triangle_count(), 0) {
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      triangles_[t] = t;
      const auto& corner = mesh.shape(t).vertex;
      centre_[t] = corner[0] + corner[1] + corner[2];
    }
    order_.resize(dofs_.count());
    next_ = dofs_.count();
  }

  std::vector<int> order() {
    split(0, isize(triangles_));
    return std::move(order_);
  }

 private:
  static constexpr int kLeaf = 6;  // triangles

  // Vertices and edges as one list: edges after all vertices.
  template <class Visit>
  void for_each_entity(int triangle, const Visit& visit) const {
    for (const int v : mesh_.triangles()[triangle]) visit(v);
    for (const int e : mesh_.edges_of(triangle)) visit(mesh_.vertex_count() + e);
  }

  // Filled from the end: separators first, so that they are eliminated last.
  void place(int entity) {
    if (seen_[entity]) return;
    seen_[entity] = 1;
    if (entity >= mesh_.vertex_count()) {
      order_[--next_] = dofs_.edge(entity - mesh_.vertex_count());
    } else {
      for (int d = 2; d >= 0; --d) order_[--next_] = dofs_.vertex(entity, d);
    }
  }

  void split(int begin, int end) {
    if (end - begin <= kLeaf) {
      for (int i = begin; i < end; ++i)
        for_each_entity(triangles_[i], [&](int entity) { place(entity); });
      return;
    }
    Box2 box;
    for (int i = begin; i < end; ++i) box.extend(centre_[triangles_[i]]);
    const int axis = box.sizes().x() >= box.sizes().y() ? 0 : 1;
    const int middle = (begin + end) / 2;
    std::nth_element(triangles_.begin() + begin, triangles_.begin() + middle,
                     triangles_.begin() + end, [&](int a, int b) {
                       const double x = centre_[a][axis], y = centre_[b][axis];
                       return x != y ? x < y : a < b;
                     });
    const int cut = straightened(begin, middle, end);
    ++stamp_;
    for (int i = begin; i < cut; ++i)
      for_each_entity(triangles_[i], [&](int entity) { side_[entity] = stamp_; });
    for (int i = cut; i < end; ++i)
      for_each_entity(triangles_[i], [&](int entity) {
        if (side_[entity] == stamp_) place(entity);
      });
    split(begin, cut);
    split(cut, end);
  }

  // Centres beside a line leave a ragged boundary: a triangle with two neighbours across changes
  // sides, till there is none. On unstructured meshes that takes a third of the separator away.
  // Returns where the second half begins.
  int straightened(int begin, int middle, int end) {
    half_stamp_ += 2;
    for (int i = begin; i < end; ++i) half_[triangles_[i]] = half_stamp_ + (i >= middle);
    int count = middle - begin;
    bool any = true;
    while (any) {
      any = false;
      for (int i = begin; i < end; ++i) {
        const int t = triangles_[i], own = half_[t], other = 2 * half_stamp_ + 1 - own;
        int across = 0, beside = 0;
        for (const int e : mesh_.edges_of(t))
          for (const int neighbour : mesh_.edges()[e].triangle) {
            if (neighbour < 0 || neighbour == t) continue;
            across += half_[neighbour] == other;
            beside += half_[neighbour] == own;
          }
        const int left = own == half_stamp_ ? count - 1 : end - begin - count - 1;
        if (across <= beside || left < 1) continue;
        half_[t] = other;
        count += own == half_stamp_ ? -1 : 1;
        any = true;
      }
    }
    std::stable_partition(triangles_.begin() + begin, triangles_.begin() + end,
                          [&](int t) { return half_[t] == half_stamp_; });
    return begin + count;
  }

  const ParametricMesh& mesh_;
  DofMap dofs_;
  std::vector<int> triangles_;
  std::vector<Vec2> centre_;
  std::vector<char> seen_;  // vertices, then edges
  std::vector<int> side_;
  std::vector<int> half_;  // of triangles
  std::vector<int> order_;
  int next_ = 0, stamp_ = 0, half_stamp_ = 0;
};

}  // namespace

std::vector<int> nested_dissection_order(const ParametricMesh& mesh) {
  return Dissection(mesh).order();
}

std::vector<std::array<int, 2>> dof_vertices(const ParametricMesh& mesh) {
  const DofMap dofs(mesh);
  std::vector<std::array<int, 2>> vertices(dofs.count());
  for (int v = 0; v < mesh.vertex_count(); ++v)
    for (int d = 0; d < 3; ++d) vertices[dofs.vertex(v, d)] = {v, v};
  for (int e = 0; e < mesh.edge_count(); ++e)
    vertices[dofs.edge(e)] = {mesh.edges()[e].low, mesh.edges()[e].high};
  return vertices;
}

}  // namespace batten
