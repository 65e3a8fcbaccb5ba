#include "batten/skinning/facets.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/fem/triangle_locator.h"
#include "batten/skinning/mesher.h"

namespace batten {
namespace {

// ------------------------------------------------------------------------------------- lines

/// A line of the region in (u, v): a chain of mesh edges, or a curve.
class Line {
 public:
  Line(const ParametricMesh& mesh, const LineRun& run)
      : name_(run.line.name), parameters_(run.parameters) {
    for (const int v : run.vertices)
      places_.push_back(places_.empty() ? mesh.vertices()[v]
                                        : mesh.image_near(mesh.vertices()[v], places_.back()));
    join_places();
  }
  /// A straight line over its own length.
  Line(std::string name, const Vec2& from, const Vec2& to)
      : name_(std::move(name)), parameters_{0, (to - from).norm()}, places_{from, to} {
    join_places();
  }
  explicit Line(const EmbeddedLine& line)
      : name_(line.line.name),
        embedded_(&line),
        parameters_(line.image.parameters()),
        arcs_(planar_arcs(line.image)) {}

  const std::string& name() const { return name_; }
  const EmbeddedLine* embedded() const { return embedded_; }
  const std::vector<double>& parameters() const { return parameters_; }
  double start() const { return parameters_.front(); }
  double end() const { return parameters_.back(); }

  Vec2 at(double t) const {
    if (embedded_) return embedded_->image.evaluate(t).head<2>();
    const size_t k = segment(t);
    const double s = (t - parameters_[k]) / (parameters_[k + 1] - parameters_[k]);
    return (1 - s) * places_[k] + s * places_[k + 1];
  }
  Vec2 slope(double t) const {
    if (embedded_) return embedded_->image.evaluate(t, 1).head<2>();
    const size_t k = segment(t);
    return (places_[k + 1] - places_[k]) / (parameters_[k + 1] - parameters_[k]);
  }
  /// The cubic arc between two parameters of one segment.
  PlanarCubic arc(size_t k, double s0, double s1) const { return arcs_[k].part(s0, s1); }
  size_t arc_count() const { return arcs_.size(); }
  /// The range of u that it stays in.
  std::pair<double, double> reach() const {
    std::pair<double, double> range{arcs_[0].b[0].x(), arcs_[0].b[0].x()};
    for (const PlanarCubic& arc : arcs_)
      for (const Vec2& p : arc.b)
        range = {std::min(range.first, p.x()), std::max(range.second, p.x())};
    return range;
  }
  double parameter(size_t k, double s) const {
    return parameters_[k] + s * (parameters_[k + 1] - parameters_[k]);
  }

  /// Parameter and distance of the nearest point.
  CurvePoint closest(const Vec2& p) const {
    if (embedded_) return embedded_->image.closest_point({p.x(), p.y(), 0});
    CurvePoint best{0, std::numeric_limits<double>::infinity()};
    for (size_t k = 0; k + 1 < places_.size(); ++k) {
      const Vec2 d = places_[k + 1] - places_[k];
      const double s = std::clamp((p - places_[k]).dot(d) / d.squaredNorm(), 0.0, 1.0);
      const double distance = (places_[k] + s * d - p).norm();
      if (distance < best.distance) best = {parameter(k, s), distance};
    }
    return best;
  }

 private:
  void join_places() {
    for (size_t k = 0; k + 1 < places_.size(); ++k) {
      const Vec2 third = (places_[k + 1] - places_[k]) / 3;
      arcs_.push_back({{places_[k], places_[k] + third, places_[k + 1] - third, places_[k + 1]}});
    }
  }
  size_t segment(double t) const {
    const auto above = std::upper_bound(parameters_.begin(), parameters_.end(), t);
    const auto k = static_cast<size_t>(std::max<long>(0, above - parameters_.begin() - 1));
    return std::min(k, parameters_.size() - 2);
  }

