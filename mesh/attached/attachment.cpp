// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/attached/attachment.h"

#include <Eigen/IterativeLinearSolvers>
#include <algorithm>
#include <map>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

using Kind = NonShellElement::Kind;

/// Solves K x = b by Cholesky factorization. Above 100,000 unknowns it uses conjugate gradients,
/// because the factor of a large solid would exhaust the memory.
class LaplaceSolver {
 public:
  explicit LaplaceSolver(const SparseMatrix& K) : K_(K) {
    constexpr int most_factored = 100'000;
    if (K.rows() > most_factored) {
      gradients_.setTolerance(1e-13);
      gradients_.compute(K);
    } else {
      factor_.analyze(K);
      if (!factor_.factorize(K)) fail(factor_.message());
    }
    factored_ = K.rows() <= most_factored;
  }
  void solve_in_place(MatX& b, const MatX& guess) const {
    if (factored_) return factor_.solve_in_place(b);
    const MatX x = gradients_.solveWithGuess(b, guess);
    if (gradients_.info() != Eigen::Success) fail("the iteration did not converge");
    b = x;
  }

 private:
  [[noreturn]] static void fail(const std::string& why) {
    throw NoSolutionError("elements attached to the shells: " + why);
  }
  const SparseMatrix& K_;
  SparseCholesky factor_;
  Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower, Eigen::IncompleteCholesky<double>>
      gradients_;
  bool factored_ = true;
};

class AttachmentPropagator {
 public:
  AttachmentPropagator(const Points& before, Points& after, std::vector<char> placed,
                       std::vector<Mat3> rotations, std::span<const NonShellElement> elements,
                       const AttachmentOptions& options)
      : before_(before),
        after_(after),
        placed_(std::move(placed)),
        rotations_(std::move(rotations)),
        options_(options) {
    for (const NonShellElement& e : elements)
      if (options.of(e.kind) != AttachmentRule::Stay) elements_.push_back(&e);
  }

  std::vector<int> propagate_to_attached() {
    do {
      while (move_rigid_elements()) continue;
    } while (deform_all());
    std::sort(result_.begin(), result_.end());
    return std::move(result_);
  }

 private:
  struct Motion {
    Mat3 R = Mat3::Identity();
    Vec3 translation = Vec3::Zero();
    bool is_identity = false;  ///< nothing moved: coordinates must stay bit-identical
    Vec3 operator()(const Vec3& p) const { return R * p + translation; }
  };

  /// Best rigid motion of known nodes. If their positions leave it undetermined, their rotations
  /// decide.
  Motion motion_of(const std::vector<int>& nodes, const std::vector<double>& weights = {}) const {
    // A node on the axis of a rotation does not move, but rotates.
    if (std::all_of(nodes.begin(), nodes.end(), [&](int v) {
          return after_.row(v) == before_.row(v) && rotations_[v] == Mat3::Identity();
        }))
      return {Mat3::Identity(), Vec3::Zero(), true};
    Mat3 sum = Mat3::Zero();
    for (size_t i = 0; i < nodes.size(); ++i)
      sum += (weights.empty() ? 1.0 : weights[i]) * rotations_[nodes[i]];
    const Mat3 mean = nearest_rotation(sum);
    Points from(static_cast<long>(nodes.size()), 3), to = from;
    std::vector<int> all;
    for (int i = 0; i < isize(nodes); ++i) {
      from.row(i) =
          (mean * (before_.row(nodes[i]) - before_.row(nodes[0])).transpose()).transpose();
      to.row(i) = after_.row(nodes[i]);
      all.push_back(i);
    }
    const Similarity fit = weights.empty() ? fit_similarity(from, to, all, 1)
                                           : fit_similarity(from, to, all, 1, weights);
    const Mat3 R = fit.R * mean;
    return {R, fit.translation - R * before_.row(nodes[0]).transpose(), false};
  }

  void set_node(int node, const Motion& motion) {
    if (!motion.is_identity) {
      after_.row(node) = motion(before_.row(node).transpose()).transpose();
      result_.push_back(node);
    }
    rotations_[node] = motion.R;
    placed_[node] = 1;
  }

  /// Moves rigid and interpolation elements whose nodes are known. Returns true if there was one.
  bool move_rigid_elements() {
    bool any = false;
    for (const NonShellElement* e : elements_) {
      if (e->kind == Kind::Rigid) any |= move_rigid_element(*e);
      if (e->kind == Kind::Interpolation) any |= move_interpolation_element(*e);
    }
    return any;
  }

