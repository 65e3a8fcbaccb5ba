// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/deform/deform_system.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/mesh/differential_operators.h"

namespace batten {
namespace {

/// Visits the vertices of all point constraints, chains and linear constraints.
template <class Visit>
void for_each_constrained_vertex(const DeformProblem& problem, const Visit& visit) {
  for (const auto& g : problem.point_constraints)
    for (const auto& e : g.point.entries) visit(e.vertex);
  for (const auto& c : problem.chains)
    for (const int v : c.vertices) visit(v);
  for (const auto& r : problem.rows) {
    for (const auto& e : r.combination.entries) visit(e.vertex);
    if (r.rotates_with >= 0) visit(r.rotates_with);
  }
}

/// Cotangent weights ½ (cot α + cot β) of the edges at each vertex.
class OneRingWeights {
 public:
  explicit OneRingWeights(const TriangleMesh& mesh) : start_(mesh.vertex_count() + 1, 0) {
    const MeshTopology& topology = mesh.topology();
    for (int v = 0; v < mesh.vertex_count(); ++v)
      start_[v + 1] = start_[v] + static_cast<int>(topology.neighbours(v).size());
    weight_.resize(start_.back());
    // In the order of neighbours(v): first the lower ones, then the higher ones, both in edge
    // order.
    const std::vector<double> of_edge = edge_cotangents(mesh);
    std::vector<int> next(start_.begin(), start_.end() - 1);
    for (size_t e = 0; e < of_edge.size(); ++e)
      weight_[next[topology.edges()[e].high]++] = of_edge[e];
    for (size_t e = 0; e < of_edge.size(); ++e)
      weight_[next[topology.edges()[e].low]++] = of_edge[e];
  }
  /// Weight of the edge from v to its neighbour k.
  double at(int v, size_t k) const { return weight_[start_[v] + static_cast<int>(k)]; }

