#include "batten/io/cad/face_file.h"

#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/io/cad/edge_parameter.h"
#include "batten/io/cad/step_check.h"
#include "batten/io/files/input_file.h"

namespace batten {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Vec3 from_occ(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

/// Largest of many values, computed on all threads.
template <class Function>
double largest(size_t count, const Function& value) {
  const int parts = static_cast<int>(std::min<size_t>(count, 64));
  std::vector<double> of(static_cast<size_t>(parts), 0.0);
  parallel_parts(parts, [&](int p) {
    for (size_t i = count * p / parts; i < count * (p + 1) / parts; ++i) {
      const double found = value(i);
      of[p] = std::max(of[p], std::isfinite(found) ? found : infinity);
    }
  });
  return parts > 0 ? *std::max_element(of.begin(), of.end()) : 0;
}

/// Points of the region's surface, by triangles: n² of each.
std::vector<Vec2> points_of_region(const FaceMaker& made) {
  const ParametricMesh& mesh = made.region().surface.mesh();
  const double per_triangle = 6.0 * made.cells() / mesh.triangle_count();
  const int n = std::clamp(static_cast<int>(std::ceil(std::sqrt(per_triangle))), 3, 24);
  std::vector<Vec2> points;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    const TriangleShape shape = mesh.shape(t);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const double a = (i + 1.0 / 3) / n, b = (j + 1.0 / 3) / n;
        const Vec2 uv = shape.point({a, b, 1 - a - b});
        if (made.boundary().contains(uv)) points.push_back(uv);
      }
  }
  return points;
}

/// The knots of a surface in both directions, and which of their cells a border passes through.
class KnotCells {
 public:
  KnotCells(std::vector<double> u, std::vector<double> v)
      : u_(std::move(u)), v_(std::move(v)), passed_((u_.size() - 1) * (v_.size() - 1), 0) {}

  /// A piece of the border, short against the cells.
  void pass(const Vec2& a, const Vec2& b) {
    const auto [i0, i1] = range(u_, a.x(), b.x());
    const auto [j0, j1] = range(v_, a.y(), b.y());
    for (size_t i = i0; i <= i1; ++i)
      for (size_t j = j0; j <= j1; ++j) passed_[i * (v_.size() - 1) + j] = 1;
  }

  /// n² points of each cell that are inside: `near_border` tells of a point in a cell that
  /// the border passes, `elsewhere` of any other; neighbours that the border leaves alone are asked once.
  template <class NearBorder, class Elsewhere>
  std::vector<Vec2> points(const NearBorder& near_border, const Elsewhere& elsewhere) const {
    const int n = u_.size() * v_.size() > 10'000 ? 2 : 3;
    std::vector<Vec2> points;
    for (size_t i = 0; i + 1 < u_.size(); ++i) {
      enum { Unknown, In, Out } state = Unknown;
      for (size_t j = 0; j + 1 < v_.size(); ++j) {
        const bool passed = passed_[i * (v_.size() - 1) + j];
        if (passed)
          state = Unknown;
        else if (state == Unknown)
          state = elsewhere(at(i, j, 0.5, 0.5)) ? In : Out;
        for (int k = 0; k < n * n; ++k) {
          const Vec2 uv = at(i, j, (k / n + 0.5) / n, (k % n + 0.5) / n);
          if (passed ? near_border(uv) : state == In) points.push_back(uv);
        }
      }
    }
    return points;
  }

 private:
  Vec2 at(size_t i, size_t j, double s, double t) const {
    return {(1 - s) * u_[i] + s * u_[i + 1], (1 - t) * v_[j] + t * v_[j + 1]};
  }
  static std::pair<size_t, size_t> range(const std::vector<double>& knots, double a, double b) {
    const auto cell = [&](double x) {
      const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, x);
      return static_cast<size_t>(above - knots.begin()) - 1;
    };
    return {cell(std::min(a, b)), cell(std::max(a, b))};
  }

  std::vector<double> u_, v_;
  std::vector<char> passed_;
};

/// An edge of the file, along the loop.
struct FileEdge {
  Handle(Geom_Curve) curve;
  Handle(Geom2d_Curve) line;
  double first, last;
  bool backwards;     // against the loop
  double weight = 1;  // of its parameter
  /// The parameter at a share of the parameter that the edge was made with.
  double at(double share) const {
    return first + new_share(backwards ? 1 - share : share, weight) * (last - first);
  }
};

