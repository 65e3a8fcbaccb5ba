// One region as a trimmed B-spline face of OpenCASCADE. Internal.
#pragma once

#include <BRep_Builder.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "batten/fem/triangle_locator.h"
#include "batten/io/bicubic_patch.h"
#include "batten/io/face_boundary.h"
#include "batten/io/step_face.h"

namespace batten {

/// Edges and vertices that several faces have in common: one edge for each stretch of a line, one
/// vertex for each place where stretches end.
class SharedEdges {
 public:
  /// Which place the start (false) or end (true) of a line is; lines that meet have the same there.
  using NodeOf = std::function<int(const std::string& line, bool end)>;
  SharedEdges(const LineCuts& cuts, NodeOf node_of) : cuts_(cuts), node_of_(std::move(node_of)) {}

  /// Of the stretch's start, end, along its loop.
  TopoDS_Vertex& vertex(const FaceStretch& stretch, bool end);
  /// Null until it is made.
  TopoDS_Edge& edge(const FaceStretch& stretch);

 private:
  int cut_of(const FaceStretch& stretch, bool end) const;
  LineCuts cuts_;
  NodeOf node_of_;
  std::map<int, TopoDS_Vertex> nodes_;
  std::map<std::pair<std::string, int>, TopoDS_Vertex> vertices_;  // at cuts
  std::map<std::pair<std::string, int>, TopoDS_Edge> edges_;       // before the cut, from its start
};

/// The fit of a region's surface, and the face that is made of it.
class FaceMaker {
 public:
  /// Keeps references to region and options. Fits: O(poles), seconds for large regions.
  FaceMaker(const SkinnedRegion& region, const StepFaceOptions& options,
            const CommonLines* common = nullptr);

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
  Eigen::AlignedBox3d box_;
  double size_ = 0, goal_ = 0, widest_ = 0;
  PatchFit fit_;
  BRep_Builder builder_;
  Handle(Geom_BSplineSurface) surface_;
  TopoDS_Face face_;
  SharedEdges* shared_ = nullptr;
  std::set<const void*> used_;  // edges that the face has
};

}  // namespace batten
