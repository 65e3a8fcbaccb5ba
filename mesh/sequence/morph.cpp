#include "batten/mesh/sequence/morph.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "batten/core/disjoint_sets.h"
#include "batten/core/errors.h"
#include "batten/core/parallel_chunks.h"
#include "batten/core/rotations.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/mesh/sequence/keyframe_weights.h"
#include "batten/mesh/sequence/local_global_steps.h"

namespace batten {

struct ShapeBlend::Data {
  explicit Data(const TriangleMesh& mesh) : graph(node_graph(mesh.topology())) {
    const int n = graph.nodes;
    DisjointSets groups(n);
    for (const auto& e : graph.edges) groups.unite(e.a, e.b);
    component.resize(n);
    for (int v = 0; v < n; ++v) component[v] = groups.find(v);
    find_breadth_first_order();
    std::vector<Triplet> entries = laplacian_entries(graph);
    // One node of each component is tied to its place, which the centroid then overrides.
    for (int v = 0; v < n; ++v)
      if (component[v] == v) entries.emplace_back(v, v, 1.0);
    SparseMatrix K(n, n);
    K.setFromTriplets(entries.begin(), entries.end());
    factor.analyze(K);
    if (n > 0 && !factor.factorize(K)) throw NoSolutionError("morph: " + factor.message());
    P = Q = RowPoints::Zero(n, 3);
    loads = loads_from_target = P;
    rotations.assign(n, Mat3::Identity());
    part = rest = rotations;
  }

  // Nodes in an order in which each but the first of a component follows a neighbour.
  void find_breadth_first_order() {
    std::vector<char> seen(graph.nodes, 0);
    std::queue<int> next;
    for (int v = 0; v < graph.nodes; ++v) {
      if (component[v] != v) continue;
      seen[v] = 1;
      breadth_first_order.push_back({v, -1});
      next.push(v);
      while (!next.empty()) {
        const int i = next.front();
        next.pop();
        for (const int j : graph.neighbours(i))
          if (!seen[j]) {
            seen[j] = 1;
            breadth_first_order.push_back({j, i});
            next.push(j);
          }
      }
    }
  }

  const Points& blend(const Points& p, const Points& q, double alpha) {
    const int n = graph.nodes;
    if (p.rows() != n || q.rows() != n)
      throw InputError("shapes of " + std::to_string(p.rows()) + " and " +
                       std::to_string(q.rows()) + " nodes, expected " + std::to_string(n));
    P = p, Q = q;
    local_step(graph, P, Q, {}, rotations, sums);
    logs.resize(n);
    for (const auto& [v, from] : breadth_first_order)
      logs[v] = from < 0 ? to_rotation_vector(rotations[v]) : nearest_log(rotations[v], logs[from]);
    parallel_for_each<512>(n, [&](int v) {
      part[v] = rotation_matrix(alpha * logs[v]);
      rest[v] = rotation_matrix((alpha - 1) * logs[v]);
    });
    global_step_rhs(graph, P, part, loads);
    global_step_rhs(graph, Q, rest, loads_from_target);
    x = (1 - alpha) * loads + alpha * loads_from_target;
    if (n > 0) factor.solve_in_place(x);
    centre();
    result = (1 - alpha) * p + alpha * q + x;
    if (!result.allFinite()) throw NoSolutionError("morph: positions are not finite");
    return result;
  }

  // The displacement from the straight blend has no mean in any component.
  void centre() {
    std::vector<Vec3> sum(graph.nodes, Vec3::Zero());
    std::vector<int> count(graph.nodes, 0);
    for (int v = 0; v < graph.nodes; ++v) {
      sum[component[v]] += x.row(v).transpose();
      ++count[component[v]];
    }
    for (int v = 0; v < graph.nodes; ++v)
      x.row(v) -= sum[component[v]].transpose() / count[component[v]];
  }

