// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/cad_lines.h"

#include <BRepAdaptor_Curve.hxx>
#include <BRepBndLib.hxx>
#include <BRepGProp_Face.hxx>
#include <BRepTools.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_Line.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <IGESBasic_Name.hxx>
#include <IGESControl_Writer.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGeom_BSplineCurve.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColgp_HArray1OfXYZ.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <map>
#include <sstream>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/curves/bspline.h"
#include "batten/fem/curves/hermite_curve.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/cad_writer.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_curve.h"

namespace batten {
namespace {

constexpr double kMillimetre = 1e-3;

// ---- curves ---------------------------------------------------------------------------------

class CadCurve : public InputCurve {
 public:
  CadCurve(Handle(Geom_Curve) curve, double start, double end, double scale)
      : curve_(std::move(curve)), start_(start), end_(end), scale_(scale) {
    while (curve_->IsKind(STANDARD_TYPE(Geom_TrimmedCurve)))
      curve_ = Handle(Geom_TrimmedCurve)::DownCast(curve_)->BasisCurve();
    find_breaks();
  }

  double start() const override { return start_; }
  double end() const override { return end_; }
  std::vector<double> breaks() const override { return breaks_; }
  bool piecewise_cubic() const override { return cubic_; }

  Vec3 evaluate(double t, int order) const override {
    gp_Pnt p;
    gp_Vec d1, d2;
    switch (order) {
      case 0:
        curve_->D0(t, p);
        return scale_ * from_occ(p.XYZ());
      case 1:
        curve_->D1(t, p, d1);
        return scale_ * from_occ(d1.XYZ());
      case 2:
        curve_->D2(t, p, d1, d2);
        return scale_ * from_occ(d2.XYZ());
      default:
        throw std::logic_error("a CAD curve has derivatives of order 0 to 2");
    }
  }

 private:
  void find_breaks() {
    breaks_ = {start_};
    if (const auto spline = Handle(Geom_BSplineCurve)::DownCast(curve_); !spline.IsNull()) {
      cubic_ = spline->Degree() <= 3 && !spline->IsRational();
      add_knots(*spline);
    } else {
      const auto bezier = Handle(Geom_BezierCurve)::DownCast(curve_);
      cubic_ = curve_->IsKind(STANDARD_TYPE(Geom_Line)) ||
               (!bezier.IsNull() && bezier->Degree() <= 3 && !bezier->IsRational());
      GeomAdaptor_Curve adaptor(curve_, start_, end_);
      TColStd_Array1OfReal ends(1, adaptor.NbIntervals(GeomAbs_C1) + 1);
      adaptor.Intervals(ends, GeomAbs_C1);
      for (const double t : ends) add_break(t);
    }
    breaks_.push_back(end_);
  }

  void add_break(double t) {
    const double near = 1e-12 * (end_ - start_);
    if (t > breaks_.back() + near && t < end_ - near) breaks_.push_back(t);
  }

  void add_knots(const Geom_BSplineCurve& spline) {
    // An edge on a periodic spline may extend across the seam.
    const double period = spline.IsPeriodic() ? spline.Period() : 0;
    const int period_count =
        period > 0 ? static_cast<int>((end_ - spline.FirstParameter()) / period) : 0;
    for (int period_index = std::min(period_count, 0) - (period > 0); period_index <= period_count;
         ++period_index)
      for (int k = 1; k <= spline.NbKnots(); ++k)
        if (cubic_ || spline.Multiplicity(k) >= spline.Degree())
          add_break(spline.Knot(k) + period_index * period);
  }

  Handle(Geom_Curve) curve_;
  double start_, end_, scale_;
  std::vector<double> breaks_;
  bool cubic_ = false;
};

void add_seams(const TopoDS_Face& face, TopTools_IndexedMapOfShape& seams) {
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next())
    if (is_seam(TopoDS::Edge(e.Current()), face)) seams.Add(e.Current());
}

}  // namespace

double millimetres_in(double model_unit_in_metres) {
  if (!(model_unit_in_metres > 0) || !std::isfinite(model_unit_in_metres))
    throw InputError("a model unit of " + format_number(model_unit_in_metres) +
                     " m; expected more than 0");
  return kMillimetre / model_unit_in_metres;
}

