// SPDX-License-Identifier: MPL-2.0
// Morphing: blends, morphs, fits to other meshes; walks over terrain.
#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/mesh/sequence/morph.h"
#include "batten/mesh/triangle_mesh.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/reference_frame_solver.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten;
using namespace batten_test;

namespace {

/// A bar along x, twisted about y by an angle from end to end.
Points twisted(const Points& p, double angle) {
  Points q = p;
  const double bend = angle / 3 + 1e-9;
  for (int v = 0; v < p.rows(); ++v) {
    const double a = bend * p(v, 0), r = 1 / bend - p(v, 2);
    q.row(v) << r * std::sin(a), p(v, 1), 1 / bend - r * std::cos(a);
  }
  return q;
}

Vec3 mean_of(const Points& p) { return p.colwise().mean().transpose(); }

MeshSequence sequence_of(const TriangleMesh& mesh, std::vector<Points> frames, double step = 1) {
  MeshSequence s;
  for (const auto& t : mesh.triangles()) s.shells.add_face(t);
  s.frames = std::move(frames);
  s.shells.points = s.frames.front();
  for (size_t k = 0; k < s.frames.size(); ++k) s.times.push_back(step * static_cast<double>(k));
  return s;
}

/// Largest relative change of an edge.
double edge_change(const TriangleMesh& mesh, const Points& p, const Points& q) {
  double most = 0;
  for (const auto& [a, b] : node_edges(mesh))
    most =
        std::max(most, std::abs((q.row(a) - q.row(b)).norm() / (p.row(a) - p.row(b)).norm() - 1));
  return most;
}

/// Triangles whose normals oppose the mean of their neighbours.
int folds(const TriangleMesh& mesh, const Points& p) {
  const TriangleMesh now = mesh.with_points(p);
  int count = 0;
  for (int t = 0; t < now.triangle_count(); ++t) {
    Vec3 around = Vec3::Zero();
    for (int c = 0; c < 3; ++c)
      if (const int other = now.topology().across(t, c); other >= 0)
        around += now.area_vector(other);
    count += now.area_vector(t).dot(around) < 0;
  }
  return count;
}

}  // namespace

TEST_CASE("a blend begins and ends with its shapes", "[mesh][sequences]") {
  Random random(71);
  const TriangleMesh mesh = disjoint_union(bar(10, 2, 3, 0.6), sphere(2));
  const Points p = mesh.points();
  Points q = moved(random_motion(random), twisted(p, 1.5));
  for (int v = 0; v < q.rows(); ++v) q.row(v) += 0.02 * random.point().transpose();
  ShapeBlend blend(mesh);
  CHECK(distance(blend.blend(p, q, 0), p) < 1e-13);
  CHECK(distance(blend.blend(p, q, 1), q) < 1e-13);
  // The same from the other side, and on two threads.
  const Points half = blend.blend(p, q, 0.3);
  CHECK(distance(blend.blend(q, p, 0.7), half) < 1e-6);
  const ThreadGuard guard(2);
  CHECK(blend.blend(p, q, 0.3) == half);
  CHECK(!error_message([&] { blend.blend(p.topRows(3), q, 0.5); }).empty());
}

TEST_CASE("a turned copy is blended by turning", "[mesh][sequences]") {
  Random random(72);
  const TriangleMesh mesh = bar(12, 3, 3, 0.6);
  const Points p = moved({random_rotation_matrix(random), Vec3(1, 2, 3)}, mesh.points());
  ShapeBlend blend(mesh);
  for (const double angle : {0.5, 2.0, 3.1}) {
    const Vec3 log = to_rotation_vector(random.point(), angle), translation = random.point();
    const Vec3 c = mean_of(p);
    const Points q = moved(RigidMotion::about(c, rotation_matrix(log), c + translation), p);
    for (const double alpha : {0.25, 0.5, 0.9}) {
      const Points wanted =
          moved(RigidMotion::about(c, rotation_matrix(alpha * log), c + alpha * translation), p);
      CHECK(distance(blend.blend(p, q, alpha), wanted) < 1e-12);
    }
    CHECK(edge_change(mesh, p, blend.blend(p, q, 0.5)) < 1e-12);
    const Points linear = 0.5 * (p + q);
    CHECK((angle < 1 || edge_change(mesh, p, linear) > 0.3));
  }
}

