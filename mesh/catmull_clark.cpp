#include "batten/mesh/catmull_clark.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "batten/core/errors.h"
#include "batten/core/index.h"

namespace batten {
namespace {

using Key = std::pair<int, int>;
Key key(int a, int b) { return std::minmax(a, b); }

/// A polygon mesh with its edges.
class Cage {
 public:
  struct Edge {
    int low, high;
    std::vector<int> faces;
    bool sharp = false;
  };

  Cage(Points points, std::vector<std::vector<int>> faces, const std::vector<Key>& creases)
      : points_(std::move(points)), faces_(std::move(faces)), edges_at_(points_.rows()) {
    for (int f = 0; f < count_of(faces_); ++f)
      for (size_t i = 0; i < faces_[f].size(); ++i) edge_of(f, i).faces.push_back(f);
    for (const Key& crease : creases) {
      const auto found = number_.find(crease);
      if (found == number_.end())
        throw InputError("the crease from node " + std::to_string(crease.first + 1) + " to " +
                         std::to_string(crease.second + 1) + " is no edge of the cage");
      edges_[found->second].sharp = true;
    }
    for (Edge& edge : edges_) edge.sharp = edge.sharp || edge.faces.size() != 2;
    faces_at_.resize(points_.rows());
    for (int f = 0; f < count_of(faces_); ++f)
      for (const int v : faces_[f]) faces_at_[v].push_back(f);
  }

  Cage subdivided() const {
    const long v0 = points_.rows(), e0 = v0 + count_of(faces_);
    Points points(e0 + count_of(edges_), 3);
    for (int f = 0; f < count_of(faces_); ++f) points.row(v0 + f) = centre(f).transpose();
    std::vector<Key> creases;
    for (int e = 0; e < count_of(edges_); ++e) {
      const Edge& edge = edges_[e];
      const Vec3 ends = at(edge.low) + at(edge.high);
      const int own = static_cast<int>(e0) + e;
      if (edge.sharp) {
        points.row(own) = ends.transpose() / 2;
        creases.emplace_back(key(edge.low, own));
        creases.emplace_back(key(edge.high, own));
      } else {
        points.row(own) = (ends + centre(edge.faces[0]) + centre(edge.faces[1])).transpose() / 4;
      }
    }
    for (int v = 0; v < v0; ++v) points.row(v) = moved(v).transpose();
    std::vector<std::vector<int>> quads;
    for (int f = 0; f < count_of(faces_); ++f) {
      const auto& face = faces_[f];
      const size_t n = face.size();
      for (size_t i = 0; i < n; ++i)
        quads.push_back({face[i], static_cast<int>(e0) + number(face[i], face[(i + 1) % n]),
                         static_cast<int>(v0) + f,
                         static_cast<int>(e0) + number(face[(i + n - 1) % n], face[i])});
    }
    return Cage(std::move(points), std::move(quads), creases);
  }

  /// Of quads.
  ShellMesh limit() const {
    ShellMesh mesh;
    mesh.points.resize(points_.rows(), 3);
    for (int v = 0; v < points_.rows(); ++v) mesh.points.row(v) = limit_of(v).transpose();
    for (const auto& face : faces_) mesh.add_face(face);
    return mesh;
  }

 private:
  Edge& edge_of(int f, size_t i) {
    const Key k = key(faces_[f][i], faces_[f][(i + 1) % faces_[f].size()]);
    const auto [found, is_new] = number_.emplace(k, count_of(edges_));
    if (is_new) {
      edges_.push_back({k.first, k.second, {}, false});
      edges_at_[k.first].push_back(found->second);
      edges_at_[k.second].push_back(found->second);
    }
    return edges_[found->second];
  }
  int number(int a, int b) const { return number_.at(key(a, b)); }
  Vec3 at(int v) const { return points_.row(v).transpose(); }
  Vec3 centre(int f) const {
    Vec3 sum = Vec3::Zero();
    for (const int v : faces_[f]) sum += at(v);
    return sum / static_cast<double>(faces_[f].size());
  }
  Vec3 far_end(int e, int v) const {
    return at(edges_[e].low == v ? edges_[e].high : edges_[e].low);
  }

  /// (a + m v + b)/(m + 2) along sharp edges; nothing where a node has none.
  bool along_crease(int v, double m, Vec3& result) const {
    Vec3 ends = Vec3::Zero();
    int sharp = 0;
    for (const int e : edges_at_[v])
      if (edges_[e].sharp) {
        ends += far_end(e, v);
        ++sharp;
      }
    if (sharp == 0) return edges_at_[v].empty() && (result = at(v), true);
    const bool stays = sharp != 2 || faces_at_[v].size() == 1;
    result = stays ? at(v) : Vec3((ends + m * at(v)) / (m + 2));
    return true;
  }

  Vec3 moved(int v) const {
    Vec3 result;
    if (along_crease(v, 6, result)) return result;
    const double n = static_cast<double>(edges_at_[v].size());
    Vec3 sum = Vec3::Zero();
    for (const int e : edges_at_[v]) sum += far_end(e, v);
    for (const int f : faces_at_[v]) sum += centre(f);
    return at(v) * (n - 2) / n + sum / (n * n);
  }

  Vec3 limit_of(int v) const {
    Vec3 result;
    if (along_crease(v, 4, result)) return result;
    const double n = static_cast<double>(edges_at_[v].size());
    Vec3 sum = n * n * at(v);
    for (const int e : edges_at_[v]) sum += 4 * far_end(e, v);
    for (const int f : faces_at_[v]) {
      const auto& quad = faces_[f];
      sum += at(quad[(std::find(quad.begin(), quad.end(), v) - quad.begin() + 2) % 4]);
    }
    return sum / (n * (n + 5));
  }

  Points points_;
  std::vector<std::vector<int>> faces_;
  std::vector<Edge> edges_;
  std::map<Key, int> number_;
  std::vector<std::vector<int>> edges_at_, faces_at_;
};

void check(const ShellMesh& cage, const CatmullClarkOptions& options) {
  constexpr double most = 4e6;
  if (options.rounds < 1)
    throw InputError(std::to_string(options.rounds) + " rounds of subdivision, expected 1 or more");
  double quads = 0;
  for (int f = 0; f < cage.face_count(); ++f) quads += static_cast<double>(cage.corners(f).size());
  for (int k = 1; k < options.rounds && quads <= most; ++k) quads *= 4;
  if (quads > most)
    throw InputError(std::to_string(options.rounds) + " rounds of subdivision of " +
                     std::to_string(cage.face_count()) +
                     " faces are more than 4,000,000 quads, expected fewer rounds");
}

}  // namespace

ShellMesh catmull_clark(const ShellMesh& cage, const CatmullClarkOptions& options) {
  check(cage, options);
  std::vector<std::vector<int>> faces;
  for (int f = 0; f < cage.face_count(); ++f)
    faces.emplace_back(cage.corners(f).begin(), cage.corners(f).end());
  std::vector<Key> creases;
  for (const auto& [a, b] : options.creases) creases.push_back(key(a, b));
  Cage fine = Cage(cage.points, std::move(faces), creases).subdivided();
  for (int round = 1; round < options.rounds; ++round) fine = fine.subdivided();
  return fine.limit();
}

}  // namespace batten