std::shared_ptr<const InputCurve> cad_curve(Handle(Geom_Curve) curve, double start, double end,
                                            double scale) {
  return std::make_shared<CadCurve>(std::move(curve), start, end, scale);
}

std::vector<CharacterLine> read_cad_lines(const std::filesystem::path& file,
                                          double model_unit_in_metres, bool creases,
                                          int* face_count) {
  const double scale = millimetres_in(model_unit_in_metres);
  CadFile cad = read_cad(file);
  if (face_count) *face_count = cad.faces.Extent();
  if (creases) heal_shape(cad);
  TopTools_IndexedMapOfShape of_faces, seams;
  for (int f = 1; f <= cad.faces.Extent(); ++f) {
    TopExp::MapShapes(cad.faces(f), TopAbs_EDGE, of_faces);
    add_seams(TopoDS::Face(cad.faces(f)), seams);
  }
  std::vector<CharacterLine> lines;
  const std::vector<std::string> names = edge_names(cad);
  for (int e = 1; e <= cad.edges.Extent(); ++e) {
    const TopoDS_Shape& edge = cad.edges(e);
    if (names[e - 1].empty() || (creases && (!of_faces.Contains(edge) || seams.Contains(edge))))
      continue;
    double start, end;
    const Handle(Geom_Curve) curve = curve_of(TopoDS::Edge(edge), start, end);
    lines.push_back(
        {names[e - 1], cad_curve(curve, start, end, scale), CharacterLine::Role::Outline});
  }
  if (lines.empty())
    throw InputError(file.string() + ": found " + cad.found +
                     " and no curve; expected curves or "
                     "the edges of surfaces");
  return lines;
}

// ---- surfaces -------------------------------------------------------------------------------

struct CadSurface::Data {
  struct Sample {
    Vec3 x;
    double u, v;
  };
  struct Edge {
    Handle(Geom_Curve) curve;
    double start, end;
    std::vector<Sample> samples;  // parameter stored in u
  };

  double scale = 1;  // converts from millimetres
  Box3 box;          // millimetres
  TopoDS_Face face;
  Handle(Geom_Surface) surface;
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
  std::vector<Sample> samples;  // inside the trimmed face
  std::vector<Edge> edges;

  void build();
  double to_inside(const Vec3& p) const;
  double to_edges(const Vec3& p, double limit) const;
  std::unique_ptr<BRepTopAdaptor_FClass2d> classifier;
  bool inside(double u, double v) const {
    return classifier->Perform(gp_Pnt2d(u, v)) != TopAbs_OUT;
  }
};

namespace {

/// The number of samples in a direction with this many polynomial pieces, 17 to 65.
int sample_count(int pieces) { return std::clamp(4 * pieces + 1, 17, 65); }

}  // namespace

void CadSurface::Data::build() {
  Bnd_Box around;
  BRepBndLib::Add(face, around, false);
  if (!around.IsVoid()) {
    double low[3], high[3];
    around.Get(low[0], low[1], low[2], high[0], high[1], high[2]);
    box = Box3(Vec3(low[0], low[1], low[2]), Vec3(high[0], high[1], high[2]));
  }
  surface = BRep_Tool::Surface(face);
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  int nu = 33, nv = 33;
  if (const auto spline = Handle(Geom_BSplineSurface)::DownCast(surface); !spline.IsNull()) {
    nu = sample_count(spline->NbUKnots() - 1);
    nv = sample_count(spline->NbVKnots() - 1);
  }
  classifier = std::make_unique<BRepTopAdaptor_FClass2d>(face, 1e-9);
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j) {
      const double u = u0 + (u1 - u0) * (i + 0.5) / nu, v = v0 + (v1 - v0) * (j + 0.5) / nv;
      if (inside(u, v)) samples.push_back({from_occ(surface->Value(u, v).XYZ()), u, v});
    }
  TopTools_IndexedMapOfShape map;
  TopExp::MapShapes(face, TopAbs_EDGE, map);
  for (int e = 1; e <= map.Extent(); ++e) {
    Edge edge;
    edge.curve = curve_of(TopoDS::Edge(map(e)), edge.start, edge.end);
    if (edge.curve.IsNull()) continue;
    int n = 33;
    if (const auto spline = Handle(Geom_BSplineCurve)::DownCast(edge.curve); !spline.IsNull())
      n = std::max(n, 2 * sample_count(spline->NbKnots() - 1));
    for (int i = 0; i < n; ++i) {
      const double t = edge.start + (edge.end - edge.start) * i / (n - 1);
      edge.samples.push_back({from_occ(edge.curve->Value(t).XYZ()), t, 0});
    }
    edges.push_back(std::move(edge));
  }
}

