#include "batten/io/step.h"

#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Eigen/Geometry>
#include <GProp_GProps.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <STEPControl_Reader.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <cmath>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/io/occ_settings.h"
#include "batten/io/step_text.h"

namespace batten {
namespace {

gp_Pnt to_occ(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Vec3 from_occ(const gp_XYZ& p) { return {p.X(), p.Y(), p.Z()}; }

// ---- writing --------------------------------------------------------------------------------

using Ordinates = Eigen::Matrix<double, 10, 3>;
enum { kJ = 0, kK = 1, kC = 2, kJJK = 3, kJKK = 4, kKKC = 5, kKCC = 6, kJCC = 7, kJJC = 8 };

/// Bézier points of the bicubic that is the cubic with the given ordinates; row 4 i + j belongs to
/// s^i t^j. Through the power basis: p = Σ a_mn s^m t^n, a_mn by differences of the ordinates. On
/// the sides s = 0 and t = 0 the rows are the ordinates themselves, to the last bit.
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

/// One surface as a shell whose vertices and edges are made once.
class ShellMaker {
 public:
  ShellMaker(const Surface& surface, double size)
      : surface_(surface),
        mesh_(surface.mesh()),
        size_(size),
        vertices_(mesh_.vertex_count()),
        edges_(mesh_.edge_count()) {}

  TopoDS_Shell make() {
    for (int v = 0; v < mesh_.vertex_count(); ++v)
      vertices_[v] = vertex(surface_.dofs().row(surface_.dof_map().vertex(v)));
    TopoDS_Shell shell;
    builder_.MakeShell(shell);
    for (int t = 0; t < mesh_.triangle_count(); ++t) add_triangle(t, shell);
    return shell;
  }

 private:
  TopoDS_Vertex vertex(const Vec3& p) {
    TopoDS_Vertex result;
    builder_.MakeVertex(result, to_occ(p), tolerance());
    return result;
  }

  /// The cubic with these Bézier points, parameter 0 to 1 from `a` to `b`.
  TopoDS_Edge edge(const TopoDS_Vertex& a, const TopoDS_Vertex& b,
                   const Eigen::Matrix<double, 4, 3>& points) {
    TColgp_Array1OfPnt poles(1, 4);
    double length = 0;
    for (int i = 0; i < 4; ++i) {
      poles(i + 1) = to_occ(points.row(i));
      if (i > 0) length += (points.row(i) - points.row(i - 1)).norm();
    }
    if (!(length > 1e-9 * size_))
      throw InputError("STEP: an element edge at (" + number(points(0, 0)) + ", " +
                       number(points(0, 1)) + ", " + number(points(0, 2)) + ") has length " +
                       number(length) + "; expected a surface without collapsed edges");
    TopoDS_Edge result;
    builder_.MakeEdge(result, new Geom_BSplineCurve(poles, unit_knots(), end_knots(4), 3),
                      tolerance());
    builder_.Add(result, a.Oriented(TopAbs_FORWARD));
    builder_.Add(result, b.Oriented(TopAbs_REVERSED));
    builder_.Range(result, 0, 1);
    return result;
  }

  void add_triangle(int t, TopoDS_Shell& shell) {
    const auto q = surface_.triangle_dofs(t);
    const C1Triangle hct(TriangleElement::HCT, mesh_.shape(t));
    const std::array<Ordinates, 3> net{hct.bezier(0, q), hct.bezier(1, q), hct.bezier(2, q)};
    const auto& corner = mesh_.triangles()[t];

    const TopoDS_Vertex centroid = vertex(net[0].row(kC));
    std::array<TopoDS_Edge, 3> spoke;  // of corner i, towards the centroid
    for (int i = 0; i < 3; ++i) {
      const Ordinates& b = net[(i + 2) % 3];  // corner i is its V_j
      Eigen::Matrix<double, 4, 3> points;
      points << b.row(kJ), b.row(kJJC), b.row(kJCC), b.row(kC);
      spoke[i] = edge(vertices_[corner[i]], centroid, points);
    }
    for (int s = 0; s < 3; ++s) {
      const int j = (s + 1) % 3, k = (s + 2) % 3, e = mesh_.edges_of(t)[s];
      const bool along = mesh_.edge_sign(t, s) > 0;  // edges run from the lower vertex
      if (edges_[e].IsNull()) {
        Eigen::Matrix<double, 4, 3> points;
        points << net[s].row(kJ), net[s].row(kJJK), net[s].row(kJKK), net[s].row(kK);
        if (!along) points = points.colwise().reverse().eval();
        edges_[e] = edge(vertices_[mesh_.edges()[e].low], vertices_[mesh_.edges()[e].high], points);
      }
      add_face(net[s], edges_[e], along, spoke[k], spoke[j], shell);
    }
  }

  void add_face(const Ordinates& net, const TopoDS_Edge& side, bool along,
                const TopoDS_Edge& spoke_k, const TopoDS_Edge& spoke_j, TopoDS_Shell& shell) {
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
    if (along)
      add(side, v_j, v_k, TopAbs_FORWARD);
    else
      add(side, v_k, v_j, TopAbs_REVERSED);
    add(spoke_k, v_k, centroid, TopAbs_FORWARD);
    add(spoke_j, v_j, centroid, TopAbs_REVERSED);
    wire.Closed(true);
    builder_.Add(face, wire);
    builder_.Add(shell, face);
  }

  double tolerance() const { return 1e-9 * size_; }

  const Surface& surface_;
  const ParametricMesh& mesh_;
  double size_;
  BRep_Builder builder_;
  std::vector<TopoDS_Vertex> vertices_;
  std::vector<TopoDS_Edge> edges_;
};

/// Diagonal of the box around all vertices of the meshes. Throws InputError for what is not finite.
double size_of(const std::vector<const Surface*>& surfaces) {
  Eigen::AlignedBox3d box;
  for (const Surface* surface : surfaces) {
    if (!surface->dofs().allFinite())
      throw InputError("STEP: a surface has dofs that are not finite");
    for (int v = 0; v < surface->mesh().vertex_count(); ++v)
      box.extend(Vec3(surface->dofs().row(surface->dof_map().vertex(v))));
  }
  return box.diagonal().norm();
}

// ---- reading back ---------------------------------------------------------------------------

TopoDS_Shape read_shape(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path))
    throw InputError(path.string() + ": no such file; expected a STEP file");
  STEPControl_Reader reader;
  TopoDS_Shape shape;
  if (reader.ReadFile(path.string().c_str()) == IFSelect_RetDone) {
    reader.TransferRoots();
    shape = reader.OneShape();
  }
  if (shape.IsNull())
    throw InputError(path.string() + ": OpenCASCADE finds no shape in it; expected a STEP file");
  return shape;
}

constexpr int kEdgePoints = 9;

/// A face seen along one of its edges.
struct Side {
  Handle(Geom_Surface) surface;
  Handle(Geom2d_Curve) line;
  bool reversed = false;

