// SPDX-License-Identifier: MPL-2.0
#include "batten/mesh/regions/dual_laplacian_deformer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/mesh/regions/local_global_solver.h"

namespace batten {

// Polygonal faces, their dual mesh, and the rows of the energy.

/// Counterparts of the fields of DualLaplacianOptions.
struct DualLaplacianEnergyOptions {
  bool edge_midpoints, fits_scale;
  double membrane, poisson_ratio;
};

/// The face across each edge of each face (edge k joins corners k and k+1), or -1. Throws
/// InputError as described at DualLaplacianDeformer.
std::vector<std::vector<int>> face_adjacency(const std::vector<std::vector<int>>& faces,
                                             int vertex_count);

/// The triangles of a mesh as faces.
std::vector<std::vector<int>> faces_of(const TriangleMesh& mesh);

/// Unit mean normal of a polygon times twice its area.
Vec3 area_vector(const std::vector<int>& face, const Points& points);

/// Weights with Σ w = 1, nearest to 1/k, such that Σ w_j r_j is normal to the plane of the r_j.
VecX tangent_free_weights(const Eigen::Matrix3Xd& r);

/// The energy of DualLaplacianDeformer as rows, with one element and one cell per face, and one
/// element and cell per constrained vertex next to free ones. `constrained`: fixed vertices and
/// those of handles.
ArapEnergy dual_laplacian_energy(const TriangleMesh& mesh,
                                 const std::vector<std::vector<int>>& faces,
                                 std::vector<int> constrained,
                                 const DualLaplacianEnergyOptions& options);

namespace {

const DualLaplacianOptions& checked(const DualLaplacianOptions& options) {
  if (options.max_iterations < 1 || !(options.tolerance >= 0) || !(options.membrane > 0) ||
      !std::isfinite(options.membrane) || !(options.poisson_ratio >= 0) ||
      !(options.poisson_ratio <= 1))
    throw InputError("dual Laplacian deformer: found max_iterations = " +
                     std::to_string(options.max_iterations) +
                     ", tolerance = " + format_number(options.tolerance) +
                     ", membrane = " + format_number(options.membrane) +
                     ", poisson_ratio = " + format_number(options.poisson_ratio) +
                     ", expected 1 or more, 0 or more, above 0, 0 to 1");
  return options;
}

DualLaplacianEnergyOptions row_options(const DualLaplacianOptions& options) {
  return {options.border == DualLaplacianOptions::Border::EdgeMidpoints,
          options.lengths == DualLaplacianOptions::Lengths::Fitted, options.membrane,
          options.poisson_ratio};
}

std::vector<int> constrained_vertices(std::vector<int> fixed, const std::vector<Handle>& handles) {
  for (const Handle& handle : handles)
    fixed.insert(fixed.end(), handle.vertices.begin(), handle.vertices.end());
  return fixed;
}

}  // namespace

DualLaplacianDeformer::DualLaplacianDeformer(const TriangleMesh& mesh,
                                             std::vector<std::vector<int>> faces,
                                             std::vector<int> fixed, std::vector<Handle> handles,
                                             const DualLaplacianOptions& options)
    : IterativeDeformer(mesh, fixed, handles,
                        dual_laplacian_energy(mesh, faces.empty() ? faces_of(mesh) : faces,
                                              constrained_vertices(fixed, handles),
                                              row_options(checked(options))),
                        "dual Laplacian deformer", options.max_iterations, options.tolerance) {}

namespace {

using Faces = std::vector<std::vector<int>>;
using Terms = std::vector<std::pair<int, double>>;  // vertex, coefficient

void check_faces(const Faces& faces, int vertex_count) {
  for (size_t f = 0; f < faces.size(); ++f) {
    const std::string name = "face " + std::to_string(f);
    if (faces[f].size() < 3)
      throw InputError(name + " has " + std::to_string(faces[f].size()) +
                       " corners, expected three or more");
    std::vector<int> corners = faces[f];
    std::sort(corners.begin(), corners.end());
    for (size_t k = 0; k < corners.size(); ++k) {
      const std::string corner = "vertex " + std::to_string(corners[k]);
      if (corners[k] < 0 || corners[k] >= vertex_count)
        throw InputError(name + " uses " + corner + ", expected 0 to " +
                         std::to_string(vertex_count - 1));
      if (k > 0 && corners[k] == corners[k - 1])
        throw InputError(name + " has " + corner + " twice, expected distinct corners");
    }
  }
}

void add_mean(Terms& terms, const std::vector<int>& vertices, double factor) {
  for (const int v : vertices) terms.emplace_back(v, factor / static_cast<double>(vertices.size()));
}

/// Appends a row to A and its value on the rest shape to the base. Terms may be in any order and
/// repeat vertices.
void append(ArapEnergy& rows, long r, Terms& terms, const Points& rest) {
  std::stable_sort(terms.begin(), terms.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  Vec3 base = Vec3::Zero();
  rows.A.startVec(r);
  for (size_t i = 0; i < terms.size();) {
    const int v = terms[i].first;
    double sum = 0;
    for (; i < terms.size() && terms[i].first == v; ++i) sum += terms[i].second;
    rows.A.insertBack(r, v) = sum;
    base += sum * rest.row(v).transpose();
  }
  rows.base.row(r) = base.transpose();
}

class DualLaplacianAssembler {
 public:
  DualLaplacianAssembler(const TriangleMesh& mesh, const Faces& faces,
                         const std::vector<int>& constrained,
                         const DualLaplacianEnergyOptions& options)
      : faces_(faces), options_(options), size_(mesh.size()), n_(mesh.vertex_count()) {
    across_ = face_adjacency(faces, n_);
    is_constrained_.assign(n_, 0);
    for (const int v : constrained) is_constrained_[v] = 1;
    may_rotate_ = is_constrained_;
    for (const auto& face : faces)
      if (std::all_of(face.begin(), face.end(), [&](int v) { return is_constrained_[v]; }))
        for (const int v : face) may_rotate_[v] = 0;
    rest_ = mesh.points().rowwise() - mesh.points().colwise().mean();
    centres_.resize(static_cast<long>(faces.size()), 3);
    for (size_t f = 0; f < faces.size(); ++f)
      centres_.row(static_cast<long>(f)) = mean_of(faces[f]).transpose();
    find_clamped_edges();
  }

  ArapEnergy rows() {
    ArapEnergy rows;
    long count = 0;
    for (size_t f = 0; f < faces_.size(); ++f)
      count +=
          static_cast<long>(faces_[f].size()) + (has_laplacian(f) ? 1 : 0) + primal_row_count(f);
    std::vector<int> clamps;  // constrained vertices with clamped edges
    for (const ClampedEdge& edge : clamped_edges_)
      if (clamps.empty() || clamps.back() != edge.constrained) clamps.push_back(edge.constrained);
    rows.A.resize(count + isize(clamped_edges_), n_);
    rows.base.resize(count + isize(clamped_edges_), 3);
    rows.mean.resize(isize(faces_) + isize(clamps), n_);
    rows.cell_vertices.assign(faces_.size(), -1);
    rows.cell_vertices.insert(rows.cell_vertices.end(), clamps.begin(), clamps.end());
    rows.fits_scale = options_.fits_scale;
    long r = 0;
    for (size_t f = 0; f < faces_.size(); ++f) {
      const long first = r;
      if (has_laplacian(f)) add_laplacian(rows, r, f);
      if (options_.poisson_ratio < 1) add_primal_rows(rows, r, f);
      face_bending_.push_back({r, area(f), rows.base.middleRows(first, r - first).norm()});
      add_edges(rows, r, f);
      rows.row_start.push_back(static_cast<int>(r));
      rows.cells.push_back(static_cast<int>(f));
      auto corners = faces_[f];
      std::sort(corners.begin(), corners.end());
      rows.mean.startVec(static_cast<long>(f));
      for (const int v : corners)
        rows.mean.insertBack(static_cast<long>(f), v) = 1.0 / static_cast<double>(corners.size());
    }
    add_clamped_edges(rows, r);
    rows.A.finalize();
    rows.mean.finalize();
    scale_membrane_rows(rows);
    return rows;
  }

 private:
  Vec3 mean_of(const std::vector<int>& vertices) const {
    Vec3 sum = Vec3::Zero();
    for (const int v : vertices) sum += rest_.row(v).transpose();
    return sum / static_cast<double>(vertices.size());
  }

  bool has_laplacian(size_t f) const {
    return options_.edge_midpoints ||
           std::find(across_[f].begin(), across_[f].end(), -1) == across_[f].end();
  }

  double area(size_t f) const { return area_vector(faces_[f], rest_).norm() / 2; }

  void add_laplacian(ArapEnergy& rows, long& r, size_t f) {
    const auto k = faces_[f].size();
    const Vec3 own = centres_.row(static_cast<long>(f)).transpose();
    Eigen::Matrix3Xd to(3, k);
    const auto edge = [&](size_t j) {
      return std::vector<int>{faces_[f][j], faces_[f][(j + 1) % k]};
    };
    for (size_t j = 0; j < k; ++j) {
      const int other = across_[f][j];
      to.col(static_cast<long>(j)) =
          (other >= 0 ? Vec3(centres_.row(other).transpose()) : mean_of(edge(j))) - own;
    }
    const double c = to.colwise().squaredNorm().mean() / 4;
    const VecX w = tangent_free_weights(to);
    const double scale = c > 0 ? std::sqrt(options_.poisson_ratio * area(f)) / c : 0;
    terms_.clear();
    for (size_t j = 0; j < k; ++j) {
      const double weight = scale * w[static_cast<long>(j)];
      if (across_[f][j] >= 0)
        add_mean(terms_, faces_[across_[f][j]], weight);
      else
        add_mean(terms_, edge(j), weight);
    }
    add_mean(terms_, faces_[f], -scale);
    append(rows, r++, terms_, rest_);
  }

  /// Adds the membrane rows, weighted for μ_f = 1.
  void add_edges(ArapEnergy& rows, long& r, size_t f) {
    const auto k = faces_[f].size();
    const double square = square_of_edges(f);
    // A face of nearly zero area still holds its vertices together.
    const double weight = std::sqrt(square > 0 ? std::max(area(f) / square, 1e-3) : 1e-3);
    for (size_t j = 0; j < k; ++j) {
      terms_ = {{faces_[f][j], -weight}, {faces_[f][(j + 1) % k], weight}};
      append(rows, r++, terms_, rest_);
    }
  }

  void find_clamped_edges() {
    for (size_t f = 0; f < faces_.size(); ++f)
      for (size_t k = 0; k < faces_[f].size(); ++k) {
        int from = faces_[f][k], to = faces_[f][(k + 1) % faces_[f].size()];
        if (is_constrained_[from] == is_constrained_[to]) continue;
        if (is_constrained_[to]) std::swap(from, to);
        if (!may_rotate_[from]) continue;
        clamped_edges_.push_back({from, to, area(f) / 4});
      }
    std::sort(clamped_edges_.begin(), clamped_edges_.end(), [](const auto& a, const auto& b) {
      return std::tie(a.constrained, a.free) < std::tie(b.constrained, b.free);
    });
    // An edge between two faces was found twice.
    size_t count = 0;
    for (const ClampedEdge& edge : clamped_edges_)
      if (count > 0 && clamped_edges_[count - 1].constrained == edge.constrained &&
          clamped_edges_[count - 1].free == edge.free)
        clamped_edges_[count - 1].area += edge.area;
      else
        clamped_edges_[count++] = edge;
    clamped_edges_.resize(count);
  }

  /// The change of slope along an edge at a constrained vertex, whose surface has the rotation of
  /// its handle, divided by half of the length of the edge: the curvature of the half edge.
  void add_clamped_edges(ArapEnergy& rows, long& r) {
    long cell = isize(faces_) - 1;
    int last = -1;
    for (const auto& [constrained, free, area] : clamped_edges_) {
      if (constrained != last) {
        rows.mean.startVec(++cell);
        rows.mean.insertBack(cell, constrained) = 1;
        rows.cells.push_back(static_cast<int>(cell));
        rows.row_start.push_back(static_cast<int>(r));
      }
      last = constrained;
      const double square = (rest_.row(free) - rest_.row(constrained)).squaredNorm();
      const double scale = square > 0 ? std::sqrt(area) * 2 / square : 0;
      terms_ = {{free, scale}, {constrained, -scale}};
      append(rows, r++, terms_, rest_);
      rows.row_start.back() = static_cast<int>(r);
    }
  }

  void scale_membrane_rows(ArapEnergy& rows) const {
    double area = 0, bent = 0;
    for (const FaceBending& b : face_bending_) {
      area += b.area;
      bent += std::sqrt(b.area) * b.curvature;
    }
    const double mean = area > 0 ? bent / area : 0, far = size_ > 0 ? 1 / size_ : 1;
    for (size_t f = 0; f < face_bending_.size(); ++f) {
      const double own = face_bending_[f].area > 0
                             ? face_bending_[f].curvature / std::sqrt(face_bending_[f].area)
                             : 0;
      const double weight = std::sqrt(options_.membrane * far * far + mean * mean + own * own);
      for (long r = face_bending_[f].edges; r < rows.row_start[f + 1]; ++r) {
        rows.base.row(r) *= weight;
        for (RowMatrix::InnerIterator a(rows.A, r); a; ++a) a.valueRef() *= weight;
      }
    }
  }

  /// Number of primal rows: one per neighbour, and one per mode in which the k corners leave a
  /// plane.
  long primal_row_count(size_t f) const {
    if (!(options_.poisson_ratio < 1)) return 0;
    return std::count_if(across_[f].begin(), across_[f].end(), [](int g) { return g >= 0; }) +
           static_cast<long>(faces_[f].size()) - 3;
  }

  /// Appends the row in terms_ in units of curvature: divided by its value for unit second
  /// derivatives.
  void add_curvature_row(ArapEnergy& rows, long& r, size_t f) {
    Mat3 made = Mat3::Zero();
    for (const auto& [vertex, coefficient] : terms_) {
      const Vec3 u = (rest_.row(vertex) - centres_.row(static_cast<long>(f))).transpose();
      made += coefficient / 2 * u * u.transpose();
    }
    const double weights = 2 * (1 - options_.poisson_ratio) / static_cast<double>(faces_[f].size());
    const double scale = made.norm() > 0 ? std::sqrt(weights * area(f)) / made.norm() : 0;
    for (auto& [vertex, coefficient] : terms_) coefficient *= scale;
    append(rows, r++, terms_, rest_);
  }

  void add_primal_rows(ArapEnergy& rows, long& r, size_t f) {
    const auto k = static_cast<long>(faces_[f].size());
    const Vec3 n = area_vector(faces_[f], rest_).normalized();
    const Vec3 own = centres_.row(static_cast<long>(f)).transpose();
    const Vec3 e1 = n.unitOrthogonal(), e2 = n.cross(e1);
    const auto flat = [&](const Vec3& p) { return Vec3(1, e1.dot(p - own), e2.dot(p - own)); };
    MatX X(k, 3);
    for (long j = 0; j < k; ++j) X.row(j) = flat(rest_.row(faces_[f][j]).transpose()).transpose();
    const Svd svd = full_svd(X);
    const MatX from_corners = least_squares(X, MatX::Identity(k, k));
    // Corners beyond each edge, minus the values that the affine function through the corners of
    // the face predicts.
    for (long j = 0; j < k; ++j) {
      const int other = across_[f][j];
      if (other < 0) continue;
      std::vector<int> beyond;
      for (const int v : faces_[other])
        if (v != faces_[f][j] && v != faces_[f][(j + 1) % k]) beyond.push_back(v);
      const Vec3 at = flat(mean_of(beyond));
      const VecX weights = from_corners.transpose() * at;
      terms_.clear();
      add_mean(terms_, beyond, 1);
      for (long i = 0; i < k; ++i) terms_.emplace_back(faces_[f][i], -weights[i]);
      add_curvature_row(rows, r, f);
    }
    for (long d = 3; d < k; ++d) {
      terms_.clear();
      for (long i = 0; i < k; ++i) terms_.emplace_back(faces_[f][i], svd.U(i, d));
      add_curvature_row(rows, r, f);
    }
  }

  double square_of_edges(size_t f) const {
    double sum = 0;
    for (size_t j = 0; j < faces_[f].size(); ++j)
      sum += (rest_.row(faces_[f][(j + 1) % faces_[f].size()]) - rest_.row(faces_[f][j]))
                 .squaredNorm();
    return sum;
  }

  /// Index of the first edge row of a face, its area, and its curvature times √area.
  struct FaceBending {
    long edges;
    double area, curvature;
  };

  /// An edge from a constrained vertex to a free one, and the area that belongs to its half.
  struct ClampedEdge {
    int constrained, free;
    double area;
  };

  const Faces& faces_;
  const DualLaplacianEnergyOptions& options_;
  double size_;
  int n_;
  Faces across_;
  Points rest_, centres_;
  Terms terms_;
  std::vector<FaceBending> face_bending_;
  std::vector<char> is_constrained_;
  std::vector<char> may_rotate_;  // constrained vertices without constrained faces
  std::vector<ClampedEdge> clamped_edges_;
};

}  // namespace

Faces face_adjacency(const Faces& faces, int vertex_count) {
  check_faces(faces, vertex_count);
  struct Side {
    std::array<int, 2> edge;  // lower vertex first
    int face, number;
  };
  std::vector<Side> sides;
  Faces across(faces.size());
  for (size_t f = 0; f < faces.size(); ++f) {
    across[f].assign(faces[f].size(), -1);
    for (size_t k = 0; k < faces[f].size(); ++k) {
      const auto [low, high] = std::minmax(faces[f][k], faces[f][(k + 1) % faces[f].size()]);
      sides.push_back({{low, high}, static_cast<int>(f), static_cast<int>(k)});
    }
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.edge < b.edge; });
  for (size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side &a = sides[i], &b = sides[i + 1];
    if (a.edge != b.edge) continue;
    if (i + 2 < sides.size() && sides[i + 2].edge == a.edge)
      throw InputError("the edge between vertices " + std::to_string(a.edge[0]) + " and " +
                       std::to_string(a.edge[1]) +
                       " has more than two faces, expected at most two");
    across[a.face][a.number] = b.face;
    across[b.face][b.number] = a.face;
  }
  return across;
}

Faces faces_of(const TriangleMesh& mesh) {
  Faces faces;
  for (const auto& t : mesh.triangles()) faces.emplace_back(t.begin(), t.end());
  return faces;
}

Vec3 area_vector(const std::vector<int>& face, const Points& points) {
  const Vec3 from = points.row(face[0]).transpose();
  Vec3 sum = Vec3::Zero();
  for (size_t k = 1; k + 1 < face.size(); ++k)
    sum +=
        (points.row(face[k]).transpose() - from).cross(points.row(face[k + 1]).transpose() - from);
  return sum;
}

VecX tangent_free_weights(const Eigen::Matrix3Xd& r) {
  const long k = r.cols();
  const VecX even = VecX::Constant(k, 1.0 / static_cast<double>(k));
  const Vec3 mean = r.rowwise().mean();
  const Eigen::Matrix3Xd centred = r.colwise() - mean;
  const Svd svd = thin_svd(centred);
  // Work in the plane of the two largest singular values. Changes of w along columns of V sum to 0.
  VecX w = even;
  for (int d = 0; d < 2; ++d) {
    if (!(svd.values[d] > 1e-3 * svd.values[0])) return even;
    const double off = svd.U.col(d).dot(mean);
    w -= svd.V.col(d) * (off / svd.values[d]);
  }
  return w;
}

/// Links faces of different patches at non-manifold edges, so that they rotate together and keep
/// their angles.
void link_non_manifold_edges(const MeshTopology& topology, const Faces& faces, ArapEnergy& rows) {
  if (topology.node_count() == topology.vertex_count()) return;
  std::vector<std::pair<std::array<int, 2>, int>> sides;  // nodes of an edge, face
  for (size_t f = 0; f < faces.size(); ++f)
    for (size_t k = 0; k < faces[f].size(); ++k) {
      const auto [low, high] = std::minmax(
          {topology.node_of(faces[f][k]), topology.node_of(faces[f][(k + 1) % faces[f].size()])});
      sides.push_back({{low, high}, static_cast<int>(f)});
    }
  std::sort(sides.begin(), sides.end());
  for (size_t i = 0, end = 0; i < sides.size(); i = end) {
    while (end < sides.size() && sides[end].first == sides[i].first) ++end;
    for (size_t k = i + 1; k < end && end - i > 2; ++k)
      rows.links.push_back({sides[i].second, sides[k].second, 1});
  }
}

ArapEnergy dual_laplacian_energy(const TriangleMesh& mesh, const Faces& faces,
                                 std::vector<int> constrained,
                                 const DualLaplacianEnergyOptions& options) {
  // The solver reports invalid vertices.
  std::erase_if(constrained, [&](int v) { return v < 0 || v >= mesh.vertex_count(); });
  constrained = mesh.topology().expand_to_nodes(std::move(constrained));
  ArapEnergy rows = DualLaplacianAssembler(mesh, faces, constrained, options).rows();
  if (!rows.fits_scale) link_non_manifold_edges(mesh.topology(), faces, rows);
  return rows;
}

}  // namespace batten
