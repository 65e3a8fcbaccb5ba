// SPDX-License-Identifier: MPL-2.0
#include "batten/io/step/exact_faces.h"

#include <Geom2d_BSplineCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/fem/curves/bspline.h"
#include "batten/io/cad/occ_settings.h"

namespace batten {
namespace {

using Ordinates = Eigen::Matrix<double, 10, 3>;
enum { kJ = 0, kK = 1, kC = 2, kJJK = 3, kJKK = 4, kKKC = 5, kKCC = 6, kJCC = 7, kJJC = 8 };

/// Maps the 10 Bézier ordinates of a cubic triangle to the 16 control points of the same surface as
/// a bicubic. Row 4 i + j belongs to s^i t^j. It goes through the power basis: p = Σ a_mn s^m t^n,
/// with a_mn from differences of the ordinates. On the sides s = 0 and t = 0 the control points
/// equal the ordinates exactly.
const Eigen::Matrix<double, 16, 10>& bicubic_from_triangle() {
  static const Eigen::Matrix<double, 16, 10> matrix = [] {
    constexpr int binomial[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
    constexpr int factorial[4] = {1, 1, 2, 6};
    constexpr int ordinate[4][4] = {// [power of V_k][power of the centroid]
                                    {kJ, kJJC, kJCC, kC},
                                    {kJJK, 9, kKCC, -1},
                                    {kJKK, kKKC, -1, -1},
                                    {kK, -1, -1, -1}};
    Eigen::Matrix<double, 16, 10> B = Eigen::Matrix<double, 16, 10>::Zero();
    for (int m = 0; m <= 3; ++m)
      for (int n = 0; m + n <= 3; ++n) {
        const int trinomial = 6 / (factorial[m] * factorial[n] * factorial[3 - m - n]);
        for (int a = 0; a <= m; ++a)
          for (int c = 0; c <= n; ++c) {
            const int sign = (m - a + n - c) % 2 ? -1 : 1;
            const int difference = sign * binomial[m][a] * binomial[n][c] * trinomial;
            for (int i = m; i <= 3; ++i)
              for (int j = n; j <= 3; ++j)
                B(4 * i + j, ordinate[a][c]) +=
                    double(binomial[i][m] * binomial[j][n] * difference) /
                    (binomial[3][m] * binomial[3][n]);
          }
      }
    return B;
  }();
  return matrix;
}

TColStd_Array1OfReal unit_knots() {
  TColStd_Array1OfReal knots(1, 2);
  knots(1) = 0;
  knots(2) = 1;
  return knots;
}

TColStd_Array1OfInteger end_knots(int multiplicity) {
  TColStd_Array1OfInteger result(1, 2);
  result.Init(multiplicity);
  return result;
}

Handle(Geom2d_BSplineCurve) parameter_line(const gp_Pnt2d& from, const gp_Pnt2d& to) {
  TColgp_Array1OfPnt2d poles(1, 2);
  poles(1) = from;
  poles(2) = to;
  return new Geom2d_BSplineCurve(poles, unit_knots(), end_knots(2), 1);
}

using Cubic = BezierCubic<Vec3>;

/// The restriction of a cubic to [from, to].
Cubic part_of(const Cubic& whole, double from, double to) {
  if (from == 0 && to == 1) return whole;
  return {{whole.blossom(from, from, from), whole.blossom(to, from, from),
           whole.blossom(to, to, from), whole.blossom(to, to, to)}};
}

/// Makes the CAD faces of model faces; each shared vertex and edge is made once.
class FacesMaker {
 public:
  FacesMaker(const StepPlan& plan, double size)
      : plan_(plan),
        numbering_(plan),
        size_(size),
        vertices_(numbering_.vertex_count()),
        edges_(numbering_.edge_count()) {}

  std::vector<TopoDS_Face> faces(int region) {
    const Surface& surface = plan_.regions[region]->surface;
    const SharedEntityIds& numbers = numbering_.regions()[region];
    for (int v = 0; v < surface.mesh().vertex_count(); ++v)
      if (TopoDS_Vertex& made = vertices_[numbers.vertices[v]]; made.IsNull())
        made = vertex(surface.dofs().row(surface.dof_map().vertex(v)));
    for (int t = 0; t < surface.mesh().triangle_count(); ++t) add_triangle(surface, t, numbers);
    return std::move(faces_);
  }

  /// Copies the vertices and edges along curves to `shared`. Call it after all faces are made.
  void share(SharedEdges& shared) const {
    for (const auto& [name, chain] : numbering_.lines()) {
      const int n = isize(chain.edges);
      for (int k = 0; k <= n; ++k) shared.vertex(name, k) = vertices_[chain.vertices[k]];
      for (int k = 0; k < n; ++k) {
        const MadeEdge& made = edges_[chain.edges[k]];
        shared.edge(name, k + 1) = TopoDS::Edge(
            made.edge.Oriented(made.start == chain.vertices[k] ? TopAbs_FORWARD : TopAbs_REVERSED));
      }
    }
  }

 private:
  TopoDS_Vertex vertex(const Vec3& p) {
    TopoDS_Vertex result;
    builder_.MakeVertex(result, to_occ(p), tolerance());
    return result;
  }

  /// The edge along a cubic, parametrised over [0, 1] from `a` to `b`.
  TopoDS_Edge edge(const TopoDS_Vertex& a, const TopoDS_Vertex& b, const Cubic& cubic) {
    double length = 0;
    for (size_t i = 1; i < 4; ++i) length += (cubic.b[i] - cubic.b[i - 1]).norm();
    if (!(length > 1e-9 * size_))
      throw InputError("STEP: an element edge at (" + format_number(cubic.b[0].x()) + ", " +
                       format_number(cubic.b[0].y()) + ", " + format_number(cubic.b[0].z()) +
                       ") has length " + format_number(length) +
                       "; expected a surface without collapsed edges");
    CubicSpline spline;
    spline.knots = {0, 1};
    spline.multiplicities = {4, 4};
    spline.poles.assign(cubic.b.begin(), cubic.b.end());
    TopoDS_Edge result;
    builder_.MakeEdge(result, to_occ(spline), tolerance());
    builder_.Add(result, a.Oriented(TopAbs_FORWARD));
    builder_.Add(result, b.Oriented(TopAbs_REVERSED));
    builder_.Range(result, 0, 1);
    return result;
  }

  void add_triangle(const Surface& surface, int t, const SharedEntityIds& numbers) {
    const ParametricMesh& mesh = surface.mesh();
    const auto q = surface.triangle_dofs(t);
    const C1Triangle hct(TriangleElement::HCT, mesh.shape(t));
    const std::array<Ordinates, 3> net{hct.bezier(0, q), hct.bezier(1, q), hct.bezier(2, q)};
    ParametricMesh::Triangle corner = mesh.triangles()[t];
    for (int& v : corner) v = numbers.vertices[v];

    const TopoDS_Vertex centroid = vertex(net[0].row(kC));
    std::array<TopoDS_Edge, 3> spoke;  // from corner i to the centroid
    for (int i = 0; i < 3; ++i) {
      const Ordinates& b = net[(i + 2) % 3];  // in which corner i is V_j
      spoke[i] =
          edge(vertices_[corner[i]], centroid, {{b.row(kJ), b.row(kJJC), b.row(kJCC), b.row(kC)}});
    }
    for (int s = 0; s < 3; ++s) {
      const int j = (s + 1) % 3, k = (s + 2) % 3, e = mesh.edges_of(t)[s];
      const bool along = mesh.edge_sign(t, s) > 0;  // mesh edges start at the lower vertex index
      Cubic cubic{{net[s].row(kJ), net[s].row(kJJK), net[s].row(kJKK), net[s].row(kK)}};
      if (!along) std::reverse(cubic.b.begin(), cubic.b.end());
      const auto line = numbers.on_lines.find(e);
      const SideSubdivision pieces =
          line != numbers.on_lines.end()
              ? line->second
              : SideSubdivision{
                    {corner[along ? j : k], corner[along ? k : j]}, {numbers.edges[e]}, {0, 1}};
      add_face(net[s], side_edges(pieces, cubic, along), spoke[k], spoke[j]);
    }
  }

  /// An edge on the triangle's side, which is t = 0 in its face.
  struct SideEdge {
    TopoDS_Edge edge;
    double from, to;  // parameter s at its start and end
  };

  /// The edges from V_j to V_k. `cubic`: the whole side, from the lower vertex index; `along`:
  /// true if that vertex is V_j.
  std::vector<SideEdge> side_edges(const SideSubdivision& pieces, const Cubic& cubic, bool along) {
    std::vector<SideEdge> side;
    for (size_t i = 0; i < pieces.edges.size(); ++i) {
      const int start = pieces.vertices[i], end = pieces.vertices[i + 1];
      double from = pieces.fractions[i], to = pieces.fractions[i + 1];
      MadeEdge& made = edges_[pieces.edges[i]];
      if (made.edge.IsNull()) {
        const Cubic part = part_of(cubic, from, to);
        if (vertices_[start].IsNull()) vertices_[start] = vertex(part.b[0]);
        if (vertices_[end].IsNull()) vertices_[end] = vertex(part.b[3]);
        made.start = start;
        made.edge = edge(vertices_[start], vertices_[end], part);
      }
      if (made.start != start) std::swap(from, to);
      side.push_back({made.edge, along ? from : 1 - from, along ? to : 1 - to});
    }
    if (!along) std::reverse(side.begin(), side.end());
    return side;
  }

  void add_face(const Ordinates& net, const std::vector<SideEdge>& side, const TopoDS_Edge& spoke_k,
                const TopoDS_Edge& spoke_j) {
    const Eigen::Matrix<double, 16, 3> points = bicubic_from_triangle() * net;
    TColgp_Array2OfPnt poles(1, 4, 1, 4);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) poles(i + 1, j + 1) = to_occ(points.row(4 * i + j));
    TopoDS_Face face;
    builder_.MakeFace(face,
                      new Geom_BSplineSurface(poles, unit_knots(), unit_knots(), end_knots(4),
                                              end_knots(4), 3, 3),
                      tolerance());

    const gp_Pnt2d v_j(0, 0), v_k(1, 0), centroid(0, 1);
    TopoDS_Wire wire;
    builder_.MakeWire(wire);
    const auto add = [&](const TopoDS_Edge& e, const gp_Pnt2d& from, const gp_Pnt2d& to,
                         TopAbs_Orientation orientation) {
      builder_.UpdateEdge(e, parameter_line(from, to), face, tolerance());
      builder_.Range(e, face, 0, 1);
      builder_.SameRange(e, true);
      builder_.SameParameter(e, true);
      builder_.Add(wire, e.Oriented(orientation));
    };
    for (const auto& [edge, from, to] : side)
      add(edge, {from, 0}, {to, 0}, from < to ? TopAbs_FORWARD : TopAbs_REVERSED);
    add(spoke_k, v_k, centroid, TopAbs_FORWARD);
    add(spoke_j, v_j, centroid, TopAbs_REVERSED);
    wire.Closed(true);
    builder_.Add(face, wire);
    faces_.push_back(face);
  }

  double tolerance() const { return 1e-9 * size_; }

  struct MadeEdge {
    TopoDS_Edge edge;
    int start = 0;  // index of its start vertex
  };

  const StepPlan& plan_;
  const ExactFaceNumbering numbering_;
  double size_;
  BRep_Builder builder_;
  std::vector<TopoDS_Vertex> vertices_;
  std::vector<MadeEdge> edges_;
  std::vector<TopoDS_Face> faces_;  // of the current model face
};

}  // namespace

RegionFaces exact_faces(const StepPlan& plan, double size, SharedEdges* shared) {
  FacesMaker maker(plan, size);
  RegionFaces faces(plan.regions.size());
  for (size_t r = 0; r < faces.size(); ++r)
    if (!plan.regions[r]->surface.trim()) faces[r] = maker.faces(static_cast<int>(r));
  if (shared) maker.share(*shared);
  return faces;
}

namespace {

std::vector<int> add(int count, std::vector<int>& all) {
  std::vector<int> numbers(static_cast<size_t>(count));
  std::iota(numbers.begin(), numbers.end(), isize(all));
  all.insert(all.end(), numbers.begin(), numbers.end());
  return numbers;
}
/// The curve's parameters at the vertices of an edge-aligned curve.
std::vector<double> on_line(const StepLine& line, const EdgeAlignedLine& aligned_line,
                            double distance) {
  const HermiteCurve &curve = *line.curve, &fitted = aligned_line.fitted;
  const bool along = direction_along(fitted, curve, distance) > 0;
  std::vector<double> at;
  for (const double t : aligned_line.parameters) {
    const double fraction = (t - fitted.start()) / (fitted.end() - fitted.start());
    at.push_back(curve.start() + (along ? fraction : 1 - fraction) * (curve.end() - curve.start()));
  }
  return at;
}

}  // namespace

ExactFaceNumbering::ExactFaceNumbering(const StepPlan& plan) : plan_(plan) {
  for (const SkinnedRegion* region : plan.regions) {
    SharedEntityIds own;
    own.vertices = add(region->surface.mesh().vertex_count(), vertices_);
    own.edges = add(region->surface.mesh().edge_count(), edges_);
    if (!region->surface.trim())
      for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
        if (!aligned_line.line.name.empty()) join(aligned_line, own);
    numbers_.push_back(std::move(own));
  }
  const auto to_roots = [&](std::vector<int>& numbers) {
    for (int& v : numbers) v = root(v);
  };
  for (SharedEntityIds& of : numbers_) {
    to_roots(of.vertices);
    for (auto& [edge, pieces] : of.on_lines) to_roots(pieces.vertices);
  }
  for (auto& [name, line] : lines_) to_roots(line.vertices);
}

int ExactFaceNumbering::root(int vertex) const {
  while (vertices_[vertex] != vertex) vertex = vertices_[vertex];
  return vertex;
}

// Union of two vertices; the lower index becomes the root.
void ExactFaceNumbering::unite(int a, int b) {
  a = root(a);
  b = root(b);
  vertices_[std::max(a, b)] = std::min(a, b);
}

const LineEntityIds& ExactFaceNumbering::numbers_of(const std::string& name) {
  const auto [it, added] = lines_.try_emplace(name);
  LineEntityIds& numbers = it->second;
  if (!added) return numbers;
  const StepLine& line = plan_.lines.at(name);
  const int cuts = isize(line.cuts);
  numbers.vertices = add(cuts + 2, vertices_);
  numbers.edges = add(cuts + 1, edges_);
  for (const bool end : {false, true}) {
    const int v = end ? numbers.vertices.back() : numbers.vertices.front();
    unite(end_points_.emplace(line.places[end], v).first->second, v);
  }
  return numbers;
}

void ExactFaceNumbering::join(const EdgeAlignedLine& aligned_line, SharedEntityIds& own) {
  const StepLine& line = plan_.lines.at(aligned_line.line.name);
  const LineEntityIds& numbers = numbers_of(aligned_line.line.name);
  std::vector<double> places{line.curve->start()};
  places.insert(places.end(), line.cuts.begin(), line.cuts.end());
  places.push_back(line.curve->end());
  std::vector<int> at;  // index in `places` of each vertex of the aligned curve
  for (const double t : on_line(line, aligned_line, plan_.distance)) {
    const auto next = std::lower_bound(places.begin() + 1, places.end() - 1, t);
    at.push_back(static_cast<int>(next - places.begin()) - (*next - t > t - *(next - 1)));
    unite(own.vertices[aligned_line.vertices[at.size() - 1]], numbers.vertices[at.back()]);
  }
  for (size_t k = 0; k < aligned_line.edges.size(); ++k) {
    const bool up = aligned_line.vertices[k] < aligned_line.vertices[k + 1];
    const int from = at[up ? k : k + 1], to = at[up ? k + 1 : k], step = from < to ? 1 : -1;
    SideSubdivision& pieces = own.on_lines[aligned_line.edges[k]];
    for (int c = from; c != to + step; c += step) {
      pieces.vertices.push_back(numbers.vertices[c]);
      pieces.fractions.push_back(
          std::abs((places[c] - places[from]) / (places[to] - places[from])));
      if (c != to) pieces.edges.push_back(numbers.edges[std::min(c, c + step)]);
    }
  }
}

void cut_at_vertices(StepPlan& plan) {
  for (const SkinnedRegion* region : plan.regions)
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned) {
      if (region->surface.trim() || aligned_line.line.name.empty()) continue;
      StepLine& line = plan.lines.at(aligned_line.line.name);
      const double span = line.curve->end() - line.curve->start();
      // Vertices of two model faces at the same point count as one, even if their parameters differ
      // by rounding.
      const double hair = plan.distance / line.curve->length() * span;
      const auto at = on_line(line, aligned_line, plan.distance);
      std::vector<double> added;
      for (size_t k = 1; k + 1 < at.size(); ++k)
        if (std::none_of(line.cuts.begin(), line.cuts.end(),
                         [&](double cut) { return std::abs(cut - at[k]) <= hair; }))
          added.push_back(at[k]);
      line.cuts.insert(line.cuts.end(), added.begin(), added.end());
      std::sort(line.cuts.begin(), line.cuts.end());
    }
}

}  // namespace batten
