// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/regions/local_global_solver.h"

#include <algorithm>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/mesh/deform/deform_system.h"
#include "batten/mesh/rotation_fitting.h"

namespace batten {
namespace {

constexpr int kChunk = 512;

/// Groups items by owner: those of owner o are item[start[o]] … item[start[o+1] - 1].
template <class ForEach>
void group_by_owner(int owners, std::vector<int>& start, std::vector<int>& item,
                    const ForEach& for_each) {
  start.assign(owners + 1, 0);
  for_each([&](int owner, int) { ++start[owner + 1]; });
  for (int o = 0; o < owners; ++o) start[o + 1] += start[o];
  item.resize(start.back());
  std::vector<int> next(start.begin(), start.end() - 1);
  for_each([&](int owner, int i) { item[next[owner]++] = i; });
}

}  // namespace

LocalGlobalSolver::Constraints LocalGlobalSolver::collect_constraints(const MeshTopology& topology,
                                                                      const DeformProblem& given,
                                                                      const ArapEnergy& rows) {
  const auto n = static_cast<int>(rows.A.cols());
  check(given, n);
  const DeformProblem problem = expand_to_nodes(given, topology);
  Constraints constraints{ConstraintSet(n), {}, {}};
  DisjointSets parts(n);
  for (long r = 0; r < rows.A.rows(); ++r) {
    int first = -1;
    for (RowMatrix::InnerIterator a(rows.A, r); a; ++a)
      if (first < 0)
        first = static_cast<int>(a.col());
      else
        parts.unite(first, static_cast<int>(a.col()));
  }
  for (int v = topology.node_count(); v < n; ++v) parts.unite(topology.node_of(v), v);
  std::vector<char> is_anchored(n, 0);
  const auto add = [&](const std::string& name, std::vector<int> vertices, int handle) {
    for (const int v : sorted_unique(std::move(vertices))) {
      constraints.rows.fix(name, v, Vec3::Zero());
      constraints.vertex.push_back(v);
      constraints.handle.push_back(handle);
      is_anchored[parts.find(v)] = 1;
    }
  };
  add("fixed", problem.fixed, -1);
  for (size_t h = 0; h < problem.handles.size(); ++h)
    add(problem.handles[h].name, problem.handles[h].vertices, static_cast<int>(h));
  std::vector<int> unconnected;
  for (int v = 0; v < n; ++v)
    if (!is_anchored[parts.find(v)]) unconnected.push_back(v);
  add("unconstrained part", unconnected, -1);
  std::vector<char> is_constrained(n, 0);
  for (const int v : constraints.vertex) is_constrained[v] = 1;
  for (int v = topology.node_count(); v < n; ++v)
    if (!is_constrained[v])
      constraints.rows.add("non-manifold edge", {{v, 1.0}, {topology.node_of(v), -1.0}},
                           Vec3::Zero());
  return constraints;
}

LocalGlobalSolver::LocalGlobalSolver(const TriangleMesh& mesh, DeformProblem problem,
                                     ArapEnergy rows, const std::string& name)
    : LocalGlobalSolver(mesh, problem, rows, name,
                        collect_constraints(mesh.topology(), problem, rows)) {}

LocalGlobalSolver::LocalGlobalSolver(const TriangleMesh& mesh, DeformProblem problem,
                                     ArapEnergy rows, const std::string& name,
                                     Constraints constraints)
    : LocalGlobalIteration(mesh.size(), name),
      problem_(std::move(problem)),
      rows_(std::move(rows)),
      origin_(mesh.triangle_count() > 0 ? Vec3(mesh.box().center()) : Vec3(Vec3::Zero())),
      points_(mesh.points()),
      constrained_vertex_(std::move(constraints.vertex)),
      constrained_handle_(std::move(constraints.handle)),
      positions_(constraints.rows, AffineReduction::RhsMode::Deferred) {
  const RowMatrix reduced = reduced_matrix(rows_.A, positions_);
  B_ = reduced;
  if (positions_.free_count() > 0) {
    const SparseMatrix N = normal_matrix(B_, reduced);
    factor_.analyze(N);
    if (!factor_.factorize(N)) throw NoSolutionError(name_ + ": " + factor_.message());
  }
  rhs_ = MatX::Zero(isize(constraints.rows.constraints()), 3);
  gather_cells();
  colour_cells();
  compute_handle_weights();
  find_prescribed_cells();
  find_coincident_vertices(mesh.topology());
  const long count = rows_.A.rows();
  resize(positions_.free_count(),
         rows_.links.empty() ? positions_.free_count() : 3L * cell_count());
  if (!rows_.links.empty()) rotations_before_ = rotations_ = MatX::Zero(3L * cell_count(), 3);
  now_ = constrained_part_ = residual_ = RowPoints::Zero(count, 3);
  covariances_.assign(element_count(), Mat3::Zero());
  G_.assign(cell_count(), Mat3::Identity());
  G_before_ = G_;
  energy_parts_.assign(std::max(element_count(), cell_count()) / kChunk + 1, 0);
  p_ = points_.rowwise() - origin_.transpose();
  result_ = points_;
}

void LocalGlobalSolver::find_coincident_vertices(const MeshTopology& topology) {
  std::vector<char> is_free(topology.vertex_count(), 0);
  for (const int v : positions_.free_dofs()) is_free[v] = 1;
  for (int v = 0; v < topology.vertex_count(); ++v)
    if (!is_free[v])
      for (const int other : topology.coincident_vertices(v))
        if (is_free[other]) coincident_vertices_.emplace_back(v, other);
}

void LocalGlobalSolver::gather_cells() {
  const int m = rows_.cells_of_element;
  group_by_owner(cell_count(), element_start_, elements_, [&](const auto& visit) {
    for (size_t k = 0; k < rows_.cells.size(); ++k) visit(rows_.cells[k], static_cast<int>(k) / m);
  });
  base_square_.assign(element_count(), 0);
  for (int e = 0; e < element_count(); ++e)
    for (int r = rows_.row_start[e]; r < rows_.row_start[e + 1]; ++r)
      base_square_[e] += rows_.base.row(r).squaredNorm();
}

void LocalGlobalSolver::colour_cells() {
  std::vector<int> link;  // per cell
  group_by_owner(cell_count(), link_start_, link, [&](const auto& visit) {
    for (size_t k = 0; k < rows_.links.size(); ++k) {
      visit(rows_.links[k].a, static_cast<int>(k));
      visit(rows_.links[k].b, static_cast<int>(k));
    }
  });
  if (rows_.links.empty()) return;
  std::vector<int> colour(cell_count(), -1), taken;  // taken: last cell that excluded the colour
  for (int c = 0; c < cell_count(); ++c) {
    for (int k = link_start_[c]; k < link_start_[c + 1]; ++k) {
      const auto& l = rows_.links[link[k]];
      linked_.push_back(l.a == c ? l.b : l.a);
      link_weight_.push_back(l.weight);
      const int other = colour[linked_.back()];
      if (other >= 0) taken[other] = c;
    }
    const auto free = std::find_if(taken.begin(), taken.end(), [&](int by) { return by != c; });
    colour[c] = static_cast<int>(free - taken.begin());
    if (free == taken.end()) taken.push_back(-1);
  }
  group_by_owner(isize(taken), colour_start_, coloured_, [&](const auto& visit) {
    for (int c = 0; c < cell_count(); ++c) visit(colour[c], c);
  });
}

// Interpolation weights of the handles: 1 on the own vertices of a handle, 0 on all other
// constrained ones, min |A q|² elsewhere.
void LocalGlobalSolver::compute_handle_weights() {
  const auto handles = static_cast<long>(problem_.handles.size());
  MatX indicator = MatX::Zero(rhs_.rows(), handles);
  for (size_t k = 0; k < constrained_handle_.size(); ++k)
    if (constrained_handle_[k] >= 0) indicator(static_cast<long>(k), constrained_handle_[k]) = 1;
  MatX field = positions_.particular_solution(indicator);
  if (positions_.free_count() > 0 && handles > 0) {
    MatX load = B_.transpose() * MatX(rows_.A * -field);
    factor_.solve_in_place(load);
    field += positions_.D() * load;
  }
  weights_ = rows_.mean * field;
}

void LocalGlobalSolver::find_prescribed_cells() {
  prescribed_.assign(cell_count(), 0);
  if (rows_.cell_vertices.empty()) return;
  std::vector<char> constrained(points_.rows(), 0);
  for (const int v : constrained_vertex_) constrained[v] = 1;
  for (int c = 0; c < cell_count(); ++c)
    prescribed_[c] = rows_.cell_vertices[c] >= 0 && constrained[rows_.cell_vertices[c]];
  // An element whose unknowns are all constrained determines the rotations of its cells.
  for (int e = 0; e < element_count(); ++e) {
    bool determined = true;
    for (int r = rows_.row_start[e]; r < rows_.row_start[e + 1] && determined; ++r)
      for (RowMatrix::InnerIterator a(rows_.A, r); a; ++a)
        determined = determined && constrained[a.col()];
    const int m = rows_.cells_of_element;
    if (determined)
      for (int k = 0; k < m; ++k) prescribed_[rows_.cells[e * m + k]] = 0;
  }
}

void LocalGlobalSolver::set_constraint_rhs() {
  for (size_t k = 0; k < constrained_vertex_.size(); ++k) {
    const Vec3 at = points_.row(constrained_vertex_[k]).transpose();
    rhs_.row(static_cast<long>(k)) =
        (constrained_handle_[k] < 0 ? at : edit_.handles[constrained_handle_[k]](at)) - origin_;
  }
  positions_.set_rhs(rhs_);
  const MatX& d0 = positions_.d0();
  parallel_chunks(constrained_part_.rows(), [&](long first, long last) {
    for (long r = first; r < last; ++r) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (RowMatrix::InnerIterator a(rows_.A, r); a; ++a) sum += a.value() * d0.row(a.col());
      constrained_part_.row(r) = sum;
    }
  });
}