  std::string name_;
  const EmbeddedLine* embedded_ = nullptr;
  std::vector<double> parameters_;
  std::vector<Vec2> places_;  // of a run's vertices
  std::vector<PlanarCubic> arcs_;
};

/// Where the curve of a line breaks: its ends and corners.
std::vector<double> breaks(const EmbeddedLine& line) {
  std::vector<double> t{line.image.start(), line.image.end()};
  for (const HermiteCurve* curve : {&line.image, &line.fitted})
    for (const int node : curve->mesh().corners()) t.push_back(curve->parameters()[node]);
  std::sort(t.begin(), t.end());
  t.erase(std::unique(t.begin(), t.end()), t.end());
  return t;
}

/// By how much a curve turns between two parameters inside of which it is smooth, radians.
double turn(const HermiteCurve& curve, double t0, double t1) {
  constexpr int samples = 4;
  double sum = 0;
  Vec3 before;
  for (int k = 0; k <= samples; ++k) {
    const double inside = std::clamp(static_cast<double>(k) / samples, 1e-6, 1 - 1e-6);
    const Vec3 slope = curve.evaluate(t0 + inside * (t1 - t0), 1);
    if (k > 0) sum += std::atan2(before.cross(slope).norm(), before.dot(slope));
    before = slope;
  }
  return sum;
}

/// Parameters that cut a line evenly in pieces of about `edge_length`, `at_least` so many, and turn
/// by 36 degrees each at most. They follow from the line's curve in space alone.
std::vector<double> divisions(const EmbeddedLine& line, double edge_length, int at_least) {
  const HermiteCurve& curve = line.fitted;
  constexpr int samples = 16;  // of each segment
  std::vector<double> t{curve.start()}, arc{0};
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 1; k <= samples; ++k) {
      const double from = curve.parameters()[s], to = curve.parameters()[s + 1];
      const double next = k == samples ? to : from + (to - from) * k / samples;
      arc.push_back(arc.back() + (curve.evaluate({s, static_cast<double>(k) / samples}, 0) -
                                  curve.evaluate({s, static_cast<double>(k - 1) / samples}, 0))
                                     .norm());
      t.push_back(next);
    }
  const auto interpolated = [](const std::vector<double>& x, const std::vector<double>& y,
                               double at) {
    const auto above = std::lower_bound(x.begin() + 1, x.end() - 1, at);
    const auto k = static_cast<size_t>(above - x.begin());
    if (x[k] == x[k - 1]) return y[k];
    return y[k - 1] + (y[k] - y[k - 1]) * ((at - x[k - 1]) / (x[k] - x[k - 1]));
  };
  constexpr double most = 36 * std::numbers::pi / 180;
  std::vector<double> result;
  const auto halve = [&](const auto& self, double t0, double t1, int depth) -> void {
    if (depth < 12 && turn(curve, t0, t1) > most) {
      const double middle = 0.5 * (t0 + t1);
      self(self, t0, middle, depth + 1);
      self(self, middle, t1, depth + 1);
    } else {
      result.push_back(t1);
    }
  };
  const std::vector<double> ends = breaks(line);
  result.push_back(ends.front());
  for (size_t b = 0; b + 1 < ends.size(); ++b) {
    const double from = interpolated(t, arc, ends[b]), to = interpolated(t, arc, ends[b + 1]);
    const double share = (to - from) / std::max(arc.back(), 1e-300);
    const int count = std::max({1, static_cast<int>(std::lround((to - from) / edge_length)),
                                static_cast<int>(std::ceil(at_least * share - 1e-9))});
    double before = ends[b];
    for (int k = 1; k <= count; ++k) {
      const double next =
          k == count ? ends[b + 1] : interpolated(arc, t, from + (to - from) * k / count);
      halve(halve, before, next, 0);
      before = next;
    }
  }
  return result;
}

// ------------------------------------------------------------------------------------- mesh

/// A place on a line where an edge ends.
struct Stop {
  double t;
  int node;
  bool fixed;  // a break, a mesh vertex, or shared with another line
};

/// The part of a line between two neighbouring stops: one edge of the mesh.
struct Piece {
  int line;
  double t0, t1;
  int a, b;
  bool curved;
  Vec2 from = Vec2::Zero(), to = Vec2::Zero();  // its ends, where the line has them
};

/// A mesh of a region in (u, v) that follows its lines.
struct RegionMesh {
  std::shared_ptr<const ParametricMesh> mesh;
  std::vector<Line> lines;
  std::vector<Piece> pieces;
  std::vector<int> piece_of_edge;            // or -1
  std::vector<std::vector<int>> edge_lists;  // of each line, in its order, of kept pieces
  std::vector<std::vector<int>> piece_lists;

  /// The image of a point of the mesh.
  Vec2 image(const Location& where) const {
    const auto& v = mesh->triangles()[where.triangle];
    const auto& e = mesh->edges_of(where.triangle);
    Vec2 p = mesh->shape(where.triangle).point(where.L);
    for (int i = 0; i < 3; ++i) {
      if (piece_of_edge[e[i]] < 0 || where.L[i] == 1) continue;
      const Piece& piece = pieces[static_cast<size_t>(piece_of_edge[e[i]])];
      if (!piece.curved) continue;
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const bool forward = v[j] == piece.a;
      const double Lj = where.L[forward ? j : k], Lk = where.L[forward ? k : j];
      if (Lj == 0 || Lk == 0) continue;
      const double s = where.L[i] == 0 ? Lk : 0.5 * (1 + Lk - Lj);
      const Vec2 on_line =
          lines[static_cast<size_t>(piece.line)].at(piece.t0 + s * (piece.t1 - piece.t0));
      if (where.L[i] == 0) return mesh->image_near(on_line, p);
      const Vec2& from = mesh->vertices()[piece.a];
      const Vec2 chord = (1 - s) * from + s * mesh->image_near(mesh->vertices()[piece.b], from);
      p += Lj * Lk / (s * (1 - s)) * (mesh->image_near(on_line, chord) - chord);
    }
    return p;
  }
};

/// Whether a triangle at a curved edge is far enough from folding: the corners of its six-node
/// triangle, and a lattice of its image.
bool unfolded(const RegionMesh& m, int t) {
  constexpr double least = 0.2;  // of the straight triangle
  const TriangleShape shape = m.mesh->shape(t);
  Vec2 middle[3];  // of the edge opposite each corner
  for (int i = 0; i < 3; ++i) middle[i] = m.image({t, (Vec3::Ones() - Vec3::Unit(i)) / 2});
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const Vec2 to_j = 4 * middle[k] - 3 * shape.vertex[i] - shape.vertex[j],
               to_k = 4 * middle[j] - 3 * shape.vertex[i] - shape.vertex[k];
    if (!(cross(to_j, to_k) > least * 2 * shape.area)) return false;
  }
  constexpr int n = 8;
  Vec2 x[n + 1][n + 1];
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j) x[i][j] = m.image({t, Vec3(i, j, n - i - j) / n});
  const double limit = least * 2 * shape.area / (n * n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      if (!(cross(x[i + 1][j] - x[i][j], x[i][j + 1] - x[i][j]) > limit)) return false;
      if (i + j + 1 < n &&
          !(cross(x[i][j + 1] - x[i + 1][j + 1], x[i + 1][j] - x[i + 1][j + 1]) > limit))
        return false;
    }
  return true;
}

