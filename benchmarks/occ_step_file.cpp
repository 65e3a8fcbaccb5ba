// SPDX-License-Identifier: MPL-2.0
#include "occ_step_file.h"

#include <map>

#if BATTEN_BENCH_OCC_STEP

#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRepTopAdaptor_FClass2d.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_Surface.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Poly_Triangulation.hxx>
#include <STEPControl_Reader.hxx>
#include <STEPControl_Writer.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <gp_Pln.hxx>

namespace batten::bench {
namespace {

// OpenCASCADE's models are in millimetres.
Vec3 point(const gp_Pnt& p, double millimetre) { return Vec3(p.X(), p.Y(), p.Z()) * millimetre; }

bool save(const TopoDS_Shape& shape, const std::string& file) {
  Message::DefaultMessenger()->ChangePrinters().Clear();
  STEPControl_Writer writer;
  return writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone &&
         writer.Write(file.c_str()) == IFSelect_RetDone;
}

}  // namespace

struct OccStepFile::Data {
  TopoDS_Shape shape;
  std::vector<TopoDS_Face> faces;
  double millimetre = 1;  // in model units
};

OccStepFile::OccStepFile(const std::string& file, double unit_in_metres)
    : data_(std::make_unique<Data>()) {
  Message::DefaultMessenger()->ChangePrinters().Clear();
  data_->millimetre = 1e-3 / unit_in_metres;
  STEPControl_Reader reader;
  if (reader.ReadFile(file.c_str()) != IFSelect_RetDone) return;
  reader.TransferRoots();
  data_->shape = reader.OneShape();
  if (data_->shape.IsNull()) return;
  for (TopExp_Explorer it(data_->shape, TopAbs_FACE); it.More(); it.Next())
    data_->faces.push_back(TopoDS::Face(it.Current()));
}
OccStepFile::~OccStepFile() = default;

int OccStepFile::faces() const { return static_cast<int>(data_->faces.size()); }
bool OccStepFile::valid() const { return BRepCheck_Analyzer(data_->shape).IsValid(); }
bool OccStepFile::write(const std::string& file) const { return save(data_->shape, file); }

std::vector<Vec3> OccStepFile::points(int face, int n) const {
  const TopoDS_Face& f = data_->faces[static_cast<size_t>(face)];
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(f);
  double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
  BRepTools::UVBounds(f, u0, u1, v0, v1);
  BRepTopAdaptor_FClass2d inside(f, 1e-9);
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const gp_Pnt2d uv(u0 + (u1 - u0) * (i + 0.5) / n, v0 + (v1 - v0) * (j + 0.5) / n);
      if (inside.Perform(uv) == TopAbs_IN)
        points.push_back(point(surface->Value(uv.X(), uv.Y()), data_->millimetre));
    }
  return points;
}

std::vector<Vec3> OccStepFile::rim(int face, int n) const {
  const TopoDS_Face& f = data_->faces[static_cast<size_t>(face)];
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(f);
  std::vector<Vec3> points;
  for (TopExp_Explorer e(f, TopAbs_EDGE); e.More(); e.Next()) {
    double first = 0, last = 0;
    const auto line = BRep_Tool::CurveOnSurface(TopoDS::Edge(e.Current()), f, first, last);
    for (int k = 0; !line.IsNull() && k <= n; ++k) {
      const gp_Pnt2d uv = line->Value(first + (last - first) * k / n);
      points.push_back(point(surface->Value(uv.X(), uv.Y()), data_->millimetre));
    }
  }
  return points;
}

OccStepFile::Facets OccStepFile::facets(double distance) const {
  BRepTools::Clean(data_->shape);
  constexpr double any_angle = 3;
  BRepMesh_IncrementalMesh(data_->shape, distance / data_->millimetre, false, any_angle, false);
  Facets result;
  std::map<std::array<double, 3>, int> numbers;  // points on shared edges are identical
  for (const TopoDS_Face& face : data_->faces) {
    TopLoc_Location location;
    const auto mesh = BRep_Tool::Triangulation(face, location);
    if (mesh.IsNull()) continue;
    std::vector<int> number;
    for (int i = 1; i <= mesh->NbNodes(); ++i) {
      const Vec3 p = point(mesh->Node(i).Transformed(location), data_->millimetre);
      const auto [it, added] =
          numbers.emplace(std::array{p.x(), p.y(), p.z()}, static_cast<int>(result.points.size()));
      if (added) result.points.push_back(p);
      number.push_back(it->second);
    }
    for (int t = 1; t <= mesh->NbTriangles(); ++t) {
      int a = 0, b = 0, c = 0;
      mesh->Triangle(t).Get(a, b, c);
      if (face.Orientation() == TopAbs_REVERSED) std::swap(b, c);
      result.triangles.push_back({number[static_cast<size_t>(a - 1)],
                                  number[static_cast<size_t>(b - 1)],
                                  number[static_cast<size_t>(c - 1)]});
    }
  }
  return result;
}

bool write_facetted(const std::string& file, const OccStepFile::Facets& facets,
                    double unit_in_metres) {
  const double millimetres = 1e3 * unit_in_metres;
  std::vector<TopoDS_Vertex> vertices;
  for (const Vec3& p : facets.points) {
    const Vec3 q = millimetres * p;
    vertices.push_back(BRepBuilderAPI_MakeVertex(gp_Pnt(q.x(), q.y(), q.z())));
  }
  std::map<std::pair<int, int>, TopoDS_Edge> edges;
  BRep_Builder builder;
  TopoDS_Shell shell;
  builder.MakeShell(shell);
  for (const auto& t : facets.triangles) {
    BRepBuilderAPI_MakeWire wire;
    for (size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      TopoDS_Edge& edge = edges[std::minmax(a, b)];
      if (edge.IsNull()) {
        BRepBuilderAPI_MakeEdge made(vertices[static_cast<size_t>(std::min(a, b))],
                                     vertices[static_cast<size_t>(std::max(a, b))]);
        if (!made.IsDone()) break;
        edge = made.Edge();
      }
      wire.Add(TopoDS::Edge(edge.Oriented(a < b ? TopAbs_FORWARD : TopAbs_REVERSED)));
    }
    if (!wire.IsDone()) continue;
    BRepBuilderAPI_MakeFace face(wire.Wire(), true);
    if (face.IsDone()) builder.Add(shell, face.Face());
  }
  return save(shell, file);
}

}  // namespace batten::bench

#else

namespace batten::bench {

struct OccStepFile::Data {};
OccStepFile::OccStepFile(const std::string&, double) {}
OccStepFile::~OccStepFile() = default;
int OccStepFile::faces() const { return 0; }
bool OccStepFile::valid() const { return false; }
std::vector<Vec3> OccStepFile::points(int, int) const { return {}; }
std::vector<Vec3> OccStepFile::rim(int, int) const { return {}; }
bool OccStepFile::write(const std::string&) const { return false; }
OccStepFile::Facets OccStepFile::facets(double) const { return {}; }
bool write_facetted(const std::string&, const OccStepFile::Facets&, double) { return false; }

}  // namespace batten::bench

#endif
