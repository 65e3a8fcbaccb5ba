// Deform scenes: TOML files that define features, constraints and edits of a mesh (all keys:
// docs/deform.md). These functions read the scene file only, not the mesh.
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
#include "batten/mesh/editing/feature_relation.h"
#include "batten/mesh/editing/feature_rotation_estimator.h"
#include "batten/sculpting/curves/sculpted_curve.h"

namespace batten {

/// [[constraint]]: constrains a point to a plane or a line.
struct GuideSpec {
  std::string name;
  SourceLocation location;
  /// Feature, selection or proposal. The guided point is the mean of its vertices, or of the
  /// vertices of its loop.
  LocatedString of;
  PointConstraint::Kind kind = PointConstraint::Kind::OnPlane;
  Vec3 direction = Vec3::UnitZ();
  std::optional<Vec3> through;  ///< a point of the plane or line; empty: the guided point itself
};

/// [[relation]]: a geometric relation between features that edits preserve.
struct RelationSpec {
  using Kind = FeatureRelation::Kind;
  std::string name;
  SourceLocation location;
  Kind kind = Kind::Parallel;
  std::vector<LocatedString> of;               ///< features; '*' is a wildcard
  std::optional<std::pair<Vec3, Vec3>> plane;  ///< Symmetric: normal, and a point of the plane
};

/// [[chain]]: a character line of the mesh whose shape is preserved, rigidly or softly.
struct LineSpec {
  std::string name;
  SourceLocation location;
  /// points; the line passes through the nearest vertices, following creases.
  std::vector<Vec3> through;
  std::vector<long> nodes;  ///< alternatively: node numbers in the mesh file, in order
  bool closed = false;
  bool rigid = false;
  /// soft: width of the strip of sheet whose stiffness the line gets, model units; 0: a tenth of
  /// the line's length.
  double width = 0;
};

/// [[curve]]: a chain of vertices that becomes a deformable curve. It is faired, shaped by its own
/// loads, and then imposed on its vertices exactly.
struct CurveSpec {
  using Ends = SculptedCurveOptions::Ends;
  LineSpec line;  ///< name and vertices; `rigid` and `width` are ignored
  bool faired = true;
  FairOptions fair;  ///< fairing options
  Ends ends = Ends::Clamped;
  double alpha = 0, beta = 1;  ///< relative stretch and bending stiffness against the loads
  std::vector<CurveLoad> loads;
};

/// [[position_constraint]]: moves one vertex to a position, by a soft (least-squares) or hard constraint.
struct PositionConstraintSpec {
  std::string name;
  SourceLocation location;
  std::optional<long> node;  ///< node number in the mesh file
  std::optional<Vec3> at;    ///< alternatively: the vertex nearest to this point
  Vec3 to = Vec3::Zero();
  std::optional<double> weight;  ///< weight of the soft constraint; empty: hard constraint
};

/// [[edit]]: one edit of the mesh. It starts from the result of the previous edit.
struct EditSpec {
  /// A handle and its prescribed motion: translation, rotation by `degrees` about `axis`, scale.
  struct MovedHandle {
    std::string name;
    SourceLocation location;
    std::vector<LocatedString> vertices;
    Vec3 translate = Vec3::Zero(), axis = Vec3::UnitZ();
    double degrees = 0, scale = 1;
    std::optional<Vec3> about;  ///< centre of rotation and scaling; empty: mean of its vertices
  };
  /// A feature with a prescribed scale factor.
  struct ScaledFeature {
    LocatedString feature;
    double factor = 1;
  };
  /// A feature whose rotation is prescribed, by `degrees` about `axis`.
  struct RotatedFeature {
    LocatedString feature;
    Vec3 axis = Vec3::UnitZ();
    double degrees = 0;
  };
  using RotationMode = batten::RotationMode;
  /// A guide whose plane or line is moved to pass through another point.
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
  /// True: features that are not scaled keep the position that they would have if no feature were
  /// scaled.
  bool keep_centres = true;
  std::vector<MovedGuide> guides;
};

/// [modes]: shell properties for two decks that compute natural frequencies, before and after the
/// edits.
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

/// Contents of a deform scene.
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
  std::string mesh_out, vtp;       ///< file names; empty: not written
  bool large_field_nodes = false;  ///< see MeshWriteOptions::large_field_nodes
  std::optional<ModesSpec> modes;
  std::vector<MeshPictureSpec> pictures;

  /// All parameters: EDIT.HANDLE.x, .y, .z, .degrees, .scale, EDIT.FEATURE.scale and CURVE.LOAD.
  std::vector<Parameter> parameters() const;
  /// Sets a parameter, or a component EDIT.HANDLE.turn.x, .y, .z of the rotation vector (direction
  /// of the axis, length: angle in degrees). Throws InputError, beginning with `where`, for an
  /// unknown name (it suggests the nearest one), a number that is not finite, or a scale ≤ 0.
  void set(const std::string& parameter, double value, const std::string& where);
};

/// True if a scene edits a mesh: it names a mesh or has an edit. Throws InputError if the file
/// cannot be read or is not TOML.
bool is_deform_scene(const std::filesystem::path& file);
/// Sets one component of a rotation vector (length: angle in degrees), given and stored as axis and
/// angle.
void set_rotation_component(int coordinate, double value, Vec3& axis, double& degrees);

/// Reads a deform scene. Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?"
DeformScene read_deform_scene(const std::filesystem::path& file);
/// Parses a deform scene from text. `file` appears in messages, and paths are relative to its
/// folder. `edits_required` = false accepts a scene under construction without edits.
DeformScene parse_deform_scene(const std::string& text, const std::filesystem::path& file,
                               bool edits_required = true);

}  // namespace batten