/// Whether two segments without a common end meet.
bool meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const Vec2 low = a.cwiseMin(b), high = a.cwiseMax(b);
  if ((c.cwiseMax(d) - low).minCoeff() < 0 || (high - c.cwiseMin(d)).minCoeff() < 0) return false;
  const double ca = cross(d - c, a - c), cb = cross(d - c, b - c);
  const double ac = cross(b - a, c - a), ad = cross(b - a, d - a);
  return ca * cb <= 0 && ac * ad <= 0;
}

class Builder {
 public:
  Builder(const SkinnedRegion& region, double edge_length) : region_(region) {
    const ParametricMesh& mesh = region.surface.mesh();
    if (region.boundary.empty() || region.boundary[0].empty())
      throw InputError(who() + "found embedded lines, but no boundary");
    for (const LineRun& run : region.runs) lines_.emplace_back(mesh, run);
    for (const EmbeddedLine& line : region.embedded) lines_.emplace_back(line);
    stops_.resize(lines_.size());
    at_least_.assign(lines_.size(), 1);
    on_boundary_.assign(lines_.size(), 0);
    for (const auto& loop : region.boundary)
      for (const BoundaryPiece& piece : loop) {
        constexpr int least_edges = 8;  // of a loop
        on_boundary_[line_of(piece)] = 1;
        at_least_[line_of(piece)] =
            (least_edges + static_cast<int>(loop.size()) - 1) / static_cast<int>(loop.size());
      }
    Vec2 low = mesh.vertices()[0], high = low;
    for (const Vec2& p : mesh.vertices()) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    same_ = 1e-7 * (high - low).norm();
    // Lengths in (u, v) and in space, of edges of elements that are not outside.
    const double mean = facet_length(region);
    if (!(edge_length > 0)) edge_length = mean;
    double sum = 0;
    int count = 0;
    for_each_edge(region.surface, [&](int e) {
      sum += mesh.edge_length(e);
      ++count;
    });
    size_ = sum / count * (edge_length / mean);
    space_ = edge_length;
    if (mesh.period() > 0) cut_open();
  }

  template <class Action>
  static void for_each_edge(const Surface& surface, const Action& action) {
    const ParametricMesh& mesh = surface.mesh();
    const auto outside = [&](int t) {
      return t < 0 || (surface.trim() && surface.trim()->side(t) == Trim::Side::Outside);
    };
    for (int e = 0; e < mesh.edge_count(); ++e) {
      const auto& edge = mesh.edges()[e];
      if (!outside(edge.triangle[0]) || !outside(edge.triangle[1])) action(e);
    }
  }

  RegionMesh build() {
    place_fixed_stops();
    find_crossings();
    divide();
    RegionMesh result;
    result.lines = lines_;
    constexpr int rounds = 12;
    for (int round = 0;; ++round) {
      list_pieces();
      if (untangle(round < rounds)) continue;
      fill(result);
      std::set<int> folded;
      for (int t = 0; t < result.mesh->triangle_count(); ++t) {
        const auto& e = result.mesh->edges_of(t);
        std::vector<int> curved;
        for (const int edge : e)
          if (result.piece_of_edge[edge] >= 0 && pieces_[result.piece_of_edge[edge]].curved)
            curved.push_back(result.piece_of_edge[edge]);
        if (!curved.empty() && !unfolded(result, t)) folded.insert(curved.begin(), curved.end());
      }
      if (folded.empty()) return result;
      // In a cusp no halving helps: its last edges stay straight.
      if (round >= rounds)
        for (const int p : folded) straight_.insert(key(pieces_[p]));
      else
        for (const int p : folded) halve(p);
      if (round > 2 * rounds) throw InputError(who() + "its facets fold where lines touch");
    }
  }

