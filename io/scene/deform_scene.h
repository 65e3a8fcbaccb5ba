// A deform scene is one small TOML file that says what to hold, keep and move on a mesh
// (docs/deform.md has every key). These functions read the scene only; the mesh has its own file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curves/fair_curve.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/scene/scene.h"
#include "batten/io/scene/scene_selections.h"
#include "batten/mesh/attached/attachment.h"
#include "batten/mesh/deform/deform_problem.h"
#include "batten/sculpting/curves/deformable_curve.h"

namespace batten {

/// [[guide]]: a point that stays on a plane or on a line.
struct GuideSpec {
  std::string name;
  SourceLocation location;
  LocatedString
      of;  ///< feature, selection or proposal; the point is the mean of its vertices, or of
           ///< those of its loop
  PointConstraint::Kind kind = PointConstraint::Kind::OnPlane;
  Vec3 direction = Vec3::UnitZ();
  std::optional<Vec3> through;  ///< a point of the plane or line; none: where the point is
};

/// [[relation]]: what features keep between them.
struct RelationSpec {
  enum class Kind {
    Parallel,  ///< they turn alike
    Coaxial,   ///< and their centres keep their places to each other, along the common axis
    Distance,  ///< the vector between two centres keeps its length and turns with the first
    Spacing,   ///< centres that follow each other at even steps keep doing so
    Symmetric  ///< two centres stay mirror images about a plane
  };
  std::string name;
  SourceLocation location;
  Kind kind = Kind::Parallel;
  std::vector<LocatedString> of;               ///< features; '*' stands for any letters
  std::optional<std::pair<Vec3, Vec3>> plane;  ///< Symmetric: normal, a point of it
};

/// [[line]]: a character line that keeps its shape, rigidly or in the soft sense.
struct LineSpec {
  std::string name;
  SourceLocation location;
  std::vector<Vec3> through;  ///< points; the line goes through the vertices nearest to them, and
                              ///< along creases between
  std::vector<long> nodes;    ///< or the numbers of its nodes in the mesh file, in their order
  bool closed = false;
  bool rigid = false;
  double width = 0;  ///< soft: it resists like a strip of the sheet of this width, model units;
                     ///< 0: a tenth of the line's length
};

/// [[curve]]: a line of vertices that becomes a deformable curve: faired, shaped by its own loads,
/// and then imposed on its vertices exactly.
struct CurveSpec {
  enum class Ends { Clamped, Pinned, Free };
  LineSpec line;  ///< its name and vertices; rigid and width are not used
  bool faired = true;
  FairOptions fair;  ///< how it is faired
  Ends ends = Ends::Clamped;
  double alpha = 0, beta = 1;  ///< relative weights that resist the curve's loads
  std::vector<CurveLoad> loads;
};

/// [[pull]]: a vertex that a row draws to a place, in the least-squares sense or exactly.
struct PositionConstraintSpec {
  std::string name;
  SourceLocation location;
  std::optional<long> node;  ///< number of the node in the mesh file
  std::optional<Vec3> at;    ///< or the point that the vertex is nearest to
  Vec3 to = Vec3::Zero();
  std::optional<double> weight;  ///< weight of a soft row; none: a hard row
};

/// [[edit]]: what moves in one edit of the mesh, which starts from the result of the edit before.
struct EditSpec {
  struct MovedHandle {
    std::string name;
    SourceLocation location;
    std::vector<LocatedString> vertices;
    Vec3 translate = Vec3::Zero(), axis = Vec3::UnitZ();
    double degrees = 0, scale = 1;
    std::optional<Vec3> about;  ///< centre of turn and scale; none: the mean of its vertices
  };
  struct ScaledFeature {
    LocatedString feature;
    double factor = 1;
  };
  struct RotatedFeature {
    LocatedString feature;
    Vec3 axis = Vec3::UnitZ();
    double degrees = 0;
  };
  /// Where the sheet turns that no handle says how: what features and curvature turn with.
  enum class RotationMode {
    Estimated,  ///< features turn as the sheet does where they are, when it is deformed without them
    Dual,       ///< the shape that dual Laplacian vectors find
    Nonlinear,  ///< the shape that is as rigid as possible piece by piece: for large turns
    Harmonic    ///< the turns of the handles, spread
  };
  struct MovedGuide {
    LocatedString guide;
    Vec3 through;
  };
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> fixed, region;
  std::vector<MovedHandle> handles;
  std::vector<ScaledFeature> scales;
  std::vector<RotatedFeature> rotated_features;
  RotationMode rotation_mode = RotationMode::Estimated;
  bool keep_centres = true;  ///< features that are not scaled stay where they are without scales
  std::vector<MovedGuide> guides;
};

/// [modes]: shell and material of the decks for natural frequencies, before and after.
struct ModesSpec {
  double thickness = 0, young = 0, poisson = 0, density = 0;
  int count = 10;
  std::vector<LocatedString> clamped;
  std::string before, after;  ///< file names of the two decks
};

/// [[picture]]: before and after side by side, or the mesh after each edit.
struct MeshPictureSpec {
  enum class Show { BeforeAfter, Steps, After, Displacement };
  std::string file, title;
  Show show = Show::BeforeAfter;
  bool mesh = false;
  double azimuth = -30, elevation = 30, zoom = 1;
  int up = 2;  ///< axis that points upwards, 0 (x) to 2 (z)
  PictureSize size;
};

/// A deform scene as data.
struct DeformScene : SceneSelections {
  std::filesystem::path mesh;
  DeformProblem::Weighting weighting = DeformProblem::Weighting::Area;
  AttachmentOptions following;
  std::vector<FeatureSpec> features;
  std::vector<GuideSpec> guides;
  std::vector<RelationSpec> relations;
  std::vector<LineSpec> lines;
  std::vector<CurveSpec> curves;
  std::vector<PositionConstraintSpec> position_constraints;
  std::vector<EditSpec> edits;
  std::string mesh_out, vtp;       ///< file names; "" for none
  bool large_field_nodes = false;  ///< MeshWriteOptions::large_field_nodes
  std::optional<ModesSpec> modes;
  std::vector<MeshPictureSpec> pictures;

  /// What can be set: EDIT.HANDLE.x, .y, .z, .degrees, .scale, EDIT.FEATURE.scale and CURVE.LOAD.
  std::vector<Parameter> parameters() const;
  /// Sets one of these numbers, or EDIT.HANDLE.turn.x, .y, .z: the turn as a vector along its axis, as
  /// long as its angle in degrees. Throws InputError, beginning with `where`: an unknown name (the
  /// nearest is offered), a number that is not finite, a scale not above 0.
  void set(const std::string& parameter, double value, const std::string& where);
};

/// Whether a scene edits a mesh: it names a mesh or has an edit. Throws InputError when the file
/// cannot be read or is not TOML.
bool is_deform_scene(const std::filesystem::path& file);
/// Sets one coordinate of a turn as a vector along its axis, as long as its angle in degrees.
void set_rotation_component(int coordinate, double value, Vec3& axis, double& degrees);

/// Reads a deform scene. Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?"
DeformScene read_deform_scene(const std::filesystem::path& file);
/// Reads the same from a text. Messages name `file`; paths in the scene are relative to its folder.
/// A scene that is being made may have no edit yet.
DeformScene parse_deform_scene(const std::string& text, const std::filesystem::path& file,
                               bool edits_required = true);

}  // namespace batten