void LocalGlobalSolver::start(const Points* guess) {
  for (long v = 0; v < p_.rows(); ++v)
    p_.row(v) = (guess ? *guess : points_).row(v) - origin_.transpose();
  for (size_t k = 0; k < constrained_vertex_.size(); ++k)
    p_.row(constrained_vertex_[k]) = rhs_.row(static_cast<long>(k));
  const auto& free = positions_.free_dofs();
  for (size_t k = 0; k < free.size(); ++k) y_.row(static_cast<long>(k)) = p_.row(free[k]);
  rotation_vectors_.clear();
  for (const HandleTransform& move : edit_.handles)
    rotation_vectors_.push_back(move.rotation_vector);
  interpolate_rotations(weights_, rotation_vectors_, G_);
  if (rows_.fits_scale)
    for (int c = 0; c < cell_count(); ++c)
      if (prescribed_[c])
        for (long h = 0; h < weights_.cols(); ++h)
          if (weights_(c, h) == 1) G_[c] *= edit_.handles[h].scale;
  if (!guess) return;
  evaluate_rows();
  local_step();
}

void LocalGlobalSolver::evaluate_rows() {
  parallel_chunks<kChunk>(element_count(), [&](long first, long last) {
    for (long e = first; e < last; ++e) {
      covariances_[e].setZero();
      for (int r = rows_.row_start[e]; r < rows_.row_start[e + 1]; ++r) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (RowMatrix::InnerIterator a(rows_.A, r); a; ++a) sum += a.value() * p_.row(a.col());
        now_.row(r) = sum;
        covariances_[e] += sum.transpose() * rows_.base.row(r);
      }
    }
  });
}