 private:
  std::string who() const { return "facets of region '" + region_.name + "': "; }
  size_t line_of(const BoundaryPiece& piece) const {
    return static_cast<size_t>(piece.index) +
           (piece.kind == BoundaryPiece::Kind::Run ? 0 : region_.runs.size());
  }
  int new_node(const Vec2& p) {
    nodes_.push_back(p);
    return static_cast<int>(nodes_.size()) - 1;
  }
  // The fixed stop of a line near a point of it, or null. Closed lines have two at their seam.
  const Stop* fixed_near(size_t line, const Vec2& p) const {
    for (const Stop& stop : stops_[line])
      if ((near(nodes_[stop.node], p) - p).norm() <= same_) return &stop;
    return nullptr;
  }
  void fix(size_t line, double t, int node) { stops_[line].push_back({t, node, true}); }
  /// p or its image that is nearest to another point.
  Vec2 near(const Vec2& p, const Vec2& anchor) const {
    return region_.surface.mesh().image_near(p, anchor);
  }
  double period() const { return region_.surface.mesh().period(); }
  bool has_seam() const { return period() > 0; }
  size_t seam() const { return lines_.size() - 1; }
  /// By how much p is to the right of the seam.
  double beyond_seam(const Vec2& p) const {
    const Vec2 from = lines_[seam()].at(0), to = lines_[seam()].at(lines_[seam()].end());
    return p.x() - from.x() - (p.y() - from.y()) / (to.y() - from.y()) * (to.x() - from.x());
  }

  /// A ring is meshed between two images of a straight seam from rim to rim, which are then one
  /// again. It begins at that vertex of the first rim where it is least along any line, and
  /// crosses no hole.
  void cut_open() {
    const ParametricMesh& mesh = region_.surface.mesh();
    size_ = std::min(size_, period() / 8);
    std::vector<Vec2> rims[2];
    for (const int r : {0, 1})
      for (const BoundaryPiece& piece : region_.boundary.at(static_cast<size_t>(r)))
        for (const int v : region_.runs.at(static_cast<size_t>(piece.index)).vertices)
          rims[r].push_back(mesh.vertices()[v]);
    struct Sample {
      Vec2 c, direction;
      bool boundary;
    };
    std::vector<Sample> samples;
    for (size_t l = region_.runs.size(); l < lines_.size(); ++l) {
      const HermiteCurve& image = lines_[l].embedded()->image;
      constexpr int cuts = 16;  // of a segment
      for (int s = 0; s < image.segment_count(); ++s)
        for (int k = 0; k <= cuts; ++k) {
          const CurveMesh::Where where{s, static_cast<double>(k) / cuts};
          samples.push_back({image.evaluate(where).head<2>(),
                             image.evaluate(where, 1).head<2>().normalized(),
                             on_boundary_[l] != 0});
        }
    }
    double least = std::numeric_limits<double>::infinity();
    Vec2 best[2];
    for (const Vec2& from : rims[0]) {
      Vec2 to = rims[1][0];
      for (const Vec2& p : rims[1])
        if (std::abs(near(p, from).x() - from.x()) < std::abs(near(to, from).x() - from.x()))
          to = p;
      to = near(to, from);
      const Vec2 up = (to - from).normalized();
      double along = 0;
      for (const Sample& sample : samples) {
        const double share = (sample.c.y() - from.y()) / (to.y() - from.y());
        const double beside =
            std::abs(std::remainder(sample.c.x() - from.x() - share * (to - from).x(), period()));
        // Lines beside it count less and less.
        const double reach = 0.5 * size_;
        if (beside < reach)
          along = std::max(along, (sample.boundary ? 2 : 1) * (1 - beside / reach) *
                                      std::abs(sample.direction.dot(up)));
        if (sample.boundary && beside < 0.1 * size_) along = 10;
      }
      constexpr double worth_it = 0.05;
      if (along > least - worth_it) continue;
      least = along;
      best[0] = from;
      best[1] = to;
    }
    if (least >= 10)
      throw InputError(who() + "no straight seam from rim to rim of the ring is free of holes");
    lines_.emplace_back("seam", best[0], best[1]);
    stops_.emplace_back();
    at_least_.push_back(1);
    on_boundary_.push_back(0);
  }

  void place_fixed_stops() {
    std::map<int, int> node_of_vertex;
    const ParametricMesh& mesh = region_.surface.mesh();
    for (size_t r = 0; r < region_.runs.size(); ++r)
      for (size_t k = 0; k < region_.runs[r].vertices.size(); ++k) {
        const int v = region_.runs[r].vertices[k];
        const auto [found, added] = node_of_vertex.try_emplace(v, static_cast<int>(nodes_.size()));
        if (added) new_node(mesh.vertices()[v]);
        fix(r, region_.runs[r].parameters[k], found->second);
      }
    // Ends and corners; those of the boundary first, so that inner lines come to it.
    for (const bool boundary : {true, false})
      for (size_t l = region_.runs.size(); l < lines_.size(); ++l) {
        if (static_cast<bool>(on_boundary_[l]) != boundary) continue;
        const EmbeddedLine* line = lines_[l].embedded();
        for (const double t :
             line ? breaks(*line) : std::vector<double>{lines_[l].start(), lines_[l].end()}) {
          const Vec2 p = lines_[l].at(t);
          int node = -1;
          for (size_t i = 0; node < 0 && i < nodes_.size(); ++i)
            if ((near(nodes_[i], p) - p).norm() <= same_) node = static_cast<int>(i);
          fix(l, t, node >= 0 ? node : new_node(p));
        }
      }
    // Ends that lie on another line.
    for (size_t l = 0; l < lines_.size(); ++l)
      for (const double t : {lines_[l].start(), lines_[l].end()}) {
        const Vec2 p = lines_[l].at(t);
        const int node = fixed_near(l, p)->node;
        for (size_t m = 0; m < lines_.size(); ++m) {
          if (m == l || fixed_near(m, p)) continue;
          const CurvePoint there = closest(lines_[m], p);
          if (there.distance > same_) continue;
          fix(m, there.u, node);
          if (!on_boundary_[l] && lines_[l].embedded()) nodes_[node] = lines_[m].at(there.u);
        }
      }
  }