TEST_CASE("a bar that winds by more than a half turn keeps its size half way",
          "[mesh][sequences]") {
  const TriangleMesh mesh = bar(40, 3, 3, 0.3);
  ShapeBlend blend(mesh);
  const Points p = mesh.points(), q = twisted(p, 5);
  for (const double alpha : {0.2, 0.5, 0.8}) {
    const Points v = blend.blend(p, q, alpha);
    CHECK(folds(mesh, v) == 0);
    const Points wanted = twisted(p, alpha * 5);
    // Compared up to a rigid motion: the centroid of the blend moves along a straight line.
    const Trajectory t =
        trajectory_of({wanted, v}, nodes_where(v, [](const Vec3&) { return true; }));
    const double apart =
        distance(moved(RigidMotion::about(mean_of(wanted), t.rotations[1], mean_of(v)), wanted), v);
    INFO("alpha " << alpha << ": " << apart << ", edges " << edge_change(mesh, wanted, v));
    CHECK(apart < 0.02);
    CHECK(edge_change(mesh, wanted, v) < 0.06);
  }
}

TEST_CASE("a morph is the source, then the blend, then the target", "[mesh][sequences]") {
  const TriangleMesh mesh = bar(10, 2, 3, 0.6);
  std::vector<Points> a, b;
  const RigidMotion apart{rotation_matrix(to_rotation_vector(Vec3::UnitZ(), 0.8)), Vec3(4, -3, 0)};
  for (int k = 0; k < 12; ++k) {
    Points p = twisted(mesh.points(), 0.4 + 0.05 * k), q = twisted(mesh.points(), 0.4 + 0.1 * k);
    p.col(0).array() += 0.1 * k;
    q.col(0).array() += 0.1 * k;
    a.push_back(p);
    b.push_back(moved(apart, q));
  }
  const MeshSequence source = sequence_of(mesh, a), target = sequence_of(mesh, b, 0.5);
  MorphOptions options;
  options.source = {3, 9};
  options.target = {0, 8};
  const MeshSequence result = morph(source, target, mesh, options);
  CHECK(ground_alignment(b[0], b[0], Vec3::UnitZ()).translation.norm() < 1e-13);
  const RigidMotion align = ground_alignment(b[0], a[3], Vec3::UnitZ());
  // b[0] is a[0]'s bar at another position; a[3] is twisted slightly more.
  CHECK(distance(ground_alignment(b[0], a[0], Vec3::UnitZ()), apart.inverse()) < 1e-12);
  CHECK(std::abs(align.rotation(2, 2) - 1) < 1e-14);
  const Points raised = b[0].rowwise() + Eigen::RowVector3d(0, 0, 0.7);
  CHECK(std::abs(ground_alignment(raised, a[0], Vec3::UnitZ()).translation.z()) < 1e-13);
  REQUIRE(result.frame_count() == 3 + 8 + 3);
  check(result, "morph");
  for (int k = 0; k <= 3; ++k) {
    CHECK(result.frames[k] == a[k]);
    CHECK(result.times[k] == k);
  }
  CHECK(result.times[10] == Approx(3 + (6 + 4) / 2.0));
  for (int k = 8; k < 12; ++k) {
    CHECK(distance(result.frames[k + 2], moved(align, b[k])) < 1e-12);
    CHECK(result.times[k + 2] == Approx(8 + 0.5 * (k - 8)));
  }
  for (const Points& p : result.frames) CHECK(folds(mesh, p) == 0);
  // With prescribed length and position.
  options.frames = 5;
  options.alignment = RigidMotion{Mat3::Identity(), Vec3(0, 0, 2)};
  const MeshSequence prescribed = morph(source, target, mesh, options);
  CHECK(prescribed.frame_count() == 3 + 5 + 3);
  CHECK(distance(prescribed.frames[7], (b[8].rowwise() + Eigen::RowVector3d(0, 0, 2)).eval()) <
        1e-13);

  const auto refused = [&](const MeshSequence& to, const MorphInterval& from,
                           const MorphInterval& until) {
    MorphOptions o;
    o.source = from, o.target = until;
    return error_message([&] { morph(source, to, mesh, o); });
  };
  CHECK(refused(target, {3, 9}, {0, 8}).empty());
  CHECK(refused(target, {3, 12}, {0, 8}).find("source") != std::string::npos);
  CHECK(refused(target, {3, 9}, {8, 8}).find("target") != std::string::npos);
  const TriangleMesh other = bar(10, 1, 3, 0.6);
  CHECK(refused(sequence_of(other, {other.points(), other.points()}), {3, 9}, {0, 1})
            .find("different faces") != std::string::npos);
}