  gp_Pnt point(double parameter) const {
    const gp_Pnt2d uv = line->Value(parameter);
    return surface->Value(uv.X(), uv.Y());
  }
  /// Outward unit normal, or zero where there is none.
  Vec3 normal(double parameter) const {
    const gp_Pnt2d uv = line->Value(parameter);
    gp_Pnt p;
    gp_Vec du, dv;
    surface->D1(uv.X(), uv.Y(), p, du, dv);
    const Vec3 n = from_occ(du.Crossed(dv).XYZ());
    if (!(n.norm() > 1e-12 * du.Magnitude() * dv.Magnitude())) return Vec3::Zero();
    return (reversed ? -1 : 1) * n.normalized();
  }
};

void measure_edges(const TopoDS_Shape& shape, StepReport& report) {
  TopTools_IndexedMapOfShape edges;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  report.edges = edges.Extent();
  std::vector<std::vector<Side>> sides(edges.Extent());
  for (TopExp_Explorer f(shape, TopAbs_FACE); f.More(); f.Next()) {
    const TopoDS_Face& face = TopoDS::Face(f.Current());
    for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
      const TopoDS_Edge& edge = TopoDS::Edge(e.Current());
      double first, last;
      sides[edges.FindIndex(edge) - 1].push_back(
          {BRep_Tool::Surface(face), BRep_Tool::CurveOnSurface(edge, face, first, last),
           face.Orientation() == TopAbs_REVERSED});
    }
  }