  /// The nearest point of a line to p or one of its images.
  CurvePoint closest(const Line& line, const Vec2& p) const {
    if (!has_seam()) return line.closest(p);
    const auto [low, high] = line.reach();
    CurvePoint best{0, std::numeric_limits<double>::infinity()};
    for (double k = std::floor((low - p.x()) / period()); p.x() + (k - 1) * period() <= high; ++k) {
      const CurvePoint there = line.closest({p.x() + k * period(), p.y()});
      if (there.distance < best.distance) best = there;
    }
    return best;
  }

  void find_crossings() {
    for (size_t l = 0; l < lines_.size(); ++l)
      for (size_t m = l + 1; m < lines_.size(); ++m) {
        if (on_boundary_[l] && on_boundary_[m]) continue;
        if (!lines_[l].embedded() && !lines_[m].embedded()) continue;  // share mesh vertices
        // Against each image of the second line that comes near.
        double first = 0, last = 0;
        if (has_seam()) {
          const auto a = lines_[l].reach(), b = lines_[m].reach();
          first = std::ceil((a.first - b.second - same_) / period());
          last = std::floor((a.second - b.first + same_) / period());
        }
        for (double k = first; k <= last; ++k)
          for (size_t i = 0; i < lines_[l].arc_count(); ++i)
            for (size_t j = 0; j < lines_[m].arc_count(); ++j)
              cross_arcs(l, i, 0, 1, m, j, 0, 1, k * period(), 0);
      }
  }

  /// The second line moved by du.
  void cross_arcs(size_t l, size_t i, double s0, double s1, size_t m, size_t j, double t0,
                  double t1, double du, int depth) {
    const PlanarCubic a = lines_[l].arc(i, s0, s1);
    PlanarCubic b = lines_[m].arc(j, t0, t1);
    for (Vec2& p : b.b) p.x() += du;
    Vec2 low[2], high[2];
    for (const int side : {0, 1}) {
      const auto& points = side == 0 ? a.b : b.b;
      low[side] = high[side] = points[0];
      for (const Vec2& p : points) {
        low[side] = low[side].cwiseMin(p);
        high[side] = high[side].cwiseMax(p);
      }
    }
    if ((high[0] - low[1]).minCoeff() < -same_ || (high[1] - low[0]).minCoeff() < -same_) return;
    constexpr int deepest = 6;
    if (depth < deepest) {
      const double s = 0.5 * (s0 + s1), t = 0.5 * (t0 + t1);
      for (const int part : {0, 1, 2, 3})
        cross_arcs(l, i, part < 2 ? s0 : s, part < 2 ? s : s1, m, j, part % 2 ? t : t0,
                   part % 2 ? t1 : t, du, depth + 1);
      return;
    }
    double s = 0.5, t = 0.5;
    for (int step = 0; step < 20; ++step) {
      Mat2 J;
      J.col(0) = a.slope(s);
      J.col(1) = -b.slope(t);
      const Vec2 move = J.fullPivLu().solve(b.at(t) - a.at(s));
      if (!move.allFinite()) return;
      s = std::clamp(s + move[0], -0.5, 1.5);
      t = std::clamp(t + move[1], -0.5, 1.5);
    }
    constexpr double hair = 1e-6;
    if (s < -hair || s > 1 + hair || t < -hair || t > 1 + hair) return;
    s = std::clamp(s, 0.0, 1.0);
    t = std::clamp(t, 0.0, 1.0);
    if ((a.at(s) - b.at(t)).norm() > same_) return;
    const Stop *on_l = fixed_near(l, a.at(s)), *on_m = fixed_near(m, b.at(t));
    if (on_l && on_m) return;
    const double at_l = lines_[l].parameter(i, s0 + s * (s1 - s0)),
                 at_m = lines_[m].parameter(j, t0 + t * (t1 - t0));
    const int node = on_l   ? on_l->node
                     : on_m ? on_m->node
                            : new_node(on_boundary_[m] ? lines_[m].at(at_m) : lines_[l].at(at_l));
    if (!on_l) fix(l, at_l, node);
    if (!on_m) fix(m, at_m, node);
  }

