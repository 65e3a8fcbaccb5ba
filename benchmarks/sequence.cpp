// SPDX-License-Identifier: MPL-2.0
// Deforming meshes: the six sizes of the paper from keyframes to all frames, one alternating
// iteration, two threads compared with one, and library deformers with a factor per frame.
#include <cmath>
#include <fstream>
#include <numbers>

#include "batten/benchmarks/cgal_deform.h"
#include "batten/core/geometry.h"
#include "batten/mesh/sequence/sequence_editor.h"
#include "bench.h"

using namespace batten;
using namespace batten::bench;

namespace {

/// A closed body, sixteen times as long as thick, that bends back and forth.
struct Swimmer {
  int around, along;
  MeshSequence sequence;
  TriangleMesh mesh;
  FrameConstraints constraints;

  Swimmer(int triangles, int frames)
      : around(std::max(8, static_cast<int>(std::lround(std::sqrt(triangles / 7.0))))),
        along(triangles / 2 / around),
        mesh(straight()) {
    sequence.shells.points = mesh.points();
    for (const auto& t : mesh.triangles()) sequence.shells.add_face(t);
    for (int k = 0; k < frames; ++k) {
      sequence.frames.push_back(bent(0.8 * std::sin(2 * std::numbers::pi * k / 60)));
      sequence.times.push_back(k);
    }
    sequence.shells.points = sequence.frames.front();
    for (int h = 0; h < 4; ++h) {  // bands: both ends, and two between them
      Handle band{"band " + std::to_string(h + 1), {}};
      const int middle = h * (along - 3) / 3 + 1;
      for (int k = middle - 1; k <= middle + 1; ++k)
        for (int a = 0; a < around; ++a) band.vertices.push_back(k * around + a);
      constraints.handles.push_back(band);
    }
  }

  TriangleMesh straight() const {
    Points p(around * (along + 1) + 2, 3);
    std::vector<std::array<int, 3>> t;
    const int ends[2] = {around * (along + 1), around * (along + 1) + 1};
    for (int k = 0; k <= along; ++k)
      for (int a = 0; a < around; ++a) {
        const double angle = 2 * std::numbers::pi * a / around;
        p.row(k * around + a) << 32.0 * k / along, std::cos(angle), std::sin(angle);
      }
    p.row(ends[0]) << 0, 0, 0;
    p.row(ends[1]) << 32, 0, 0;
    for (int a = 0; a < around; ++a) {
      const int b = (a + 1) % around;
      for (int k = 0; k < along; ++k) {
        const int i = k * around + a, j = k * around + b;
        t.push_back({i, j, j + around});
        t.push_back({i, j + around, i + around});
      }
      t.push_back({ends[0], b, a});
      t.push_back({ends[1], along * around + a, along * around + b});
    }
    return TriangleMesh(std::move(p), std::move(t));
  }

  /// The axis as an arc of this curvature times its length.
  Points bent(double angle) const {
    Points p = mesh.points();
    const double radius = std::abs(angle) > 1e-9 ? 32 / angle : 0;
    for (long v = 0; v < p.rows(); ++v) {
      const double along_axis = p(v, 0), phi = angle * along_axis / 32;
      const double x = radius != 0 ? radius * std::sin(phi) : along_axis,
                   z = radius != 0 ? radius * (1 - std::cos(phi)) : 0;
      p.row(v) << x - p(v, 2) * std::sin(phi), p(v, 1), z + p(v, 2) * std::cos(phi);
    }
    return p;
  }

  /// The ends swing upwards and rotate, the middle stays: every tenth frame, as for the foot plants
  /// of four feet.
  std::vector<SequenceKeyframe> keyframes(const SequenceEditor& editor, int every) const {
    std::vector<SequenceKeyframe> keys;
    for (int k = 0; k < sequence.frame_count(); k += every) {
      SequenceKeyframe key{k, {}};
      for (size_t h = 0; h < constraints.handles.size(); ++h) {
        const double swing = std::sin(0.05 * k + 1.5 * static_cast<double>(h));
        const Vec3 c = editor.trajectories_before()[h].centres.row(k).transpose();
        key.handles.push_back(
            HandlePose{RigidMotion::about(c, rotation_matrix(Vec3(0, 0.15 * swing, 0.1)),
                                          c + Vec3(0, 1.5 * swing, 0.5 * swing)),
                       false});
      }
      keys.push_back(std::move(key));
    }
    return keys;
  }
};

double peak_gb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0) return std::stod(line.substr(6)) / 1e6;
  return 0;
}

