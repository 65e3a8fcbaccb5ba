// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/regions/feature_region_deformer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/core/solvers/sparse_cholesky.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/selection.h"

namespace batten {

// Linear system of FeatureRegionDeformer: rows, unknowns and factorization.

/// Rows (5), followed by rows (6) for soft regions. Fixed vertices, handles and hard regions are
/// eliminated.
class FeatureRegionSystem {
 public:
  /// `faces`, `corners`: triangles and vertices of each region.
  FeatureRegionSystem(const TriangleMesh& mesh, const DeformProblem& problem,
                      const std::vector<std::string>& names,
                      const std::vector<std::vector<int>>& faces,
                      const std::vector<std::vector<int>>& corners,
                      const FeatureRegionOptions& options);

  /// Handle that constrains a vertex of the mesh, or a DeformSystem::ConstraintSource.
  int constrained_by(int vertex) const { return system_.constrained_by[vertex]; }
  int unknowns() const { return positions_.free_count(); }

  /// Solves for `result` (all vertices). `face_rotation(region, k)`: scale times rotation of face k
  /// of a soft region. `scaled_rotations`: scale times rotation of each region.
  template <class FaceRotation>
  void solve(const Points& estimate, const DeformEdit& edit, const std::vector<double>& scales,
             const std::vector<Mat3>& scaled_rotations, const FaceRotation& face_rotation,
             Points& result) {
    set_hard_values(edit, scaled_rotations);
    set_curvature_targets(estimate, scales);
    const long first = system_.A.rows();
    for (size_t k = 0; k < edges_.size(); ++k)
      target_.row(first + static_cast<long>(k)) =
          (face_rotation(edges_[k].region, edges_[k].face) * edges_[k].base).transpose();
    solve_positions(edit, result);
  }

 private:
  struct EdgeEquation {
    int region, face;  // face: index within the region
    int from, to;      // dofs
    double weight;
    Vec3 base;
  };
  void add_edges(const TriangleMesh& mesh, const std::vector<std::vector<int>>& faces,
                 double weight);
  void factorize();
  void set_hard_values(const DeformEdit& edit, const std::vector<Mat3>& scaled_rotations);
  void set_curvature_targets(const Points& estimate, const std::vector<double>& scales);
  void solve_positions(const DeformEdit& edit, Points& result);

  Points points_;  // of the undeformed mesh
  FeatureRegionOptions options_;
  DeformSystem system_;
  std::vector<int> region_of_row_;  // per row of (5): the region whose scale applies, or -1
  std::vector<EdgeEquation> edges_;
  AffineReduction positions_;
  RowMatrix A_;
  SparseMatrix B_;
  SparseCholesky factor_;
  MatX rhs_, load_, x_;
  RowPoints target_;
};

namespace {

using Lists = std::vector<std::vector<int>>;

void check_rotation(const std::string& name, const Mat3& R) {
  if (!((R.transpose() * R - Mat3::Identity()).norm() < 1e-9) || !(R.determinant() > 0))
    throw InputError("the rotation of feature region '" + name +
                     "' is not a rotation matrix, expected RᵀR = 1, det R = 1");
}

void check_scale(const std::string& name, double scale) {
  if (!(scale > 0) || !(scale < 1e100))
    throw InputError("the scale of feature region '" + name + "' is " + format_number(scale) +
                     ", expected a number above 0");
}

std::vector<std::string> checked_names(const std::vector<FeatureRegion>& regions) {
  std::set<std::string> names;
  std::vector<std::string> list;
  for (const auto& region : regions) {
    if (region.name.empty()) throw InputError("found a feature region without a name");
    if (!names.insert(region.name).second)
      throw InputError("found two feature regions named '" + region.name +
                       "', expected unique names");
    if (region.rotation) check_rotation(region.name, *region.rotation);
    check_scale(region.name, region.scale);
    list.push_back(region.name);
  }
  return list;
}

const FeatureRegionOptions& checked(const FeatureRegionOptions& options) {
  if (!(options.weight > 0) || !std::isfinite(options.weight))
    throw InputError("the weight of feature regions is " + format_number(options.weight) +
                     ", expected a number above 0");
  return options;
}

}  // namespace

struct FeatureRegionDeformer::Data {
  Data(const TriangleMesh& given, std::vector<FeatureRegion> stated, DeformProblem constraints,
       const FeatureRegionOptions& wanted);
  void find_constraint_sources();
  void group();
  void take(const Points& estimate, std::span<const HandleTransform> moves);
  void fit_face_rotations(const Points& estimate);
  void fit_region_rotations();
  Mat3 mean_of_group(int group) const;

  TriangleMesh mesh;
  std::vector<FeatureRegion> regions;
  DeformProblem problem;
  FeatureRegionOptions options;
  std::vector<std::string> names;
  Lists faces, corners;
  std::optional<FeatureRegionSystem> system, soft;  // soft: for deform_per_face() with hard regions
  std::vector<int> group_of;                        // lowest region of those that rotate together
  std::vector<int> constrained_by;  // per group, at its lowest region: handle, kFixed, or kFree

