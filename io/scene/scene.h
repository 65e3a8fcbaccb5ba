// SPDX-License-Identifier: MPL-2.0
// Scenes: TOML files that describe a surface (curves, loads, constraints) and its output files.
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curves/primitive_curves.h"
#include "batten/fairing/curves/staged_fairing.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/scene/scene_stress.h"
#include "batten/mesh/shell_mesh.h"
#include "batten/sculpting/loads/parameters.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

// [[fair]]: fairing stages, applied in order to the curves of a scene (all keys: docs/scenes.md).

/// One [[fair]] stage. The members FairStage::curves and FairStage::where are set when the scene is
/// faired, not when it is read.
struct SceneFairStage : FairStage {
  std::string name;
  SourceLocation location;
  /// Names of the curves to fair; '*' is a wildcard; empty: all curves.
  std::vector<LocatedString> lines;
  /// True: the end points of open curves are fixed (FairOptions::fix_ends). Empty: true in scenes
  /// that make a surface, false in others.
  std::optional<bool> fix_ends;
};

/// Reads all [[fair]] stages of a scene, in file order. Unnamed stages are named fair-1, fair-2, …
/// by position. Throws InputError if a key or value is invalid.
std::vector<SceneFairStage> read_fair_stages(const TomlTable& root);

/// Calls f(name, value) for each parameter of the fairing stages, where `value` is a reference to
/// the value of the parameter. The parameters are named STAGE.noise, STAGE.deviation and
/// STAGE.wavelength; valid values are positive.
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

/// One curve ([[curve]]), or all curves of a file ([[curves]]).
struct SceneLine {
  std::string name;  ///< name of a [[curve]]; empty for [[curves]]: the file gives the names
  SourceLocation location;
  std::filesystem::path file;  ///< path of the curve file; empty: the scene contains the curve
  /// Length unit of `file`; empty: the unit declared in the file, or else the unit of the scene.
  std::string unit;
  std::vector<Vec3> points;  ///< points of the curve, in the unit of the scene
  /// Curve given by a key such as arc or bezier; nullptr: none.
  std::shared_ptr<const InputCurve> curve;
  std::string copy;           ///< name of the curve to copy; empty: not a copy
  AffineTransform transform;  ///< transform applied to the copied curve
  /// 0-based indices of the corner points; empty: corners are detected automatically.
  std::optional<std::vector<int>> corners;
  bool all_corners = false;  ///< files and shape keys: every point or kink is a corner
  /// Files only: the vertices of polylines in drawings and CAD files are points of smooth curves.
  bool measured = false;
  CharacterLine::Role role = CharacterLine::Role::Outline;
  CharacterLine::MeshAlignment mesh_alignment = CharacterLine::MeshAlignment::Auto;
  /// Holes only. True: the surface passes through the curve. False: the curve only trims it.
  bool constrains_surface = true;
  /// [[curves]] only: names of the curves to read, to skip, to treat as inner curves or as holes.
  std::vector<LocatedString> only, skip, inner, holes;
  bool creases = false;  ///< CAD files only; true: also read creases inside faces as curves
};

/// [skin]: meshing options, material, boundary conditions and fairing of the surface.
struct SceneSkin {
  SkinOptions options;
  SurfaceStiffness material = SurfaceStiffness::isotropic(0, 1);
  /// True if the scene gives the corner angle.
  bool corner_angle_is_stated = false;
  /// True if the scene gives alpha (beta) as a single number instead of three.
  bool isotropic_alpha = true, isotropic_beta = true;
  LoadUnits units = LoadUnits::Relative;
  enum class FixedBoundary { Lines, Corners } boundary = FixedBoundary::Lines;
  /// Shape of the surface between the curves. Auto: the recognised primitive or rest shape
  /// (rest_shape.h), with least bending relative to that shape. Bending: least bending relative to
  /// a plane. Variation: minimum-variation surface [MoretonSequin1992]. Loft: loft across sections.
  enum class Fair { Auto, Bending, Variation, Loft } fair = Fair::Auto;
  /// True if bending is measured relative to a curved rest shape.
  bool has_rest() const { return fair != Fair::Bending; }
  /// True if the surface is faired: the final shape is not the shape of least bending energy.
  bool is_faired() const { return fair == Fair::Variation || fair == Fair::Loft; }
  /// Fair::Variation: interpolates from the minimum-bending to the minimum-variation shape, 0 to 1.
  double strength = 1;
  /// Fair::Variation: maximum displacement by fairing, in the unit of the scene; 0: unlimited.
  double max_displacement = 0;
  /// Fair::Loft: names of the section curves, which are sides of four-sided faces.
  std::vector<LocatedString> sections;
  /// The value of `fair` as it is written in the scene, such as "auto".
  std::string fair_name() const;
};