struct Result {
  double set_up = 0, keyframes = 0, frames = 0, missed = 0, jerk = 0;
  double total() const { return set_up + keyframes + frames; }
};

Result edit(const Swimmer& s) {
  Result r;
  std::unique_ptr<SequenceEditor> editor;
  r.set_up = wall_seconds_of(
      [&] { editor = std::make_unique<SequenceEditor>(s.sequence, s.mesh, s.constraints); });
  r.keyframes = wall_seconds_of([&] { editor->set_keyframes(s.keyframes(*editor, 10)); });
  std::vector<Points> last;
  double jerk = 0;
  r.frames = wall_seconds_of([&] {
    editor->frames(0, s.sequence.frame_count() - 1, [&](int k, const Points& p) {
      for (size_t h = 0; h < s.constraints.handles.size(); ++h) {
        Vec3 c = Vec3::Zero();
        for (const int v : s.constraints.handles[h].vertices) c += p.row(v).transpose();
        c /= static_cast<double>(s.constraints.handles[h].vertices.size());
        r.missed = std::max(r.missed,
                            (c - editor->trajectories()[h].centres.row(k).transpose()).norm() / 32);
      }
      last.push_back(p);
      if (last.size() > 3) last.erase(last.begin());
      if (last.size() == 3)
        jerk = std::max(jerk, (last[2] - 2 * last[1] + last[0]).rowwise().norm().maxCoeff());
    });
  });
  const auto before = second_differences(s.sequence.frames);
  r.jerk = jerk / *std::max_element(before.begin(), before.end());
  return r;
}

void sizes(Checks& checks) {
  struct Size {
    const char* name;
    int triangles, frames;
    const char *precomputation, *solve;
  };
  const Size all[] = {
      {"box", 1664, 20, "1.3 s", "0.2 s"},        {"cloth", 5000, 87, "12 s", "6.15 s"},
      {"dinosaur", 8476, 154, "3 min", "28.1 s"}, {"dinosaur", 20000, 190, "22 min", "108.6 s"},
      {"frog", 23000, 187, "25 min", "201 s"},    {"horse", 29000, 420, "50 min", "30 min"}};
  Table table;
  table.add({"size of", "triangles", "frames", "set-up s", "keyframes s", "frames s", "total s",
             "peak GB", "2007: before", "solve"});
  Result last;
  double missed = 0;
  for (const Size& size : all) {
    const Swimmer s(size.triangles, size.frames);
    last = edit(s);
    missed = std::max(missed, last.missed);
    table.add({size.name, text("%d", s.mesh.triangle_count()), text("%d", size.frames),
               text("%.3f", last.set_up), text("%.3f", last.keyframes), text("%.3f", last.frames),
               text("%.2f", last.total()), text("%.2f", peak_gb()), size.precomputation,
               size.solve});
  }
  std::printf("Four handles prescribed at every tenth frame, %d threads\n", thread_count());
  table.print();
  checks.at_most("horse: total, seconds", last.total(), 30);
  checks.at_most("horse: peak memory, GB", peak_gb(), 1.5);
  checks.at_most("error of handles over the size", missed, 1e-12);
  checks.at_most("horse: largest second difference over the original", last.jerk, 1.5);
}

void threads(Checks& checks) {
  const Swimmer s(29000, 420);
  std::vector<double> ratios;
  double one = 0, two = 0;
  for (int round = 0; round < 3; ++round) {
    set_thread_count(1);
    one = edit(s).total();
    set_thread_count(2);
    two = edit(s).total();
    ratios.push_back(one / two);
  }
  set_thread_count(0);
  std::printf("horse: %.2f s on one thread, %.2f s on two\n\n", one, two);
  checks.at_least("one thread's time over two threads'", median(ratios), 1.6);
}