  DeformEdit edit;
  std::vector<std::vector<Mat3>> face_rotations;
  std::vector<std::vector<double>> areas;
  std::vector<Mat3> rotations, scaled;  // R', s R'
  std::vector<double> scales;
  Points result;
};

FeatureRegionDeformer::Data::Data(const TriangleMesh& given, std::vector<FeatureRegion> stated,
                                  DeformProblem constraints, const FeatureRegionOptions& wanted)
    : mesh(given),
      regions(std::move(stated)),
      problem(std::move(constraints)),
      options(checked(wanted)),
      names(checked_names(regions)),
      result(given.points()) {
  for (const auto& region : regions) {
    faces.push_back(faces_of(mesh, region));
    corners.push_back(vertices_of_triangles(mesh.topology(), faces.back()));
    face_rotations.emplace_back(faces.back().size(), Mat3::Identity());
    areas.emplace_back();
    for (const int f : faces.back()) areas.back().push_back(mesh.area_vector(f).norm() / 2);
    scales.push_back(region.scale);
  }
  rotations.assign(regions.size(), Mat3::Identity());
  scaled = rotations;
  system.emplace(mesh, problem, names, faces, corners, options);
  group();
  find_constraint_sources();
}

void FeatureRegionDeformer::Data::group() {
  DisjointSets groups(regions.size());
  if (options.kind == FeatureRegionOptions::Kind::Hard) {
    std::vector<int> first(mesh.vertex_count(), -1);
    for (size_t r = 0; r < regions.size(); ++r)
      for (const int v : corners[r])
        if (first[v] < 0)
          first[v] = static_cast<int>(r);
        else
          groups.unite(first[v], static_cast<int>(r));
  }
  for (size_t r = 0; r < regions.size(); ++r) group_of.push_back(groups.find(static_cast<int>(r)));
}

void FeatureRegionDeformer::Data::find_constraint_sources() {
  constrained_by.assign(regions.size(), DeformSystem::kFree);
  for (size_t r = 0; r < regions.size(); ++r)
    for (const int v : corners[r])
      if (system->constrained_by(v) != DeformSystem::kFree)
        constrained_by[group_of[r]] =
            std::max(constrained_by[group_of[r]], system->constrained_by(v));
}

void FeatureRegionDeformer::Data::take(const Points& estimate,
                                       std::span<const HandleTransform> moves) {
  edit.handles.assign(moves.begin(), moves.end());
  check(problem, edit);
  if (estimate.rows() != mesh.vertex_count() || !estimate.allFinite())
    throw InputError("the estimate has " + std::to_string(estimate.rows()) + " points, expected " +
                     std::to_string(mesh.vertex_count()) + " finite ones");
  fit_face_rotations(estimate);
  fit_region_rotations();
}

void FeatureRegionDeformer::Data::fit_face_rotations(const Points& estimate) {
  for (size_t r = 0; r < regions.size(); ++r)
    parallel_chunks<256>(isize(faces[r]), [&](long begin, long end) {
      const auto n = static_cast<size_t>(end - begin);
      rotations_of_triangles(mesh.triangles(), std::span(faces[r]).subspan(begin, n), mesh.points(),
                             estimate, std::span(face_rotations[r]).subspan(begin, n));
    });
}

Mat3 FeatureRegionDeformer::Data::mean_of_group(int group) const {
  std::vector<Mat3> all;
  std::vector<double> weights;
  for (size_t r = 0; r < regions.size(); ++r)
    if (group_of[r] == group) {
      all.insert(all.end(), face_rotations[r].begin(), face_rotations[r].end());
      weights.insert(weights.end(), areas[r].begin(), areas[r].end());
    }
  return options.mean == FeatureRegionOptions::Mean::Squared ? mean_rotation(all, weights)
                                                             : median_rotation(all, weights);
}

void FeatureRegionDeformer::Data::fit_region_rotations() {
  std::vector<const Mat3*> prescribed(regions.size(), nullptr);  // per group
  for (size_t r = 0; r < regions.size(); ++r)
    if (regions[r].rotation && !prescribed[group_of[r]])
      prescribed[group_of[r]] = &*regions[r].rotation;
  for (size_t r = 0; r < regions.size(); ++r) {
    const int group = group_of[r], by = constrained_by[group];
    scales[r] = by >= 0 ? edit.handles[by].scale : regions[r].scale;
    if (regions[r].rotation) {
      rotations[r] = *regions[r].rotation;
    } else if (prescribed[group]) {
      rotations[r] = *prescribed[group];
    } else if (by >= 0) {
      rotations[r] = rotation_matrix(edit.handles[by].rotation_vector);
    } else if (by != DeformSystem::kFree) {
      rotations[r].setIdentity();
    } else {
      rotations[r] = group == static_cast<int>(r) ? mean_of_group(group) : rotations[group];
    }
    scaled[r] = scales[r] * rotations[r];
  }
}

FeatureRegionDeformer::FeatureRegionDeformer(const TriangleMesh& mesh,
                                             std::vector<FeatureRegion> regions,
                                             std::vector<int> fixed, std::vector<Handle> handles,
                                             const FeatureRegionOptions& options) {
  DeformProblem constraints;
  constraints.fixed = std::move(fixed);
  constraints.handles = std::move(handles);
  data_ = std::make_unique<Data>(mesh, std::move(regions), std::move(constraints), options);
}
FeatureRegionDeformer::~FeatureRegionDeformer() = default;
FeatureRegionDeformer::FeatureRegionDeformer(FeatureRegionDeformer&&) noexcept = default;
FeatureRegionDeformer& FeatureRegionDeformer::operator=(FeatureRegionDeformer&&) noexcept = default;

const Points& FeatureRegionDeformer::deform(const Points& estimate,
                                            std::span<const HandleTransform> moves) {
  Data& d = *data_;
  d.take(estimate, moves);
  d.system->solve(
      estimate, d.edit, d.scales, d.scaled,
      [&](int region, int) -> const Mat3& { return d.scaled[region]; }, d.result);
  return d.result;
}

const Points& FeatureRegionDeformer::deform_per_face(const Points& estimate,
                                                     std::span<const HandleTransform> moves) {
  Data& d = *data_;
  d.take(estimate, moves);
  FeatureRegionSystem* system = &*d.system;
  if (d.options.kind == FeatureRegionOptions::Kind::Hard) {
    FeatureRegionOptions soft = d.options;
    soft.kind = FeatureRegionOptions::Kind::Soft;
    if (!d.soft) d.soft.emplace(d.mesh, d.problem, d.names, d.faces, d.corners, soft);
    system = &*d.soft;
  }
  system->solve(
      estimate, d.edit, d.scales, d.scaled,
      [&](int region, int k) -> Mat3 { return d.scales[region] * d.face_rotations[region][k]; },
      d.result);
  return d.result;
}

void FeatureRegionDeformer::set_rotation(int region, const std::optional<Mat3>& rotation) {
  FeatureRegion& r = data_->regions.at(region);
  if (rotation) check_rotation(r.name, *rotation);
  r.rotation = rotation;
}

void FeatureRegionDeformer::set_scale(int region, double scale) {
  FeatureRegion& r = data_->regions.at(region);
  check_scale(r.name, scale);
  r.scale = scale;
}

const Points& FeatureRegionDeformer::positions() const { return data_->result; }
const std::vector<Mat3>& FeatureRegionDeformer::region_rotations() const {
  return data_->rotations;
}
const std::vector<double>& FeatureRegionDeformer::region_scales() const { return data_->scales; }
const std::vector<Mat3>& FeatureRegionDeformer::face_rotations(int region) const {
  return data_->face_rotations.at(region);
}
const std::vector<int>& FeatureRegionDeformer::faces(int region) const {
  return data_->faces.at(region);
}
const std::vector<int>& FeatureRegionDeformer::vertices(int region) const {
  return data_->corners.at(region);
}
const std::vector<FeatureRegion>& FeatureRegionDeformer::regions() const { return data_->regions; }
int FeatureRegionDeformer::unknowns() const { return data_->system->unknowns(); }

namespace {

/// Adds hard regions as form features; their rotations are set at each edit.
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
        if (from >= 0 && to >= 0)  // otherwise both are constrained
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
    if (!factor_.factorize(N)) throw NoSolutionError("feature regions: " + factor_.message());
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
  if (!load_.allFinite()) throw NoSolutionError("feature regions: positions are not finite");
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

std::vector<std::vector<int>> components_of_mask(const TriangleMesh& mesh,
                                                 const std::vector<char>& mask) {
  const int n = mesh.vertex_count();
  if (isize(mask) != n)
    throw InputError("the mask has " + std::to_string(mask.size()) +
                     " marks, expected one for each of " + std::to_string(n) + " vertices");
  std::vector<std::vector<int>> components;
  std::vector<char> seen(n, 0);
  for (int seed = 0; seed < n; ++seed) {
    if (!mask[seed] || seen[seed]) continue;
    std::vector<int> component = {seed};
    seen[seed] = 1;
    for (size_t k = 0; k < component.size(); ++k)
      for (const int v : mesh.topology().neighbours(component[k]))
        if (mask[v] && !seen[v]) {
          seen[v] = 1;
          component.push_back(v);
        }
    std::sort(component.begin(), component.end());
    components.push_back(std::move(component));
  }
  return components;
}

std::vector<int> faces_of(const TriangleMesh& mesh, const FeatureRegion& region) {
  const std::string name = "feature region '" + region.name + "'";
  const auto in_range = [&](const std::vector<int>& numbers, const char* what, int count) {
    for (const int i : numbers)
      if (i < 0 || i >= count)
        throw InputError(name + ": found " + what + " " + std::to_string(i) + ", expected 0 to " +
                         std::to_string(count - 1));
  };
  in_range(region.faces, "triangle", mesh.triangle_count());
  if (region.faces.empty()) in_range(region.vertices, "vertex", mesh.vertex_count());
  std::vector<int> faces =
      region.faces.empty() ? triangles_touching(mesh.topology(), region.vertices) : region.faces;
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  if (faces.empty()) throw InputError(name + " has no triangles, expected at least one");
  return faces;
}

}  // namespace batten