/// Edges of the file's face that are no seam, and how far any edge is from the face and from its
/// vertices.
struct FileEdges {
  std::vector<FileEdge> edges;
  double gap = 0;
};

/// Reads the edges of a face; none if one of them lacks its curve.
std::optional<FileEdges> edges_of_face(const TopoDS_Face& face,
                                       const Geom_BSplineSurface& surface) {
  FileEdges found;
  double& gap = found.gap;
  for (TopExp_Explorer it(face.Oriented(TopAbs_FORWARD), TopAbs_EDGE); it.More(); it.Next()) {
    const TopoDS_Edge& edge = TopoDS::Edge(it.Current());
    FileEdge e{};
    e.backwards = edge.Orientation() == TopAbs_REVERSED;
    double first, last;
    e.curve = BRep_Tool::Curve(edge, e.first, e.last);
    e.line = BRep_Tool::CurveOnSurface(edge, face, first, last);
    // Readers put edges without length where lines meet at a tangent.
    if (BRep_Tool::Degenerated(edge)) continue;
    if (e.curve.IsNull() || e.line.IsNull()) return std::nullopt;
    e.weight = parameter_weight(*e.curve);
    const int n = 4 * (surface.NbUKnots() + surface.NbVKnots());
    for (int i = 0; i <= n; ++i) {
      const double t = e.at(double(i) / n);
      const gp_Pnt2d uv = e.line->Value(t);
      gap = std::max(gap, e.curve->Value(t).Distance(surface.Value(uv.X(), uv.Y())));
    }
    TopoDS_Vertex a, b;
    TopExp::Vertices(edge, a, b);
    if (!a.IsNull()) gap = std::max(gap, BRep_Tool::Pnt(a).Distance(e.curve->Value(e.first)));
    if (!b.IsNull()) gap = std::max(gap, BRep_Tool::Pnt(b).Distance(e.curve->Value(e.last)));
    if (!BRep_Tool::IsClosed(edge, face)) found.edges.push_back(e);
  }
  return found;
}

/// Points of the file's face, by the cells of its knots, that are inside of its trim. (Close to the
/// border the region's own loops decide: they are far quicker, and how near the two borders are is
/// measured elsewhere.)
std::vector<Vec2> points_of_face(const TopoDS_Face& face, const Geom_BSplineSurface& surface,
                                 const std::vector<FileEdge>& edges, const FaceMaker& made) {
  std::vector<double> u, v;
  for (int i = 1; i <= surface.NbUKnots(); ++i) u.push_back(surface.UKnot(i));
  for (int j = 1; j <= surface.NbVKnots(); ++j) v.push_back(surface.VKnot(j));
  KnotCells cells(u, v);
  for (const FileEdge& e : edges) {
    const int n = 8 * (surface.NbUKnots() + surface.NbVKnots());
    gp_Pnt2d before = e.line->Value(e.at(0));
    for (int i = 1; i <= n; ++i) {
      const gp_Pnt2d here = e.line->Value(e.at(double(i) / n));
      cells.pass({before.X(), before.Y()}, {here.X(), here.Y()});
      before = here;
    }
  }
  BRepTopAdaptor_FClass2d classifier(face, 1e-9);
  return cells.points([&](const Vec2& uv) { return made.boundary().contains(uv); },
                      [&](const Vec2& uv) {
                        return classifier.Perform({uv.x(), uv.y()}) == TopAbs_IN;
                      });
}

/// How far an edge of the file is from the line, or from the region's rim where no other region has
/// the line, at the same share of the parameter.
double apart(const FileEdge& e, const FaceStretch& stretch, double share, const FaceMaker& made) {
  const double start = stretch.curve.start(), end = stretch.curve.end();
  const double t = share < 1 ? start + share * (end - start) : end;
  const Vec3 p = from_occ(e.curve->Value(e.at(share)));
  return (p - (stretch.shared ? stretch.curve.evaluate(t) : made.position(stretch.uv(t)))).norm();
}

