// SPDX-License-Identifier: MPL-2.0
// Registration of a mesh to a target surface: springs that slide, and bending without bias at
// boundaries.
#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/editing/target_follower.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/mesh_models.h"

using namespace batten;
using namespace batten_test;

namespace {

/// The plane z = slope x + 10.
ClosestTargetPoint tilted_plane(double slope) {
  const Vec3 normal = Vec3(-slope, 0, 1).normalized();
  return [normal](const Vec3& p, const Vec3& along) -> std::optional<TargetPoint> {
    if (along.dot(normal) < 0) return std::nullopt;
    return TargetPoint{p - (p - Vec3(0, 0, 10)).dot(normal) * normal, normal, false};
  };
}

/// The shape after some iterations of the springs.
Points follow(const TriangleMesh& mesh, DeformProblem::Bending bending,
              const TargetFollower& follower, int iterations) {
  DeformProblem problem;
  problem.bending = bending;
  problem.rows = follower.springs("target", problem.weighting);
  FormFeatureDeformer deformer(mesh, problem);
  Points shape = mesh.points();
  for (int k = 0; k < iterations; ++k) {
    DeformEdit edit;
    edit.targets = follower.closest_points(shape);
    shape = deformer.deform(edit);
  }
  return shape;
}

std::vector<int> all_vertices(const TriangleMesh& mesh) {
  std::vector<int> all;
  for (int v = 0; v < mesh.vertex_count(); ++v) all.push_back(v);
  return all;
}

}  // namespace

TEST_CASE("a flat plate follows a tilted plane exactly, also at its boundary", "[mesh][target]") {
  const PreparedMesh plate = prepare(plate_with_holes().shells);
  const TriangleMesh& mesh = plate.mesh;
  const double slope = GENERATE(0.02, -0.4);
  const TargetFollower follower(mesh, all_vertices(mesh), tilted_plane(slope),
                                {.smoothing = 60, .reach = 500});
  const auto off = [&](const Points& shape) { return follower.distance(shape).largest; };
  CHECK(off(mesh.points()) > 9);
  CHECK(off(follow(mesh, DeformProblem::Bending::Hinges, follower, 60)) < 1e-6);
  // The Laplacian of boundary vertices resists the slope across the boundary.
  CHECK(off(follow(mesh, DeformProblem::Bending::Laplacian, follower, 60)) > 0.1);
}

TEST_CASE("affine displacements of a flat mesh cost no bending", "[mesh][target]") {
  const PreparedMesh plate = prepare(plate_with_holes().shells);
  DeformProblem problem;
  problem.bending = DeformProblem::Bending::Hinges;
  for (int v = 0; v < plate.mesh.vertex_count(); ++v)
    if (plate.mesh.point(v).x() == 0) problem.fixed.push_back(v);
  problem.weighting = GENERATE(DeformProblem::Weighting::Area, DeformProblem::Weighting::Uniform);
  FormFeatureDeformer deformer(plate.mesh, problem);
  const auto matrices = deformer.problem_matrices({});
  const auto k = static_cast<long>(matrices.vertices.size());
  MatX affine(k, 4), bent(k, 1);
  for (long i = 0; i < k; ++i) {
    const Vec3 p = plate.mesh.point(matrices.vertices[static_cast<size_t>(i)]);
    affine.row(i) << 1, p.x() / 300, p.y() / 300, p.x() / 150 - p.y() / 100;
    bent(i, 0) = p.x() * p.x() / 2;  // second derivative 1
  }
  const double scale = (matrices.A * bent).norm();
  CHECK((matrices.A * affine).norm() < 1e-10 * scale);
  if (problem.weighting == DeformProblem::Weighting::Area) {
    // The energy of a cylinder is about that of the Laplacian, κ² times the area.
    double area = 0;
    for (int t = 0; t < plate.mesh.triangle_count(); ++t)
      area += plate.mesh.area_vector(t).norm() / 2;
    CHECK(scale * scale == Approx(area).epsilon(0.1));
  }
}

TEST_CASE("vertices beyond the target have no springs", "[mesh][target]") {
  const PreparedMesh plate = prepare(plate_with_holes().shells);
  const TriangleMesh& mesh = plate.mesh;
  const auto all = tilted_plane(0);
  const ClosestTargetPoint half = [&](const Vec3& p, const Vec3& along) {
    auto found = all(p, along);
    if (found && p.x() > 150) found->at_boundary = true;
    return found;
  };
  const TargetFollower follower(mesh, all_vertices(mesh), half);
  const TargetDistance distance = follower.distance(mesh.points());
  int beyond = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) beyond += mesh.point(v).x() > 150;
  CHECK(distance.ignored == beyond);
  CHECK(distance.vertices + beyond == mesh.vertex_count());
  CHECK(distance.rms == Approx(10));
  // With the orientation of the target reversed, and an offset on the side of its normals.
  const ClosestTargetPoint reversed = [&](const Vec3& p, const Vec3& along) {
    auto found = all(p, Vec3(-along));
    if (found) found->normal *= -1;
    return found;
  };
  const TargetFollower other(mesh, all_vertices(mesh), reversed, {.offset = 10});
  CHECK(other.distance(mesh.points()).largest < 1e-12);
  CHECK(error_message([&] {
          TargetFollower(mesh, all_vertices(mesh), all, {.reach = 9});
        }).find("check its unit and position") != std::string::npos);
}
