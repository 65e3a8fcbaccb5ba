// SPDX-License-Identifier: MPL-2.0
// Edits of all frames: unchanged and moved parts.
#include "batten/mesh/sequence/sequence_editor.h"

#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/reference_frame_solver.h"
#include "batten/tests/support/thread_guard.h"

using namespace batten;
using namespace batten_test;

namespace {

/// A bar that bends back and forth while it moves forward.
struct Moving {
  TriangleMesh mesh;
  MeshSequence sequence;
  std::vector<int> left, right;

  explicit Moving(int frames, const TriangleMesh& bar_mesh = bar(14, 3, 3, 0.6))
      : mesh(bar_mesh),
        left(nodes_where(mesh.points(), [](const Vec3& x) { return x.x() < 0.01; })),
        right(nodes_where(mesh.points(), [](const Vec3& x) { return x.x() > 2.99; })) {
    for (int k = 0; k < frames; ++k) {
      sequence.frames.push_back(at(k));
      sequence.times.push_back(k);
    }
    for (const auto& t : mesh.triangles()) sequence.shells.add_face(t);
    sequence.shells.points = sequence.frames.front();
    mesh = mesh.with_points(sequence.frames.front());
  }
  Points at(int k) const {
    Points p = mesh.points();
    const double bend = 0.5 * std::sin(0.35 * k) + 1e-3;
    for (int v = 0; v < p.rows(); ++v) {
      const double a = bend * (p(v, 0) - 1.5), r = 1 / bend - p(v, 2);
      p.row(v) << 1.5 + r * std::sin(a) + 0.1 * k, p(v, 1), 1 / bend - r * std::cos(a);
    }
    return p;
  }
  FrameConstraints constraints() const {
    FrameConstraints h;
    h.handles = {{"left", left}, {"right", right}};
    return h;
  }
  /// A rigid motion of a handle about its centroid in a frame.
  HandlePose pose(const std::vector<int>& handle, int frame, const Vec3& log,
                  const Vec3& translation) const {
    const Vec3 c = centroid(sequence.frames[frame], handle);
    return {RigidMotion::about(c, rotation_matrix(log), c + translation), false};
  }
  SequenceKeyframe lifted(int frame, double height = 0.5, double angle = 0.3) const {
    return {frame,
            {HandlePose{},
             pose(right, frame, to_rotation_vector(Vec3(0, 1, 0.2), angle), Vec3(0, 0, height))}};
  }
};

double size_of_jump(const std::vector<Points>& frames, int first, int last) {
  const auto second = second_differences(frames);
  return *std::max_element(second.begin() + first, second.begin() + last + 1);
}

double largest(const std::vector<Points>& a, const std::vector<Points>& b) {
  double most = a.size() == b.size() ? 0 : 1e300;
  for (size_t k = 0; k < a.size() && k < b.size(); ++k) most = std::max(most, distance(a[k], b[k]));
  return most;
}

std::vector<Points> edited_by(const Moving& m, std::vector<SequenceKeyframe> keys,
                              const SequenceEditOptions& options = {}) {
  SequenceEditor editor(m.sequence, m.mesh, m.constraints(), options);
  editor.set_keyframes(std::move(keys));
  return editor.frames();
}

}  // namespace

TEST_CASE("no keyframes change no bit, keyframes that change nothing change nothing",
          "[mesh][sequences]") {
  const Moving m(12);
  CHECK(edited_by(m, {}) == m.sequence.frames);
  const SequenceKeyframe still{5, {HandlePose{}, HandlePose{}}}, more{9, {{}, HandlePose{}}};
  const double one = largest(edited_by(m, {still}), m.sequence.frames),
               two = largest(edited_by(m, {more, still}), m.sequence.frames);
  INFO("one " << one << ", two " << two);
  CHECK(one < 1e-13);
  CHECK(two < 1e-13);
}

TEST_CASE("one rigid motion of all handles moves all frames by it", "[mesh][sequences]") {
  Random random(61);
  const Moving m(12);
  for (int k = 0; k < 3; ++k) {
    const RigidMotion motion = random_motion(random);
    std::vector<Points> wanted;
    for (const Points& p : m.sequence.frames) wanted.push_back(moved(motion, p));
    std::vector<SequenceKeyframe> keys;
    for (int f = 0; f < 12; ++f) keys.push_back({f, {HandlePose{motion}, HandlePose{motion}}});
    const double every = largest(edited_by(m, keys), wanted),
                 one = largest(edited_by(m, {keys[4]}), wanted);
    INFO("every frame " << every << ", one " << one);
    CHECK(every < 1e-12);
    CHECK(one < 1e-12);
  }
}