/// [[target]]: a surface to which the shape is fitted; without a target, the bending energy is
/// minimised. Several [[target]] tables are combined into one target surface.
struct SceneTarget {
  SourceLocation location;
  std::filesystem::path file;  ///< the target: a CAD file or a mesh file
  /// The target as a mesh that the scene lists in place of a file; nullptr: none.
  std::shared_ptr<const ShellMesh> mesh = nullptr;
  std::string unit;  ///< length unit of a mesh file; empty: the unit of the scene
  /// True: the mesh is a control cage, and the target is its Catmull-Clark limit surface.
  bool cage = false;
  /// Largest accepted distance from the target, model units; 0: 1e-4 of the size of the model.
  double tolerance = 0;
};

/// [[neighbour]]: given faces that the surface continues and that keep their shape.
struct SceneNeighbour {
  SourceLocation location;
  std::filesystem::path file;  ///< CAD file or mesh
  /// Names of the faces that are used ("face 1" …; face sets of a mesh), and of those that are left
  /// out; empty: all faces, no face.
  std::vector<std::string> faces, without;
  NeighbourContinuity continuity = NeighbourContinuity::Automatic;
  /// True: openings between the faces are filled. Empty: they are if the scene has no outline curves
  /// or if `openings` selects some.
  std::optional<bool> fill;
  /// Numbers of the openings to fill, from 1, the longest first; empty: all but outer boundaries.
  std::vector<int> openings;
  /// Names of free edges: the openings that contain them are filled, or `bridge` connects them.
  std::vector<std::string> edges;
  /// True: one face connects two openings or the `edges` of all neighbours, instead of a face in each
  /// opening.
  bool bridge = false;
  double tension = 0;  ///< of a bridge between open edges; 0: 1
};

/// [[constraint]]: a constraint at the point of the unloaded surface nearest to `at` (Point,
/// Normal, Tangent), or along a curve (LineNormal).
struct SceneConstraint {
  enum class Type { Point, Normal, Tangent, LineNormal };
  std::string name;
  SourceLocation location;
  Type type = Type::Point;
  Vec3 at = Vec3::Zero();
  Vec3 goal = Vec3::Zero();    ///< Point: prescribed position; other types: prescribed direction
  Vec2 along = Vec2::UnitX();  ///< Tangent: parameter direction (u, v) of the prescribed tangent
  /// Type::Point: maximum of |goal − middle| per coordinate, model units; infinite: no limit.
  double range = std::numeric_limits<double>::infinity();
  Vec3 middle = Vec3::Zero();  ///< Point: value of `goal` in the scene file
  LocatedString line;          ///< LineNormal: name of the curve
  /// Constraints of type LineNormal: true if the scene gives no direction, so that the tangent
  /// planes along the curve stay unchanged.
  bool keep_tangent_planes = false;
};

/// [[load]]: a load whose magnitude, a number or a function of time, is a parameter of the scene.
struct SceneLoad : ScalarParameter {
  SourceLocation name_location;  ///< location of the name in the scene file
  enum class Type {
    Pressure,
    Uniform,
    Gravity,
    Point,
    Line,
    /// Springs from measured points to the surface; their foot points slide on the surface.
    PointCloudSprings,
    AttractorSprings  ///< springs from surface points to points, a curve or a plane
  };
  Type type = Type::Pressure;
  /// Direction of the load, a unit vector; not used by loads of the types Pressure,
  /// PointCloudSprings and AttractorSprings.
  Vec3 direction = Vec3::UnitZ();
  Vec3 at = Vec3::Zero();  ///< Point: point of application
  SceneArea area;          ///< Pressure, Uniform: area of application
  LocatedString line;      ///< Line: name of the loaded curve
  /// For PointCloudSprings: file of the measured points. For AttractorSprings: the name `curve`
  /// interpreted as the path of a curve file.
  std::filesystem::path file;
  SourceLocation location;       ///< location of the file name `file` in the scene
  std::string unit;              ///< length unit of `file`; empty: the unit of the scene
  Load::AttractorSprings pulls;  ///< AttractorSprings: settings of the springs except the curve
  LocatedString curve;           ///< AttractorSprings: name of a curve or of a curve file
};

