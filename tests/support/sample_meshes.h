// SPDX-License-Identifier: MPL-2.0
// Triangle meshes with known properties, and a reader for real ones.
#pragma once

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"
#include "batten/mesh/triangle_mesh.h"
#include "batten/tests/support/sampling.h"

namespace batten_test {

/// Largest difference of a coordinate, relative to the size of the expected points.
inline double relative(const Points& found, const Points& expected) {
  return (found - expected).cwiseAbs().maxCoeff() /
         (expected.colwise().maxCoeff() - expected.colwise().minCoeff()).norm();
}

/// n×n×2 triangles of the unit square with random diagonals, inner vertices moved by up to `jitter`
/// of the spacing. Vertex (i, j) has the number j (n+1) + i.
inline TriangleMesh flat_square(int n, double jitter, unsigned seed) {
  Random random(seed);
  Points p((n + 1) * (n + 1), 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      Vec3 at(i, j, 0);
      if (i > 0 && i < n && j > 0 && j < n) at += jitter * Vec3(random(), random(), 0);
      p.row(j * (n + 1) + i) = at / n;
    }
  std::vector<std::array<int, 3>> triangles;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      if (random() < 0) {
        triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
      } else {
        triangles.insert(triangles.end(), {{a, b, d}, {b, c, d}});
      }
    }
  return {p, triangles};
}

/// n×n squares of a curved sheet over [0, 4]² with alternating diagonals and displaced inner
/// vertices. Vertex (i, j) has the number j (n+1) + i.
inline TriangleMesh sheet(int n, double height = 0.4, double jitter = 0.15) {
  Random random(7);
  Points points((n + 1) * (n + 1), 3);
  std::vector<std::array<int, 3>> triangles;
  const double h = 4.0 / n;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = h * (i + (i > 0 && i < n ? jitter * random() : 0));
      const double y = h * (j + (j > 0 && j < n ? jitter * random() : 0));
      points.row(j * (n + 1) + i) << x, y, height * std::sin(x) * std::cos(0.7 * y);
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      if ((i + j) % 2) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
      } else {
        triangles.push_back({a, b, d});
        triangles.push_back({b, c, d});
      }
    }
  return TriangleMesh(points, triangles);
}

/// Surface of revolution: a profile (r, z), from outside to inside, about the z axis in n steps,
/// with normals up. A last point with r = 0 closes it, otherwise there is a hole. Ring k has the
/// vertices kn … kn + n-1.
inline TriangleMesh revolved_profile(const std::vector<Vec2>& profile, int n) {
  const bool closed = profile.back().x() == 0;
  const int rings = static_cast<int>(profile.size()) - (closed ? 1 : 0);
  Points p(rings * n + (closed ? 1 : 0), 3);
  for (int k = 0; k < rings; ++k)
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      p.row(k * n + i) << profile[k].x() * std::cos(angle), profile[k].x() * std::sin(angle),
          profile[k].y();
    }
  if (closed) p.row(rings * n) << 0, 0, profile.back().y();
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    for (int k = 0; k + 1 < rings; ++k) {
      const int a = k * n + i, b = k * n + next, c = a + n, d = b + n;
      triangles.insert(triangles.end(), {{a, b, d}, {a, d, c}});
    }
    if (closed) triangles.push_back({(rings - 1) * n + i, (rings - 1) * n + next, rings * n});
  }
  return {p, triangles};
}

/// Points of a profile through the given ones, with segments of about `h`.
inline std::vector<Vec2> subdivided(const std::vector<Vec2>& corners, double h) {
  std::vector<Vec2> result = {corners[0]};
  for (size_t i = 1; i < corners.size(); ++i) {
    const int pieces =
        std::max(1, static_cast<int>((corners[i] - corners[i - 1]).norm() / h + 0.5));
    for (int k = 1; k <= pieces; ++k)
      result.push_back(corners[i - 1] + (corners[i] - corners[i - 1]) * k / pieces);
    result.back() = corners[i];
  }
  return result;
}

/// The unit sphere: an icosahedron with triangles quartered `levels` times.
inline TriangleMesh sphere(int levels) {
  const double g = std::numbers::phi;
  std::vector<Vec3> p = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                         {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<int, 3>> triangles = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [at, is_new] = middle.emplace(std::minmax(a, b), static_cast<int>(p.size()));
      if (is_new) p.push_back(0.5 * (p[a] + p[b]));
      return at->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
    for (Vec3& at : p) at.normalize();
  }
  Points points(static_cast<int>(p.size()), 3);
  for (size_t i = 0; i < p.size(); ++i) points.row(static_cast<int>(i)) = p[i].normalized();
  return {points, triangles};
}

/// Both meshes in one, disconnected.
inline TriangleMesh disjoint_union(const TriangleMesh& a, const TriangleMesh& b) {
  Points p(a.vertex_count() + b.vertex_count(), 3);
  p << a.points(), b.points();
  auto triangles = a.triangles();
  for (auto t : b.triangles()) {
    for (int& v : t) v += a.vertex_count();
    triangles.push_back(t);
  }
  return {p, triangles};
}

/// Faces of an OBJ or OFF file, ignoring names, groups and normals.
inline ShellMesh read_shells(const std::string& path) {
  std::ifstream in(path);
  std::vector<Vec3> p;
  ShellMesh shells;
  std::string line, word;
  const bool off = path.ends_with(".off");
  int nodes = 0, faces = 0;
  if (off) in >> word >> nodes >> faces >> word;
  for (Vec3 at; nodes > 0 && in >> at.x() >> at.y() >> at.z(); --nodes) p.push_back(at);
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::vector<int> face;
    int k = 0;
    Vec3 at;
    if (off ? bool(words >> k) : (words >> word && word == "f")) {
      for (int v; words >> v; words.ignore(off ? 0 : 32, ' ')) face.push_back(off ? v : v - 1);
      if (!face.empty()) shells.add_face(face);
    } else if (!off && word == "v" && words >> at.x() >> at.y() >> at.z()) {
      p.push_back(at);
    }
    word.clear();
  }
  shells.points.resize(static_cast<int>(p.size()), 3);
  for (size_t i = 0; i < p.size(); ++i) shells.points.row(static_cast<int>(i)) = p[i].transpose();
  return shells;
}

}  // namespace batten_test