 private:
  std::vector<int> start_;
  std::vector<double> weight_;
};

}  // namespace

DeformSystem::DeformSystem(const TriangleMesh& mesh, const DeformProblem& problem)
    : positions(0), rotations(0) {
  const MeshTopology& topology = mesh.topology();
  for (const auto& f : problem.features) feature_vertices_.push_back(sorted_unique(f.vertices));
  find_parts(topology, problem);
  order_features();
  find_constrained(topology, problem);

  origin = mesh.triangle_count() > 0 ? mesh.box().center() : Vec3(Vec3::Zero());
  rest = mesh.points().rowwise() - origin.transpose();

  number_dofs(topology, problem);
  positions = ConstraintSet(isize(vertex));
  rotations = ConstraintSet(isize(vertex));
  add_soft_rows(mesh, problem);
  add_hard_rows(topology, problem);
}

void DeformSystem::find_parts(const MeshTopology& topology, const DeformProblem& problem) {
  const int n = topology.vertex_count(), components = topology.component_count();
  DisjointSets groups(components + n);
  const auto node = [&](int v) {
    return topology.component()[v] >= 0 ? topology.component()[v] : components + v;
  };
  for (const auto& vertices : feature_vertices_)
    for (const int v : vertices) groups.unite(node(vertices[0]), node(v));
  for (int v = topology.node_count(); v < n; ++v) groups.unite(node(topology.node_of(v)), node(v));
  for (const LinearConstraint& row : problem.rows)
    if (row.connects)
      for (const auto& e : row.combination.entries)
        groups.unite(node(row.combination.entries[0].vertex), node(e.vertex));
  std::vector<int> number_dofs(components + n, -1);
  part_.resize(n);
  for (int v = 0; v < n; ++v) {
    int& part = number_dofs[groups.find(node(v))];
    if (part < 0) part = part_count_++;
    part_[v] = part;
  }
}

void DeformSystem::order_features() {
  const auto count = isize(feature_vertices_);
  std::vector<std::pair<int, int>> members;  // vertex, feature
  for (int f = 0; f < count; ++f)
    for (const int v : feature_vertices_[f]) members.emplace_back(v, f);
  std::sort(members.begin(), members.end());
  std::vector<std::vector<std::pair<int, int>>> shared(count);  // other feature, vertex
  for (size_t a = 0, b = 0; a < members.size(); a = b) {
    while (b < members.size() && members[b].first == members[a].first) ++b;
    // A chain through all features that meet here connects them as well as all pairs would.
    for (size_t k = a + 1; k < b; ++k) {
      shared[members[k - 1].second].emplace_back(members[k].second, members[a].first);
      shared[members[k].second].emplace_back(members[k - 1].second, members[a].first);
    }
  }
  std::vector<int> by_highest(count);
  std::iota(by_highest.begin(), by_highest.end(), 0);
  std::stable_sort(by_highest.begin(), by_highest.end(), [&](int f, int g) {
    return feature_vertices_[f].back() > feature_vertices_[g].back();
  });
  reference_.assign(count, -1);
  for (const int first : by_highest) {
    if (reference_[first] >= 0) continue;
    reference_[first] = feature_vertices_[first].back();
    feature_order_.push_back(first);
    for (size_t next = feature_order_.size() - 1; next < feature_order_.size(); ++next)
      for (const auto& [other, v] : shared[feature_order_[next]])
        if (reference_[other] < 0) {
          reference_[other] = v;
          feature_order_.push_back(other);
        }
  }
}

void DeformSystem::find_constrained(const MeshTopology& topology, const DeformProblem& problem) {
  const int n = topology.vertex_count();
  constrained_by.assign(n, problem.region ? kOutside : kFree);
  if (problem.region)
    for (const int v : *problem.region) constrained_by[v] = kFree;
  for (const int v : problem.fixed) constrained_by[v] = kFixed;
  for (size_t h = 0; h < problem.handles.size(); ++h)
    for (const int v : problem.handles[h].vertices)
      if (constrained_by[v] < 0) constrained_by[v] = static_cast<int>(h);

  // Parts without constraints stay. A linear constraint fixes a part unless its coefficients there
  // sum to zero (a difference within the part).
  std::vector<char> is_constrained(part_count_, 0);
  for (int v = 0; v < n; ++v)
    if (constrained_by[v] != kFree) is_constrained[part_[v]] = 1;
  for (const auto& r : problem.rows) {
    std::map<int, double> sum, size;
    for (const auto& e : r.combination.entries) {
      sum[part_[e.vertex]] += e.coefficient;
      size[part_[e.vertex]] += std::abs(e.coefficient);
    }
    for (const auto& [part, total] : sum)
      if (std::abs(total) > 1e-9 * size[part]) is_constrained[part] = 1;
  }
  std::vector<char> unconnected(part_count_, 0);
  for (int v = 0; v < n; ++v) {
    if (constrained_by[v] != kFree || is_constrained[part_[v]]) continue;
    constrained_by[v] = kUnconnected;
    if (!topology.neighbours(v).empty()) unconnected[part_[v]] = 1;
  }
  if (const auto left = std::count(unconnected.begin(), unconnected.end(), 1); left > 0)
    notes.push_back(std::to_string(left) + (left == 1 ? " part" : " parts") +
                    " of the mesh without fixed nodes and handles (not moved)");
}

void DeformSystem::number_dofs(const MeshTopology& topology, const DeformProblem& problem) {
  const int n = topology.vertex_count();
  std::vector<char> part(n, 0);
  for (int v = 0; v < n; ++v) {
    if (constrained_by[v] != kFree) continue;
    ++moving;
    part[v] = 1;
    for (const int u : topology.neighbours(v)) {
      part[u] = 1;
      if (constrained_by[u] != kFree)
        for (const int w : topology.neighbours(u)) part[w] = 1;
    }
  }
  for (const auto& vertices : feature_vertices_)
    for (const int v : vertices) part[v] = 1;
  for_each_constrained_vertex(problem, [&](int v) { part[v] = 1; });
  // Vertices constrained twice: the reduction decides whether that is a conflict.
  std::vector<int> times(n, 0);
  for (const int v : sorted_unique(problem.fixed)) times[v] = 1;
  for (const auto& h : problem.handles)
    for (const int v : sorted_unique(h.vertices))
      if (++times[v] > 1) part[v] = 1;
  dof.assign(n, -1);
  for (int v = 0; v < n; ++v)
    if (part[v]) {
      dof[v] = isize(vertex);
      vertex.push_back(v);
    }
}

std::vector<int> DeformSystem::curved_vertices(const MeshTopology& topology) const {
  std::vector<int> rows;
  for (const int v : vertex) {
    const auto ring = topology.neighbours(v);
    bool moves = constrained_by[v] == kFree, rigid = feature_of_[v] >= 0;
    for (const int u : ring) {
      moves = moves || constrained_by[u] == kFree;
      rigid = rigid && feature_of_[u] == feature_of_[v];
    }
    if (moves && !rigid && !ring.empty()) rows.push_back(v);
  }
  return rows;
}

int DeformSystem::scale_of(int v) const {
  if (feature_of_[v] >= 0) return feature_of_[v];
  return constrained_by[v] >= 0 ? isize(feature_vertices_) + constrained_by[v] : -1;
}

std::vector<DeformSystem::SoftRow> DeformSystem::soft_constraint_rows(
    const DeformProblem& problem) const {
  std::vector<SoftRow> rows;
  for (const auto& chain : problem.chains) add_chain(chain, problem.weighting, rows);
  for (size_t r = 0; r < problem.rows.size(); ++r) {
    const LinearConstraint& row = problem.rows[r];
    if (!row.weight) continue;
    // The right-hand side is set at each edit.
    SoftRow soft_rows{{},
                      Vec3::Zero(),
                      row.rotates_with < 0 ? -1 : dof[row.rotates_with],
                      -1,
                      static_cast<int>(r)};
    for (const auto& e : row.combination.entries)
      soft_rows.terms.emplace_back(dof[e.vertex], std::sqrt(*row.weight) * e.coefficient);
    rows.push_back(std::move(soft_rows));
  }
  for (SoftRow& row : rows) {
    auto& terms = row.terms;
    std::sort(terms.begin(), terms.end());
    for (size_t i = 1; i < terms.size();)
      if (terms[i].first == terms[i - 1].first) {
        terms[i - 1].second += terms[i].second;
        terms.erase(terms.begin() + static_cast<long>(i));
      } else {
        ++i;
      }
  }
  return rows;
}

void DeformSystem::add_soft_rows(const TriangleMesh& mesh, const DeformProblem& problem) {
  const MeshTopology& topology = mesh.topology();
  feature_of_.assign(mesh.vertex_count(), -1);
  for (size_t f = 0; f < feature_vertices_.size(); ++f)
    for (const int v : feature_vertices_[f]) feature_of_[v] = static_cast<int>(f);
  const bool hinges = problem.bending == DeformProblem::Bending::Hinges;
  const std::vector<int> curved = hinges ? std::vector<int>() : curved_vertices(topology);
  const std::vector<SoftRow> soft_rows = soft_constraint_rows(problem);
  const long hinge_rows = hinges ? static_cast<long>(topology.edges().size()) : 0;
  long entries = 4 * hinge_rows;
  for (const int v : curved) entries += static_cast<long>(topology.neighbours(v).size()) + 1;
  for (const SoftRow& row : soft_rows) entries += static_cast<long>(row.terms.size());
  const auto rows = static_cast<long>(curved.size() + soft_rows.size()) + hinge_rows;
  A.resize(rows, static_cast<long>(vertex.size()));
  A.reserve(entries);
  base.resize(rows, 3);
  add_curvature_rows(mesh, curved, problem.weighting);
  if (hinges) add_hinge_rows(mesh, problem.weighting);
  curvature_rows = static_cast<long>(linear_constraint_of_row.size());
  for (const SoftRow& row : soft_rows) {
    const auto r = static_cast<long>(linear_constraint_of_row.size());
    A.startVec(r);
    for (const auto& [d, c] : row.terms) A.insertBack(r, d) = c;
    base.row(r) = row.base;
    rotates_with.push_back(row.rotates_with);
    scaled_by.push_back(row.scaled_by);
    linear_constraint_of_row.push_back(row.target);
  }
  A.finalize();
  A.conservativeResize(static_cast<long>(linear_constraint_of_row.size()), A.cols());
  base.conservativeResize(A.rows(), 3);
}

void DeformSystem::add_hinge_rows(const TriangleMesh& mesh, DeformProblem::Weighting weighting) {
  const MeshTopology& topology = mesh.topology();
  const auto opposite = [&](int triangle, int a, int b) {
    const auto& corners = topology.triangles()[triangle];
    return *std::find_if(corners.begin(), corners.end(), [&](int v) { return v != a && v != b; });
  };
  for (const auto& edge : topology.edges()) {
    if (edge.left < 0 || edge.right < 0) continue;
    const std::array<int, 4> hinge{edge.low, edge.high, opposite(edge.left, edge.low, edge.high),
                                   opposite(edge.right, edge.low, edge.high)};
    const bool known = std::all_of(hinge.begin(), hinge.end(), [&](int v) { return dof[v] >= 0; });
    const bool moves = known && std::any_of(hinge.begin(), hinge.end(),
                                            [&](int v) { return constrained_by[v] == kFree; });
    const bool rigid = feature_of_[hinge[0]] >= 0 &&
                       std::all_of(hinge.begin(), hinge.end(),
                                   [&](int v) { return feature_of_[v] == feature_of_[hinge[0]]; });
    if (moves && !rigid) add_hinge_row(mesh, hinge, weighting);
  }
}

// The jump of the slope across the edge i, j between the corners k and l of its triangles, divided by
// the mean of both heights: the second derivative across the edge, on a regular mesh without a third
// of that along it. The weight, the area of both triangles, gives a bent cylinder the energy of the
// Laplacian, for equilateral triangles and for halved squares.
void DeformSystem::add_hinge_row(const TriangleMesh& mesh, const std::array<int, 4>& hinge,
                                 DeformProblem::Weighting weighting) {
  const auto& [i, j, k, l] = hinge;
  const Vec3 along = mesh.point(j) - mesh.point(i);
  const double length = along.norm();
  std::array<double, 4> row{};
  double heights = 0;
  for (const int corner : {2, 3}) {
    const Vec3 to = mesh.point(hinge[corner]) - mesh.point(i);
    const double foot = to.dot(along) / (length * length), height = (to - foot * along).norm();
    constexpr double flattest = 1e-3;  // of the length of the edge
    const double slope = 1 / std::max(height, flattest * length);
    row[corner] = slope;
    row[0] -= (1 - foot) * slope;
    row[1] -= foot * slope;
    heights += height;
  }
  const double area = heights * length / 2;
  double scale = std::sqrt(area) * 2 / heights;
  if (weighting == DeformProblem::Weighting::Uniform) scale /= std::sqrt(area / 3);
  const auto r = static_cast<long>(linear_constraint_of_row.size());
  std::array<int, 4> order{0, 1, 2, 3};
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return dof[hinge[a]] < dof[hinge[b]]; });
  A.startVec(r);
  Vec3 sum = Vec3::Zero();
  for (const int c : order) {
    A.insertBack(r, dof[hinge[c]]) = scale * row[c];
    sum += scale * row[c] * rest.row(hinge[c]).transpose();
  }
  base.row(r) = sum;
  rotates_with.push_back(dof[i]);
  scaled_by.push_back(scale_of(i));
  linear_constraint_of_row.push_back(-1);
}