  /// Stops between the fixed ones.
  void divide() {
    for (size_t l = 0; l < lines_.size(); ++l) {
      auto& stops = stops_[l];
      const auto before = [](const Stop& a, const Stop& b) { return a.t < b.t; };
      if (const EmbeddedLine* line = lines_[l].embedded()) {
        std::vector<Stop> all;
        for (const double t : divisions(*line, space_, at_least_[l])) all.push_back({t, -1, false});
        // A fixed stop takes the place of one that is near; ends and corners are fixed themselves.
        for (const Stop& fixed : stops) {
          const auto next = std::lower_bound(all.begin(), all.end(), fixed, before);
          const auto i = static_cast<size_t>(next - all.begin());
          const size_t above = std::min(i, all.size() - 1), below = i == 0 ? 0 : i - 1;
          const size_t near =
              std::abs(all[above].t - fixed.t) <= std::abs(all[below].t - fixed.t) ? above : below;
          const double gap = all[above].t - all[below].t;
          constexpr double share = 0.3;
          if (!all[near].fixed && (std::abs(all[near].t - fixed.t) <= share * gap || gap == 0))
            all[near] = fixed;
          else
            all.insert(all.begin() + static_cast<long>(i), fixed);
        }
        stops = std::move(all);
        for (Stop& stop : stops)
          if (stop.node < 0) stop.node = new_node(lines_[l].at(stop.t));
      }
      std::stable_sort(stops.begin(), stops.end(), before);
      if (has_seam() && l == seam()) {
        std::vector<Stop> all;
        for (const Stop& stop : stops) {
          const double from = all.empty() ? 0 : all.back().t, gap = stop.t - from;
          const auto cuts = static_cast<int>(std::lround(gap / size_));
          for (int k = 1; k < cuts; ++k) {
            const double t = from + gap * k / cuts;
            all.push_back({t, new_node(lines_[l].at(t)), false});
          }
          all.push_back(stop);
        }
        stops = std::move(all);
      }
    }
  }

  using Key = std::pair<int, double>;
  static Key key(const Piece& piece) { return {piece.line, piece.t0}; }

  void list_pieces() {
    pieces_.clear();
    for (size_t l = 0; l < lines_.size(); ++l)
      for (size_t k = 0; k + 1 < stops_[l].size(); ++k) {
        const Stop &a = stops_[l][k], &b = stops_[l][k + 1];
        Piece piece{static_cast<int>(l), a.t, b.t, a.node, b.node, lines_[l].embedded() != nullptr};
        if (!on_boundary_[l] && !inside(lines_[l].at(0.5 * (a.t + b.t)))) continue;
        if (straight_.count(key(piece))) piece.curved = false;
        piece.from = near(nodes_[a.node], lines_[l].at(a.t));
        piece.to = near(nodes_[b.node], lines_[l].at(b.t));
        pieces_.push_back(piece);
      }
  }

  /// Of a ring the holes alone: between the rims is inside.
  bool inside(const Vec2& p) {
    const Trim* trim = region_.surface.trim().get();
    if (trim) return trim->loops().contains(region_.surface.mesh().wrapped(p));
    if (has_seam()) return true;
    if (!loops_) loops_ = boundary_loops(region_);
    return loops_->contains(p);
  }

  void halve(int p) {
    const Piece& piece = pieces_[p];
    const double middle = 0.5 * (piece.t0 + piece.t1);
    auto& stops = stops_[piece.line];
    const auto place = std::find_if(stops.begin(), stops.end(),
                                    [&](const Stop& stop) { return stop.t >= middle; });
    const int node = new_node(lines_[piece.line].at(middle));
    stops.insert(place, {middle, node, false});
  }

  /// Halves the curved pieces whose chords meet. Returns whether there were any.
  bool untangle(bool may_halve) {
    std::set<int> tangled;
    const int count = static_cast<int>(pieces_.size());
    for (int p = 0; p < count; ++p)
      for (int q = p + 1; q < count; ++q) {
        const Piece &a = pieces_[p], &b = pieces_[q];
        const int shared = (a.a == b.a) + (a.a == b.b) + (a.b == b.a) + (a.b == b.b);
        // Those that share both ends lie on each other.
        const Vec2 move = near(b.from, a.from) - b.from;
        if (shared == 1 || (shared == 0 && !meet(a.from, a.to, b.from + move, b.to + move)))
          continue;
        const bool curved = a.curved || b.curved;
        if (!may_halve || !curved)
          throw InputError(who() + "the lines '" + lines_[a.line].name() + "' and '" +
                           lines_[b.line].name() + "' cross where they share no point");
        if (a.curved) tangled.insert(p);
        if (b.curved) tangled.insert(q);
      }
    for (const int p : tangled) halve(p);
    return !tangled.empty();
  }