TEST_CASE("frames outside of the influence keep their bits, parts of the frames are the whole's",
          "[mesh][sequences]") {
  const Moving m(20);
  SequenceEditOptions options;
  options.influence = {4, 14};
  SequenceEditor editor(m.sequence, m.mesh, m.constraints(), options);
  editor.set_keyframes({m.lifted(9)});
  const std::vector<Points> all = editor.frames();
  for (int k = 0; k < 20; ++k) {
    if (k <= 4 || k >= 14)
      CHECK(all[k] == m.sequence.frames[k]);
    else
      CHECK(distance(all[k], m.sequence.frames[k]) > 1e-4);
  }
  CHECK(distance(all[9], editor.keyframe_positions()[0]) < 1e-4 * m.mesh.size());
  int next = 6;
  editor.frames(6, 13, [&](int k, const Points& p) {
    CHECK(k == next++);
    CHECK(p == all[k]);
  });
  CHECK(next == 14);
  const ThreadGuard guard(2);
  SequenceEditor other(m.sequence, m.mesh, m.constraints(), options);
  other.set_keyframes({m.lifted(9)});
  CHECK(other.frames() == all);
}

TEST_CASE("a twist at one keyframe goes through all frames of a bar that bends",
          "[mesh][sequences]") {
  const Moving m(16);
  const double pi = std::numbers::pi;
  for (const auto smoothness :
       {TrajectoryOptions::Smoothness::Smooth, TrajectoryOptions::Smoothness::PiecewiseLinear}) {
    const Vec3 axis =
        centroid(m.sequence.frames[7], m.right) - centroid(m.sequence.frames[7], m.left);
    const SequenceKeyframe twist{
        7,
        {HandlePose{}, m.pose(m.right, 7, to_rotation_vector(axis, 150 * pi / 180), Vec3::Zero())}};
    SequenceEditOptions options;
    options.trajectories = smoothness;
    options.frames.max_iterations = 400;
    SequenceEditor editor(m.sequence, m.mesh, m.constraints(), options);
    editor.set_keyframes({twist});
    const auto frames = editor.frames();
    double at_key = 0;
    for (const auto& [a, b] : node_edges(m.mesh)) {
      const Points &p = m.sequence.frames[7], &q = editor.keyframe_positions()[0];
      at_key += std::abs((q.row(a) - q.row(b)).norm() / (p.row(a) - p.row(b)).norm() - 1) /
                static_cast<double>(node_edges(m.mesh).size());
    }
    double change = 0, mean = 0, shape = 0;
    long count = 0;
    for (int k = 0; k < 16; ++k) {
      shape = std::max({shape, bent(m.sequence.frames[k], frames[k], m.right),
                        bent(m.sequence.frames[k], frames[k], m.left)});
      for (const auto& [a, b] : node_edges(m.mesh)) {
        const double was = (m.sequence.frames[k].row(a) - m.sequence.frames[k].row(b)).norm(),
                     is = (frames[k].row(a) - frames[k].row(b)).norm();
        change = std::max(change, std::abs(is / was - 1));
        mean += std::abs(is / was - 1);
        ++count;
      }
      // The far end has rotated by 150° relative to the near one, in addition to the motion of the
      // sequence.
      const auto rotation = [&](const std::vector<int>& handle) {
        return trajectory_of({m.sequence.frames[k], frames[k]}, handle).rotations[1];
      };
      const Eigen::AngleAxisd apart(rotation(m.left).transpose() * rotation(m.right));
      CHECK(apart.angle() == Approx(150 * pi / 180).epsilon(1e-6));
    }
    INFO("handles bent " << shape << ", edges " << change << ", mean " << mean / count
                         << ", at the keyframe " << at_key);
    CHECK(shape < 1e-12);
    CHECK(change < 0.5);
    CHECK(mean / count < 1.35 * at_key);
  }
}

TEST_CASE("an edit brings no jerks", "[mesh][sequences]") {
  const Moving m(40);
  const double before = size_of_jump(m.sequence.frames, 1, 38);
  const auto one = edited_by(m, {m.lifted(20, 0.3, 0.2)});
  INFO("before " << before << ", one keyframe " << size_of_jump(one, 1, 38));
  CHECK(size_of_jump(one, 1, 38) <= 1.5 * before);
  SequenceEditOptions options;
  options.influence = {5, 35};
  const auto some = edited_by(
      m, {m.lifted(12, 0.2, 0.1), m.lifted(20, 0.4, 0.2), m.lifted(28, 0.3, 0.1)}, options);
  INFO("three with influence " << size_of_jump(some, 7, 33));
  CHECK(size_of_jump(some, 7, 33) <= 1.5 * before);
}