  bool move_rigid_element(const NonShellElement& e) {
    std::vector<int> known, open;
    for (const int v : e.nodes) (placed_[v] ? known : open).push_back(v);
    if (known.empty() || open.empty()) return false;
    const Motion motion = motion_of(known);
    for (const int v : open)
      if (!placed_[v]) set_node(v, motion);
    return true;
  }

  bool move_interpolation_element(const NonShellElement& e) {
    if (e.nodes.size() < 2 || placed_[e.nodes[0]]) return false;
    const std::vector<int> others(e.nodes.begin() + 1, e.nodes.end());
    if (!std::all_of(others.begin(), others.end(), [&](int v) { return placed_[v] != 0; }))
      return false;
    set_node(e.nodes[0], motion_of(others, e.weights));
    return true;
  }

  // ---- other elements connected to known nodes --------------------------------------------------

  struct Body {
    std::vector<int> nodes, anchors;  ///< unknown nodes; known nodes that they are connected to
    bool rigid = false;
    Motion motion;
  };

  static bool joins(const NonShellElement& e) {
    return e.kind != Kind::Rigid && e.kind != Kind::Interpolation && e.nodes.size() > 1;
  }

  /// Moves all bodies connected to known nodes. Returns true if there was one.
  bool deform_all() {
    bodies_.clear();
    body_of_.assign(placed_.size(), -1);
    find_bodies();
    std::vector<int> smooth;
    for (Body& body : bodies_) {
      body.motion = motion_of(body.anchors);
      if (body.rigid || body.motion.is_identity)
        for (const int v : body.nodes) set_node(v, body.motion);
      else
        smooth.insert(smooth.end(), body.nodes.begin(), body.nodes.end());
    }
    if (!smooth.empty()) deform(smooth);
    return !bodies_.empty();
  }

  void find_bodies() {
    DisjointSets groups(placed_.size());
    for (const NonShellElement* e : elements_) {
      int first = -1;
      for (const int v : e->nodes)
        if (joins(*e) && !placed_[v]) {
          if (first >= 0) groups.unite(first, v);
          first = v;
        }
    }
    std::map<int, Body> found;  // by the lowest unknown node
    for (const NonShellElement* e : elements_) {
      if (!joins(*e)) continue;
      const auto open =
          std::find_if(e->nodes.begin(), e->nodes.end(), [&](int v) { return !placed_[v]; });
      if (open == e->nodes.end()) continue;
      Body& body = found[groups.find(*open)];
      body.rigid |= options_.of(e->kind) == AttachmentRule::Rigid;
      for (const int v : e->nodes) (placed_[v] ? body.anchors : body.nodes).push_back(v);
    }
    for (auto& [lowest, body] : found) {
      if (body.anchors.empty()) continue;
      for (auto* list : {&body.nodes, &body.anchors}) {
        *list = sorted_unique(std::move(*list));
      }
      for (const int v : body.nodes) body_of_[v] = isize(bodies_);
      bodies_.push_back(std::move(body));
    }
  }

  struct Edge {
    int a, b;
    double weight;
  };

  /// All pairs of nodes of one element of which at least one is unknown.
  std::vector<Edge> edges_of(const std::vector<int>& row) const {
    std::vector<Edge> edges;
    for (const NonShellElement* e : elements_) {
      if (!joins(*e)) continue;
      for (size_t i = 0; i < e->nodes.size(); ++i)
        for (size_t j = 0; j < i; ++j) {
          const int a = e->nodes[j], b = e->nodes[i];
          if (a == b || (row[a] < 0 && row[b] < 0)) continue;
          // Coincident nodes stay together, without a singular weight.
          const double square =
              std::max((before_.row(a) - before_.row(b)).squaredNorm(), 1e-12 * scale_);
          edges.push_back({a, b, scale_ / square});
        }
    }
    return edges;
  }