namespace {

/// The `most` samples closest to p, nearest first.
template <typename Sample>
std::vector<const Sample*> nearest(const std::vector<Sample>& samples, const Vec3& p, size_t most) {
  std::vector<std::pair<double, const Sample*>> order;
  order.reserve(samples.size());
  for (const Sample& s : samples) order.emplace_back((s.x - p).squaredNorm(), &s);
  const size_t n = std::min(most, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<long>(n), order.end());
  std::vector<const Sample*> result;
  for (size_t i = 0; i < n; ++i) result.push_back(order[i].second);
  return result;
}

}  // namespace

double CadSurface::Data::to_inside(const Vec3& p) const {
  double best = std::numeric_limits<double>::infinity();
  for (const Sample* s : nearest(samples, p, 4)) {
    best = std::min(best, (s->x - p).norm());
    double u = s->u, v = s->v, damping = 0, previous = std::numeric_limits<double>::infinity();
    double last_u = u, last_v = v;
    for (int step = 0; step < 40; ++step) {
      gp_Pnt x;
      gp_Vec xu, xv, xuu, xvv, xuv;
      surface->D2(u, v, x, xu, xv, xuu, xvv, xuv);
      const Vec3 r = from_occ(x.XYZ()) - p;
      const Vec3 a = from_occ(xu.XYZ()), b = from_occ(xv.XYZ());
      const double distance = r.norm();
      // The step was too long: go half-way back, and continue with Gauss-Newton.
      if (distance > previous * (1 + 1e-14)) {
        u = (u + last_u) / 2;
        v = (v + last_v) / 2;
        damping = 1;
        if (std::abs(u - last_u) <= 1e-14 * (u1 - u0) && std::abs(v - last_v) <= 1e-14 * (v1 - v0))
          break;
        continue;
      }
      previous = distance;
      Eigen::Matrix2d H;
      H << a.dot(a), a.dot(b), a.dot(b), b.dot(b);
      Eigen::Matrix2d curved = H;
      if (damping == 0) {
        const double uv = r.dot(from_occ(xuv.XYZ()));
        curved(0, 0) += r.dot(from_occ(xuu.XYZ()));
        curved(0, 1) += uv;
        curved(1, 0) += uv;
        curved(1, 1) += r.dot(from_occ(xvv.XYZ()));
        if (curved(0, 0) > 0 && curved.determinant() > 0) H = curved;
      }
      const double det = H.determinant();
      if (!(det > 0)) break;
      const Vec2 g(a.dot(r), b.dot(r));
      last_u = u;
      last_v = v;
      u = std::clamp(u - (H(1, 1) * g[0] - H(0, 1) * g[1]) / det, u0, u1);
      v = std::clamp(v - (H(0, 0) * g[1] - H(0, 1) * g[0]) / det, v0, v1);
      if (std::abs(u - last_u) <= 1e-13 * (u1 - u0) && std::abs(v - last_v) <= 1e-13 * (v1 - v0))
        break;
    }
    const double distance = (from_occ(surface->Value(u, v).XYZ()) - p).norm();
    if (distance < best && inside(u, v)) best = distance;
  }
  return best;
}

double CadSurface::Data::to_edges(const Vec3& p, double limit) const {
  double best = limit;
  for (const Edge& edge : edges)
    for (const Sample* s : nearest(edge.samples, p, 2)) {
      // The minimum lies within one sampling step; keep Newton's method inside that bracket.
      const double step = (edge.end - edge.start) / static_cast<double>(edge.samples.size() - 1);
      double low = std::max(edge.start, s->u - step), high = std::min(edge.end, s->u + step);
      double t = s->u;
      best = std::min(best, (s->x - p).norm());
      for (int i = 0; i < 60 && high - low > 1e-14 * (edge.end - edge.start); ++i) {
        gp_Pnt x;
        gp_Vec d1, d2;
        edge.curve->D2(t, x, d1, d2);
        const Vec3 r = from_occ(x.XYZ()) - p, a = from_occ(d1.XYZ());
        const double slope = r.dot(a), curvature = a.dot(a) + r.dot(from_occ(d2.XYZ()));
        best = std::min(best, r.norm());
        (slope > 0 ? high : low) = t;
        double next = curvature > 0 ? t - slope / curvature : low;
        if (!(next > low && next < high)) next = (low + high) / 2;
        if (std::abs(next - t) <= 1e-14 * (edge.end - edge.start)) break;
        t = next;
      }
    }
  return best;
}

