// SPDX-License-Identifier: MPL-2.0
// What is displayed of a document: a snapshot as plain data, which any thread may read, and frames
// of meshes.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/io/report/network_report.h"
#include "batten/io/scene/scene_text.h"

namespace batten {

struct DisplayTopology;
struct Frame;
class TriangleMesh;

/// Display data of an edited mesh, beside its facets. Its vertices are display points.
struct MeshView {
  /// How an edit uses a vertex.
  enum class Role { Free, Fixed, Handle, Feature };
  /// A named set of vertices.
  struct Part {
    enum class Kind { Proposal, Selection, Set };
    Kind kind = Kind::Proposal;
    std::string name;
    std::string key = {};  ///< sets: "set" or "property", the key of [[select]]
    double diameter = 0;   ///< proposals: diameter of the circle of equal area
    std::vector<int> points;
  };
  std::vector<Part> parts;
  std::vector<Role> roles;   ///< per display point
  std::vector<float> rest;   ///< x, y, z per display point: the undeformed mesh
  std::vector<long> labels;  ///< node number in the mesh file, per display point
};

/// Kind of analysis of a shape with [stress].
enum class Analysis { None, Stress, Modes };

/// Stresses of a shape for the load case with the largest stress, or its natural modes.
struct StressView {
  std::string problem;  ///< why there are no results; empty: there are
  std::string load_case;
  double von_mises = 0, displacement = 0;  ///< maxima over all load cases
  double yield = 0;                        ///< yield stress; 0: not given
  double deformation_scale = 1;            ///< magnification of drawn displacements
  std::vector<float> values;               ///< von Mises stress per display point
  std::vector<float> moved;                ///< displacements, x, y, z consecutively
  std::vector<double> frequencies;         ///< natural frequencies, ascending
  /// Mode shapes, layout as `moved`, normalised to a maximum of 1.
  std::vector<std::vector<float>> mode_shapes;
};

/// A document at one moment. Surface points are in frames (sculpting/session/frame.h).
struct DocumentView {
  std::string title;        ///< file name; "untitled" before the first save
  std::string folder;       ///< name of its folder; empty before the first save
  int document_number = 0;  ///< changes when another document is opened
  std::string unit, text;
  bool changed = false, can_undo = false, can_redo = false;
  std::string problem;  ///< why there is no surface; empty: there is

  /// A table of the scene.
  struct Table {
    SceneTable name;
    std::vector<std::pair<std::string, std::string>> values;  ///< keys and TOML values
  };
  std::vector<Table> tables;  ///< tables in file order, top level first

  /// A parameter that can be set interactively.
  struct Slider {
    std::string name;
    std::string unit;                    ///< empty: dimensionless, or in relative units
    double value = 0, min = 0, max = 0;  ///< the range may be infinite
    bool driven = false;                 ///< driven by a [[parameter]], so it cannot be set
  };
  std::vector<Slider> sliders;

  /// A line of the scene as a polyline.
  struct Polyline {
    std::string line;
    std::vector<Vec3> points;
  };
  std::vector<Polyline> lines;  ///< the input lines, after fairing

  // Surface, if there is one:
  bool surface = false;
  int triangles = 0;
  double size = 0;
  bool has_stress = false;               ///< the scene has [stress]
  std::vector<std::string> regions;      ///< names for DisplayTopology::first_facet
  std::vector<std::string> shown_lines;  ///< names for DisplayTopology::lines
  std::optional<NetworkReport> network;  ///< report of a network: joins, choices, shells
  std::vector<DefectReport> defects;

  // Mesh, and point constraints of a shape:
  std::shared_ptr<const MeshView> mesh;  ///< shared as long as its contents are unchanged
  /// A handle, or a point constraint of a shape.
  struct Handle {
    std::string name;            ///< EDIT.HANDLE: prefix of its parameters
    Vec3 centre = Vec3::Zero();  ///< current position of its centre
    /// Translation, and rotation vector along the axis with the angle in degrees as its length.
    Vec3 shift = Vec3::Zero(), rotation_vector = Vec3::Zero();
    bool moves = false;  ///< true: it belongs to the last edit, or to a sequence
    /// false: a point constraint, whose shift is its current position.
    bool can_rotate = true;
    std::vector<Vec3> path = {};  ///< centre in all frames of a sequence
  };
  std::vector<Handle> handles;

  /// Location of a load, constraint or support on a shape.
  struct Mark {
    enum class Kind {
      Load,    ///< point load; `at`: on the unloaded surface; `along`: direction
      Normal,  ///< normal constraint; `at`, `along` as for Load
      Force,   ///< point force of [stress]; `at` is near the current surface
      Support  ///< point support of [stress]
    };
    Kind kind = Kind::Load;
    Vec3 at = Vec3::Zero(), along = Vec3::Zero();
  };
  std::vector<Mark> marks;
  std::vector<std::string> supported_lines;  ///< names of supported lines in [stress]
  /// Display points on the unloaded surface (x, y, z); null until drawn.
  std::shared_ptr<const std::vector<float>> unloaded;

  // Sequence:
  /// State of the timeline.
  struct Timeline {
    int frames = 0, frame = 0;     ///< number of frames, and the current frame, 0-based
    std::vector<int> keyframes;    ///< keyframes of the last step, 0-based
    std::vector<Vec3> footprints;  ///< positions of planted feet
  };
  std::optional<Timeline> timeline;

  /// Bounding box of the lines, lower and upper corner; both zero if there are no lines.
  std::array<Vec3, 2> box() const;
  /// A table by name, or nullptr.
  const Table* table(const SceneTable& name) const;
  /// The first unused name with this prefix: "push 1", "push 2", …
  std::string free_name(const std::string& beginning) const;
};

/// Converts shapes of a mesh to frames. A vertex on a crease has several display points with
/// separate normals. Creases are determined once, on the undeformed mesh.
class MeshDisplay {
 public:
  /// `lines`: vertex chains to draw. Cost: O(triangles · log triangles).
  MeshDisplay(const TriangleMesh& mesh, const std::vector<std::vector<int>>& lines);

  /// Fills a frame with a shape (n×3). Cost: O(triangles); no allocation once the frame has its
  /// size.
  void draw(const Points& shape, Frame& frame) const;
  const std::vector<int>& vertices() const { return vertices_; }  ///< vertex of each display point

 private:
  std::shared_ptr<const DisplayTopology> pattern_;
  std::vector<int> vertices_;
};

}  // namespace batten
