// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/lines/mesh_neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/corners/corners.h"
#include "batten/fairing/curves/curve_fit.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

// Flags of the faces that belong to one of the named sets or properties of a mesh file.
std::vector<char> faces_of(const MeshFile& file, const std::vector<std::string>& names) {
  std::vector<char> in(static_cast<size_t>(file.shells().face_count()), 0);
  for (const std::string& name : names) {
    bool found = false;
    std::vector<std::string> known;
    for (const auto* list : {&file.sets(), &file.properties()})
      for (const MeshSet& set : *list) {
        if (set.faces.empty()) continue;
        known.push_back(set.name);
        if (set.name != name) continue;
        found = true;
        for (const int f : set.faces) in[f] = 1;
      }
    if (!found)
      throw InputError(
          "found no face set '" + name + "', expected " +
          (known.empty() ? "a mesh with face sets" : "one of: " + comma_separated(known)));
  }
  return in;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + isize(values) / 2, values.end());
  return values[values.size() / 2];
}

// Low-pass filter 2 S - S² of values at the vertices of a loop, with S = B^rounds, where B has the
// weights (1/4, 1/2, 1/4): a smooth loop with edges h shrinks by O(h⁴) only.
template <class Value>
std::vector<Value> filtered(const std::vector<Value>& values, int rounds) {
  const size_t count = values.size();
  const auto average = [&](std::vector<Value> all) {
    for (int round = 0; round < rounds; ++round) {
      const std::vector<Value> old = all;
      for (size_t i = 0; i < count; ++i)
        all[i] = (old[(i + count - 1) % count] + 2 * old[i] + old[(i + 1) % count]) / 4;
    }
    return all;
  };
  std::vector<Value> once = average(values);
  const std::vector<Value> twice = average(once);
  for (size_t i = 0; i < count; ++i) once[i] = 2 * once[i] - twice[i];
  return once;
}

// A closed polygon.
class Loop {
 public:
  explicit Loop(std::vector<Vec3> points) : points_(std::move(points)) {}
  int count() const { return isize(points_); }
  const Vec3& point(int i) const {
    return points_[static_cast<size_t>((i % count() + count()) % count())];
  }

  // Sum of the angles between consecutive edges, degrees.
  double total_turning_deg() const {
    double sum = 0;
    for (int i = 0; i < count(); ++i)
      sum += degrees_between(point(i) - point(i - 1), point(i + 1) - point(i));
    return sum;
  }

  // Median distance of a point from the cubic through the two points on each side.
  double fourth_difference() const {
    std::vector<double> all;
    for (int i = 0; i < count(); ++i)
      all.push_back(
          (point(i) - (4 * (point(i - 1) + point(i + 1)) - point(i - 2) - point(i + 2)) / 6)
              .norm());
    return median(std::move(all));
  }

  Loop smoothed(int rounds) const { return Loop(filtered(points_, rounds)); }

 private:
  std::vector<Vec3> points_;
};

// Number of rounds of Loop::smoothed() that remove the zigzag of a loop, such as the rim of a hole in
// a scan; 0: it has none. Filtering reduces the sum of the turning angles of a zigzag by many turns,
// and hardly that of a curve with corners. `noisy`: takes the largest number of rounds that hardly
// changes the size of the loop.
int rounds_against_zigzag(const Loop& loop, bool noisy) {
  constexpr int fewest = 12, first = 4;
  constexpr double most_turning = 720, same_turning = 60;  // degrees
  // The filter shrinks a circle of n vertices by less than 1 %.
  constexpr double most_rounds = 0.01;  // times n²
  const int most = static_cast<int>(most_rounds * loop.count() * loop.count());
  if (loop.count() < fewest) return 0;
  double turning = loop.smoothed(std::min(first, most)).total_turning_deg();
  if (loop.total_turning_deg() - turning < most_turning) return 0;
  int rounds = first;
  while (2 * rounds <= most) {
    rounds *= 2;
    const double before = std::exchange(turning, loop.smoothed(rounds).total_turning_deg());
    if (before - turning < same_turning) break;
  }
  constexpr int smoother = 4;
  return noisy ? most : std::min(smoother * rounds, most);
}

