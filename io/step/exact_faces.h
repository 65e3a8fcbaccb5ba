// Makes the CAD faces that are exactly the surfaces of regions. Internal.
#pragma once

#include <TopoDS_Face.hxx>
#include <vector>
#include <map>
#include <string>

#include "batten/io/step/face_maker.h"
#include "batten/io/step/step_plan.h"

namespace batten {

using RegionFaces = std::vector<std::vector<TopoDS_Face>>;  ///< faces of each StepPlan::regions

/// Makes three bicubic faces for each triangle, triangle by triangle (step.h). Regions that
/// embedded lines cut get none. Vertices and edges exist once: lines of one name have the same
/// ones, and ends of lines in the same place are one vertex. Edges along lines end at the plan's
/// cuts, so that a side of a triangle may be several edges. `shared`, unless null, gets the
/// vertices and edges along lines, for other faces and for their names. `size` is that of the
/// model; tolerances are 1e-9 of it.
///
/// Call cut_at_vertices() first. Throws InputError for an edge without length.
RegionFaces exact_faces(const StepPlan& plan, double size, SharedEdges* shared);


// Numbers the vertices and edges that exact faces have in common. Internal.

/// The pieces of a side of a triangle, from its lower vertex number to the higher: one edge, or
/// several where vertices of other triangles lie on it.
struct SideSubdivision {
  std::vector<int> vertices, edges;  // numbers
  std::vector<double> fractions;     // place of each vertex on the side, from 0 to 1
};

/// The numbers that a region's vertices and edges have among those of all regions.
struct SharedEntityIds {
  std::vector<int> vertices, edges;
  std::map<int, SideSubdivision> on_lines;  // edges along named lines, which `edges` does not tell
};

/// The numbers of vertices and edges along a line, from its start.
struct LineEntityIds {
  std::vector<int> vertices, edges;
};

/// Numbers vertices and edges of all regions. Vertices and edges in the same place of lines with
/// the same name get one number; so do ends of lines in the same place. Edges along lines end at
/// the plan's cuts (cut_at_vertices). Regions that embedded lines cut share no numbers.
class ExactFaceNumbering {
 public:
  /// Numbers everything and keeps a reference to the plan.
  explicit ExactFaceNumbering(const StepPlan& plan);

  /// The numbers of each StepPlan::regions.
  const std::vector<SharedEntityIds>& regions() const { return numbers_; }
  const std::map<std::string, LineEntityIds>& lines() const { return lines_; }
  size_t vertex_count() const { return vertices_.size(); }
  size_t edge_count() const { return edges_.size(); }

 private:
  int root(int vertex) const;
  void unite(int a, int b);
  const LineEntityIds& numbers_of(const std::string& name);
  void join(const EdgeAlignedLine& aligned_line, SharedEntityIds& own);

  const StepPlan& plan_;
  std::vector<int> vertices_;  // of each vertex, a lower number that it is one with, or its own
  std::vector<int> edges_;
  std::map<std::string, LineEntityIds> lines_;
  std::map<int, int> end_points_;
  std::vector<SharedEntityIds> numbers_;
};

/// Adds cuts to the plan's lines where triangles of exact faces have vertices on them.
void cut_at_vertices(StepPlan& plan);

}  // namespace batten