/// [[stiffness]]: a stiffness field that is added to alpha or beta.
struct SceneStiffnessField : ScalarParameter {
  SourceLocation name_location;  ///< location of the name in the scene file
  StiffnessField::Kind kind = StiffnessField::Kind::Bending;
  SceneArea area;
  /// Direction of the additional stiffness: a vector (u, v), or the name of the curve that the
  /// direction follows. Empty: the stiffness is isotropic.
  std::optional<std::variant<Vec2, LocatedString>> along;
};

/// [[offset]]: displaces a curve by a distance; the distance is a parameter of the scene.
struct SceneLineOffset : ScalarParameter {
  SourceLocation name_location;  ///< location of the name in the scene file
  LocatedString line;
  std::optional<Vec3> direction;  ///< empty: the curve moves along the surface normal
  /// Length over which the displacement fades to zero at each end, as a fraction of the length of
  /// the curve. Empty: 0.25 at an end that lies on a curve without offset, otherwise 0.
  std::optional<double> fade;
};

/// One entry of the list `drives` of a [[parameter]]: a rule by which the parameter `of` drives the
/// parameter `driven`. The value of `driven` is `offset` plus the sum of `factor` times the value
/// of `of` over all rules that drive `driven`.
struct SceneRule {
  std::string of, driven;  ///< names of the driving and of the driven parameter
  SourceLocation location;
  double factor = 1;
  std::optional<double> offset;  ///< empty: the value of the driven parameter in the scene
};

/// [motion]: density, damping coefficient, and parameter θ (½ to 1) of the implicit time
/// integration of the dynamic simulation.
struct SceneMotion {
  double density = 1, damping = 1, theta = 1;
};

/// A picture of the surface, defined by [[picture]] or by [[sweep]].
struct ScenePicture {
  std::string file;
  PictureScene look;  ///< view and content; `look.regions` is set at drawing
  PictureSize size;
};

/// [[sweep]]: one sheet of pictures with a panel for each value of a parameter.
struct SceneSweep {
  std::string parameter;
  std::vector<double> values;
  int columns = 0;  ///< panels per row; 0: automatic, for an almost square sheet
  /// View and file of the sheet. The title of a panel consists of `picture.look.title` and the value
  /// of the parameter.
  ScenePicture picture;
};

/// Settings from [skin], [[face]] and [[join]] for finding and joining the faces between the curves
/// of a scene.
struct SceneNetwork {
  SourceLocation location;  ///< location of [skin]
  double tolerance = 0;  ///< gap tolerance of curve ends, model units; 0: default of NetworkOptions
  /// Largest angle, degrees, at which one edge smoothly continues another at a node
  /// (NetworkOptions::tangent_angle).
  double tangent_angle = NetworkOptions{}.tangent_angle;
  /// Maximum number of faces that share an edge.
  int max_faces_per_edge = RegionSearchOptions{}.max_faces_per_edge;
  /// Crease angle, degrees: edges at which faces meet at a larger angle are creases.
  double crease_angle = ModelOptions{}.crease_angle_deg;
  /// Largest permitted angle between two faces at a smooth edge, degrees.
  double join_tolerance = ModelOptions{}.join_tolerance_deg;
  /// Set if the curves describe one half of a symmetric model: the axis (0, 1, 2 for x, y, z)
  /// perpendicular to the symmetry plane, which passes through the origin.
  std::optional<int> symmetry;
  bool fair_noisy_lines = true;  ///< true: noisy curves are faired if the scene has no [[fair]]
  std::vector<RegionSpec> regions;
  std::vector<JoinSpec> joins;
};

/// A parameter of a scene that the command line or a program can set, with its permitted range.
struct Parameter {
  std::string name;
  double value, min, max;
};

