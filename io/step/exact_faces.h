// SPDX-License-Identifier: MPL-2.0
// Converts HCT model faces to CAD faces that represent their surfaces exactly.
#pragma once

#include <TopoDS_Face.hxx>
#include <map>
#include <string>
#include <vector>

#include "batten/io/step/face_maker.h"
#include "batten/io/step/step_plan.h"

namespace batten {

/// The CAD faces of each model face in StepPlan::regions.
using RegionFaces = std::vector<std::vector<TopoDS_Face>>;

/// Makes three bicubic faces per triangle, in the order of the triangles (see step.h). Trimmed
/// model faces get none. Each vertex and edge exists once: curves with the same name share them,
/// and coincident curve ends share one vertex. Edges along curves end at the cuts of the plan, so
/// one side of a triangle may consist of several edges. `shared`, unless null, receives the
/// vertices and edges along curves, for other faces and for their names. `size`: size of the model;
/// tolerances are 1e-9 of it.
///
/// Call cut_at_vertices() first. Throws InputError for an edge of length zero.
RegionFaces exact_faces(const StepPlan& plan, double size, SharedEdges* shared);

// Numbering of the vertices and edges that exact faces share.

/// Subdivision of one side of a triangle, from its lower vertex index to the higher one. It is one
/// edge, or several if vertices of other triangles lie on the side.
struct SideSubdivision {
  std::vector<int> vertices, edges;  // global indices
  std::vector<double> fractions;     // position of each vertex on the side, 0 to 1
};

/// Global indices of a model face's vertices and edges.
struct SharedEntityIds {
  std::vector<int> vertices, edges;
  std::map<int, SideSubdivision> on_lines;  // sides along named curves; replaces `edges` there
};

/// Global indices of the vertices and edges along a curve, from its start.
struct LineEntityIds {
  std::vector<int> vertices, edges;
};

/// Assigns global indices to the vertices and edges of all model faces. Coincident vertices and
/// edges on curves with the same name get the same index, and so do coincident ends of curves.
/// Edges along curves end at the cuts of the plan (cut_at_vertices()). Trimmed model faces share no
/// indices.
class ExactFaceNumbering {
 public:
  /// Numbers all vertices and edges. Keeps a reference to `plan`.
  explicit ExactFaceNumbering(const StepPlan& plan);

  /// The indices for each model face of StepPlan::regions.
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
  // Union-find parents of the vertices: a lower index, or the own one for a root.
  std::vector<int> vertices_;
  std::vector<int> edges_;
  std::map<std::string, LineEntityIds> lines_;
  std::map<int, int> end_points_;
  std::vector<SharedEntityIds> numbers_;
};

/// Adds a cut to the plan's curves at each triangle vertex of an exact face.
void cut_at_vertices(StepPlan& plan);

}  // namespace batten
