// SPDX-License-Identifier: MPL-2.0
#include "occ_loft.h"

#if BATTEN_BENCH_OCC_LOFT

#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Section.hxx>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepExtrema_DistShapeShape.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <Geom_BSplineCurve.hxx>
#include <IGESControl_Reader.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Standard_Failure.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <gp_Pln.hxx>

#include <algorithm>

namespace batten::bench {
namespace {

gp_Pnt point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Vec3 point(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

// Uniform in arc length.
std::vector<Vec3> resampled(const std::vector<Vec3>& points, int count) {
  std::vector<double> at{0};
  for (size_t i = 1; i < points.size(); ++i)
    at.push_back(at.back() + (points[i] - points[i - 1]).norm());
  std::vector<Vec3> even;
  for (int k = 0; k < count; ++k) {
    const double s = at.back() * k / (count - 1);
    const auto above = std::upper_bound(at.begin() + 1, at.end() - 1, s);
    const auto i = static_cast<size_t>(above - at.begin());
    const double f = (s - at[i - 1]) / (at[i] - at[i - 1]);
    even.push_back(points[i - 1] + f * (points[i] - points[i - 1]));
  }
  return even;
}

// Chains segments to one curve; none if they are not one open curve.
std::vector<Vec3> chained(std::vector<std::vector<Vec3>> pieces, double near) {
  if (pieces.empty()) return {};
  std::vector<Vec3> whole = std::move(pieces.back());
  pieces.pop_back();
  while (!pieces.empty()) {
    bool grown = false;
    for (size_t i = 0; i < pieces.size() && !grown; ++i) {
      std::vector<Vec3>& piece = pieces[i];
      for (int way = 0; way < 4 && !grown; ++way) {
        if (way % 2 == 1) std::reverse(piece.begin(), piece.end());
        if (way == 2) std::reverse(whole.begin(), whole.end());
        if ((whole.back() - piece.front()).norm() > near) continue;
        whole.insert(whole.end(), piece.begin() + 1, piece.end());
        pieces.erase(pieces.begin() + static_cast<long>(i));
        grown = true;
      }
    }
    if (!grown) return {};
  }
  return whole;
}

}  // namespace

struct IgesFace::Data {
  TopoDS_Face face;
  Bnd_Box box;
};

std::vector<IgesFace> IgesFace::read(const std::filesystem::path& file) {
  Message::DefaultMessenger()->ChangePrinters().Clear();
  IGESControl_Reader reader;
  std::vector<IgesFace> faces;
  if (reader.ReadFile(file.c_str()) != IFSelect_RetDone) return faces;
  Interface_Static::SetCVal("xstep.cascade.unit", "M");
  reader.TransferRoots();
  for (TopExp_Explorer e(reader.OneShape(), TopAbs_FACE); e.More(); e.Next()) {
    IgesFace& face = faces.emplace_back();
    face.data_ = std::make_shared<Data>();
    face.data_->face = TopoDS::Face(e.Current());
    BRepBndLib::AddOptimal(face.data_->face, face.data_->box, false, false);
  }
  return faces;
}

Vec3 IgesFace::low() const { return point(data_->box.CornerMin()); }
Vec3 IgesFace::high() const { return point(data_->box.CornerMax()); }

std::vector<Vec3> IgesFace::section(double x, int count) const {
  BRepAlgoAPI_Section cut(data_->face, gp_Pln(gp_Pnt(x, 0, 0), gp::DX()), Standard_False);
  cut.Approximation(Standard_True);
  cut.Build();
  std::vector<std::vector<Vec3>> pieces;
  for (TopExp_Explorer e(cut.Shape(), TopAbs_EDGE); e.More(); e.Next()) {
    double first = 0, last = 0;
    const auto curve = BRep_Tool::Curve(TopoDS::Edge(e.Current()), first, last);
    constexpr int samples = 2000;
    std::vector<Vec3>& piece = pieces.emplace_back();
    for (int k = 0; k <= samples; ++k)
      piece.push_back(point(curve->Value(first + (last - first) * k / samples)));
  }
  const double size = (high() - low()).norm();
  const std::vector<Vec3> whole = chained(std::move(pieces), 1e-4 * size);
  return whole.empty() ? whole : resampled(whole, count);
}

double IgesFace::distance(const Vec3& p) const {
  const BRepExtrema_DistShapeShape nearest(BRepBuilderAPI_MakeVertex(point(p)).Vertex(),
                                           data_->face);
  return nearest.Value();
}

std::vector<Vec3> loft_points(const std::vector<std::vector<Vec3>>& sections, int n) {
  std::vector<Vec3> points;
  try {
    BRepOffsetAPI_ThruSections loft(Standard_False, Standard_False, 1e-6);
    for (const auto& section : sections) {
      const bool closed = section.size() > 3 && section.front() == section.back();
      const size_t count = section.size() - (closed ? 1 : 0);
      Handle(TColgp_HArray1OfPnt) through = new TColgp_HArray1OfPnt(1, static_cast<int>(count));
      for (size_t i = 0; i < count; ++i)
        through->SetValue(static_cast<int>(i) + 1, point(section[i]));
      GeomAPI_Interpolate spline(through, closed, 1e-9);
      spline.Perform();
      loft.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(spline.Curve())));
    }
    loft.Build();
    if (!loft.IsDone()) return points;
    for (TopExp_Explorer e(loft.Shape(), TopAbs_FACE); e.More(); e.Next()) {
      double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
      BRepTools::UVBounds(TopoDS::Face(e.Current()), u0, u1, v0, v1);
      const BRepAdaptor_Surface surface(TopoDS::Face(e.Current()));
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          points.push_back(
              point(surface.Value(u0 + (u1 - u0) * (i + 0.5) / n, v0 + (v1 - v0) * (j + 0.5) / n)));
    }
  } catch (const Standard_Failure&) {
    points.clear();
  }
  return points;
}

}  // namespace batten::bench

#else

namespace batten::bench {

struct IgesFace::Data {};
std::vector<IgesFace> IgesFace::read(const std::filesystem::path&) { return {}; }
Vec3 IgesFace::low() const { return Vec3::Zero(); }
Vec3 IgesFace::high() const { return Vec3::Zero(); }
std::vector<Vec3> IgesFace::section(double, int) const { return {}; }
double IgesFace::distance(const Vec3&) const { return 0; }
std::vector<Vec3> loft_points(const std::vector<std::vector<Vec3>>&, int) { return {}; }

}  // namespace batten::bench

#endif
