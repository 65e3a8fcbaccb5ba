// In-memory description of a scene: which surface to make and what to write. See read_scene.h for
// reading scenes from files.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curves/primitive_curves.h"
#include "batten/fairing/curves/staged_fairing.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/scene/scene_stress.h"
#include "batten/sculpting/loads/parameters.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

// [[fair]]: fairing stages, applied in order to the lines of a scene (all keys: docs/scenes.md).

/// One [[fair]] stage. FairStage::curves and FairStage::where are set when the scene is faired.
struct SceneFairStage : FairStage {
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> lines;  ///< names of lines; '*' is a wildcard; empty: all
  std::optional<bool> fix_ends;      ///< FairOptions::fix_ends; empty: the kind of scene decides
};

/// Reads all [[fair]] stages of a scene, in order. Unnamed stages get the names fair-1, fair-2, …
/// by position. Throws InputError.
std::vector<SceneFairStage> read_fair_stages(const TomlTable& root);

/// Calls f(name, value), with a reference to the value, for each parameter of the stages:
/// STAGE.noise, STAGE.deviation or STAGE.wavelength. Valid values are positive.
template <class Stages, class Function>
void for_each_fair_parameter(Stages& stages, const Function& f) {
  for (auto& stage : stages) {
    if (stage.options.smoothing == FairOptions::Smoothing::Noise)
      f(stage.name + ".noise", stage.options.noise);
    if (stage.options.smoothing == FairOptions::Smoothing::Deviation)
      f(stage.name + ".deviation", stage.options.deviation);
    if (stage.options.smoothing == FairOptions::Smoothing::Wavelength)
      f(stage.name + ".wavelength", stage.options.wavelength);
  }
}

/// One line from [[curve]], or all curves of a file from [[curves]].
struct SceneLine {
  std::string
      name;  ///< name of a [[curve]]; empty: a [[curves]], whose curves have their own names
  SourceLocation location;
  std::filesystem::path file;  ///< resolved path; empty: the scene has the points
  /// Length unit of the file; empty: the scene's or the file's own unit.
  std::string unit;
  std::vector<Vec3> points;                 ///< points, in the scene's unit
  std::shared_ptr<const InputCurve> curve;  ///< from a shape key: arc, circle, bezier, …
  std::string copy;                         ///< name of the line that this one copies
  AffineTransform transform;                ///< transform of the copy
  /// Indices of corner points; empty: detected automatically.
  std::optional<std::vector<int>> corners;
  CharacterLine::Role role = CharacterLine::Role::Outline;
  CharacterLine::MeshAlignment mesh_alignment = CharacterLine::MeshAlignment::Auto;
  /// Holes only; false: the curve only trims the surface.
  bool constrains_surface = true;
  std::vector<LocatedString> only, skip, inner, holes;  ///< names of curves of a [[curves]]
  bool creases = false;  ///< CAD files: true: creases inside faces are curves, too
};

/// [skin]: meshing options, material and boundary conditions of the surface.
struct SceneSkin {
  SkinOptions options;
  SurfaceStiffness material = SurfaceStiffness::isotropic(0, 1);
  bool isotropic_alpha = true, isotropic_beta = true;  ///< true: the scene gives a single number
  LoadUnits units = LoadUnits::Relative;
  enum class FixedBoundary { Lines, Corners } boundary = FixedBoundary::Lines;
  /// Shape between the curves. Auto: the recognised primitive or rest shape (rest_shape.h), with
  /// least bending relative to it. Bending: least bending from a flat rest state. Variation:
  /// minimum-variation surface [MoretonSequin1992]. Loft: loft across sections.
  enum class Fair { Auto, Bending, Variation, Loft } fair = Fair::Auto;
  /// True if the surface bends relative to a rest shape.
  bool has_rest() const { return fair != Fair::Bending; }
  /// True if the shape is not the one of least energy.
  bool is_faired() const { return fair == Fair::Variation || fair == Fair::Loft; }
  /// Variation: fraction of the step from the minimum-bending shape, 0 to 1.
  double strength = 1;
  double max_displacement = 0;  ///< Variation: maximum displacement, scene unit; 0: unlimited
  /// Loft: lines that are sides of four-sided regions.
  std::vector<LocatedString> sections;
  /// The value of the key `fair` in the scene.
  std::string fair_name() const;
};