  Bnd_Box box;
  for (int e = 0; e < edges.Extent(); ++e) {
    const TopoDS_Edge& edge = TopoDS::Edge(edges(e + 1));
    if (sides[e].size() == 1) ++report.free_edges;
    double first, last;
    const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
    if (curve.IsNull()) {
      ++report.unmeasured;
      continue;
    }
    const auto gap = [&](const gp_Pnt& a, const gp_Pnt& b) {
      report.max_gap = std::max(report.max_gap, a.Distance(b));
    };
    TopoDS_Vertex start, end;
    TopExp::Vertices(edge, start, end);
    if (!start.IsNull()) gap(BRep_Tool::Pnt(start), curve->Value(first));
    if (!end.IsNull()) gap(BRep_Tool::Pnt(end), curve->Value(last));
    for (int i = 0; i < kEdgePoints; ++i) {
      const double parameter = first + (last - first) * i / (kEdgePoints - 1);
      const gp_Pnt on_edge = curve->Value(parameter);
      box.Add(on_edge);
      std::vector<Vec3> normals;
      for (const Side& side : sides[e]) {
        if (side.line.IsNull()) {
          ++report.unmeasured;
          continue;
        }
        gap(on_edge, side.point(parameter));
        normals.push_back(side.normal(parameter));
        if (normals.back().isZero()) ++report.unmeasured;
      }
      for (size_t a = 0; a < normals.size(); ++a)
        for (size_t b = 0; b < a; ++b) {
          const double angle =
              std::atan2(normals[a].cross(normals[b]).norm(), normals[a].dot(normals[b]));
          report.max_normal_jump_deg =
              std::max(report.max_normal_jump_deg, angle * 180 / std::numbers::pi);
        }
    }
  }
  if (!box.IsVoid()) report.size = std::sqrt(box.SquareExtent());
}

/// Points inside the face, as a grid over the box of its parameters; the box's middle if none is.
std::vector<gp_Pnt2d> points_inside(const TopoDS_Face& face) {
  constexpr int n = 5;
  double u0, u1, v0, v1;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  BRepTopAdaptor_FClass2d classifier(face, 1e-9);
  std::vector<gp_Pnt2d> points;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const gp_Pnt2d uv(u0 + (u1 - u0) * (i + 0.5) / n, v0 + (v1 - v0) * (j + 0.5) / n);
      if (classifier.Perform(uv) != TopAbs_OUT) points.push_back(uv);
    }
  if (points.empty()) points.emplace_back((u0 + u1) / 2, (v0 + v1) / 2);
  return points;
}

/// Largest distance between the face, read as sub-triangle `sub` of a triangle, and the surface at
/// the same barycentric coordinates: never less than the distance to the nearest point.
double matched_deviation(const Handle(Geom_Surface) & face, const Surface& surface, int triangle,
                         int sub) {
  constexpr int n = 4;
  double worst = 0;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; i + j <= n; ++j) {
      const double s = double(i) / n, t = double(j) / n;
      Vec3 L = Vec3::Constant(t / 3);
      L[(sub + 1) % 3] += 1 - s - t;
      L[(sub + 2) % 3] += s;
      const Vec3 x = from_occ(face->Value(s, t).XYZ());
      worst = std::max(worst, (x - surface.position({triangle, L})).norm());
    }
  return worst;
}

double nearest_deviation(const TopoDS_Face& face, const Handle(Geom_Surface) & geometry,
                         const std::vector<const Surface*>& surfaces) {
  double worst = 0;
  for (const gp_Pnt2d& uv : points_inside(face)) {
    const Vec3 p = from_occ(geometry->Value(uv.X(), uv.Y()).XYZ());
    double nearest = std::numeric_limits<double>::infinity();
    for (const Surface* surface : surfaces)
      nearest = std::min(nearest, surface->closest_point(p).distance);
    worst = std::max(worst, nearest);
  }
  return worst;
}

bool on_unit_square(const TopoDS_Face& face) {
  double u0, u1, v0, v1;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  return std::abs(u0) + std::abs(u1 - 1) + std::abs(v0) + std::abs(v1 - 1) < 1e-6;
}

