// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/sequence/morph.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/fem/curves/cubic.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/sequence/local_global_steps.h"
#include "batten/mesh/sequence/trajectories/keyframe_weights.h"
#include "batten/mesh/triangle_mesh.h"

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
    // One node of each component is fixed to make the matrix regular; centre() then sets the
    // centroid.
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

  // Orders the nodes such that each one, except the first of a component, follows a neighbour.
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
      throw InputError("found shapes of " + std::to_string(p.rows()) + " and " +
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

  // Shifts each component so that its displacement from the linear blend has zero mean.
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
  double along = 0, across = 0;  // cosine and sine of the best rotation angle, times a squared
                                 // length
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

/// Positions at parameter t of an interval.
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
                     std::to_string(interval.last + 1) + ", expected two frames of 1 to " +
                     std::to_string(sequence.frame_count()));
}

MeshSequence morph(const MeshSequence& source, const MeshSequence& target, const TriangleMesh& mesh,
                   const MorphOptions& options, const Progress& progress) {
  if (!same_faces(source.shells, target.shells))
    throw InputError("source and target of a morph have different faces: " +
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
    const double t = static_cast<double>(k) / (count - 1), alpha = smooth_step(t);
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

namespace {

constexpr double kLandmarkWeight = 1000;  // relative to the mean weight at a node

class NonRigidRegistration {
 public:
  NonRigidRegistration(const TriangleMesh& mesh, const TriangleMesh& target,
                       const std::vector<LandmarkPair>& landmarks)
      : mesh_(mesh),
        target_(target),
        search_(target),
        landmarks_(landmarks),
        graph_(node_graph(mesh.topology())),
        mean_weight_(2.0 * static_cast<double>(graph_.edges.size()) / std::max(1, graph_.nodes)),
        rotations_(graph_.nodes, Mat3::Identity()),
        nearest_(graph_.nodes) {
    p_ = loads_ = RowPoints::Zero(graph_.nodes, 3);
  }

  void check_landmarks() const {
    if (landmarks_.size() < 3)
      throw InputError("found " + std::to_string(landmarks_.size()) +
                       " landmarks, expected three or more");
    for (const auto& l : landmarks_) {
      if (l.node < 0 || l.node >= graph_.nodes)
        throw InputError("found a landmark at node " + std::to_string(l.node) + ", expected 0 to " +
                         std::to_string(graph_.nodes - 1));
      if (!l.at.allFinite()) throw InputError("a landmark is not finite");
    }
    if (mesh_.triangle_count() == 0 || target_.triangle_count() == 0)
      throw InputError("fit to a target: the mesh or the target has no triangles");
  }

  void start_with_landmarks() {
    const auto count = static_cast<long>(landmarks_.size());
    Points from(count, 3), to(count, 3);
    std::vector<int> all;
    for (long k = 0; k < count; ++k) {
      from.row(k) = mesh_.points().row(landmarks_[k].node);
      to.row(k) = landmarks_[k].at.transpose();
      all.push_back(static_cast<int>(k));
    }
    const Similarity s = fit_similarity(from, to, all);
    for (int v = 0; v < graph_.nodes; ++v)
      p_.row(v) = (s.scale * (s.R * mesh_.point(v)) + s.translation).transpose();
    now_ = p_;
  }

  void stage(double penalty_weight, int iterations) {
    p_ = now_;
    const double mu = penalty_weight * mean_weight_, lambda = kLandmarkWeight * mean_weight_;
    VecX at_node = VecX::Constant(graph_.nodes, mu);
    for (const auto& l : landmarks_) at_node[l.node] = lambda;
    factorize(at_node);
    for (int iteration = 0; iteration < iterations; ++iteration) {
      local_step(graph_, p_, now_, {}, rotations_, sums_);
      find_nearest();
      global_step_rhs(graph_, p_, rotations_, loads_);
      for (int v = 0; v < graph_.nodes; ++v)
        if (nearest_[v]) loads_.row(v) += at_node[v] * (nearest_[v]->transpose() - p_.row(v));
      // If no part of the target faces a node, its weight attracts it to its current position.
      for (int v = 0; v < graph_.nodes; ++v)
        if (!nearest_[v]) loads_.row(v) += at_node[v] * (now_.row(v) - p_.row(v));
      x_ = loads_;
      factor_.solve_in_place(x_);
      now_ = p_ + x_;
    }
  }

  TargetFit result() {
    TargetFit fit;
    fit.positions = now_;
    find_nearest(false);
    double sum = 0;
    for (int v = 0; v < graph_.nodes; ++v) {
      const double d = nearest_[v] ? (nearest_[v]->transpose() - now_.row(v)).norm() : 0;
      sum += d / std::max(1, graph_.nodes);
      fit.largest_distance = std::max(fit.largest_distance, d);
    }
    fit.mean_distance = sum;
    for (const auto& l : landmarks_)
      fit.landmark_distance =
          std::max(fit.landmark_distance, (now_.row(l.node) - l.at.transpose()).norm());
    const TriangleMesh fitted = with_nodes(now_);
    for (int t = 0; t < fitted.triangle_count(); ++t) {
      Vec3 centre = Vec3::Zero();
      for (const int v : fitted.triangles()[t]) centre += fitted.point(v) / 3;
      const auto found = search_.nearest(centre);
      if (found && target_.area_vector(found->triangle).dot(fitted.area_vector(t)) < 0)
        ++fit.inverted;
    }
    return fit;
  }

 private:
  void factorize(const VecX& at_node) {
    std::vector<Triplet> entries = laplacian_entries(graph_);
    for (int v = 0; v < graph_.nodes; ++v) entries.emplace_back(v, v, at_node[v]);
    SparseMatrix K(graph_.nodes, graph_.nodes);
    K.setFromTriplets(entries.begin(), entries.end());
    if (!analysed_) factor_.analyze(K, FactorReuse::many);
    analysed_ = true;
    if (!factor_.factorize(K)) throw NoSolutionError("fit to a target: " + factor_.message());
  }

  TriangleMesh with_nodes(const RowPoints& nodes) const {
    Points all(mesh_.vertex_count(), 3);
    for (int v = 0; v < mesh_.vertex_count(); ++v)
      all.row(v) = nodes.row(mesh_.topology().node_of(v));
    return mesh_.with_points(std::move(all));
  }

  void find_nearest(bool facing = true) {
    const TriangleMesh now = with_nodes(now_);
    std::vector<Vec3> normals(graph_.nodes, Vec3::Zero());
    for (int t = 0; t < now.triangle_count(); ++t)
      for (const int v : now.triangles()[t])
        normals[mesh_.topology().node_of(v)] += now.area_vector(t);
    parallel_for_each<64>(graph_.nodes, [&](int v) {
      const auto found = search_.nearest(now_.row(v).transpose(),
                                         facing ? std::optional<Vec3>(normals[v]) : std::nullopt);
      nearest_[v] = found ? std::optional<Vec3>(found->at) : std::nullopt;
    });
    if (facing)
      for (const auto& l : landmarks_) nearest_[l.node] = l.at;
  }

  const TriangleMesh& mesh_;
  const TriangleMesh& target_;
  TriangleTree search_;
  const std::vector<LandmarkPair>& landmarks_;
  NodeGraph graph_;
  double mean_weight_;
  SparseCholesky factor_;
  bool analysed_ = false;
  RowPoints p_, now_, loads_;
  MatX x_;
  std::vector<Mat3> rotations_;
  std::vector<double> sums_;
  std::vector<std::optional<Vec3>> nearest_;
};

}  // namespace

TargetFit fit_to_target(const TriangleMesh& mesh, const TriangleMesh& target,
                        const std::vector<LandmarkPair>& landmarks, const TargetFitOptions& options,
                        const Progress& progress) {
  if (options.stages < 1 || options.iterations < 1 || !(options.initial_weight > 0) ||
      !(options.final_weight >= options.initial_weight))
    throw InputError(
        "fit to a target: expected stages, iterations and weights above 0, with final_weight >= "
        "initial_weight");
  NonRigidRegistration fit(mesh, target, landmarks);
  fit.check_landmarks();
  fit.start_with_landmarks();
  const double growth = options.final_weight / options.initial_weight;
  for (int s = 0; s < options.stages; ++s) {
    progress.update("fit", static_cast<double>(s) / options.stages);
    const double f = options.stages > 1 ? static_cast<double>(s) / (options.stages - 1) : 1;
    fit.stage(options.initial_weight * std::pow(growth, f), options.iterations);
  }
  return fit.result();
}

MeshSequence transfer_target_motion(const ShellMesh& shells, const Points& fitted,
                                    const MeshSequence& target, const TriangleMesh& target_mesh,
                                    int frame) {
  if (frame < 0 || frame >= target.frame_count() || fitted.rows() != shells.node_count())
    throw InputError("found a fit to frame " + std::to_string(frame + 1) + " with " +
                     std::to_string(fitted.rows()) + " nodes, expected a frame of 1 to " +
                     std::to_string(target.frame_count()) + " and " +
                     std::to_string(shells.node_count()) + " nodes");
  const MeshTopology& topology = target_mesh.topology();
  const auto at_frame = [&](const Points& nodes) {
    Points all(topology.vertex_count(), 3);
    for (int v = 0; v < topology.vertex_count(); ++v) all.row(v) = nodes.row(topology.node_of(v));
    return target_mesh.with_points(std::move(all));
  };
  const TriangleMesh there = at_frame(target.frames[frame]);
  const TriangleTree search(there);
  struct SurfaceBinding {
    std::array<int, 3> corners;
    Vec3 weights, offset;  // offset: the remaining distance in the axes of the triangle
  };
  // Columns: a unit vector along an edge, one across it, and the normal.
  const auto axes = [](const TriangleMesh& mesh, const std::array<int, 3>& t) {
    Mat3 A;
    A.col(0) = (mesh.point(t[1]) - mesh.point(t[0])).normalized();
    A.col(2) = (mesh.point(t[1]) - mesh.point(t[0]))
                   .cross(mesh.point(t[2]) - mesh.point(t[0]))
                   .normalized();
    A.col(1) = A.col(2).cross(A.col(0));
    return A;
  };
  std::vector<SurfaceBinding> bindings(fitted.rows());
  parallel_for_each<64>(static_cast<int>(fitted.rows()), [&](int v) {
    const auto found = search.nearest(fitted.row(v).transpose());
    const auto& t = there.triangles()[found->triangle];
    bindings[v] = {t, found->weights,
                   axes(there, t).transpose() * (fitted.row(v).transpose() - found->at)};
  });
  MeshSequence result;
  result.shells = shells;
  result.times = target.times;
  for (const Points& nodes : target.frames) {
    const TriangleMesh now = at_frame(nodes);
    Points p(fitted.rows(), 3);
    parallel_for_each<512>(static_cast<int>(p.rows()), [&](int v) {
      const SurfaceBinding& binding = bindings[v];
      Vec3 at = axes(now, binding.corners) * binding.offset;
      for (int k = 0; k < 3; ++k) at += binding.weights[k] * now.point(binding.corners[k]);
      p.row(v) = at.transpose();
    });
    result.frames.push_back(std::move(p));
  }
  result.shells.points = result.frames.front();
  return result;
}

namespace {

/// Six times the enclosed volume of a closed mesh, negative if its faces point inwards; 0 for an
/// open mesh.
double six_times_volume(const TriangleMesh& mesh) {
  if (!mesh.topology().boundary_loops().empty()) return 0;
  const Eigen::RowVector3d middle = mesh.points().colwise().mean();
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles()) {
    const Vec3 p = mesh.points().row(a) - middle, q = mesh.points().row(b) - middle,
               r = mesh.points().row(c) - middle;
    sum += p.dot(q.cross(r));
  }
  return sum;
}

/// The mesh with all faces reversed.
ShellMesh with_reversed_faces(const ShellMesh& shells) {
  ShellMesh result;
  result.points = shells.points;
  for (int f = 0; f < shells.face_count(); ++f) {
    std::vector<int> face(shells.corners(f).begin(), shells.corners(f).end());
    std::ranges::reverse(face);
    result.add_face(face);
  }
  return result;
}

}  // namespace

RegisteredTarget registered_target(const MeshSequence& source, const TriangleMesh& mesh,
                                   int source_frame, const MeshSequence& target, int target_frame,
                                   const std::vector<MorphLandmark>& landmarks,
                                   const TargetFitOptions& options, const Progress& progress) {
  if (source_frame < 0 || source_frame >= source.frame_count() || target_frame < 0 ||
      target_frame >= target.frame_count())
    throw InputError("found a registration of frame " + std::to_string(source_frame + 1) +
                     " to frame " + std::to_string(target_frame + 1) +
                     ", expected frames of 1 to " + std::to_string(source.frame_count()) +
                     " and of 1 to " + std::to_string(target.frame_count()));
  const Points& ours = source.frames[source_frame];
  ShellMesh shells = target.shells;
  shells.points = target.frames[target_frame];
  TriangleMesh target_mesh = prepare(shells).mesh;
  Points vertices(mesh.vertex_count(), 3);
  for (int v = 0; v < vertices.rows(); ++v) vertices.row(v) = ours.row(mesh.topology().node_of(v));
  const TriangleMesh our_mesh = mesh.with_points(std::move(vertices));
  if (six_times_volume(our_mesh) * six_times_volume(target_mesh) < 0)
    target_mesh = prepare(with_reversed_faces(shells)).mesh;
  std::vector<LandmarkPair> pairs;
  for (const MorphLandmark& l : landmarks) {
    int node = 0;
    (ours.rowwise() - l.from.transpose()).rowwise().squaredNorm().minCoeff(&node);
    pairs.push_back({node, l.to});
  }
  RegisteredTarget result;
  result.fit = fit_to_target(our_mesh, target_mesh, pairs, options, progress);
  result.target_size = target_mesh.size();
  result.sequence = transfer_target_motion(source.shells, result.fit.positions, target, target_mesh,
                                           target_frame);
  return result;
}

}  // namespace batten
