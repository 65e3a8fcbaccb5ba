// SPDX-License-Identifier: MPL-2.0
// Makes a trimmed B-spline face, or an analytic face, of OpenCASCADE from a model face.
#pragma once

#include <BRep_Builder.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/geometry.h"
#include "batten/fem/curves/bicubic_patch.h"
#include "batten/fem/surface_projector.h"
#include "batten/io/cad/cad_format.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/step/analytic_face.h"
#include "batten/io/step/face_boundary.h"

namespace batten {

/// Edges and vertices shared by several faces: one edge per piece of a curve between two cuts, one
/// vertex per point where such pieces end. Each is null until it is set.
class SharedEdges {
 public:
  /// Keeps a reference to `plan`.
  explicit SharedEdges(const StepPlan& plan) : plan_(plan) {}

  /// The vertex at the start or end of a segment (along its loop), and the edge of the segment.
  TopoDS_Vertex& vertex(const FaceBoundarySegment& segment, bool end);
  TopoDS_Edge& edge(const FaceBoundarySegment& segment);
  /// The vertex at a cut of the curve. Cuts are counted from 1; 0 is the start of the curve, and
  /// the number after the last cut is its end.
  TopoDS_Vertex& vertex(const std::string& line, int cut);
  /// The edge that ends at this cut, or at the end of the curve. Its orientation is forward if it
  /// runs along the curve.
  TopoDS_Edge& edge(const std::string& line, int cut) { return edges_[{line, cut}]; }
  /// All edges, with the names of their curves.
  std::vector<CadCurveItem> along_lines() const;

 private:
  int cut_of(const FaceBoundarySegment& segment, bool end) const;
  const StepPlan& plan_;
  std::map<int, TopoDS_Vertex> end_points_;
  std::map<std::pair<std::string, int>, TopoDS_Vertex> vertices_;  // by curve and cut
  // By curve and the cut at the edge's end.
  std::map<std::pair<std::string, int>, TopoDS_Edge> edges_;
};

/// Fits a B-spline surface to a model face and makes a trimmed face of it.
class FaceMaker {
 public:
  /// Keeps references to `region`, `options` and `analytic`. `analytic`: the analytic face to make;
  /// null: a B-spline face. Throws InputError as FaceBoundary does.
  FaceMaker(const SkinnedRegion& region, const StepFaceOptions& options,
            const StepPlan* common = nullptr, const AnalyticFace* analytic = nullptr);

  const SkinnedRegion& region() const { return region_; }
  const FaceBoundary& boundary() const { return boundary_; }
  FaceBoundary& boundary() { return boundary_; }
  double size() const { return size_; }
  /// The largest tolerance of edges and vertices once the face has been made, model units.
  double tolerance() const { return widest_; }
  const AnalyticFace* analytic() const { return analytic_; }
  /// Number of knot cells of the fit; 64 for an analytic face.
  int cells() const;
  /// Point of the model face's surface at the (u, v) of the boundary.
  Vec3 position(const Vec2& uv) const;
  /// Unit normal of the model face; zero if the surface is singular.
  Vec3 normal(const Vec2& uv) const;
  /// The last fit, relative to the centre of the model face's bounding box; and a point of the
  /// face, in model coordinates.
  const BicubicPatch& patch() const { return fit_.patch; }
  Vec3 fitted_position(const Vec2& uv) const;
  Vec3 fitted_normal(const Vec2& uv) const;  ///< not normalised; its side is undefined
  /// Number of poles in each direction; 0 for an analytic face.
  int poles_u() const { return analytic_ ? 0 : fit_.patch.u.functions(); }
  int poles_v() const { return analytic_ ? 0 : fit_.patch.v.functions(); }
  double fitted_angle_deg() const { return fit_.angle_deg; }  ///< PatchFit::angle_deg

  /// Fits the surface, including its tangent planes along joins with normal corrections. If these
  /// cannot be reached, the fit comes as close as possible. O(poles); takes seconds for large
  /// model faces.
  void fit();

  /// Refits with more poles, given measurements of the last face. `deviation`: measured distance
  /// from the model face; `angle_deg`: measured angle across its smooth joins. Returns false and
  /// keeps the last fit if nothing needs to be improved or no finer fit is better.
  bool refine(double deviation, double angle_deg);

  /// The edges of the last face that lie on curves, with the names of the curves.
  const std::vector<CadCurveItem>& along_lines() const { return along_lines_; }

  /// Makes the face of the last fit. Edges on curves with another adjacent side are exactly the
  /// curves; they are those of `shared`, or new ones if `shared` is null. All other edges are
  /// curves on the face itself, approximated within `coincidence` (model units).
  TopoDS_Face make(double coincidence, SharedEdges* shared = nullptr);

 private:
  PatchTarget target() const;
  std::vector<PatchTangent> tangents(const BoundaryStep& longest) const;
  void fit(const BicubicPatch* start);
  double widened(double distance);
  TopoDS_Vertex vertex(const FaceBoundarySegment& before, const FaceBoundarySegment& after);
  TopoDS_Edge edge(const FaceBoundarySegment& segment, const TopoDS_Vertex& a,
                   const TopoDS_Vertex& b);
  void finish(TopoDS_Edge& edge, const TopoDS_Vertex& a, const TopoDS_Vertex& b, double first,
              double last);
  std::vector<TopoDS_Edge> edges(const FaceLoop& loop);
  void add_wire(const FaceLoop& loop);
  void add_annulus();
  void make_analytic();
  Handle(Geom2d_BSplineCurve)
      analytic_pcurve(const FaceBoundarySegment& segment, const Geom_Curve& curve, double first,
                      double last, bool reversed);
  std::vector<TopoDS_Edge> analytic_edges(FaceLoop loop, int winding);
  TopoDS_Edge degenerate_edge(const TopoDS_Vertex& at, const Vec2& from, const Vec2& to);
  TopoDS_Edge analytic_seam(const TopoDS_Vertex& a, const TopoDS_Vertex& b, const Vec2& from,
                            double to);

  const SkinnedRegion& region_;
  const StepFaceOptions& options_;
  FaceBoundary boundary_;
  Vec3 middle_;
  SurfaceEvaluator near_origin_;
  Box3 box_;
  double size_ = 0, widest_ = 0;
  PatchGoal goal_;
  int failed_angles_ = 0;  // number of refinements that missed the angle
  double coincidence_ = 0;
  PatchFit fit_;
  BRep_Builder builder_;
  const AnalyticFace* analytic_ = nullptr;
  Vec2 near_ = Vec2::Zero();  // where the next pcurve of an analytic face starts
  std::vector<std::array<Vec2, 2>> pcurve_ends_;  // first and last parameters of its pcurves
  Handle(Geom_Surface) surface_;
  Handle(Geom_BSplineSurface) surface_near_origin_;  // less rounding error near the origin
  TopoDS_Face face_;
  SharedEdges* shared_ = nullptr;
  std::set<const void*> used_;  // edges already in the face
  std::vector<CadCurveItem> along_lines_;
};

}  // namespace batten