void DeformSystem::add_curvature_rows(const TriangleMesh& mesh, const std::vector<int>& vertices,
                                      DeformProblem::Weighting weighting) {
  const MeshTopology& topology = mesh.topology();
  const OneRingWeights weights(mesh);
  const VecX area = mixed_areas(mesh);
  for (const int v : vertices) {
    const auto r = static_cast<long>(linear_constraint_of_row.size());
    const auto ring = topology.neighbours(v);
    const double scale =
        weighting == DeformProblem::Weighting::Area ? 0.5 / std::sqrt(area[v]) : 0.5 / area[v];
    Vec3 sum = Vec3::Zero();
    double own = 0;
    for (size_t k = 0; k < ring.size(); ++k) {
      const double w = scale * weights.at(v, k);
      own += w;
      sum += w * (rest.row(v) - rest.row(ring[k])).transpose();
    }
    A.startVec(r);
    bool done = false;
    for (size_t k = 0; k < ring.size(); ++k) {
      if (!done && ring[k] > v) {
        A.insertBack(r, dof[v]) = own;
        done = true;
      }
      A.insertBack(r, dof[ring[k]]) = -scale * weights.at(v, k);
    }
    if (!done) A.insertBack(r, dof[v]) = own;
    base.row(r) = sum;
    rotates_with.push_back(dof[v]);
    scaled_by.push_back(scale_of(v));
    linear_constraint_of_row.push_back(-1);
  }
}