/// [[target]]: a surface that the shape of the lines is fitted to, instead of minimising bending.
/// Several targets are combined into one.
struct SceneTarget {
  SourceLocation location;
  std::filesystem::path file;  ///< a CAD file or a mesh
  std::string unit;            ///< length unit of a mesh; empty: the scene's
  /// true: the mesh is a control cage; the target is its Catmull-Clark limit surface.
  bool cage = false;
  double tolerance = 0;  ///< model units; 0: 1e-4 of the model's size
};

/// [[constraint]]: acts at the point of the unloaded surface nearest to `at` (Point, Normal,
/// Tangent), or along a curve (LineNormal).
struct SceneConstraint {
  enum class Type { Point, Normal, Tangent, LineNormal };
  std::string name;
  SourceLocation location;
  Type type = Type::Point;
  Vec3 at = Vec3::Zero();
  Vec3 goal = Vec3::Zero();    ///< Point: prescribed position; else the prescribed direction
  Vec2 along = Vec2::UnitX();  ///< Tangent: direction in (u, v)
  /// Point: largest allowed |goal − middle| in each coordinate, model units. Default: no limit.
  double range = std::numeric_limits<double>::infinity();
  Vec3 middle = Vec3::Zero();  ///< Point: the position given in the scene
  LocatedString line;          ///< LineNormal: name of the curve
  /// LineNormal: true if the scene gives no direction, so that the tangent planes stay unchanged.
  bool keep_tangent_planes = false;
};

/// [[load]]: a load and its parameter, a number or a function of time.
struct SceneLoad : ScalarParameter {
  SourceLocation name_location;  ///< location of its name in the file
  enum class Type {
    Pressure,
    Uniform,
    Gravity,
    Point,
    Line,
    /// Springs from measured points to the surface; their foot points slide on it.
    PointCloudSprings,
    AttractorSprings  ///< springs from surface points to points, a curve or a plane
  };
  Type type = Type::Pressure;
  /// Unit vector; not for Pressure, PointCloudSprings and AttractorSprings.
  Vec3 direction = Vec3::UnitZ();
  Vec3 at = Vec3::Zero();  ///< Point: point of application
  SceneArea area;          ///< Pressure, Uniform: area of application
  LocatedString line;      ///< Line: name of the line
  /// PointCloudSprings: file of the points; AttractorSprings: `curve` as a file.
  std::filesystem::path file;
  SourceLocation location;       ///< location of `file` in the scene
  std::string unit;              ///< unit of the file's numbers; empty: the scene's
  Load::AttractorSprings pulls;  ///< AttractorSprings: everything except the curve
  LocatedString curve;           ///< AttractorSprings: name of a line, or of a file
};

/// [[stiffness]]: a stiffness field that is added to alpha or beta.
struct SceneStiffnessField : ScalarParameter {
  SourceLocation name_location;  ///< location of its name in the file
  StiffnessField::Kind kind = StiffnessField::Kind::Bending;
  SceneArea area;
  /// Direction of the stiffness in (u, v), or name of the line that it follows; empty: isotropic.
  std::optional<std::variant<Vec2, LocatedString>> along;
};

/// [[offset]]: displaces a line by a parameter.
struct SceneLineOffset : ScalarParameter {
  SourceLocation name_location;  ///< location of its name in the file
  LocatedString line;
  std::optional<Vec3> direction;  ///< empty: along the surface normal
  /// Fade length at each end, as a fraction of the line's length. Empty: a quarter at an end that
  /// lies on a line that does not move, else 0.
  std::optional<double> fade;
};

/// One entry of drives = [...] of a [[parameter]]: driven = offset + factor · of, summed over all
/// rules that drive the same parameter.
struct SceneRule {
  std::string of, driven;  ///< names of the two parameters
  SourceLocation location;
  double factor = 1;
  std::optional<double> offset;  ///< empty: the driven parameter's own value
};

/// [motion]: density, damping and time integration parameter θ of a motion.
struct SceneMotion {
  double density = 1, damping = 1, theta = 1;
};

/// [[picture]], and the picture of a [[sweep]].
struct ScenePicture {
  std::string file;
  PictureScene look;  ///< view and content; its `regions` are set when the picture is drawn
  PictureSize size;
};

/// [[sweep]]: one picture with one panel per value of a parameter.
struct SceneSweep {
  std::string parameter;
  std::vector<double> values;
  int columns = 0;       ///< panels per row; 0: sheet as square as possible
  ScenePicture picture;  ///< the sheet; each panel's title is look.title and the value
};

