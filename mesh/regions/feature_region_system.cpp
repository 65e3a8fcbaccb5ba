#include "batten/mesh/regions/feature_region_system.h"

#include <cmath>

#include "batten/core/errors.h"
#include "batten/core/parallel_chunks.h"
#include "batten/mesh/deform/normal_equations.h"

namespace batten {
namespace {

/// Hard regions are form features; what they turn by is told at each edit.
DeformProblem with_features(DeformProblem problem, const std::vector<std::string>& names,
                            const std::vector<std::vector<int>>& corners,
                            FeatureRegionOptions::Kind kind) {
  if (kind == FeatureRegionOptions::Kind::Hard)
    for (size_t r = 0; r < names.size(); ++r)
      problem.features.push_back({names[r], corners[r], FormFeature::Kind::Free});
  return problem;
}

}  // namespace

FeatureRegionSystem::FeatureRegionSystem(const TriangleMesh& mesh, const DeformProblem& problem,
                                         const std::vector<std::string>& names,
                                         const std::vector<std::vector<int>>& faces,
                                         const std::vector<std::vector<int>>& corners,
                                         const FeatureRegionOptions& options)
    : points_(mesh.points()),
      options_(options),
      system_(mesh, with_features(problem, names, corners, options.kind)),
      positions_(system_.positions, AffineReduction::RhsMode::Deferred) {
  std::vector<int> region(mesh.vertex_count(), -1);
  for (size_t r = 0; r < corners.size(); ++r)
    for (const int v : corners[r]) region[v] = static_cast<int>(r);
  for (const int dof : system_.rotates_with)
    region_of_row_.push_back(dof < 0 ? -1 : region[system_.vertex[dof]]);
  if (options.kind == FeatureRegionOptions::Kind::Soft)
    add_edges(mesh, faces, options.weight / (mesh.size() * mesh.size()));
  factorize();
}

void FeatureRegionSystem::add_edges(const TriangleMesh& mesh,
                                    const std::vector<std::vector<int>>& faces, double weight) {
  for (size_t r = 0; r < faces.size(); ++r)
    for (size_t k = 0; k < faces[r].size(); ++k) {
      const auto& v = mesh.triangles()[faces[r][k]];
      double square = 0;
      for (int c = 0; c < 3; ++c)
        square += (mesh.point(v[(c + 1) % 3]) - mesh.point(v[c])).squaredNorm();
      if (!(square > 0)) continue;
      const double w =
          std::sqrt(weight * std::max(mesh.area_vector(faces[r][k]).norm() / 2 / square, 1e-3));
      for (int c = 0; c < 3; ++c) {
        const int a = v[c], b = v[(c + 1) % 3], from = system_.dof[a], to = system_.dof[b];
        if (from >= 0 && to >= 0)  // otherwise both are held
          edges_.push_back({static_cast<int>(r), static_cast<int>(k), from, to, w,
                            w * (mesh.point(b) - mesh.point(a))});
      }
    }
}

void FeatureRegionSystem::factorize() {
  const long curved = system_.A.rows(), rows = curved + static_cast<long>(edges_.size());
  A_.resize(rows, system_.A.cols());
  A_.reserve(system_.A.nonZeros() + 2 * static_cast<long>(edges_.size()));
  for (long r = 0; r < curved; ++r) {
    A_.startVec(r);
    for (RowMatrix::InnerIterator a(system_.A, r); a; ++a) A_.insertBack(r, a.col()) = a.value();
  }
  for (size_t k = 0; k < edges_.size(); ++k) {
    const long r = curved + static_cast<long>(k);
    const EdgeEquation& e = edges_[k];
    A_.startVec(r);
    A_.insertBack(r, std::min(e.from, e.to)) = e.from < e.to ? -e.weight : e.weight;
    A_.insertBack(r, std::max(e.from, e.to)) = e.from < e.to ? e.weight : -e.weight;
  }
  A_.finalize();
  const RowMatrix reduced = reduced_matrix(A_, positions_);
  B_ = reduced;
  if (positions_.free_count() > 0) {
    const SparseMatrix N = normal_matrix(B_, reduced);
    factor_.analyze(N);
    if (!factor_.factorize(N)) throw NoSolutionError("the feature regions: " + factor_.message());
  }
  rhs_ = MatX::Zero(static_cast<long>(system_.values.size()), 3);
  load_ = MatX::Zero(positions_.free_count(), 3);
  x_ = MatX::Zero(A_.cols(), 3);
  target_ = RowPoints::Zero(rows, 3);
}

void FeatureRegionSystem::set_hard_values(const DeformEdit& edit,
                                          const std::vector<Mat3>& scaled_rotations) {
  using Kind = DeformSystem::Value::Kind;
  for (size_t k = 0; k < system_.values.size(); ++k) {
    const auto& value = system_.values[k];
    Vec3 d = system_.rest.row(value.vertex).transpose();
    if (value.kind == Kind::Handle)
      d = edit.handles[value.source](points_.row(value.vertex).transpose()) - system_.origin;
    else if (value.kind == Kind::Feature)
      d = scaled_rotations[value.source] * (d - system_.rest.row(value.reference).transpose());
    rhs_.row(static_cast<long>(k)) = d.transpose();
  }
  positions_.set_rhs(rhs_);
}

void FeatureRegionSystem::set_curvature_targets(const Points& estimate,
                                                const std::vector<double>& scales) {
  parallel_chunks(system_.A.rows(), [&](long first, long last) {
    for (long r = first; r < last; ++r) {
      Eigen::RowVector3d sum = system_.base.row(r);
      if (options_.rhs == FeatureRegionOptions::Rhs::Estimate) {
        sum.setZero();
        for (RowMatrix::InnerIterator a(system_.A, r); a; ++a)
          sum += a.value() * (estimate.row(system_.vertex[a.col()]) - system_.origin.transpose());
      }
      const int region = region_of_row_[r];
      target_.row(r) = region < 0 ? sum : scales[region] * sum;
    }
  });
}

void FeatureRegionSystem::solve_positions(const DeformEdit& edit, Points& result) {
  const MatX& d0 = positions_.d0();
  parallel_chunks(A_.rows(), [&](long first, long last) {
    for (long r = first; r < last; ++r)
      for (RowMatrix::InnerIterator a(A_, r); a; ++a) target_.row(r) -= a.value() * d0.row(a.col());
  });
  parallel_chunks(B_.cols(), [&](long first, long last) {
    for (long c = first; c < last; ++c) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (SparseMatrix::InnerIterator b(B_, c); b; ++b) sum += b.value() * target_.row(b.row());
      load_.row(c) = sum;
    }
  });
  if (B_.cols() > 0) factor_.solve_in_place(load_);
  if (!load_.allFinite()) throw NoSolutionError("the feature regions: positions are not finite");
  x_.noalias() = positions_.D() * load_;
  x_ += d0;
  for (long v = 0; v < points_.rows(); ++v) {
    const int h = system_.constrained_by[v];
    if (h == DeformSystem::kFree)
      result.row(v) = x_.row(system_.dof[v]) + system_.origin.transpose();
    else if (h >= 0)
      result.row(v) = edit.handles[h](points_.row(v).transpose()).transpose();
    else
      result.row(v) = points_.row(v);
  }
}

}  // namespace batten