double CadSurface::distance(const Vec3& p) const {
  const Vec3 q = p / data_->scale;
  return data_->scale * data_->to_edges(q, data_->to_inside(q));
}

double CadSurface::distance_lower_bound(const Vec3& p) const {
  const Box3& box = data_->box;
  return box.isEmpty() ? 0 : data_->scale * box.exteriorDistance(Vec3(p / data_->scale));
}

double distance(const std::vector<CadSurface>& faces, const Vec3& p, size_t& first) {
  if (faces.empty())
    throw InputError("found no faces to measure distances from, expected at least one");
  first = std::min(first, faces.size() - 1);
  double best = faces[first].distance(p);
  const size_t asked = first;
  for (size_t i = 0; i < faces.size(); ++i) {
    if (i == asked || faces[i].distance_lower_bound(p) >= best) continue;
    const double other = faces[i].distance(p);
    if (other >= best) continue;
    best = other;
    first = i;
  }
  return best;
}

std::vector<CadSurface> read_cad_surfaces(const std::filesystem::path& file,
                                          double model_unit_in_metres) {
  const double scale = millimetres_in(model_unit_in_metres);
  const CadFile cad = read_cad(file);
  std::vector<CadSurface> result;
  for (int f = 1; f <= cad.faces.Extent(); ++f) {
    auto data = std::make_shared<CadSurface::Data>();
    data->scale = scale;
    data->face = TopoDS::Face(cad.faces(f));
    data->build();
    CadSurface surface;
    surface.data_ = std::move(data);
    result.push_back(std::move(surface));
  }
  return result;
}

namespace fs = std::filesystem;
namespace {

Handle(IGESGeom_BSplineCurve) iges_curve(const CubicSpline& spline) {
  std::vector<double> all;
  for (size_t k = 0; k < spline.knots.size(); ++k)
    all.insert(all.end(), static_cast<size_t>(spline.multiplicities[k]), spline.knots[k]);
  const int count = isize(spline.poles);
  // IGES numbers knots from -degree and poles from 0.
  const Handle(TColStd_HArray1OfReal) knots = new TColStd_HArray1OfReal(-3, count);
  const Handle(TColStd_HArray1OfReal) weights = new TColStd_HArray1OfReal(0, count - 1, 1.0);
  const Handle(TColgp_HArray1OfXYZ) poles = new TColgp_HArray1OfXYZ(0, count - 1);
  for (int i = -3; i <= count; ++i) knots->SetValue(i, all[i + 3]);
  for (int i = 0; i < count; ++i) poles->SetValue(i, to_occ(spline.poles[i]).XYZ());
  const Handle(IGESGeom_BSplineCurve) curve = new IGESGeom_BSplineCurve;
  curve->Init(count - 1, 3, false, spline.closed, true, false, knots, weights, poles,
              spline.knots.front(), spline.knots.back(), gp_XYZ(0, 0, 0));
  return curve;
}

void write_iges_curves(const fs::path& path, const std::vector<CubicSpline>& splines,
                       const std::string& unit) {
  IGESControl_Writer writer(unit.c_str(), 0);
  double largest = 0;
  for (const CubicSpline& spline : splines) {
    for (const Vec3& p : spline.poles) largest = std::max(largest, p.cwiseAbs().maxCoeff());
    const auto curve = iges_curve(spline);
    // The label in the directory entry holds eight characters; the name property holds the full
    // name.
    curve->SetLabel(occ_string(spline.name.substr(0, 8)));
    const Handle(IGESBasic_Name) name = new IGESBasic_Name;
    name->Init(1, occ_string(spline.name));
    curve->AddProperty(name);
    if (!writer.AddEntity(name) || !writer.AddEntity(curve))
      throw Error(path.string() + ": OpenCASCADE cannot convert the curves to IGES");
  }
  IGESData_GlobalSection header = writer.Model()->GlobalSection();
  header.SetMaxCoord(largest);
  header.SetResolution(1e-9 * largest);
  header.SetAuthorName(occ_string(""));
  header.SetSendName(occ_string(path.stem().string()));
  header.SetFileName(occ_string(path.filename().string()));
  writer.Model()->SetGlobalSection(header);
  std::ostringstream text;
  text.imbue(std::locale::classic());
  if (!print_iges(writer, text)) throw Error(path.string() + ": OpenCASCADE cannot write IGES");
  write_file_atomically(path, [&](std::ostream& out) { out << text.str(); });
}

}  // namespace