/// How the faces between the curves of a scene are found and joined: keys of [skin], [[face]] and
/// [[join]].
struct SceneNetwork {
  SourceLocation location;  ///< location of [skin]
  double tolerance = 0;     ///< gap tolerance, model units; 0: default of NetworkOptions
  double tangent_angle = NetworkOptions{}.tangent_angle;  ///< NetworkOptions, degrees
  /// Maximum number of regions at an edge.
  int max_faces_per_edge = RegionSearchOptions{}.max_faces_per_edge;
  double crease_angle = ModelOptions{}.crease_angle_deg;      ///< ModelOptions, degrees
  double join_tolerance = ModelOptions{}.join_tolerance_deg;  ///< ModelOptions, degrees
  /// The lines describe one half: the model is mirrored in the plane through the origin
  /// perpendicular to this axis, 0, 1, 2 for x, y, z.
  std::optional<int> symmetry;
  bool fair_noisy_lines = true;  ///< true: noisy lines are faired, if there is no [[fair]]
  std::vector<RegionSpec> regions;
  std::vector<JoinSpec> joins;
};

/// A parameter that can be set from outside, with its range.
struct Parameter {
  std::string name;
  double value, min, max;
};

/// Contents of a scene. Names are resolved when the model is made.
struct Scene {
  std::filesystem::path file;  ///< empty for a scene created in memory
  std::string name = "surface", unit = "mm";
  std::vector<SceneLine> lines;
  std::vector<SceneFairStage> fairing;  ///< [[fair]]: fairing before skinning
  SceneNetwork network;
  SceneSkin skin;
  std::vector<SceneTarget> targets;
  std::vector<SceneConstraint> constraints;
  std::vector<SceneLoad> loads;
  std::vector<SceneStiffnessField> weights;
  std::vector<SceneLineOffset> moves;
  std::vector<ScalarParameter> sliders;  ///< parameters from [[parameter]]
  std::vector<SceneRule> rules;          ///< parameters driven by others
  SceneMotion motion;
  std::optional<SceneStress> stress;
  std::string step, vtu, vtp, calculix;  ///< [output]: file names; empty: not written
  enum class StepForm {
    /// Face; if that exceeds step_tolerance, Exact for a single untrimmed region of up to 10,000
    /// triangles.
    Auto,
    Face,  ///< one B-spline face per region, within step_tolerance
    Exact  ///< three faces per triangle
  } step_form = StepForm::Auto;
  bool step_lines = false;        ///< true: the STEP file also contains the lines as curves
  bool step_ap242 = false;        ///< true: AP242 instead of AP214
  double step_tolerance = 0;      ///< model units; 0: 1e-4 of the region's size
  std::filesystem::path compare;  ///< [compare]: CAD file to whose faces distances are measured
  std::vector<ScenePicture> pictures;
  std::vector<SceneSweep> sweeps;

  /// All parameters: loads, weights, moves and [[parameter]] by name; coordinates of constraints as
  /// name.x, name.y, name.z; alpha and beta (or alpha_uu, alpha_uv, alpha_vv, beta_uu, beta_uv,
  /// beta_vv if the scene gives three numbers); STAGE.noise, STAGE.deviation, STAGE.wavelength of
  /// [[fair]]. The value of a time-dependent parameter is its value at time 0; driven parameters
  /// follow their rules.
  std::vector<Parameter> parameters() const;
  /// The same parameters with their time functions and rules.
  std::vector<ScalarParameter> named_values() const;
  /// Sets a parameter; a time-dependent one becomes constant. Throws InputError, beginning with
  /// `where`, for an unknown name (it suggests the nearest one), a driven parameter, or a value out
  /// of range. Also throws it for a material that violates material_requirement(), or a direction
  /// of length 0.
  void set(const std::string& parameter, double value, const std::string& where);

  /// True if anything other than lines acts on the surface.
  bool is_sculpted() const;

  /// The location as "FILE:LINE:COLUMN: ", the prefix of messages.
  std::string at(const SourceLocation& location) const {
    return format_location(file.string(), location);
  }
};

/// The condition that a material violates, as text; empty if its energy is positive, so that a
/// minimum exists.
std::string material_requirement(const SurfaceStiffness& material);

/// True if the line `run` of a layout is the scene's line `line` or a part of it. A line cut at its
/// corners has parts named "line.1", "line.2", …
bool is_part_of(const std::string& run, const std::string& line);

}  // namespace batten