/// Contents of a scene file. Names of curves and faces are resolved when the model is made.
struct Scene {
  std::filesystem::path file;  ///< path of the scene file; empty: the scene was created in memory
  std::string name = "surface", unit = "mm";
  std::vector<SceneLine> lines;
  std::vector<SceneFairStage> fairing;  ///< [[fair]]: stages that fair the curves before skinning
  SceneNetwork network;
  SceneSkin skin;
  std::vector<SceneTarget> targets;
  std::vector<SceneNeighbour> neighbours;
  std::vector<SceneConstraint> constraints;
  std::vector<SceneLoad> loads;
  std::vector<SceneStiffnessField> weights;
  std::vector<SceneLineOffset> moves;
  std::vector<ScalarParameter> sliders;  ///< parameters defined by [[parameter]]
  std::vector<SceneRule> rules;          ///< rules by which parameters drive other parameters
  SceneMotion motion;
  std::optional<SceneStress> stress;
  std::string step, vtu, vtp, mesh,
      calculix;  ///< [output]: names of output files; empty: not written
  /// Text of a scene file that describes this scene, which was created in memory. It is written as
  /// NAME.toml, unless the output folder contains another file of this name. Empty: not written.
  std::string text;
  enum class StepForm {
    /// Automatic: like Face, except for a scene with a single untrimmed face of up to 10,000
    /// triangles whose B-spline face exceeds step_tolerance. Such a scene is written like Exact.
    Auto,
    Face,  ///< one B-spline face per face of the model, within step_tolerance
    Exact  ///< three exact bicubic faces per triangle
  } step_form = StepForm::Auto;
  /// True: the STEP file also contains the faces of `neighbours`, sewn to those of the model.
  bool step_neighbours = true;
  bool step_lines = false;  ///< true: the STEP file also contains the curves of the scene
  bool step_ap242 = false;  ///< true: STEP AP242; false: AP214
  /// Largest distance of the STEP faces from the surface, model units; 0: 1e-4 of the size of each
  /// face.
  double step_tolerance = 0;
  std::filesystem::path compare;  ///< [compare]: CAD file to compare with the surface; empty: none
  std::vector<ScenePicture> pictures;
  std::vector<SceneSweep> sweeps;

  /// All parameters of the scene, with their values and ranges. Loads, stiffness fields, offsets
  /// and [[parameter]] have the names given in the scene; coordinates of constraints are NAME.x,
  /// NAME.y, NAME.z. The material has alpha and beta (or alpha_uu, alpha_uv, alpha_vv, beta_uu,
  /// beta_uv, beta_vv if the scene gives three numbers). Stages of [[fair]] have STAGE.noise,
  /// STAGE.deviation, STAGE.wavelength. The value of a time-dependent parameter is its value at
  /// time 0; driven parameters have the values given by their rules.
  std::vector<Parameter> parameters() const;
  /// All parameters of the scene (those of parameters()), with their time functions and rules.
  std::vector<ScalarParameter> named_values() const;
  /// Sets a parameter of the scene; a time-dependent parameter becomes constant. Throws InputError
  /// for an unknown name (the message suggests the nearest one), a driven parameter, a value out of
  /// range, a material that violates material_requirement(), and a direction of length 0. `where`:
  /// first words of messages.
  void set(const std::string& parameter, double value, const std::string& where);

  /// True if the scene has loads, constraints, stiffness fields, offsets or [[parameter]], or if
  /// the boundary is fixed at its corners only.
  bool is_sculpted() const;

  /// The prefix of messages about a location in the scene file: "FILE:LINE:COLUMN: ".
  std::string at(const SourceLocation& location) const {
    return format_location(file.string(), location);
  }
};

/// The requirement that the stiffnesses of a material violate, as text. Empty if the material is
/// valid: its elastic energy is positive, so that a minimum exists.
std::string material_requirement(const SurfaceStiffness& material);

/// True if `run`, the name of a curve of a surface, stands for the curve `line` of the scene or for
/// a part of `line`. A curve that is cut at its corners has parts named "line.1", "line.2", …
bool is_part_of(const std::string& run, const std::string& line);

// Reads scenes from TOML files (all keys: docs/scenes.md). These functions do not read the curve,
// mesh and CAD files that a scene names.

/// Reads a scene. Throws InputError ("FILE:LINE:COLUMN: found …, expected …; did you mean …?") if
/// the file is invalid.
Scene read_scene(const std::filesystem::path& file);
/// Parses a scene from text. `file` appears in messages, and relative paths are resolved against
/// its folder. `lines_required` = false accepts an unfinished scene without curves.
Scene parse_scene(const std::string& text, const std::filesystem::path& file,
                  bool lines_required = true);

}  // namespace batten