void DeformSystem::add_chain(const CharacterChain& chain, DeformProblem::Weighting weighting,
                             std::vector<SoftRow>& rows) const {
  const auto& v = chain.vertices;
  const size_t n = v.size();
  const auto at = [&](size_t k) { return rest.row(v[k % n]).transpose(); };
  for (size_t k = chain.closed ? 0 : 1; k < (chain.closed ? n : n - 1); ++k) {
    const size_t before = (k + n - 1) % n, after = (k + 1) % n;
    const double l0 = (at(k) - at(before)).norm(), l1 = (at(after) - at(k)).norm();
    if (!(l0 > 0 && l1 > 0))
      throw InputError("chain '" + chain.name + "' has coincident neighbours at vertex " +
                       std::to_string(v[k]));
    const double a = (l0 + l1) / 2;
    const double w = weighting == DeformProblem::Weighting::Area ? std::sqrt(chain.width / a)
                                                                 : std::sqrt(chain.width / a) / a;
    rows.push_back(
        {{{dof[v[before]], w / l0}, {dof[v[k]], -w / l0 - w / l1}, {dof[v[after]], w / l1}},
         w * ((at(after) - at(k)) / l1 - (at(k) - at(before)) / l0),
         dof[v[k]],
         scale_of(v[k]),
         -1});
  }
}