// Fits curves to one boundary loop.
class BoundaryCurves {
 public:
  BoundaryCurves(const TriangleMesh& mesh, const MeshBoundary& boundary)
      : surface_(boundary), count_(isize(boundary.vertices)) {
    for (const int v : boundary.vertices) points_.push_back(mesh.point(v));
    const double h = boundary.length / count_;
    const Loop loop(points_);
    constexpr double least_noise = 0.005;
    const bool noisy = boundary.noise > least_noise * h;
    if (const int rounds = rounds_against_zigzag(loop, noisy)) {
      constexpr double of_edge = 0.02;
      tolerance_ = of_edge * h;
      accuracy_ = std::max(tolerance_, boundary.noise);
      place_on_surface(loop.smoothed(rounds), noisy ? rounds : 0);
      return;
    }
    constexpr double exact = 0.01, rough = 0.1, of_noise = 1.5, corner_angle = 50;
    tolerance_ = std::clamp(of_noise * loop.fourth_difference(), exact * h, rough * h);
    accuracy_ = tolerance_;
    corners_ = find_corners(points_, true, corner_angle);
  }

  // Appends the curves to `faces`, and their names to `opening`.
  void add_to(NeighbourFaces& faces, NeighbourOpening& opening) const {
    faces.accuracy = std::max(faces.accuracy, accuracy_);
    if (corners_.empty()) return add(0, count_, faces, opening);
    for (size_t k = 0; k < corners_.size(); ++k)
      add(corners_[k], k + 1 < corners_.size() ? corners_[k + 1] : corners_.front() + count_, faces,
          opening);
  }

 private:
  // Moves the loop to `smooth`, projected onto the weighted means of the quadratics fitted at nearby
  // vertices. `noise_rounds`: rounds of the filter for the distances of this projection and the angles
  // of the normals around the loop.
  void place_on_surface(const Loop& smooth, int noise_rounds) {
    constexpr std::array<double, 9> weights{1, 8, 28, 56, 70, 56, 28, 8, 1};  // binomial
    constexpr int half = isize(weights) / 2;
    MeshBoundary placed = surface_;
    std::vector<double> heights;
    for (int i = 0; i < count_; ++i) {
      const auto mean = [&](const auto& of) {
        auto sum = (0 * of(i)).eval();
        for (int k = -half; k <= half; ++k)
          sum += weights[k + half] / 256 * of((i + k + half * count_) % count_);
        return sum;
      };
      const Vec3 x = mean([&](int k) -> Vec3 { return on_surface(k, smooth.point(i)); });
      placed.normals[i] = mean([&](int k) -> Vec3 { return normal_at(k, x); }).normalized();
      placed.curvatures[i] = mean([&](int k) -> Mat3 { return surface_.curvatures[k]; });
      heights.push_back((x - smooth.point(i)).dot(placed.normals[i]));
    }
    heights = filtered(heights, noise_rounds);
    for (int i = 0; i < count_; ++i) points_[i] = smooth.point(i) + heights[i] * placed.normals[i];
    placed.points = points_;
    placed.normals = filtered_normals(placed.normals, noise_rounds);
    surface_ = std::move(placed);
  }

  // Filters the angles around the loop between normals and slowly varying normals.
  std::vector<Vec3> filtered_normals(std::vector<Vec3> normals, int rounds) const {
    const std::vector<Vec3> slow = filtered(normals, rounds);
    const auto tangent = [&](int i) {
      return (points_[(i + 1) % count_] - points_[(i + count_ - 1) % count_]).normalized();
    };
    const auto slow_normal = [&](int i) {
      return (slow[i] - slow[i].dot(tangent(i)) * tangent(i)).normalized();
    };
    std::vector<double> angles;
    for (int i = 0; i < count_; ++i)
      angles.push_back(std::atan2(tangent(i).dot(slow_normal(i).cross(normals[i])),
                                  slow_normal(i).dot(normals[i])));
    angles = filtered(angles, rounds);
    for (int i = 0; i < count_; ++i)
      normals[i] = Eigen::AngleAxisd(angles[i], tangent(i)) * slow_normal(i);
    return normals;
  }

  // Offset of x from the fitted surface's point i, along the tangent plane there.
  Vec3 tangential(int i, const Vec3& x) const {
    const Vec3 d = x - surface_.points[i], &n = surface_.normals[i];
    return d - d.dot(n) * n;
  }

  // Projection along the normal onto the quadratic fitted at vertex i.
  Vec3 on_surface(int i, const Vec3& x) const {
    const Vec3 d = tangential(i, x);
    return surface_.points[i] + d + d.dot(surface_.curvatures[i] * d) / 2 * surface_.normals[i];
  }

  // Normal at x of the quadratic fitted at vertex i.
  Vec3 normal_at(int i, const Vec3& x) const {
    return (surface_.normals[i] - surface_.curvatures[i] * tangential(i, x)).normalized();
  }