void write_cad_curves(const fs::path& path, const std::vector<NamedCurve>& curves,
                      const CurveFileOptions& options) {
  const std::string unit = cad_unit(options.unit_in_metres);
  std::vector<CubicSpline> splines;
  double size = 0;
  for (const NamedCurve& curve : curves)
    for (CubicSpline& spline : cubic_splines(curve.name, curve.curve)) {
      size = std::max(size, spline.size);
      splines.push_back(std::move(spline));
    }
  OccSettings occ;
  occ.set_unit(unit);
  occ.set("write.iges.unit", unit.c_str());
  try {
    if (lower_extension(path).starts_with(".ig")) return write_iges_curves(path, splines, unit);
    const std::string name = path.stem().string();
    write_parts(path, {part_of_curves(name, splines)},
                {{name, "", "curves"}, options.ap242, 1e-9 * size}, occ);
  } catch (const Standard_Failure& failure) {
    throw Error(path.string() + ": OpenCASCADE failed to write it: " + failure.GetMessageString());
  }
}

// Reads the loops of curves around faces.

namespace {

/// Groups the edges of a wire into connected chains, without degenerate edges and seams.
std::vector<std::vector<int>> chains_of(const TopoDS_Wire& wire, const TopoDS_Face& face,
                                        const CadFile& cad, const std::vector<std::string>& names) {
  std::vector<int> edges;
  TopTools_IndexedMapOfShape vertices;
  std::vector<std::pair<int, int>> ends;
  for (TopExp_Explorer e(wire, TopAbs_EDGE); e.More(); e.Next()) {
    const TopoDS_Edge edge = TopoDS::Edge(e.Current());
    const int index = cad.edges.FindIndex(edge) - 1;
    if (index < 0 || names[index].empty() || is_seam(edge, face)) continue;
    edges.push_back(index);
    ends.emplace_back(vertices.Add(TopExp::FirstVertex(edge)) - 1,
                      vertices.Add(TopExp::LastVertex(edge)) - 1);
  }
  DisjointSets together(static_cast<size_t>(vertices.Extent()));
  for (const auto& [a, b] : ends) together.unite(a, b);
  std::map<int, std::vector<int>> chains;
  for (size_t i = 0; i < edges.size(); ++i)
    chains[together.find(ends[i].first)].push_back(edges[i]);
  std::vector<std::vector<int>> result;
  for (auto& [group, chain] : chains) result.push_back(std::move(chain));
  return result;
}

/// Turning angle from one edge to the next, as seen against the face normal, radians.
double turning_angle(const BRepAdaptor_Curve& from, bool from_reversed, const BRepAdaptor_Curve& to,
                     bool to_reversed, const gp_Vec& normal) {
  gp_Pnt at;
  gp_Vec in, out;
  from.D1(from_reversed ? from.FirstParameter() : from.LastParameter(), at, in);
  to.D1(to_reversed ? to.LastParameter() : to.FirstParameter(), at, out);
  if (from_reversed) in.Reverse();
  if (to_reversed) out.Reverse();
  return std::atan2(normal.Dot(in.Crossed(out)), in.Dot(out));
}

/// The normal of the face near the end of an edge. It is not evaluated at the end, because it is
/// undefined at poles.
gp_Vec normal_near_end(const TopoDS_Edge& edge, const TopoDS_Face& face) {
  constexpr double back = 0.01;  // fraction of the edge
  double start, end;
  const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, start, end);
  if (curve.IsNull()) return {0, 0, 0};
  const bool reversed = edge.Orientation() == TopAbs_REVERSED;
  const gp_Pnt2d uv =
      curve->Value(reversed ? start + back * (end - start) : end - back * (end - start));
  gp_Pnt at;
  gp_Vec normal;
  BRepGProp_Face(face).Normal(uv.X(), uv.Y(), at, normal);
  return normal;
}