void DeformSystem::add_hard_rows(const MeshTopology& topology, const DeformProblem& problem) {
  const auto fix_vertex = [&](const std::string& name, int v, Value::Kind kind, int source) {
    positions.fix(name, dof[v], Vec3::Zero());
    values.push_back({kind, source, v, -1});
    rotations.fix(name, dof[v], Vec3::Zero());
    rotated_by.push_back(kind == Value::Kind::Handle ? source : -1);
  };
  for (const int v : sorted_unique(problem.fixed))
    if (dof[v] >= 0) fix_vertex("fixed", v, Value::Kind::Fixed, -1);
  for (const int v : vertex)
    if (constrained_by[v] == kOutside || constrained_by[v] == kUnconnected)
      fix_vertex(
          constrained_by[v] == kOutside ? "outside the region of interest" : "unconstrained part",
          v, Value::Kind::Fixed, -1);
  for (size_t h = 0; h < problem.handles.size(); ++h)
    for (const int v : sorted_unique(problem.handles[h].vertices))
      if (dof[v] >= 0)
        fix_vertex(problem.handles[h].name, v, Value::Kind::Handle, static_cast<int>(h));
  const size_t fixed_equations = values.size();
  feature_dof.resize(problem.features.size());
  for (const int f : feature_order_) {
    const std::string& name = problem.features[f].name;
    const int reference = reference_[f];
    feature_dof[f] = dof[reference];
    const bool rotates = problem.features[f].kind == FormFeature::Kind::Free;
    for (const int v : feature_vertices_[f]) {
      if (!rotates) {
        rotations.fix(name, dof[v], Vec3::Zero());
        rotated_by.push_back(-1);
      }
      if (v == reference) continue;
      positions.add(name, {{dof[v], 1.0}, {dof[reference], -1.0}}, Vec3::Zero());
      values.push_back({Value::Kind::Feature, f, v, reference});
      if (rotates) {
        rotations.add(name, {{dof[v], 1.0}, {dof[reference], -1.0}}, Vec3::Zero());
        rotated_by.push_back(-1);
      }
    }
  }
  feature_constraints = static_cast<int>(values.size() - fixed_equations);
  for (const auto& group : problem.shared_rotations)
    for (size_t i = 1; i < group.size(); ++i) {
      rotations.add(problem.features[group[i]].name,
                    {{feature_dof[group[i]], 1.0}, {feature_dof[group[0]], -1.0}}, Vec3::Zero());
      rotated_by.push_back(-1);
    }
  for (int v = topology.node_count(); v < topology.vertex_count(); ++v)
    if (constrained_by[v] == kFree && feature_of_[v] < 0) {
      const std::vector<ConstraintSet::Entry> one_place{{dof[v], 1.0},
                                                        {dof[topology.node_of(v)], -1.0}};
      positions.add("non-manifold edge", one_place, Vec3::Zero());
      values.push_back({Value::Kind::CoincidentVertices, -1, -1, -1});
      rotations.add("non-manifold edge", one_place, Vec3::Zero());
      rotated_by.push_back(-1);
    }
  add_tied_rotations(problem);
  for (size_t r = 0; r < problem.rows.size(); ++r) {
    const LinearConstraint& row = problem.rows[r];
    if (row.weight) continue;
    std::vector<ConstraintSet::Entry> entries;
    for (const auto& e : row.combination.entries) entries.push_back({dof[e.vertex], e.coefficient});
    positions.add(row.name, std::move(entries), Vec3::Zero());
    values.push_back({Value::Kind::Row, static_cast<int>(r), -1, -1});
  }

  // A part that only position constraints hold does not rotate: one of its vertices, of no feature if
  // there is one, because features rotate by estimates.
  std::vector<char> is_determined(part_count_, 0);
  for (const auto& row : rotations.constraints())
    if (row.entries.size() == 1) is_determined[part_[vertex[row.entries[0].dof]]] = 1;
  for (const bool of_features : {false, true})
    for (const int v : vertex) {
      if (is_determined[part_[v]] || (feature_of_[v] >= 0) != of_features) continue;
      is_determined[part_[v]] = 1;
      rotations.fix("no rotation", dof[v], Vec3::Zero());
      rotated_by.push_back(-1);
    }
}

