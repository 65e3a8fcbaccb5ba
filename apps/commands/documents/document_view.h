// What a window shows of a document: plain data that any thread may read.
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

/// A mesh that is edited: what a window shows of it beside its facets. Vertices are display points.
struct MeshView {
  /// What vertices are for.
  enum class Role { Free, Fixed, Handle, Feature };
  /// Vertices that go by a name.
  struct Part {
    enum class Kind { Proposal, Selection, Set };
    Kind kind = Kind::Proposal;
    std::string name;
    std::string key = {};  ///< of a set: "set" or "property", the key of [[select]]
    double diameter = 0;   ///< of a proposal: diameter of the circle of the same area
    std::vector<int> points;
  };
  std::vector<Part> parts;
  std::vector<Role> roles;   ///< of each display point
  std::vector<float> rest;   ///< of each display point, x, y, z: the mesh as it was read
  std::vector<long> labels;  ///< the number in the mesh file of each display point's node
};

/// What is solved for of a shape with a [stress].
enum class Analysis { None, Stress, Modes };

/// Stresses of a shape, as its scene's [stress] has them: in the case whose stress is largest. Or how it
/// swings.
struct StressView {
  std::string problem;  ///< why there are none, in words; ""
  std::string load_case;
  double von_mises = 0, displacement = 0;       ///< the largest of all cases
  double yield = 0;                             ///< 0: not said
  double deformation_scale = 1;                 ///< of displacements that are drawn
  std::vector<float> values;                    ///< equivalent stress at each display point
  std::vector<float> moved;                     ///< displacement, x, y, z one after the other
  std::vector<double> frequencies;              ///< of natural modes, slowest first
  std::vector<std::vector<float>> mode_shapes;  ///< of each, as `moved`, the largest 1 long
};

/// A document at one moment. Points of the surface are in frames (sculpting/session/frame.h).
struct DocumentView {
  std::string title;        ///< the file's name, "untitled" before the first save
  std::string folder;       ///< the name of its folder; "" before the first save
  int document_number = 0;  ///< changes where another document is opened
  std::string unit, text;
  bool changed = false, can_undo = false, can_redo = false;
  std::string problem;  ///< why there is no surface, ""

  struct Table {
    SceneTable name;
    std::vector<std::pair<std::string, std::string>> values;  ///< keys and values as TOML
  };
  std::vector<Table> tables;  ///< as in the file, the top first

  struct Slider {
    std::string name;
    std::string unit;                    ///< "": a pure number, or one in relative units
    double value = 0, min = 0, max = 0;  ///< the range may be infinite
    bool driven = false;                 ///< by a [[parameter]]: it cannot be moved
  };
  std::vector<Slider> sliders;

  struct Polyline {
    std::string line;
    std::vector<Vec3> points;
  };
  std::vector<Polyline> lines;  ///< the lines alone, as they are read and made fair

  // Of the surface, where there is one:
  bool surface = false;
  int triangles = 0;
  double size = 0;
  bool has_stress = false;               ///< the scene says [stress]
  std::vector<std::string> regions;      ///< of DisplayTopology::first_facet
  std::vector<std::string> shown_lines;  ///< of DisplayTopology::lines
  std::optional<NetworkReport> network;  ///< of a network: joins, choices, shells
  std::vector<DefectReport> defects;

  // Of a mesh, and of a shape's constraints at points:
  std::shared_ptr<const MeshView> mesh;  ///< the same object as long as it says the same
  struct Handle {
    std::string name;            ///< EDIT.HANDLE: what its parameters begin with
    Vec3 centre = Vec3::Zero();  ///< where its centre is now
    Vec3 shift = Vec3::Zero(),
         rotation_vector = Vec3::Zero();  ///< turn: along its axis, degrees long
    bool moves = false;                   ///< it is of the last edit, or of a sequence
    bool can_rotate = true;       ///< a constraint has no turn, and its shift is where it is
    std::vector<Vec3> path = {};  ///< its centre in all frames of a sequence
  };
  std::vector<Handle> handles;

  /// A place of a shape where something acts or holds.
  struct Mark {
    enum class Kind {
      Load,    ///< a point load; `at` is on the surface without loads, `along` the way it pushes
      Normal,  ///< a normal that is held, the same
      Force,   ///< a force of [stress]; `at` is near the present surface
      Support  ///< a point support of [stress]
    };
    Kind kind = Kind::Load;
    Vec3 at = Vec3::Zero(), along = Vec3::Zero();
  };
  std::vector<Mark> marks;
  std::vector<std::string> supported_lines;  ///< of [stress], as it names them
  /// Each display point on the surface without loads, x, y, z; null until it is drawn.
  std::shared_ptr<const std::vector<float>> unloaded;

  // Of a sequence:
  struct Timeline {
    int frames = 0, frame = 0;     ///< how many, and which is shown, from 0
    std::vector<int> keyframes;    ///< of the last step, from 0
    std::vector<Vec3> footprints;  ///< where feet that are planted stand
  };
  std::optional<Timeline> timeline;

  /// The smallest box around lines, low and high corner; both 0 where there are none.
  std::array<Vec3, 2> box() const;
  const Table* table(const SceneTable& name) const;
  /// A name with this beginning that no table has yet: "push 1", "push 2", …
  std::string free_name(const std::string& beginning) const;
};

}  // namespace batten