TEST_CASE("the nearest point of a mesh is the nearest of all its triangles", "[mesh][sequences]") {
  const TriangleMesh mesh = sphere(2);
  const TriangleTree search(mesh);
  Random random(73);
  for (int k = 0; k < 300; ++k) {
    const Vec3 x = 2 * random.point();
    double least = 1e300, least_facing = 1e300;
    const Vec3 normal = random.point();
    for (int t = 0; t < mesh.triangle_count(); ++t) {
      // Alternating projections onto the triangle's barycentric range, compared with a fine grid
      // and the plane.
      const auto& c = mesh.triangles()[t];
      const Vec3 a = mesh.point(c[0]), b = mesh.point(c[1]) - a, d = mesh.point(c[2]) - a;
      Mat2 G;
      G << b.dot(b), b.dot(d), b.dot(d), d.dot(d);
      const Vec2 st = G.inverse() * Vec2(b.dot(x - a), d.dot(x - a));
      double distance = 1e300;
      if (st.minCoeff() >= 0 && st.sum() <= 1) distance = (a + st[0] * b + st[1] * d - x).norm();
      for (int e = 0; e < 3; ++e) {
        const Vec3 from = mesh.point(c[e]), along = mesh.point(c[(e + 1) % 3]) - from;
        const double s = std::clamp(along.dot(x - from) / along.squaredNorm(), 0.0, 1.0);
        distance = std::min(distance, (from + s * along - x).norm());
      }
      least = std::min(least, distance);
      if (mesh.area_vector(t).dot(normal) > 0) least_facing = std::min(least_facing, distance);
    }
    const auto found = search.nearest(x);
    REQUIRE(found);
    CHECK(found->distance == Approx(least).epsilon(1e-12));
    CHECK((found->at - x).norm() == Approx(least).epsilon(1e-12));
    Vec3 from_weights = Vec3::Zero();
    for (int c = 0; c < 3; ++c)
      from_weights += found->weights[c] * mesh.point(mesh.triangles()[found->triangle][c]);
    CHECK((from_weights - found->at).norm() < 1e-13);
    CHECK(search.nearest(x, normal)->distance == Approx(least_facing).epsilon(1e-12));
  }
  CHECK_FALSE(TriangleTree(flat_square(2, 0, 1)).nearest(Vec3::Zero(), Vec3(0, 0, -1)));
}

TEST_CASE("a mesh takes the shape of another one and follows it", "[mesh][sequences]") {
  // A bar onto an ellipsoid with another tessellation, rotated and translated.
  const TriangleMesh ball = sphere(3);
  Points shape = ball.points();
  for (int v = 0; v < shape.rows(); ++v) {
    const Vec3 x = ball.point(v);
    shape.row(v) = Vec3(1.5, 1, 1).cwiseProduct(x) * (1 + 0.1 * std::sin(3 * x.x()));
  }
  const RigidMotion there{rotation_matrix(Vec3(0.3, 0.2, -0.4)), Vec3(3, 1, 2)};
  const TriangleMesh target = ball.with_points(moved(there, shape));
  const TriangleMesh mesh = bar(12, 8, 2.4, 1.6);
  std::vector<LandmarkPair> landmarks;
  const TriangleTree search(ball.with_points(shape));
  for (const Vec3& d : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1),
                        Vec3(0, 0, -1)}) {
    int node = 0;
    (mesh.points().rowwise() - (Vec3(1.2, 0, 0) + Vec3(1.2, 0.8, 0.8).cwiseProduct(d)).transpose())
        .rowwise()
        .squaredNorm()
        .minCoeff(&node);
    // One of them away from its position by the shape alone.
    const Vec3 to = d.y() > 0 ? Vec3(0.4, 1, 0.3) : d;
    landmarks.push_back({node, there(search.nearest(Vec3(2, 1.2, 1.2).cwiseProduct(to))->at)});
  }
  const TargetFit fit = fit_to_target(mesh, target, landmarks);
  const double size = target.size();
  INFO("mean " << fit.mean_distance / size << ", largest " << fit.largest_distance / size
               << ", landmarks " << fit.landmark_distance / size << ", turned " << fit.inverted);
  CHECK(fit.mean_distance < 1e-3 * size);
  CHECK(fit.largest_distance < 1e-2 * size);
  CHECK(fit.landmark_distance < 1e-3 * size);
  CHECK(fit.inverted == 0);

  Random random(74);
  std::vector<Points> frames;
  std::vector<RigidMotion> motions;
  for (int k = 0; k < 5; ++k) {
    motions.push_back(k == 2 ? RigidMotion{} : random_motion(random));
    frames.push_back(moved(motions.back(), target.points()));
  }
  const MeshSequence moving = sequence_of(target, frames);
  ShellMesh shells;
  for (const auto& t : mesh.triangles()) shells.add_face(t);
  shells.points = mesh.points();
  const MeshSequence followed = transfer_target_motion(shells, fit.positions, moving, target, 2);
  REQUIRE(followed.frame_count() == 5);
  CHECK(followed.times == moving.times);
  for (int k = 0; k < 5; ++k)
    CHECK(distance(followed.frames[k], moved(motions[k], fit.positions)) < 1e-12);
  CHECK(!error_message([&] {
           transfer_target_motion(shells, fit.positions, moving, target, 5);
         }).empty());

  const auto refused = [&](std::vector<LandmarkPair> pairs, const TargetFitOptions& o = {}) {
    return error_message([&] { fit_to_target(mesh, target, pairs, o); });
  };
  CHECK(refused({landmarks[0], landmarks[1]}).find("three") != std::string::npos);
  auto wrong = landmarks;
  wrong[0].node = 100000;
  CHECK(refused(wrong).find("100000") != std::string::npos);
  CHECK(!refused(landmarks, {0}).empty());
  CHECK(!refused(landmarks, {8, 6, 1, 0.1}).empty());
}