  void fill(RegionMesh& result) const {
    MeshTask task;
    task.edge_length = size_;
    task.keep_segments = true;
    result.pieces = pieces_;
    // Pieces that were dropped leave nodes that nobody needs. Those on a seam have two places:
    // between its images, to which each piece is moved, every node is left or right.
    std::vector<std::array<int, 2>> number(nodes_.size(), {-1, -1});
    const auto point = [&](int node, const Vec2& p) {
      const bool right = has_seam() && beyond_seam(p) > 0.5 * period() && on_seam(node);
      int& index = number[static_cast<size_t>(node)][right];
      if (index < 0) {
        index = static_cast<int>(task.points.size());
        task.points.push_back(has_seam() ? p : nodes_[static_cast<size_t>(node)]);
      }
      return index;
    };
    const auto move = [&](Piece& piece, bool right) {
      Vec2 shift = Vec2::Zero();
      if (has_seam()) {
        const bool of_seam = piece.line == static_cast<int>(seam());
        const double beyond = of_seam ? 0 : beyond_seam(0.5 * (piece.from + piece.to));
        shift.x() = (right - std::floor(beyond / period())) * period();
      }
      piece.a = point(piece.a, piece.from + shift);
      piece.b = point(piece.b, piece.to + shift);
    };
    std::vector<std::array<int, 2>> seams;
    for (Piece& piece : result.pieces) {
      if (has_seam() && piece.line == static_cast<int>(seam())) {
        Piece image = piece;
        move(image, true);
        seams.push_back({image.a, image.b});
      }
      move(piece, false);
    }
    std::vector<int> loop_of(lines_.size(), -1);
    for (size_t i = 0; i < region_.boundary.size(); ++i)
      for (const BoundaryPiece& piece : region_.boundary[i])
        loop_of[line_of(piece)] = static_cast<int>(i);
    const int outlines = has_seam() ? 2 : 1;
    if (has_seam()) loop_of[seam()] = 0;
    task.holes.resize(region_.boundary.size() - static_cast<size_t>(outlines));
    for (const Piece& piece : result.pieces) {
      const int loop = loop_of[piece.line];
      (loop < 0          ? task.inner
       : loop < outlines ? task.outline
                         : task.holes[static_cast<size_t>(loop - outlines)])
          .push_back({piece.a, piece.b});
    }
    task.outline.insert(task.outline.end(), seams.begin(), seams.end());
    try {
      result.mesh = std::make_shared<ParametricMesh>(delaunay_mesh(task));
    } catch (const InputError& error) {
      throw InputError(who() + error.what());
    }
    if (has_seam()) close(result, number);
    result.piece_of_edge.assign(result.mesh->edge_count(), -1);
    result.edge_lists.assign(lines_.size(), {});
    result.piece_lists.assign(lines_.size(), {});
    for (size_t p = 0; p < result.pieces.size(); ++p) {
      const Piece& piece = result.pieces[p];
      const int e = result.mesh->edge_between(piece.a, piece.b);
      if (e < 0)
        throw InputError(who() + "the line '" + lines_[piece.line].name() +
                         "' touches another one where they share no point");
      result.piece_of_edge[e] = static_cast<int>(p);
      result.edge_lists[piece.line].push_back(e);
      result.piece_lists[piece.line].push_back(static_cast<int>(p));
    }
  }

  bool on_seam(int node) const {
    const auto& stops = stops_[seam()];
    return std::any_of(stops.begin(), stops.end(),
                       [&](const Stop& stop) { return stop.node == node; });
  }

  /// The two images of the seam become one.
  void close(RegionMesh& result, const std::vector<std::array<int, 2>>& number) const {
    const ParametricMesh& open = *result.mesh;
    std::vector<int> becomes(static_cast<size_t>(open.vertex_count()), -1);
    for (const auto& [left, right] : number)
      if (left >= 0 && right >= 0) becomes[static_cast<size_t>(right)] = left;
    std::vector<Vec2> vertices;
    std::vector<int> closed(becomes.size(), -1);
    const ParametricMesh& mesh = region_.surface.mesh();
    for (size_t v = 0; v < becomes.size(); ++v) {
      if (becomes[v] >= 0) continue;
      closed[v] = static_cast<int>(vertices.size());
      vertices.push_back(mesh.wrapped(open.vertices()[v]));
    }
    for (size_t v = 0; v < becomes.size(); ++v)
      if (becomes[v] >= 0) closed[v] = closed[static_cast<size_t>(becomes[v])];
    std::vector<ParametricMesh::Triangle> triangles = open.triangles();
    for (auto& triangle : triangles)
      for (int& v : triangle) v = closed[static_cast<size_t>(v)];
    for (Piece& piece : result.pieces)
      for (int* node : {&piece.a, &piece.b}) *node = closed[static_cast<size_t>(*node)];
    result.mesh =
        std::make_shared<ParametricMesh>(std::move(vertices), std::move(triangles), period());
  }

  const SkinnedRegion& region_;
  std::vector<Line> lines_;  // of the region, then of a ring the seam
  std::vector<char> on_boundary_;
  std::vector<int> at_least_;
  double same_ = 0, size_ = 0, space_ = 0;
  std::vector<Vec2> nodes_;
  std::vector<std::vector<Stop>> stops_;
  std::vector<Piece> pieces_;
  std::set<Key> straight_;
  std::optional<DomainLoops> loops_;
};

// ------------------------------------------------------------------------------------- facets

bool has_own_mesh(const SkinnedRegion& region) {
  return region.surface.trim() || !region.embedded.empty();
}

