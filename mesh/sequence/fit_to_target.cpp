#include "batten/mesh/sequence/fit_to_target.h"

#include <algorithm>
#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/parallel_chunks.h"
#include "batten/core/sparse_cholesky.h"
#include "batten/mesh/aabb_tree.h"
#include "batten/mesh/deform/similarity.h"
#include "batten/mesh/sequence/local_global_steps.h"

namespace batten {
namespace {

constexpr double kLandmarkWeight = 1000;  // of the mean weight at a node

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
      throw InputError(std::to_string(landmarks_.size()) + " landmarks, expected three or more");
    for (const auto& l : landmarks_) {
      if (l.node < 0 || l.node >= graph_.nodes)
        throw InputError("a landmark at node " + std::to_string(l.node) + ", which is not there");
      if (!l.at.allFinite()) throw InputError("a landmark that is not finite");
    }
    if (mesh_.triangle_count() == 0 || target_.triangle_count() == 0)
      throw InputError("a fit needs triangles on both sides");
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
      // Where nothing of the target faces a node, its weight pulls it to where it is.
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
  AabbTree search_;
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
    throw InputError("a fit needs stages, rounds and weights that ascend from above 0");
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
    throw InputError("a fit at " + std::to_string(frame + 1) + " of " +
                     std::to_string(target.frame_count()) + " frames, with " +
                     std::to_string(fitted.rows()) + " of " + std::to_string(shells.node_count()) +
                     " nodes");
  const MeshTopology& topology = target_mesh.topology();
  const auto at_frame = [&](const Points& nodes) {
    Points all(topology.vertex_count(), 3);
    for (int v = 0; v < topology.vertex_count(); ++v) all.row(v) = nodes.row(topology.node_of(v));
    return target_mesh.with_points(std::move(all));
  };
  const TriangleMesh there = at_frame(target.frames[frame]);
  const AabbTree search(there);
  struct SurfaceBinding {
    std::array<int, 3> corners;
    Vec3 weights, offset;  // arm: what is left, along the triangle's own axes
  };
  // Columns: an edge, across it, the normal; of unit length.
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

}  // namespace batten
