// Makes one region into a trimmed B-spline face of OpenCASCADE. Internal.
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
#include "batten/io/step/analytic_face.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/step/face_boundary.h"
#include "batten/io/cad/step_options.h"

namespace batten {

/// The edges and vertices that several faces have in common: one edge for each piece of a line
/// between cuts, one vertex for each place where such pieces end. Each is null until it is set.
class SharedEdges {
 public:
  /// Keeps a reference to the plan.
  explicit SharedEdges(const StepPlan& plan) : plan_(plan) {}

  /// The vertex at the start, or at the end, of a stretch along its loop; and the stretch's edge.
  TopoDS_Vertex& vertex(const FaceBoundarySegment& segment, bool end);
  TopoDS_Edge& edge(const FaceBoundarySegment& segment);
  /// The vertex at a cut of the line. Cuts count from 1; 0 is the line's start, and the number
  /// after the last cut its end.
  TopoDS_Vertex& vertex(const std::string& line, int cut);
  /// The edge that ends at this cut, or at the line's end. Its orientation says whether it runs
  /// along the line.
  TopoDS_Edge& edge(const std::string& line, int cut) { return edges_[{line, cut}]; }
  /// All edges, with the names of their lines.
  std::vector<CadCurveItem> along_lines() const;

 private:
  int cut_of(const FaceBoundarySegment& segment, bool end) const;
  const StepPlan& plan_;
  std::map<int, TopoDS_Vertex> end_points_;
  std::map<std::pair<std::string, int>, TopoDS_Vertex> vertices_;  // by line and cut
  std::map<std::pair<std::string, int>, TopoDS_Edge> edges_;       // by line and the cut at its end
};

/// Fits a B-spline surface to a region and makes a face of it.
class FaceMaker {
 public:
  /// Keeps references to region and options, and to `analytic`, the analytic face that it is to be (null:
  /// a B-spline). Throws InputError as FaceBoundary.
  FaceMaker(const SkinnedRegion& region, const StepFaceOptions& options,
            const StepPlan* common = nullptr, const AnalyticFace* analytic = nullptr);

  const SkinnedRegion& region() const { return region_; }
  const FaceBoundary& boundary() const { return boundary_; }
  FaceBoundary& boundary() { return boundary_; }
  double size() const { return size_; }
  /// The largest tolerance of edges and vertices, once the face is made; model units.
  double tolerance() const { return widest_; }
  const AnalyticFace* analytic() const { return analytic_; }
  int cells() const;
  Vec3 position(const Vec2& uv) const;
  Vec3 normal(const Vec2& uv) const;  ///< zero where the surface is singular
  /// Returns the last fit, moved to the origin; and a point of it, model units.
  const BicubicPatch& patch() const { return fit_.patch; }
  Vec3 fitted_position(const Vec2& uv) const;
  Vec3 fitted_normal(const Vec2& uv) const;  ///< of any length and side
  /// Counts of poles; 0 of an analytic face.
  int poles_u() const { return analytic_ ? 0 : fit_.patch.u.functions(); }
  int poles_v() const { return analytic_ ? 0 : fit_.patch.v.functions(); }
  double fitted_angle_deg() const { return fit_.angle_deg; }  ///< PatchFit::angle_deg

  /// Fits the surface, with its tangent planes where the boundary has turns; where these cannot be
  /// reached, as near as they come. O(poles); seconds for large regions.
  void fit();

  /// Fits anew, with more poles, after the face of a file was measured at this deviation from the region,
  /// and at this angle across its smooth joins. Returns false, and keeps the last fit, when none
  /// reaches its goal.
  bool refine(double deviation, double angle_deg);

  /// The edges of the last face along lines, with the names of these.
  const std::vector<CadCurveItem>& along_lines() const { return along_lines_; }

  /// Makes the face of the last fit. Its edges along lines with another side are those of `shared`,
  /// or its own when that is null: they are the lines. All others are curves of the face itself,
  /// within `coincidence` of it, model units.
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
  int failed_angles_ = 0;  // refinements that did not reach one
  double coincidence_ = 0;
  PatchFit fit_;
  BRep_Builder builder_;
  const AnalyticFace* analytic_ = nullptr;
  Vec2 near_ = Vec2::Zero();  // where the next stretch of an analytic face begins
  std::vector<std::array<Vec2, 2>> pcurve_ends_;  // first and last parameters of its stretches
  Handle(Geom_Surface) surface_;
  Handle(Geom_BSplineSurface) surface_near_origin_;  // rounding is less at the origin
  TopoDS_Face face_;
  SharedEdges* shared_ = nullptr;
  std::set<const void*> used_;  // edges that the face has
  std::vector<CadCurveItem> along_lines_;
};

}  // namespace batten
