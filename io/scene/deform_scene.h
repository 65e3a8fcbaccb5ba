// SPDX-License-Identifier: MPL-2.0
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
#include "batten/sculpting/curves/deformable_curve.h"

namespace batten {

/// [[constraint]]: constrains a point of the mesh to a plane or a line.
struct GuideSpec {
  std::string name;
  SourceLocation location;
  /// Name of a feature, a selection or a proposal. The constrained point is the mean of its
  /// vertices; for a hole, of the vertices of its loop.
  LocatedString of;
  PointConstraint::Kind kind = PointConstraint::Kind::OnPlane;
  Vec3 direction = Vec3::UnitZ();
  /// A point on the constraint's plane or line. Empty: the constrained point's initial position.
  std::optional<Vec3> through;
};

/// [[relation]]: a geometric relation between features (such as parallel) that edits preserve.
struct RelationSpec {
  using Kind = FeatureRelation::Kind;
  std::string name;
  SourceLocation location;
  Kind kind = Kind::Parallel;
  std::vector<LocatedString> of;  ///< names of the related features; '*' is a wildcard
  /// For a symmetry relation: normal and one point of the symmetry plane; empty otherwise.
  std::optional<std::pair<Vec3, Vec3>> plane;
};

/// [[chain]]: a feature curve along mesh edges whose shape is preserved, rigidly or softly.
struct LineSpec {
  std::string name;
  SourceLocation location;
  /// Points near the feature curve. It passes through their nearest vertices, following creases.
  std::vector<Vec3> through;
  /// Alternative to `through`: node numbers in the mesh file, in order along the curve.
  std::vector<long> nodes;
  bool closed = false;
  bool rigid = false;
  /// Soft chains: width of the stiffened strip along the feature curve, model units; 0: a tenth of
  /// the length of the curve.
  double width = 0;
};

/// [[curve]]: a chain of vertices edited as a deformable curve. The curve is fitted and faired,
/// deformed by its own loads, and then imposed exactly on the vertices.
struct CurveSpec {
  using Ends = SculptedCurveOptions::Ends;
  LineSpec line;  ///< name and vertices of the chain; `rigid` and `width` are ignored
  /// Curve file, CAD file or scene with the curve that the chain follows; empty: that of the chain.
  std::filesystem::path file;
  std::string unit;     ///< length unit of a curve file; empty: the unit of the scene
  LocatedString curve;  ///< name of the curve in the file; empty: the only one
  bool faired = true;
  FairOptions fair;  ///< options of the fairing; used if `faired` is true
  Ends ends = Ends::Clamped;
  double alpha = 0, beta = 1;  ///< stretching and bending stiffness, relative to the loads
  std::vector<CurveLoad> loads;
};

/// [[position_constraint]]: a soft (least-squares) or hard constraint on the position of a vertex.
struct PositionConstraintSpec {
  std::string name;
  SourceLocation location;
  std::optional<long> node;  ///< node number in the mesh file
  std::optional<Vec3> at;    ///< alternative to `node`: the vertex nearest to this point
  Vec3 to = Vec3::Zero();
  std::optional<double> weight;  ///< weight of a soft constraint; empty: hard constraint
};

/// [[target]]: a surface that the mesh follows in all edits.
struct MorphTargetSpec {
  SourceLocation location;
  std::filesystem::path file;     ///< a CAD file or a mesh file
  std::string unit;               ///< length unit of a mesh file; empty: the unit of the scene
  std::vector<LocatedString> of;  ///< what follows: features, selections, proposals; empty: all
  double smoothing = 0, reach = 0, offset = 0;  ///< those of TargetFollowerOptions
};

/// [[edit]]: one edit of the mesh, applied to the result of the previous edit.
struct EditSpec {
  /// A handle with its prescribed motion: translation, rotation by `degrees` about `axis`, scaling.
  struct MovedHandle {
    std::string name;
    SourceLocation location;
    std::vector<LocatedString> vertices;
    Vec3 translate = Vec3::Zero(), axis = Vec3::UnitZ();
    double degrees = 0, scale = 1;
    /// Centre of rotation and scaling; empty: the mean of the vertices of the handle.
    std::optional<Vec3> about;
  };
  /// A feature with a prescribed scale factor.
  struct ScaledFeature {
    LocatedString feature;
    double factor = 1;
  };
  /// A feature with a prescribed rotation by `degrees` about `axis`.
  struct RotatedFeature {
    LocatedString feature;
    Vec3 axis = Vec3::UnitZ();
    double degrees = 0;
  };
  using RotationMode = batten::RotationMode;
  /// A point constraint whose plane or line is translated to pass through another point.
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
  /// True: unscaled features keep the position that they would have without any scaling.
  bool keep_centres = true;
  std::vector<MovedGuide> guides;
};

/// [[dimension]]: a quantity of the mesh, measured before and after the edits.
struct DimensionSpec {
  enum class Kind {
    Distance,  ///< between the centres of two parts
    Radius,    ///< of the circle that is fitted to a hole or to vertices
    Angle,     ///< between the axes or normals of two parts, degrees, 0 to 180
    Area,      ///< of the faces of a part
    Volume,    ///< enclosed by the faces of a part
    Mass       ///< area times `thickness` times `density`
  };
  std::string name;
  SourceLocation location;
  Kind kind = Kind::Distance;
  /// Features, selections or proposals: two for a distance and an angle, otherwise one. Empty: all
  /// faces of the mesh, for an area, a volume and a mass.
  std::vector<LocatedString> of;
  /// Unit vector; the distance is the component along it, from the first part to the second. Empty:
  /// the Euclidean distance.
  std::optional<Vec3> direction;
  double thickness = 0, density = 0;
};

/// [[require]]: a condition on a dimension of the edited mesh.
struct RequirementSpec {
  enum class Relation { Equal, AtMost, AtLeast };
  SourceLocation location;
  LocatedString dimension;
  Relation relation = Relation::Equal;
  double value = 0;
  /// The parameter that is changed until the condition holds; empty: the condition is only checked.
  LocatedString adjust;
};

/// [modes]: shell properties for two CalculiX decks that compute natural frequencies, one of the
/// mesh before the edits and one of the edited mesh.
struct ModesSpec {
  double thickness = 0, young = 0, poisson = 0, density = 0;
  int count = 10;
  std::vector<LocatedString> clamped;
  std::string before, after;  ///< file names of the decks for the mesh before and after the edits
};

/// [[picture]]: a picture of the mesh, for example before and after the edits, or after each edit.
struct MeshPictureSpec {
  enum class Show { BeforeAfter, Steps, After, Displacement };
  std::string file, title;
  Show show = Show::BeforeAfter;
  bool mesh = false;
  double azimuth = -30, elevation = 30, zoom = 1;
  int up = 2;  ///< axis that points upwards: 0, 1, 2 for x, y, z
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
  std::vector<MorphTargetSpec> targets;
  std::vector<EditSpec> edits;
  std::vector<DimensionSpec> dimensions;
  std::vector<RequirementSpec> requirements;
  std::string mesh_out, vtp;       ///< names of output files; empty: not written
  bool large_field_nodes = false;  ///< true: write Nastran GRID cards in large-field format
  std::optional<ModesSpec> modes;
  std::vector<MeshPictureSpec> pictures;