/// Parts that are tied rotate together. A feature takes the rotation of one tie only.
void DeformSystem::add_tied_rotations(const DeformProblem& problem) {
  std::vector<char> is_held(feature_vertices_.size(), 0);
  for (int v = 0; v < isize(constrained_by); ++v)
    if (feature_of_[v] >= 0 && constrained_by[v] != kFree) is_held[feature_of_[v]] = 1;
  for (const LinearConstraint& row : problem.rows) {
    if (!row.connects || row.rotates_with < 0) continue;
    const int v = row.combination.entries[0].vertex, feature = feature_of_[v];
    if (constrained_by[v] != kFree || (feature >= 0 && is_held[feature])) continue;
    if (feature >= 0) is_held[feature] = 1;
    rotations.add(row.name, {{dof[v], 1.0}, {dof[row.rotates_with], -1.0}}, Vec3::Zero());
    rotated_by.push_back(-1);
  }
}

SparseMatrix laplacian_of(const DeformSystem& system, const TriangleMesh& mesh) {
  const SparseMatrix all = cotangent_laplacian(mesh);
  if (isize(system.vertex) == mesh.vertex_count()) return all;
  const auto n = isize(system.vertex);
  SparseMatrix L(n, n);
  L.reserve(all.nonZeros());
  for (int d = 0; d < n; ++d) {
    L.startVec(d);
    for (SparseMatrix::InnerIterator it(all, system.vertex[d]); it; ++it)
      if (system.dof[it.row()] >= 0) L.insertBack(system.dof[it.row()], d) = it.value();
  }
  L.finalize();
  return L;
}