TEST_CASE("keyframes come to the same shapes from every start", "[mesh][sequences]") {
  const Moving m(24);
  std::vector<SequenceKeyframe> keys;
  for (int k = 4; k < 20; k += 2) keys.push_back(m.lifted(k, 0.3 + 0.01 * k));
  SequenceEditOptions options;
  options.frames.tolerance = 1e-8;
  options.frames.max_iterations = 2000;
  const auto handles = edited_by(m, keys, options);
  options.start = SequenceEditOptions::Start::Neighbour;
  const double neighbour = largest(edited_by(m, keys, options), handles);
  INFO("neighbour " << neighbour);
  CHECK(neighbour < 1e-4);
  options.start = SequenceEditOptions::Start::Subspace;
  options.control.vertices = 60;
  double subspace = 0;
  try {
    subspace = largest(edited_by(m, keys, options), handles);
  } catch (const InputError&) {
    return;  // a build without CGAL
  }
  INFO("subspace " << subspace);
  CHECK(subspace < 1e-4);
}

TEST_CASE("handles without a keyframe follow, features stay rigid in every frame",
          "[mesh][sequences]") {
  const Moving m(12);
  FrameConstraints constraints = m.constraints();
  constraints.features = {{"middle", nodes_where(bar(14, 3, 3, 0.6).points(), [](const Vec3& x) {
                             return std::abs(x.x() - 1.5) < 0.25;
                           })}};
  SequenceEditor editor(m.sequence, m.mesh, constraints);
  SequenceKeyframe key = m.lifted(6);
  key.handles[0].reset();
  editor.set_keyframes({key, m.lifted(9)});
  const auto frames = editor.frames();
  // A single prescribed handle moves the whole bar.
  const RigidMotion motion = key.handles[1]->motion;
  CHECK(distance(editor.keyframe_positions()[0], moved(motion, m.sequence.frames[6])) < 1e-9);
  CHECK(distance(frames[6], editor.keyframe_positions()[0]) < 1e-9);
  // An estimated rotation at a keyframe is that of the handle.
  SequenceKeyframe free = m.lifted(6);
  free.handles[1]->free_rotation = true;
  SequenceEditor finds(m.sequence, m.mesh, constraints);
  finds.set_keyframes({free});
  std::vector<Points> at_key;
  finds.frames(6, 6, [&](int, const Points& p) { at_key.push_back(p); });
  for (const int v : m.right)
    CHECK((at_key[0].row(v) - finds.keyframe_positions()[0].row(v)).norm() < 1e-12);
  CHECK(distance(at_key[0], finds.keyframe_positions()[0]) < 1e-4);
  for (int k = 0; k < 12; ++k) {
    CHECK(bent(m.sequence.frames[k], frames[k], constraints.features[0].vertices) < 1e-12);
    for (size_t h = 0; h < 2; ++h)
      CHECK((centroid(frames[k], constraints.handles[h].vertices) -
             Vec3(editor.trajectories()[h].centres.row(k)))
                .norm() < 1e-12);
  }
  CHECK((editor.trajectories_before()[1].centres.row(6) - editor.trajectories()[1].centres.row(6))
            .norm() > 0.4);
}

TEST_CASE("an editor refuses keyframes that cannot be", "[mesh][sequences]") {
  const Moving m(8);
  SequenceEditOptions options;
  options.influence = {2, 6};
  SequenceEditor editor(m.sequence, m.mesh, m.constraints(), options);
  const auto refused = [&](std::vector<SequenceKeyframe> keys) {
    return error_message([&] { editor.set_keyframes(std::move(keys)); });
  };
  const SequenceKeyframe key = m.lifted(4);
  CHECK(refused({key}).empty());
  CHECK(refused({{8, key.handles}}).find("frame 9") != std::string::npos);
  CHECK(!refused({{-1, key.handles}}).empty());
  CHECK(refused({key, key}).find("two keyframes at frame 5") != std::string::npos);
  CHECK(refused({{4, {HandlePose{}}}}).find("expected 2") != std::string::npos);
  CHECK(refused({{4, {{}, {}}}}).find("prescribes no handle") != std::string::npos);
  CHECK(!refused({{1, key.handles}}).empty());
  // After a rejected edit the sequence is unchanged.
  CHECK(editor.frames() == m.sequence.frames);
  CHECK(!error_message([&] { editor.frames(3, 8, [](int, const Points&) {}); }).empty());
  CHECK(!error_message([&] { editor.frames(-1, 3, [](int, const Points&) {}); }).empty());
  FrameConstraints nothing = m.constraints();
  nothing.handles[1].vertices = {};
  CHECK(!error_message([&] { SequenceEditor(m.sequence, m.mesh, nothing); }).empty());
  nothing.handles[1].vertices = {100000};
  CHECK(!error_message([&] { SequenceEditor(m.sequence, m.mesh, nothing); }).empty());
}