/// Display points, those on each edge from its lower end to its higher one, and lines as chains of
/// directed edges.
struct Pattern {
  Tessellation tessellation;
  std::vector<Vec2> uv;
  std::vector<std::vector<int>> edge_points;
  struct Link {
    int edge, from, to;
  };
  std::vector<std::vector<Link>> lines;
  std::shared_ptr<const ParametricMesh> mesh;
};

Pattern pattern(const SkinnedRegion& region, int n, double edge_length) {
  Pattern result;
  const Surface& surface = region.surface;
  std::optional<RegionMesh> own;
  if (has_own_mesh(region)) own = Builder(region, edge_length).build();
  result.mesh = own ? own->mesh : surface.shared_mesh();
  const ParametricMesh& mesh = *result.mesh;

  result.tessellation = tessellate(mesh, n);
  auto& points = result.tessellation.points;
  for (const auto& e : mesh.edges()) result.edge_points.push_back({e.low});
  // After the vertices come the points inside edges, from the lower end, and inside triangles.
  for (size_t p = static_cast<size_t>(mesh.vertex_count()); p < points.size(); ++p)
    for (int i = 0; i < 3; ++i)
      if (points[p].L[i] == 0)
        result.edge_points[mesh.edges_of(points[p].triangle)[i]].push_back(static_cast<int>(p));
  for (int e = 0; e < mesh.edge_count(); ++e) result.edge_points[e].push_back(mesh.edges()[e].high);

  if (!own) {
    for (const Location& where : points)
      result.uv.push_back(mesh.shape(where.triangle).point(where.L));
    for (const LineRun& run : region.runs) {
      result.lines.emplace_back();
      for (size_t k = 0; k < run.edges.size(); ++k)
        result.lines.back().push_back({run.edges[k], run.vertices[k], run.vertices[k + 1]});
    }
    return result;
  }
  const size_t lines = region.runs.size() + region.embedded.size();
  for (size_t l = 0; l < lines; ++l) {
    const auto& list = own->piece_lists[l];
    result.lines.emplace_back();
    for (const int p : list) {
      const Piece& piece = own->pieces[static_cast<size_t>(p)];
      result.lines.back().push_back({mesh.edge_between(piece.a, piece.b), piece.a, piece.b});
    }
  }
  const TriangleLocator locator(surface.mesh());
  for (Location& where : points) {
    result.uv.push_back(own->image(where));
    where = locator.locate(result.uv.back());
  }
  for (size_t f = 0; f < result.tessellation.facets.size(); ++f) {
    const auto& [a, b, c] = result.tessellation.facets[f];
    const Vec2& first = result.uv[a];
    result.tessellation.facet_triangle[f] =
        locator
            .locate((first + mesh.image_near(result.uv[b], first) +
                     mesh.image_near(result.uv[c], first)) /
                    3)
            .triangle;
  }
  return result;
}

}  // namespace

double facet_length(const SkinnedRegion& region) {
  const Surface& surface = region.surface;
  const ParametricMesh& mesh = surface.mesh();
  double sum = 0;
  int count = 0;
  Builder::for_each_edge(surface, [&](int e) {
    sum +=
        (surface.dofs().row(3 * mesh.edges()[e].low) - surface.dofs().row(3 * mesh.edges()[e].high))
            .norm();
    ++count;
  });
  return sum / count;
}

QuadraticFacets quadratic_facets(const SkinnedRegion& region, double edge_length) {
  Pattern halves = pattern(region, 2, edge_length);
  const ParametricMesh& mesh = *halves.mesh;
  const auto middle = [&](int edge) { return halves.edge_points[edge][1]; };
  QuadraticFacets result;
  result.of_elements = !has_own_mesh(region);
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const auto &v = mesh.triangles()[t], &e = mesh.edges_of(t);
    result.triangles.push_back({v[0], v[1], v[2], middle(e[2]), middle(e[0]), middle(e[1])});
    // Of four facets, the one without a corner is the middle one.
    for (int f = 4 * t; f < 4 * t + 4; ++f) {
      const auto& corners = halves.tessellation.facets[f];
      if (*std::min_element(corners.begin(), corners.end()) >= mesh.vertex_count())
        result.element.push_back(halves.tessellation.facet_triangle[f]);
    }
  }
  for (const auto& links : halves.lines) {
    result.lines.emplace_back();
    for (const auto& link : links)
      result.lines.back().push_back({link.from, link.to, middle(link.edge)});
  }
  result.nodes = std::move(halves.tessellation.points);
  result.uv = std::move(halves.uv);
  return result;
}

DisplayFacets facets(const SkinnedRegion& region, int n, double edge_length) {
  Pattern all = pattern(region, n, edge_length);
  DisplayFacets result;
  for (const auto& links : all.lines) {
    auto& chains = result.lines.emplace_back();
    for (const auto& link : links) {
      std::vector<int> piece = all.edge_points[link.edge];
      if (piece.front() != link.from) std::reverse(piece.begin(), piece.end());
      if (chains.empty() || chains.back().back() != link.from)
        chains.push_back(piece);
      else
        chains.back().insert(chains.back().end(), piece.begin() + 1, piece.end());
    }
  }
  result.tessellation = std::move(all.tessellation);
  return result;
}

}  // namespace batten