  void add(int first, int last, NeighbourFaces& faces, NeighbourOpening& opening) const {
    const std::string name = "edge" + std::to_string(faces.lines.size() + 1);
    std::vector<Vec3> points;
    for (int i = first; i <= last; ++i) points.push_back(points_[i % count_]);
    FitOptions options;
    options.tolerance = tolerance_;
    options.corners.emplace();
    options.closed = corners_.empty();
    const CurveFit fit = fit_points(name, points, options);
    NeighbourCurve neighbour;
    neighbour.name = "mesh";
    const int samples = std::clamp(8 * (last - first), 400, 8000);
    const std::vector<double>& u = fit.parameters;
    const double end = fit.curve.end();
    for (int k = 0; k <= samples; ++k) {
      const double at = end * k / samples;
      neighbour.samples.push_back(sample(fit.curve, u, at, first));
    }
    faces.lines.push_back({name, curve_from_hermite(fit.curve), CharacterLine::Role::Outline});
    faces.neighbours.push_back(std::move(neighbour));
    opening.lines.push_back(name);
  }

  // The surface at parameter `at` of a curve; `u`: parameters of its points, from vertex `first`.
  NeighbourSample sample(const HermiteCurve& curve, const std::vector<double>& u, double at,
                         int first) const {
    auto next = static_cast<int>(std::upper_bound(u.begin(), u.end(), at) - u.begin());
    next = std::clamp(next, 1, isize(u) - 1);
    const double span = u[next] - u[next - 1];
    const double t = span > 0 ? std::clamp((at - u[next - 1]) / span, 0.0, 1.0) : 0.5;
    const int a = (first + next - 1) % count_, b = (first + next) % count_;
    const Vec3 tangent = curve.evaluate(at, 1);
    const Vec3 x = curve.evaluate(at);
    const Vec3 normal = (1 - t) * normal_at(a, x) + t * normal_at(b, x);
    const Mat3 curvature = (1 - t) * surface_.curvatures[a] + t * surface_.curvatures[b];
    const Vec3 into = normal.cross(tangent).normalized();
    return {x, into, into.dot(curvature * into) * tangent.cross(into).normalized()};
  }

  MeshBoundary surface_;
  int count_;
  std::vector<Vec3> points_;
  std::vector<int> corners_;
  double tolerance_ = 0, accuracy_ = 0;
};

}  // namespace

MeshNeighbour read_mesh_neighbour(const std::filesystem::path& path,
                                  const std::vector<std::string>& only,
                                  const std::vector<std::string>& without) {
  const MeshFile file = MeshFile::read(path);
  const ShellMesh& all = file.shells();
  std::vector<char> keep = faces_of(file, only);
  if (only.empty()) keep.assign(keep.size(), 1);
  const std::vector<char> removed = faces_of(file, without);
  ShellMesh shells;
  shells.points = all.points;
  std::vector<int> number(keep.size(), -1);
  for (int f = 0; f < all.face_count(); ++f)
    if (keep[f] && !removed[f]) {
      number[f] = shells.face_count();
      shells.add_face(all.face(f), all.second_order(f));
    }
  if (shells.face_count() == 0)
    throw InputError("found no face that is not left out, expected the faces beside an opening");
  std::vector<MeshSet> sets;
  for (const auto* list : {&file.sets(), &file.properties()})
    for (const MeshSet& set : *list) {
      MeshSet rest = set;
      rest.faces.clear();
      for (const int f : set.faces)
        if (number[f] >= 0) rest.faces.push_back(number[f]);
      if (!rest.faces.empty() || !rest.nodes.empty()) sets.push_back(std::move(rest));
    }
  PreparedMesh prepared = prepare(shells);
  std::vector<MeshBoundary> boundaries = mesh_boundaries(prepared.mesh);
  return {std::move(shells), std::move(sets), std::move(prepared), std::move(boundaries)};
}

NeighbourFaces mesh_neighbour_faces(const MeshNeighbour& mesh) {
  NeighbourFaces faces;
  faces.faces = mesh.shells.face_count();
  faces.size = mesh.prepared.mesh.size();
  for (const MeshBoundary& boundary : mesh.boundaries) {
    NeighbourOpening& opening = faces.openings.emplace_back();
    opening.faces = {"mesh"};
    opening.length = boundary.length;
    opening.edge_length = boundary.length / isize(boundary.vertices);
    opening.centre = boundary.centre;
    opening.turning_deg = boundary.turning_deg;
    opening.component = boundary.component;
    BoundaryCurves(mesh.prepared.mesh, boundary).add_to(faces, opening);
  }
  find_outer_boundaries(faces.openings);
  return faces;
}

}  // namespace batten