TEST_CASE("a walk on the spot goes as far as the foot that stands", "[mesh][sequences]") {
  const TriangleMesh mesh = bar(8, 2, 1, 0.4);
  const std::vector<int> a = nodes_where(mesh.points(), [](const Vec3&x) { return x.x() < 0.01; }),
                         b = nodes_where(mesh.points(), [](const Vec3&x) { return x.x() > 0.99; });
  // Each foot is in contact half of the time and slides back by 0.25 per frame along x - y.
  const Vec3 along = Vec3(1, -1, 0).normalized();
  std::vector<Points> frames;
  for (int k = 0; k <= 16; ++k) {
    Points p = mesh.points();
    const auto put = [&](const std::vector<int>& foot, int phase) {
      phase = ((phase % 16) + 16) % 16;
      const bool stands = phase < 8;
      const double s = stands ? 1 - 0.25 * phase : -1 + 0.25 * (phase - 8);
      for (const int v : foot) p.row(v) += (s * along + Vec3(0, 0, stands ? 0 : 0.3)).transpose();
    };
    put(a, k), put(b, k + 8);
    frames.push_back(p);
  }
  CHECK(stance_speed(frames, {a, b}, along, Vec3::UnitZ()) == Approx(0.25).epsilon(1e-12));
  CHECK(stance_speed(frames, {a, b}, -along, Vec3::UnitZ()) == Approx(-0.25).epsilon(1e-12));
  const MeshSequence walk = sequence_of(mesh, frames, 0.04);
  const MeshSequence far = with_root_motion(walk, 3, along, 0.25);
  REQUIRE(far.frame_count() == 3 * 16 + 1);
  check(far, "far");
  for (int k = 0; k < far.frame_count(); ++k) {
    CHECK(distance(far.frames[k],
                   (frames[k % 16].rowwise() + (0.25 * k * along).transpose()).eval()) < 1e-13);
    CHECK(far.times[k] == Approx(0.04 * k));
    // The foot in contact does not slide.
    if (k % 16 < 7 && k + 1 < far.frame_count()) {
      CHECK((centroid(far.frames[k], a) - centroid(far.frames[k + 1], a)).norm() < 1e-13);
    }
  }
  // Open: all frames in every cycle.
  frames.pop_back();
  CHECK(with_root_motion(sequence_of(mesh, frames), 3, along, 0.25).frame_count() == 48);
  CHECK(!error_message([&] { with_root_motion(walk, 0, along, 1); }).empty());
  CHECK(!error_message([&] {
           with_root_motion(sequence_of(mesh, {frames[0]}), 2, along, 1);
         }).empty());
  CHECK(!error_message([&] { stance_speed({frames[0]}, {a}, along, Vec3::UnitZ()); }).empty());
  CHECK(!error_message([&] { stance_speed(frames, {}, along, Vec3::UnitZ()); }).empty());
}