/// Finds the unused edge of the file that is nearest to a boundary curve; their count if all are
/// used.
size_t nearest_edge(const std::vector<FileEdge>& edges, const std::vector<char>& used,
                    const FaceStretch& stretch, const FaceMaker& made) {
  size_t mine = edges.size();
  double nearest = infinity;
  for (size_t k = 0; k < edges.size(); ++k) {
    double distance = 0;
    for (const double share : {0.1, 0.3, 0.5, 0.7, 0.9})
      distance = std::max(distance, apart(edges[k], stretch, share, made));
    if (used[k] || distance >= nearest) continue;
    nearest = distance;
    mine = k;
  }
  return mine;
}

/// Measures a boundary curve against its edge of the file at n + 1 places, and adds them to
/// `points`.
void measure_stretch(const FaceStretch& stretch, const FileEdge& edge, int n, const FaceMaker& made,
                     StepPatch& report, std::vector<Vec2>& points) {
  const double start = stretch.curve.start(), end = stretch.curve.end();
  for (int i = 0; i <= n; ++i) {
    const double share = double(i) / n, t = start + share * (end - start);
    report.edge_deviation = std::max(report.edge_deviation, apart(edge, stretch, share, made));
    const Vec2 uv = i < n ? stretch.uv(t) : stretch.last();
    points.push_back(uv);
    const Vec3 x = i < n ? stretch.curve.evaluate(t)
                         : stretch.curve.evaluate({stretch.curve.segment_count() - 1, 1.0});
    report.line_gap = std::max(report.line_gap, (made.position(uv) - x).norm());
    const gp_Pnt2d of_file = edge.line->Value(edge.at(share));
    points.emplace_back(of_file.X(), of_file.Y());
  }
}

/// Measures a face of the file against the region that it was made of.
void measure_face(const TopoDS_Face& face, const FaceMaker& made, StepPatch& report) {
  const Handle(Geom_BSplineSurface) surface =
      Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(face));
  report.deviation = report.edge_gap = report.edge_deviation = infinity;
  if (surface.IsNull()) return;
  const double begin = made.boundary().seam, period = made.boundary().period;
  const auto on_file = [&](const Vec2& uv) {
    const double u = period > 0 ? uv.x() - std::floor((uv.x() - begin) / period) * period : uv.x();
    return from_occ(surface->Value(u, uv.y()));
  };
  std::vector<Vec2> points = points_of_region(made);

  // Boundary curves, each with the edge of the file that is nearest to it at the same share of the
  // parameter.
  const auto found = edges_of_face(face, *surface);
  if (!found) return;
  const std::vector<FileEdge>& edges = found->edges;
  for (const Vec2& uv : points_of_face(face, *surface, edges, made)) points.push_back(uv);
  report.edge_deviation = 0;
  std::vector<char> used(edges.size());
  for (const FaceLoop& loop : made.boundary().loops)
    for (const FaceStretch& stretch : loop) {
      const size_t mine = nearest_edge(edges, used, stretch, made);
      if (mine == edges.size()) {
        report.edge_deviation = infinity;
        continue;
      }
      used[mine] = 1;
      const int n = 8 * (stretch.curve.segment_count() + stretch.image.segment_count() +
                         surface->NbUKnots() + surface->NbVKnots());
      measure_stretch(stretch, edges[mine], n, made, report, points);
    }
  if (std::find(used.begin(), used.end(), 0) != used.end()) report.edge_deviation = infinity;
  report.edge_gap = found->gap;
  report.deviation = largest(points.size(), [&](size_t i) {
    return (on_file(points[i]) - made.position(points[i])).norm();
  });
}