  void deform(const std::vector<int>& nodes) {
    scale_ = (before_.colwise().maxCoeff() - before_.colwise().minCoeff()).squaredNorm();
    std::vector<int> row(placed_.size(), -1);
    for (int i = 0; i < isize(nodes); ++i) row[nodes[i]] = i;
    const std::vector<Edge> edges = edges_of(row);
    std::vector<Triplet> entries;
    for (const Edge& e : edges) {
      const int a = row[e.a], b = row[e.b];
      if (a >= 0) entries.emplace_back(a, a, e.weight);
      if (b >= 0) entries.emplace_back(b, b, e.weight);
      if (a >= 0 && b >= 0) entries.emplace_back(std::max(a, b), std::min(a, b), -e.weight);
    }
    const auto n = static_cast<long>(nodes.size());
    SparseMatrix K(n, n);
    K.setFromTriplets(entries.begin(), entries.end());
    const LaplaceSolver solver(K);

    const auto motion_at = [&](const Edge& e) -> const Motion& {
      return bodies_[body_of_[row[e.a] >= 0 ? e.a : e.b]].motion;
    };
    // Logarithms of the rotations relative to the motion of the body.
    MatX q = MatX::Zero(n, 3);
    const auto log_at = [&](const Edge& e, int v) {
      return to_rotation_vector(motion_at(e).R.transpose() * rotations_[v]);
    };
    for_open_ends(edges, row, [&](const Edge& e, int open, int other) {
      if (row[other] < 0) q.row(row[open]) += e.weight * log_at(e, other).transpose();
    });
    solver.solve_in_place(q, MatX::Zero(n, 3));
    // Positions relative to the motion of the body.
    MatX y = MatX::Zero(n, 3);
    for_open_ends(edges, row, [&](const Edge& e, int open, int other) {
      const Motion& motion = motion_at(e);
      const auto rotation_vector = [&](int v) -> Vec3 {
        if (row[v] < 0) return log_at(e, v);
        return q.row(row[v]).transpose();
      };
      const Vec3 edge = (before_.row(open) - before_.row(other)).transpose();
      Vec3 pull = rotated((rotation_vector(open) + rotation_vector(other)) / 2, edge);
      if (row[other] < 0)
        pull += motion.R.transpose() * (after_.row(other).transpose() - motion.translation);
      y.row(row[open]) += e.weight * pull.transpose();
    });
    MatX rest(n, 3);
    for (int i = 0; i < n; ++i) rest.row(i) = before_.row(nodes[i]);
    solver.solve_in_place(y, rest);
    for (int i = 0; i < n; ++i) {
      const Motion& motion = bodies_[body_of_[nodes[i]]].motion;
      after_.row(nodes[i]) = motion(y.row(i).transpose()).transpose();
      rotations_[nodes[i]] = motion.R * rotation_matrix(q.row(i).transpose());
      placed_[nodes[i]] = 1;
      result_.push_back(nodes[i]);
    }
  }

  template <class Visit>
  static void for_open_ends(const std::vector<Edge>& edges, const std::vector<int>& row,
                            const Visit& visit) {
    for (const Edge& e : edges) {
      if (row[e.a] >= 0) visit(e, e.a, e.b);
      if (row[e.b] >= 0) visit(e, e.b, e.a);
    }
  }

  const Points& before_;
  Points& after_;
  std::vector<char> placed_;
  std::vector<Mat3> rotations_;
  const AttachmentOptions& options_;
  std::vector<const NonShellElement*> elements_;
  std::vector<Body> bodies_;
  std::vector<int> body_of_;  // body of each unknown node, or -1
  double scale_ = 1;
  std::vector<int> result_;
};

}  // namespace

std::vector<FormFeature> connections(std::span<const NonShellElement> elements,
                                     const std::vector<char>& has_face,
                                     const AttachmentOptions& options) {
  std::vector<char> in_rigid(has_face.size(), 0);
  for (const NonShellElement& e : elements)
    if (e.kind == Kind::Rigid && options.of(e.kind) != AttachmentRule::Stay)
      for (const int v : e.nodes) in_rigid[v] = 1;
  const auto all = [](const NonShellElement& e, const auto& condition) {
    return std::all_of(e.nodes.begin(), e.nodes.end(), condition);
  };
  const auto keeps_shape = [&](const NonShellElement& e) {
    if (e.nodes.size() < 2 || options.of(e.kind) == AttachmentRule::Stay) return false;
    if (e.kind == Kind::Rigid) return true;
    if (e.kind == Kind::Bush) return all(e, [&](int v) { return has_face[v] || in_rigid[v]; });
    return e.kind == Kind::Beam && all(e, [&](int v) { return !has_face[v] && in_rigid[v]; });
  };
  std::vector<FormFeature> result;
  std::set<std::vector<int>> known;
  std::set<std::string> names;
  for (const NonShellElement& e : elements) {
    if (!keeps_shape(e)) continue;
    std::vector<int> nodes = sorted_unique(e.nodes);
    if (nodes.size() < 2 || !known.insert(nodes).second) continue;
    std::string name = e.name + " " + std::to_string(e.label);
    while (!names.insert(name).second) name += "'";
    result.push_back({name, std::move(nodes), FormFeature::Kind::Free});
  }
  return result;
}

std::vector<int> propagate_to_attached(const Points& before, Points& after,
                                       std::vector<char> placed, std::vector<Mat3> rotations,
                                       std::span<const NonShellElement> elements,
                                       const AttachmentOptions& options) {
  return AttachmentPropagator(before, after, std::move(placed), std::move(rotations), elements,
                              options)
      .propagate_to_attached();
}

}  // namespace batten