/// Ten iterations in every frame, as a library does that handles one mesh at a time.
void compare_iterations(Checks& checks) {
  one_thread();
  const Swimmer s(20000, 8);
  const int n = s.mesh.vertex_count();
  FrameOptions ten;
  ten.max_iterations = 10;
  ten.tolerance = 0;
  FrameSolver solver(s.mesh, s.constraints, ten);
  FrameOptions none = ten;
  none.max_iterations = 1;
  FrameSolver once(s.mesh, s.constraints, none);
  FrameTargets frame_targets;
  for (const auto& handle : s.constraints.handles) {
    const double swing = std::sin(1.5 * static_cast<double>(frame_targets.handles.size()));
    Vec3 c = Vec3::Zero();
    for (const int v : handle.vertices) c += s.mesh.point(v);
    c /= static_cast<double>(handle.vertices.size());
    frame_targets.handles.push_back(
        {RigidMotion::about(c, rotation_matrix(Vec3(0, 0.15 * swing, 0)), c + Vec3(0, swing, 0)),
         false});
  }
  std::vector<std::function<void()>> works{
      [&] { solver.alternate(s.mesh.points(), frame_targets); },
      [&] { once.alternate(s.mesh.points(), frame_targets); }};
  std::vector<std::string> names{"Batten, one factor for all frames"};
  std::vector<int> movable, controls;
  std::vector<char> held(n, 0);
  for (const auto& handle : s.constraints.handles)
    controls.insert(controls.end(), handle.vertices.begin(), handle.vertices.end());
  for (int v = 0; v < n; ++v) movable.push_back(v);
  Points targets(static_cast<long>(controls.size()), 3);
  long row = 0;
  for (size_t h = 0; h < s.constraints.handles.size(); ++h)
    for (const int v : s.constraints.handles[h].vertices)
      targets.row(row++) = frame_targets.handles[h].motion(s.mesh.point(v)).transpose();
  std::vector<std::shared_ptr<CgalDeform>> peers;
  const auto add_peer = [&](const char* name, CgalSolver kind) {
    const auto cgal = std::make_shared<CgalDeform>(CgalEnergy::Arap, kind, s.mesh.points(),
                                                   s.mesh.triangles(), movable, controls);
    works.emplace_back([cgal, &targets] {
      cgal->preprocess();
      cgal->edit(targets, 10);
    });
    names.emplace_back(name);
  };
  if (!cgal_version().empty()) add_peer("CGAL ARAP, SparseLU (default)", CgalSolver::SparseLu);
  if (!cgal_version().empty() && cgal_has(CgalSolver::Cholmod))
    add_peer("CGAL ARAP, CHOLMOD", CgalSolver::Cholmod);
  const auto times = side_by_side(7, works);
  const double round = (times[0] - times[1]) / 9;
  std::printf("%d vertices, one thread\n", n);
  Table table;
  table.add({"ten iterations of a frame", "ms", "ratio"});
  table.add({names[0], text("%.1f", 1e3 * times[0]), "1"});
  for (size_t w = 2; w < works.size(); ++w)
    table.add({names[w - 1] + ", one factor per frame", text("%.1f", 1e3 * times[w]),
               text("%.1f", times[w] / times[0])});
  table.print();
  const double fraction = 1e4 / n;
  std::printf("one iteration: %.2f ms; the paper: 30 ms on 10,000 vertices, 3.2 GHz Pentium\n\n",
              1e3 * round);
  checks.at_most("one iteration on 10,000 vertices, ms", 1e3 * round * fraction, 3);
  std::optional<double> slower;
  if (works.size() > 2) slower = times[2] / times[0];
  checks.at_least("CGAL with a factor per frame over Batten's time", slower, 3);
}

}  // namespace

int main() {
  set_thread_count(2);
  Checks checks;
  sizes(checks);
  threads(checks);
  compare_iterations(checks);
  checks.print("sequence");
  return 0;
}