/// Finer fits until one is as near as was promised between its samples too, so that files of
/// many regions are seldom written twice.
void settle(FaceMaker& made, double tolerance) {
  constexpr int most_fits = 5;
  for (int i = 0; i < most_fits; ++i) {
    std::vector<Vec2> points = points_of_region(made);
    KnotCells cells(made.patch().u.knots(), made.patch().v.knots());
    for (const FaceLoop& loop : made.boundary().loops)
      for (const FaceStretch& stretch : loop) {
        const int n = 8 * (stretch.curve.segment_count() + stretch.image.segment_count() +
                           made.poles_u() + made.poles_v());
        const double start = stretch.curve.start(), end = stretch.curve.end();
        Vec2 before = stretch.first();
        for (int k = 0; k < n; ++k) {
          points.push_back(stretch.uv(start + (end - start) * double(k) / n));
          cells.pass(before, points.back());
          before = points.back();
        }
        cells.pass(before, stretch.last());
      }
    const auto contains = [&](const Vec2& p) { return made.boundary().contains(p); };
    for (const Vec2& uv : cells.points(contains, contains)) points.push_back(uv);
    const double deviation = largest(points.size(), [&](size_t k) {
      return (made.fitted_position(points[k]) - made.position(points[k])).norm();
    });
    if (deviation <= tolerance || !made.refine(deviation)) return;
  }
}

}  // namespace

void check_options(const std::filesystem::path& path, const StepFaceOptions& options) {
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
    throw InputError(path.string() + ": found a tolerance of " + number(options.tolerance) +
                     "; expected a length above 0");
  if (options.most_poles < 16 || options.most_poles_in_all < 256)
    throw InputError(path.string() + ": found a limit of " + std::to_string(options.most_poles) +
                     " poles in a direction and " + std::to_string(options.most_poles_in_all) +
                     " in all; expected 16 and 256 or more");
}

FittedFaces fitted_faces(const std::vector<const SkinnedRegion*>& regions, const StepPlan& plan,
                         const StepFaceOptions& options) {
  FittedFaces made(regions.size());
  parallel_parts(count_of(made), [&](int k) {
    made[k] = std::make_unique<FaceMaker>(*regions[k], options, plan.joined ? &plan : nullptr);
    if (made.size() > 1) settle(*made[k], options.tolerance);
  });
  return made;
}

StepReport refined(const FittedFaces& made, const std::function<StepReport()>& written) {
  StepReport report;
  for (int round = 0; round < 6; ++round) {
    report = written();
    bool again = false;
    for (size_t k = 0; k < made.size(); ++k)
      if (!report.patches[k].reached) again = made[k]->refine(report.patches[k].deviation) || again;
    if (!again) break;
  }
  return report;
}

void measure_patches(StepReport& report, const std::vector<TopoDS_Face>& faces,
                     const FittedFaces& made, double tolerance, const std::function<void()>& rest) {
  std::vector<StepPatch> patches(faces.size());
  const int before = rest ? 1 : 0;
  parallel_parts(before + count_of(faces), [&](int part) {
    if (part < before) return rest();
    const auto k = static_cast<size_t>(part - before);
    StepPatch& patch = patches[k];
    patch.region = made[k]->region().name;
    patch.poles_u = made[k]->poles_u();
    patch.poles_v = made[k]->poles_v();
    measure_face(faces[k], *made[k], patch);
    patch.reached = patch.deviation <= tolerance;
  });
  report.tolerance = tolerance;
  for (const StepPatch& patch : patches) {
    report.reached = report.reached && patch.reached;
    report.max_gap = std::max(report.max_gap, patch.edge_gap);
    report.line_gap = std::max(report.line_gap, patch.line_gap);
    report.edge_deviation = std::max(report.edge_deviation, patch.edge_deviation);
    report.patches.push_back(patch);
  }
}

StepReport measured_faces(const std::filesystem::path& path, const FittedFaces& made,
                          double tolerance, const std::function<void()>& beside) {
  TopoDS_Shape shape;
  parallel_parts(2, [&](int part) {
    if (part == 1) return beside();
    shape = read_step(path);
  });
  std::vector<TopoDS_Face> faces;
  for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
    faces.push_back(TopoDS::Face(it.Current()));
  if (faces.size() != made.size())
    throw Error(path.string() + ": OpenCASCADE reads " + std::to_string(faces.size()) +
                " faces where " + std::to_string(made.size()) + " were written");
  std::vector<int> region_of_face(faces.size());
  std::iota(region_of_face.begin(), region_of_face.end(), 0);
  StepReport report;
  measure_patches(report, faces, made, tolerance,
                  [&] { report = measured_shape(shape, region_of_face); });
  report.bytes = input_size(path);
  report.max_deviation = 0;
  for (const StepPatch& patch : report.patches)
    report.max_deviation = std::max(*report.max_deviation, patch.deviation);
  return report;
}

}  // namespace batten
