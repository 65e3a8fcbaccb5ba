// One region as a trimmed B-spline face of OpenCASCADE. Internal.
#pragma once

#include <BRep_Builder.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>

#include <Eigen/Geometry>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/box.h"
#include "batten/fem/bicubic_patch.h"
#include "batten/fem/triangle_locator.h"
#include "batten/io/cad/face_boundary.h"
#include "batten/io/cad/step_face_options.h"

namespace batten {

/// Edges and vertices that several faces have in common: one edge for each stretch of a line, one
/// vertex for each place where stretches end. All are null until somebody makes them.
class SharedEdges {
 public:
  /// Keeps a reference.
  explicit SharedEdges(const StepPlan& plan) : plan_(plan) {}

  /// Of the stretch's start, end, along its loop.
  TopoDS_Vertex& vertex(const FaceStretch& stretch, bool end);
  TopoDS_Edge& edge(const FaceStretch& stretch);
  /// At a cut of the line, counted from 1; 0: its start, one more than there are: its end.
  TopoDS_Vertex& vertex(const std::string& line, int cut);
  /// Before a cut, or the line's end. Its orientation says whether it runs along the line.
  TopoDS_Edge& edge(const std::string& line, int cut) { return edges_[{line, cut}]; }

 private:
  int cut_of(const FaceStretch& stretch, bool end) const;
  const StepPlan& plan_;
  std::map<int, TopoDS_Vertex> places_;
  std::map<std::pair<std::string, int>, TopoDS_Vertex> vertices_;  // at cuts
  std::map<std::pair<std::string, int>, TopoDS_Edge> edges_;       // before the cut
};

/// The fit of a region's surface, and the face that is made of it.
class FaceMaker {
 public:
  /// Keeps references to region and options. Fits: O(poles), seconds for large regions.
  FaceMaker(const SkinnedRegion& region, const StepFaceOptions& options,
            const StepPlan* common = nullptr);

  const SkinnedRegion& region() const { return region_; }
  const FaceBoundary& boundary() const { return boundary_; }
  double size() const { return size_; }
  /// Of edges and vertices, once the face is made.
  double tolerance() const { return widest_; }
  int cells() const { return fit_.patch.u.intervals() * fit_.patch.v.intervals(); }
  Vec3 position(const Vec2& uv) const;
  int poles_u() const { return fit_.patch.u.functions(); }
  int poles_v() const { return fit_.patch.v.functions(); }

  /// After the file was measured: whether another fit may help, and is made.
  bool refine(double deviation);

  /// The face anew, with edges of its own, or those that it has in common with others.
  TopoDS_Face make(SharedEdges* shared = nullptr);

 private:
  void fit(const BicubicPatch* start);
  double widened(double distance);
  TopoDS_Vertex vertex(const FaceStretch& before, const FaceStretch& after);
  TopoDS_Edge edge(const FaceStretch& stretch, const TopoDS_Vertex& a, const TopoDS_Vertex& b);
  void finish(TopoDS_Edge& edge, const TopoDS_Vertex& a, const TopoDS_Vertex& b, double first,
              double last);
  std::vector<TopoDS_Edge> edges(const FaceLoop& loop);
  void add_wire(const FaceLoop& loop);
  void add_ring();

  const SkinnedRegion& region_;
  const StepFaceOptions& options_;
  FaceBoundary boundary_;
  Vec3 middle_;
  Surface near_origin_;
  TriangleLocator locator_;
  Box3 box_;
  double size_ = 0, goal_ = 0, widest_ = 0;
  PatchFit fit_;
  BRep_Builder builder_;
  Handle(Geom_BSplineSurface) surface_;
  TopoDS_Face face_;
  SharedEdges* shared_ = nullptr;
  std::set<const void*> used_;  // edges that the face has
};

}  // namespace batten