Mat3 LocalGlobalSolver::cell_covariance(int c) const {
  Mat3 M = Mat3::Zero();
  for (int k = element_start_[c]; k < element_start_[c + 1]; ++k) M += covariances_[elements_[k]];
  M /= rows_.cells_of_element;
  for (int k = link_start_[c]; k < link_start_[c + 1]; ++k) M += link_weight_[k] * G_[linked_[k]];
  return M;
}

// Local step for up to eight cells, none of which depends on another.
template <class CellOf>
void LocalGlobalSolver::local_step_batch(int count, const CellOf& cell_of) {
  RotationBatch M, R;
  for (int l = 0; l < RotationBatch::kLanes; ++l)
    M.set(l, l < count ? cell_covariance(cell_of(l)) : Mat3::Identity());
  nearest_rotations(M, R);
  for (int l = 0; l < count; ++l) {
    const int c = cell_of(l);
    if (prescribed_[c]) continue;
    G_[c] = R.get(l);
    if (!rows_.fits_scale) continue;
    double square = 0;
    for (int k = element_start_[c]; k < element_start_[c + 1]; ++k)
      square += base_square_[elements_[k]];
    if (square > 0) G_[c] *= std::max(0.0, G_[c].cwiseProduct(M.get(l)).sum() / square);
  }
}

template <class CellOf>
void LocalGlobalSolver::local_step_independent(int count, const CellOf& cell_of) {
  constexpr int lanes = RotationBatch::kLanes;
  parallel_for_each<kChunk / lanes>((count + lanes - 1) / lanes, [&](int batch) {
    const int first = batch * lanes;
    local_step_batch(std::min(lanes, count - first), [&](int l) { return cell_of(first + l); });
  });
}

void LocalGlobalSolver::local_step() {
  if (colour_start_.empty()) {
    local_step_independent(cell_count(), [](int c) { return c; });
    return;
  }
  for (size_t colour = 0; colour + 1 < colour_start_.size(); ++colour) {
    const int first = colour_start_[colour];
    local_step_independent(colour_start_[colour + 1] - first,
                           [&](int k) { return coloured_[first + k]; });
  }
}