  /// All parameters of the scene, with the names EDIT.HANDLE.x, .y, .z, .angle and .scale,
  /// EDIT.FEATURE.scale, EDIT.CONSTRAINT.x, .y, .z, CONSTRAINT.x, .y, .z and CURVE.LOAD.
  std::vector<Parameter> parameters() const;
  /// Sets a parameter of the scene, or one component EDIT.HANDLE.rotation.x, .y, .z of the rotation
  /// vector of a handle (direction of the axis; length: angle in degrees). Throws InputError for an
  /// unknown name (the message suggests the nearest one), a number that is not finite, or a scale ≤
  /// 0. `where`: first words of messages.
  void set(const std::string& parameter, double value, const std::string& where);
};

/// True if a scene file edits a mesh, that is, names a mesh or contains an [[edit]]. Throws
/// InputError if the file cannot be read or is not TOML.
bool is_deform_scene(const std::filesystem::path& file);
/// Sets component `coordinate` (0, 1, 2) of a rotation vector to `value`. The rotation vector,
/// whose length is the angle in degrees, is stored as `axis` and `degrees`.
void set_rotation_component(int coordinate, double value, Vec3& axis, double& degrees);

/// Reads a deform scene. Throws InputError ("FILE:LINE:COLUMN: found …, expected …; did you mean
/// …?") if the file is invalid.
DeformScene read_deform_scene(const std::filesystem::path& file);
/// Parses a deform scene from text. `file` appears in messages, and relative paths are resolved
/// against its folder. `edits_required` = false accepts an unfinished scene without edits.
DeformScene parse_deform_scene(const std::string& text, const std::filesystem::path& file,
                               bool edits_required = true);

}  // namespace batten