bool is_convex(const TopoDS_Face& any_face) {
  const TopoDS_Face face = TopoDS::Face(any_face.Oriented(TopAbs_FORWARD));
  std::vector<TopoDS_Edge> edges;
  for (BRepTools_WireExplorer e(BRepTools::OuterWire(face), face); e.More(); e.Next())
    if (!BRep_Tool::Degenerated(e.Current())) edges.push_back(e.Current());
  constexpr double straight_angle = 0.1;  // radians
  for (size_t i = 0; i < edges.size(); ++i) {
    const TopoDS_Edge &from = edges[i], &to = edges[(i + 1) % edges.size()];
    const double corner_angle = turning_angle(
        BRepAdaptor_Curve(from), from.Orientation() == TopAbs_REVERSED, BRepAdaptor_Curve(to),
        to.Orientation() == TopAbs_REVERSED, normal_near_end(from, face));
    if (!(corner_angle > -straight_angle)) return false;
  }
  return !edges.empty();
}

CadFaceBoundary loops_of(const TopoDS_Face& face, const CadFile& cad,
                         const std::vector<std::string>& names) {
  CadFaceBoundary result;
  const TopoDS_Wire outer = BRepTools::OuterWire(face);
  for (TopExp_Explorer w(face, TopAbs_WIRE); w.More(); w.Next()) {
    const TopoDS_Wire wire = TopoDS::Wire(w.Current());
    for (const auto& chain : chains_of(wire, face, cad, names)) {
      std::vector<std::string> loop;
      for (const int e : chain) loop.push_back(names[e]);
      result.loops.insert(wire.IsSame(outer) ? result.loops.begin() : result.loops.end(),
                          std::move(loop));
    }
  }
  result.tube = is_tube(face);
  result.convex = result.loops.size() == 1 && is_convex(face);
  return result;
}

/// The largest distance between curve ends at a common vertex.
double largest_gap(const CadFile& cad) {
  TopTools_IndexedMapOfShape vertices;
  TopExp::MapShapes(cad.shape, TopAbs_VERTEX, vertices);
  std::vector<std::vector<gp_Pnt>> ends(static_cast<size_t>(vertices.Extent()) + 1);
  for (int e = 1; e <= cad.edges.Extent(); ++e) {
    const TopoDS_Edge edge = TopoDS::Edge(cad.edges(e).Oriented(TopAbs_FORWARD));
    double start, end;
    const Handle(Geom_Curve) curve = curve_of(edge, start, end);
    if (curve.IsNull()) continue;
    ends[static_cast<size_t>(vertices.FindIndex(TopExp::FirstVertex(edge)))].push_back(
        curve->Value(start));
    ends[static_cast<size_t>(vertices.FindIndex(TopExp::LastVertex(edge)))].push_back(
        curve->Value(end));
  }
  double gap = 0;
  for (size_t v = 1; v < ends.size(); ++v)
    for (const gp_Pnt& p : ends[v])
      for (const gp_Pnt& q : ends[v]) gap = std::max(gap, p.Distance(q));
  return gap;
}

}  // namespace

CadFaceTopology read_cad_loops(const std::filesystem::path& file, double model_unit_in_metres) {
  CadFile cad = read_cad(file);
  heal_shape(cad);
  const std::vector<std::string> names = edge_names(cad);
  CadFaceTopology result;
  Bnd_Box box;
  for (int f = 1; f <= cad.faces.Extent(); ++f) {
    result.faces.push_back(loops_of(TopoDS::Face(cad.faces(f)), cad, names));
    result.faces.back().name = cad.face_names[f - 1];
  }
  for (int e = 1; e <= cad.edges.Extent(); ++e) BRepBndLib::Add(cad.edges(e), box, false);
  const double scale = 1e-3 / model_unit_in_metres;
  if (!box.IsVoid()) result.size = scale * std::sqrt(box.SquareExtent());
  for (const EdgeContinuity& edge : shape_continuity(cad.shape, result.size / scale).inner)
    if (const std::string& name = names[edge.edge - 1];
        !name.empty() && edge.faces[0] != edge.faces[1])
      result.joins.push_back({name, edge.angle_deg});
  result.gap = scale * largest_gap(cad);
  return result;
}

}  // namespace batten