  NodeGraph graph;
  std::vector<int> component;
  struct Step {
    int node, from;
  };
  std::vector<Step> breadth_first_order;
  SparseCholesky factor;
  RowPoints P, Q, loads, loads_from_target;
  std::vector<Mat3> rotations, part, rest;
  std::vector<Vec3> logs;
  std::vector<double> sums;
  MatX x;
  Points result;
};

ShapeBlend::ShapeBlend(const TriangleMesh& mesh) : data_(std::make_unique<Data>(mesh)) {}
ShapeBlend::~ShapeBlend() = default;
ShapeBlend::ShapeBlend(ShapeBlend&&) noexcept = default;
ShapeBlend& ShapeBlend::operator=(ShapeBlend&&) noexcept = default;
const Points& ShapeBlend::blend(const Points& p, const Points& q, double alpha) {
  return data_->blend(p, q, alpha);
}

RigidMotion ground_alignment(const Points& q, const Points& p, const Vec3& up) {
  const Vec3 n = up.normalized(), a = n.unitOrthogonal(), b = n.cross(a);
  const Vec3 cq = q.colwise().mean(), cp = p.colwise().mean();
  double along = 0, across = 0;  // cosine and sine of the turn that fits best, times a length²
  for (long v = 0; v < q.rows(); ++v) {
    const Vec3 u = q.row(v).transpose() - cq, w = p.row(v).transpose() - cp;
    along += u.dot(a) * w.dot(a) + u.dot(b) * w.dot(b);
    across += u.dot(a) * w.dot(b) - u.dot(b) * w.dot(a);
  }
  const double angle = std::atan2(across, along);
  const Vec3 translation = cp - cq;
  return RigidMotion::about(cq, Eigen::AngleAxisd(angle, n).toRotationMatrix(),
                            cq + translation - n * n.dot(translation));
}

namespace {

/// Positions and time at t of an interval.
Points sample(const MeshSequence& s, const MorphInterval& interval, double t) {
  const double from = s.times[interval.first], to = s.times[interval.last];
  const double time = from + t * (to - from);
  const auto after = std::upper_bound(s.times.begin(), s.times.end(), time);
  const int k =
      std::clamp(static_cast<int>(after - s.times.begin()) - 1, interval.first, interval.last - 1);
  const double f = std::clamp((time - s.times[k]) / (s.times[k + 1] - s.times[k]), 0.0, 1.0);
  if (f == 0) return s.frames[k];
  if (f == 1) return s.frames[k + 1];
  return (1 - f) * s.frames[k] + f * s.frames[k + 1];
}

bool same_faces(const ShellMesh& a, const ShellMesh& b) {
  if (a.node_count() != b.node_count() || a.face_count() != b.face_count()) return false;
  for (int f = 0; f < a.face_count(); ++f)
    if (!std::ranges::equal(a.face(f), b.face(f))) return false;
  return true;
}

}  // namespace

void check(const MorphInterval& interval, const MeshSequence& sequence, const char* which) {
  if (interval.first < 0 || interval.last <= interval.first ||
      interval.last >= sequence.frame_count())
    throw InputError(std::string("the interval of the ") + which + " is frames " +
                     std::to_string(interval.first + 1) + " to " +
                     std::to_string(interval.last + 1) + ", expected two of 1 to " +
                     std::to_string(sequence.frame_count()));
}

MeshSequence morph(const MeshSequence& source, const MeshSequence& target, const TriangleMesh& mesh,
                   const MorphOptions& options, const Progress& progress) {
  if (!same_faces(source.shells, target.shells))
    throw InputError("source and target of a morph have other faces: " +
                     std::to_string(source.shells.face_count()) + " and " +
                     std::to_string(target.shells.face_count()) + "; fit one to the other first");
  check(options.source, source, "source");
  check(options.target, target, "target");
  const RigidMotion align = options.alignment
                                ? *options.alignment
                                : ground_alignment(target.frames[options.target.first],
                                                   source.frames[options.source.first], options.up);
  const double source_duration =
                   source.times[options.source.last] - source.times[options.source.first],
               target_duration =
                   target.times[options.target.last] - target.times[options.target.first],
               duration = (source_duration + target_duration) / 2;
  const int count = options.frames > 0 ? std::max(2, options.frames)
                                       : (options.source.last - options.source.first +
                                          options.target.last - options.target.first + 1) /
                                                 2 +
                                             1;
  MeshSequence result;
  result.shells = source.shells;
  for (int k = 0; k < options.source.first; ++k) {
    result.frames.push_back(source.frames[k]);
    result.times.push_back(source.times[k]);
  }
  ShapeBlend blend(mesh);
  const double start = source.times[options.source.first];
  for (int k = 0; k < count; ++k) {
    progress.update("morph", static_cast<double>(k) / count);
    const double t = static_cast<double>(k) / (count - 1), alpha = t * t * (3 - 2 * t);
    const Points p = sample(source, options.source, t),
                 q = moved(align, sample(target, options.target, t));
    result.frames.push_back(k == 0 ? p : k == count - 1 ? q : blend.blend(p, q, alpha));
    result.times.push_back(start + t * duration);
  }
  const double later = start + duration - target.times[options.target.last];
  for (int k = options.target.last + 1; k < target.frame_count(); ++k) {
    result.frames.push_back(moved(align, target.frames[k]));
    result.times.push_back(target.times[k] + later);
  }
  return result;
}

}  // namespace batten