/// Faces of write_step come back in their order: as long as they agree with the surface there, no
/// search for the nearest point is needed.
double deviation(const TopoDS_Shape& shape, const std::vector<const Surface*>& surfaces,
                 const StepReport& report) {
  struct SubTriangle {
    const Surface* surface;
    int triangle, sub;
  };
  std::vector<SubTriangle> expected;
  for (const Surface* surface : surfaces)
    for (int t = 0; t < surface->mesh().triangle_count(); ++t)
      for (int s = 0; s < 3; ++s) expected.push_back({surface, t, s});
  const bool as_written = static_cast<int>(expected.size()) == report.faces;

  double worst = 0;
  size_t f = 0;
  for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next(), ++f) {
    const TopoDS_Face& face = TopoDS::Face(it.Current());
    const Handle(Geom_Surface) geometry = BRep_Tool::Surface(face);
    double found = std::numeric_limits<double>::infinity();
    if (as_written && f < expected.size() && on_unit_square(face)) {
      const auto& [surface, t, s] = expected[f];
      found = matched_deviation(geometry, *surface, t, s);
    }
    if (found > 1e-4 * report.size)
      found = std::min(found, nearest_deviation(face, geometry, surfaces));
    worst = std::max(worst, found);
  }
  return worst;
}

int count(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) {
  TopTools_IndexedMapOfShape map;
  TopExp::MapShapes(shape, kind, map);
  return map.Extent();
}

}  // namespace

std::string step_size_warning(const std::vector<const Surface*>& surfaces) {
  constexpr double bytes_per_face = 4750;
  constexpr int most_triangles = 10'000;
  int triangles = 0;
  for (const Surface* surface : surfaces) triangles += surface->mesh().triangle_count();
  if (triangles <= most_triangles) return "";
  return "the exact STEP file has " + std::to_string(3 * triangles) + " faces and about " +
         std::to_string(std::lround(3 * triangles * bytes_per_face / 1e6)) +
         " MB: fewer, larger elements make a smaller one";
}

StepReport write_step(const std::filesystem::path& file,
                      const std::vector<const Surface*>& surfaces, double model_unit_in_metres,
                      const StepOptions& options) {
  if (surfaces.empty()) throw InputError(file.string() + ": no surface to write");
  for (const Surface* surface : surfaces)
    if (surface->kind() != TriangleElement::HCT && !options.z12_as_hct)
      throw InputError(file.string() +
                       ": found a surface of Z12 elements, which are rational and have no exact "
                       "STEP form; expected HCT elements (element = \"hct\")");
  const std::string unit = cad_unit(model_unit_in_metres);
  const double size = size_of(surfaces);

  OccSettings occ;
  occ.set_unit(unit);
  occ.set("write.step.schema", "AP214IS");
  occ.set("write.step.product.name", options.name.c_str());
  occ.set("write.surfacecurve.mode", 1);
  occ.set("write.precision.mode", 2);  // the value given next
  occ.set("write.precision.val", 1e-9 * size);
  try {
    STEPControl_Writer writer;
    TopoDS_Shape shape;
    if (surfaces.size() == 1) {
      shape = ShellMaker(*surfaces[0], size).make();
    } else {
      TopoDS_Compound compound;
      BRep_Builder().MakeCompound(compound);
      for (const Surface* surface : surfaces)
        BRep_Builder().Add(compound, ShellMaker(*surface, size).make());
      shape = compound;
    }
    if (writer.Transfer(shape, STEPControl_AsIs) != IFSelect_RetDone)
      throw Error(file.string() + ": OpenCASCADE cannot turn the surface into STEP");
    save_step(writer, file, {options.name, options.author, "surfaces"});
  } catch (const Standard_Failure& failure) {
    throw Error(file.string() + ": OpenCASCADE failed to write it: " + failure.GetMessageString());
  }
  StepReport report = check_step(file, model_unit_in_metres, surfaces);
  if (const std::string warning = step_size_warning(surfaces); !warning.empty())
    report.warnings.push_back(warning);
  return report;
}

StepReport check_step(const std::filesystem::path& file, double model_unit_in_metres,
                      const std::vector<const Surface*>& surfaces) {
  OccSettings occ;
  occ.set_unit(cad_unit(model_unit_in_metres));
  try {
    const TopoDS_Shape shape = read_shape(file);
    StepReport report;
    report.file = file;
    report.bytes = std::filesystem::file_size(file);
    report.shells = count(shape, TopAbs_SHELL);
    report.faces = count(shape, TopAbs_FACE);
    measure_edges(shape, report);
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(shape, properties);
    report.area = properties.Mass();
    report.valid = BRepCheck_Analyzer(shape).IsValid();
    if (!surfaces.empty()) report.max_deviation = deviation(shape, surfaces, report);
    return report;
  } catch (const Standard_Failure& failure) {
    throw InputError(file.string() +
                     ": OpenCASCADE failed to read it: " + failure.GetMessageString());
  }
}

}  // namespace batten