double LocalGlobalSolver::energy() {
  const int m = rows_.cells_of_element;
  std::fill(energy_parts_.begin(), energy_parts_.end(), 0.0);
  parallel_chunks<kChunk>(element_count(), [&](long first, long last) {
    double sum = 0;
    for (long e = first; e < last; ++e)
      for (int k = 0; k < m; ++k) {
        const Mat3& G = G_[rows_.cells[e * m + k]];
        for (int r = rows_.row_start[e]; r < rows_.row_start[e + 1]; ++r)
          sum += (now_.row(r).transpose() - G * rows_.base.row(r).transpose()).squaredNorm() / m;
      }
    energy_parts_[first / kChunk] += sum;
  });
  if (!rows_.links.empty())
    parallel_chunks<kChunk>(cell_count(), [&](long first, long last) {
      double sum = 0;
      for (long c = first; c < last; ++c)
        for (int k = link_start_[c]; k < link_start_[c + 1]; ++k)
          // each link is visited from both ends
          sum += link_weight_[k] * (G_[c] - G_[linked_[k]]).squaredNorm() / 2;
      energy_parts_[first / kChunk] += sum;
    });
  double total = 0;
  for (const double part : energy_parts_) total += part;
  return total / 2;
}

void LocalGlobalSolver::global_step() {
  const int m = rows_.cells_of_element;
  parallel_chunks<kChunk>(element_count(), [&](long first, long last) {
    for (long e = first; e < last; ++e) {
      Mat3 G = G_[rows_.cells[e * m]];
      for (int k = 1; k < m; ++k) G += G_[rows_.cells[e * m + k]];
      for (int r = rows_.row_start[e]; r < rows_.row_start[e + 1]; ++r)
        residual_.row(r) =
            (G * rows_.base.row(r).transpose()).transpose() / m - constrained_part_.row(r);
    }
  });
  parallel_chunks(B_.cols(), [&](long first, long last) {
    for (long c = first; c < last; ++c) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (SparseMatrix::InnerIterator b(B_, c); b; ++b) sum += b.value() * residual_.row(b.row());
      next_.row(c) = sum;
    }
  });
  if (B_.cols() > 0) factor_.solve_in_place(next_);
}

double LocalGlobalSolver::update_rotations() {
  const auto& free = positions_.free_dofs();
  for (size_t k = 0; k < free.size(); ++k) p_.row(free[k]) = y_.row(static_cast<long>(k));
  for (const auto& [vertex, of] : coincident_vertices_) p_.row(vertex) = p_.row(of);
  evaluate_rows();
  local_step();
  return energy();
}

double LocalGlobalSolver::iterate(double energy_before) {
  if (rows_.links.empty()) return LocalGlobalIteration::iterate(energy_before);
  const auto iteration = [&] {
    for (int c = 0; c < cell_count(); ++c) rotations_before_.middleRows<3>(3L * c) = G_[c];
    solve_unknowns();
    y_.swap(next_);
    return update_rotations();
  };
  double now = iteration();
  if (is_increased(now, energy_before)) {  // the accelerated rotations increased the energy
    restore_rotations();
    accelerator_.reset();
    now = iteration();
  }
  for (int c = 0; c < cell_count(); ++c) rotations_.middleRows<3>(3L * c) = G_[c];
  store_rotations();
  if (accelerator_.accelerate(rotations_before_, rotations_, accelerated_))
    parallel_for_each<kChunk>(cell_count(), [&](int c) {
      if (!prescribed_[c]) G_[c] = nearest_rotation(accelerated_.middleRows<3>(3L * c));
    });
  return now;
}

const Points& LocalGlobalSolver::deform(std::span<const HandleTransform> moves, const Points* guess,
                                        int max_iterations, double tolerance) {
  edit_.handles.assign(moves.begin(), moves.end());
  check(problem_, edit_);
  if (guess && (guess->rows() != points_.rows() || !guess->allFinite()))
    throw InputError(name_ + ": the initial guess has " + std::to_string(guess->rows()) +
                     " points, expected " + std::to_string(points_.rows()) + " finite ones");
  set_constraint_rhs();
  start(guess);
  begin();
  report_.energies.reserve(max_iterations);
  run(max_iterations, tolerance);
  // The rotations that belong to the positions, not the accelerated ones.
  if (!rows_.links.empty()) restore_rotations();
  result_ = p_.rowwise() + origin_.transpose();
  // Constrained vertices are exactly at their prescribed positions, to the last bit.
  for (size_t k = 0; k < constrained_vertex_.size(); ++k) {
    const Vec3 at = points_.row(constrained_vertex_[k]).transpose();
    result_.row(constrained_vertex_[k]) =
        constrained_handle_[k] < 0 ? at : edit_.handles[constrained_handle_[k]](at);
  }
  return result_;
}

}  // namespace batten