RowMatrix reduced_matrix(const RowMatrix& A, const AffineReduction& reduction) {
  const RowMatrix D = reduction.D();
  RowMatrix B(A.rows(), D.cols());
  B.reserve(A.nonZeros());
  std::vector<std::pair<int, double>> terms;
  for (long r = 0; r < A.rows(); ++r) {
    terms.clear();
    for (RowMatrix::InnerIterator a(A, r); a; ++a)
      for (RowMatrix::InnerIterator d(D, a.col()); d; ++d)
        terms.emplace_back(d.col(), a.value() * d.value());
    std::stable_sort(terms.begin(), terms.end(),
                     [](const auto& x, const auto& y) { return x.first < y.first; });
    B.startVec(r);
    for (size_t i = 0; i < terms.size();) {
      const int column = terms[i].first;
      double sum = 0;
      for (; i < terms.size() && terms[i].first == column; ++i) sum += terms[i].second;
      B.insertBack(r, column) = sum;
    }
  }
  B.finalize();
  return B;
}

SparseMatrix normal_matrix(const SparseMatrix& B, const RowMatrix& rows) {
  const long n = B.cols();
  const long block = std::max<long>(2048, n / 8 + 1), blocks = (n + block - 1) / block;
  std::vector<std::vector<int>> index(blocks);
  std::vector<std::vector<double>> value(blocks);
  std::vector<int> length(n, 0);
  parallel_for(static_cast<int>(blocks), [&](int part) {
    std::vector<double> sum(n, 0);
    std::vector<int> mark(n, -1), list;
    const long first = part * block, last = std::min(n, first + block);
    for (long c = first; c < last; ++c) {
      list.clear();
      for (SparseMatrix::InnerIterator b(B, c); b; ++b) {
        const int* columns = rows.innerIndexPtr();
        const double* values = rows.valuePtr();
        const int end = rows.outerIndexPtr()[b.row() + 1];
        int k = end;
        while (k > rows.outerIndexPtr()[b.row()] && columns[k - 1] >= c) --k;
        for (; k < end; ++k) {
          const int r = columns[k];
          if (mark[r] != c) {
            mark[r] = static_cast<int>(c);
            sum[r] = 0;
            list.push_back(r);
          }
          sum[r] += b.value() * values[k];
        }
      }
      std::sort(list.begin(), list.end());
      length[c] = isize(list);
      for (const int r : list) {
        index[part].push_back(r);
        value[part].push_back(sum[r]);
      }
    }
  });
  SparseMatrix N(n, n);
  long entries = 0;
  for (const auto& part : index) entries += static_cast<long>(part.size());
  N.resizeNonZeros(entries);
  long at = 0;
  for (long p = 0; p < blocks; ++p) {
    std::copy(index[p].begin(), index[p].end(), N.innerIndexPtr() + at);
    std::copy(value[p].begin(), value[p].end(), N.valuePtr() + at);
    at += static_cast<long>(index[p].size());
  }
  N.outerIndexPtr()[0] = 0;
  for (long c = 0; c < n; ++c) N.outerIndexPtr()[c + 1] = N.outerIndexPtr()[c] + length[c];
  return N;
}

}  // namespace batten
