// A scene says, as data, which surface to make and what to write. read_scene.h reads scenes from
// files.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "batten/fairing/curves/primitive_curves.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/scene/scene_stress.h"
#include "batten/sculpting/loads/parameters.h"
#include "batten/skinning/surfaces/surface_model.h"
#include "batten/fairing/curvature/curvature_fairing.h"
#include "batten/fairing/curves/fair_curve.h"

namespace batten {

// [[fair]]: how the lines of a scene are faired, stage after stage (docs/scenes.md has every key).

/// One [[fair]]. It fairs whole lines or, as a local stage (a brush or a stretch), a part of the
/// curves that the stages before made.
struct FairStage {
  struct Brush {
    Vec3 at;
    double radius;
  };
  struct CurveSegment {
    Vec3 from, to;  ///< it runs between the points of the curve that are nearest to these
  };
  std::string name;
  SourceLocation location;
  std::vector<LocatedString> lines;  ///< names of lines; '*' stands for any letters; empty: all
  FairOptions options;               ///< without corners; of a local stage, the wavelength only
  /// The integral that the curve through all points makes least, instead of springs at the points.
  std::optional<CurveFunctional> minimum;
  std::optional<bool> fix_ends;              ///< not given: the kind of scene decides
  std::optional<std::vector<Vec3>> corners;  ///< places; each marks the nearest point of all lines
  std::optional<Brush> brush;
  std::optional<CurveSegment> segment;

  bool local() const { return brush || segment; }
};

/// Reads all [[fair]] of a scene, in their order. Stages without a name are called fair-1, fair-2,
/// … by their numbers. Throws InputError.
std::vector<FairStage> read_fair_stages(const TomlTable& root);

/// Calls f(name, value), with a reference to the value, for each number of the stages that can be
/// set from outside: STAGE.noise, STAGE.deviation or STAGE.wavelength. They have to be above 0.
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


/// [[line]]: one line; or [[lines]]: the curves of a file.
struct SceneLine {
  std::string name;  ///< name of a [[line]]; "": a [[lines]], whose curves have their own names
  SourceLocation location;
  std::filesystem::path file;  ///< path that can be opened; empty: the points are in the scene
  std::string unit;            ///< unit of the file's lengths; "": the scene's or the file's own
  std::vector<Vec3> points;    ///< points in the scene's unit
  std::shared_ptr<const InputCurve> curve;  ///< of a word: arc, circle, bezier, …
  std::string copy;                         ///< name of the line that this one is a copy of
  AffineTransform transform;                ///< of the copy
  std::optional<std::vector<int>> corners;  ///< of the points, stated; not given: found
  CharacterLine::Role role = CharacterLine::Role::Outline;
  CharacterLine::MeshAlignment mesh_alignment = CharacterLine::MeshAlignment::Auto;
  bool constrains_surface = true;                       ///< false, of holes: they only trim
  std::vector<LocatedString> only, skip, inner, holes;  ///< names of curves of a [[lines]]
  bool creases = false;  ///< of a CAD file: those inside of its faces are lines, too
};

/// [skin]: how the surface is made, its material, and what holds it.
struct SceneSkin {
  SkinOptions options;
  SurfaceStiffness material = SurfaceStiffness::isotropic(0, 1);
  bool isotropic_alpha = true, isotropic_beta = true;  ///< whether the scene gives one number
  LoadUnits units = LoadUnits::Relative;
  enum class FixedBoundary { Lines, Corners } boundary = FixedBoundary::Lines;
  /// The shape between the curves: what these mean (rest_shape.h), with least bending relative to it; least
  /// bending from nothing; least change of curvature; or a loft across sections.
  enum class Fair { Auto, Bending, Variation, Loft } fair = Fair::Auto;
  bool has_rest() const { return fair != Fair::Bending; }
  /// Whether another shape than that of least energy is asked for.
  bool is_faired() const { return fair == Fair::Variation || fair == Fair::Loft; }
  double strength = 1;          ///< of variation: share of the way from the bending shape
  double max_displacement = 0;  ///< of variation, in the scene's unit; 0: any
  std::vector<LocatedString>
      sections;  ///< of a loft: lines that are sides of four-cornered regions
  /// The word of the scene for `fair`.
  std::string fair_name() const;
};

/// [[target]]: a given surface that the shape of the lines is fitted to, in the place of the one that bends
/// least. Several are one target.
struct SceneTarget {
  SourceLocation location;
  std::filesystem::path file;  ///< a CAD file or a mesh
  std::string unit;            ///< of a mesh's lengths; "": the scene's
  bool cage = false;           ///< the mesh is a cage; its Catmull-Clark limit is the target
  double tolerance = 0;        ///< model units; 0: 1e-4 of the model's size
};

/// [[constraint]]: at the place of the unloaded surface that is nearest to `at` (Point, Normal,
/// Tangent), or along a line (LineNormal).
struct SceneConstraint {
  enum class Type { Point, Normal, Tangent, LineNormal };
  std::string name;
  SourceLocation location;
  Type type = Type::Point;
  Vec3 at = Vec3::Zero();
  Vec3 goal = Vec3::Zero();    ///< Point: where the surface is held; else the direction
  Vec2 along = Vec2::UnitX();  ///< Tangent: direction in (u, v)
  double range = std::numeric_limits<double>::infinity();  ///< Point: largest |goal - middle| of
                                                           ///< each coordinate, model units
  Vec3 middle = Vec3::Zero();  ///< Point: the goal that the scene states
  LocatedString line;          ///< LineNormal: the line's name
  bool keep_tangent_planes =
      false;  ///< LineNormal: whether the tangent planes stay as they are, because
              ///< the scene gives no direction
};

/// [[load]]: a load and its parameter, which is a number or a value over time.
struct SceneLoad : ScalarParameter {
  SourceLocation name_location;  ///< place of its name
  enum class Type {
    Pressure,
    Uniform,
    Gravity,
    Point,
    Line,
    PointCloudSprings,  ///< measured points that draw the surface; their feet on it slide
    AttractorSprings    ///< springs from places to points, a curve or a plane
  };
  Type type = Type::Pressure;
  Vec3 direction = Vec3::UnitZ();  ///< unit vector; not for Pressure, Scan and Pulls
  Vec3 at = Vec3::Zero();          ///< Point: place that it acts on
  SceneArea area;                  ///< Pressure, Uniform: where it acts
  LocatedString line;              ///< Line: the line's name
  std::filesystem::path file;      ///< Scan: file of its points; Pulls: `curve` as a file
  SourceLocation location;         ///< place of `file` in the scene
  std::string unit;                ///< unit of the file's numbers; "": the scene's
  Load::AttractorSprings pulls;    ///< Pulls: all but the curve
  LocatedString curve;             ///< Pulls: name of a line, or of a file
};

/// [[weight]]: a field that is added to alpha or beta.
struct SceneStiffnessField : ScalarParameter {
  SourceLocation name_location;  ///< place of its name
  StiffnessField::Kind kind = StiffnessField::Kind::Bending;
  SceneArea area;
  /// Direction in (u, v), or name of a line, along which it acts; none: in all directions.
  std::optional<std::variant<Vec2, LocatedString>> along;
};

/// [[move]]: a line that a parameter moves.
struct SceneLineOffset : ScalarParameter {
  SourceLocation name_location;  ///< place of its name
  LocatedString line;
  std::optional<Vec3> direction;  ///< none: along the surface's normal
  /// Part of the line's length, at each end, over which it fades; none: a quarter where an end lies
  /// on a line that does not move, else 0.
  std::optional<double> fade;
};

/// One entry of drives = [...] of a [[parameter]]: driven = offset + factor · of, summed over all
/// rules that drive the same parameter.
struct SceneRule {
  std::string of, driven;  ///< names of the two parameters
  SourceLocation location;
  double factor = 1;
  std::optional<double> offset;  ///< not given: the driven parameter's own value
};

/// [motion]: density, damping and time scheme of a motion.
struct SceneMotion {
  double density = 1, damping = 1, theta = 1;
};

/// [[picture]], and the picture of a [[sweep]].
struct ScenePicture {
  std::string file;
  PictureScene look;  ///< what is drawn, without the regions
  PictureSize size;
};

/// [[sweep]]: one picture with one panel for each value of a parameter.
struct SceneSweep {
  std::string parameter;
  std::vector<double> values;
  int columns = 0;       ///< panels in a row; 0: the sheet is as square as it can be
  ScenePicture picture;  ///< the sheet; each panel has look.title and the value as its title
};

/// How the surfaces between the curves of a scene are found and joined: keys of [skin], [[region]]
/// and [[join]].
struct SceneNetwork {
  SourceLocation location;  ///< of [skin]
  double tolerance = 0;     ///< distance within which lines meet, model units; 0: NetworkOptions'
  double tangent_angle = NetworkOptions{}.tangent_angle;              ///< degrees
  int max_faces_per_edge = RegionSearchOptions{}.max_faces_per_edge;  ///< most regions at one line
  double crease_angle = ModelOptions{}.crease_angle_deg;              ///< degrees
  double join_tolerance = ModelOptions{}.join_tolerance_deg;          ///< degrees
  /// The lines are those of one half: the model is mirrored in the plane through the origin at right
  /// angles to this axis, 0, 1, 2 for x, y, z.
  std::optional<int> symmetry;
  bool fair_noisy_lines = true;  ///< without any [[fair]], lines that tremble are faired
  std::vector<RegionSpec> regions;
  std::vector<JoinSpec> joins;
};

/// A number of a scene that can be set from outside, and its range.
struct Parameter {
  std::string name;
  double value, min, max;
};

/// A scene as data. Names are looked up when the model is made.
struct Scene {
  std::filesystem::path file;  ///< empty for a scene made by a program
  std::string name = "surface", unit = "mm";
  std::vector<std::string> notes;  ///< on what was written in an older way, for the summary
  std::vector<SceneLine> lines;
  std::vector<FairStage> fairing;  ///< [[fair]]: how lines are faired before they are skinned
  SceneNetwork network;
  SceneSkin skin;
  std::vector<SceneTarget> targets;
  std::vector<SceneConstraint> constraints;
  std::vector<SceneLoad> loads;
  std::vector<SceneStiffnessField> weights;
  std::vector<SceneLineOffset> moves;
  std::vector<ScalarParameter> sliders;  ///< [[parameter]]
  std::vector<SceneRule> rules;          ///< parameters that they drive
  SceneMotion motion;
  std::optional<SceneStress> stress;
  std::string step, vtu, vtp, calculix;  ///< [output]: file names, "" for none
  enum class StepForm {
    Auto,  ///< Face; Exact where that misses step_tolerance, of one region of up to 10,000
           ///< triangles that nothing cuts
    Face,  ///< one B-spline face for each region, within step_tolerance
    Exact  ///< three faces for each triangle
  } step_form = StepForm::Auto;
  bool step_lines = false;        ///< the STEP file holds the lines as curves beside the faces
  bool step_ap242 = false;        ///< it is AP242 instead of AP214
  double step_tolerance = 0;      ///< model units; 0: 1e-4 of the region's size
  std::filesystem::path compare;  ///< [compare]: a CAD file; distances from its faces are measured
  std::vector<ScenePicture> pictures;
  std::vector<SceneSweep> sweeps;

  /// All parameters: loads, weights, moves and [[parameter]] by their names; coordinates of
  /// constraints as name.x, name.y, name.z; alpha and beta, or alpha_uu, alpha_uv, alpha_vv,
  /// beta_uu, beta_uv, beta_vv where the scene gives three numbers; noises, deviations and wavelengths of
  /// [[fair]] as STAGE.noise, STAGE.deviation, STAGE.wavelength. A value over time is that at time 0; a driven
  /// one follows its rules.
  std::vector<Parameter> parameters() const;
  /// The same parameters with their values over time and their rules.
  std::vector<ScalarParameter> named_values() const;
  /// Sets a parameter; a value over time becomes a constant. Throws InputError, beginning with
  /// `where`: an unknown name (the nearest is offered), a parameter that is driven, a value out of
  /// its range, a material that material_requirement() refuses, a direction of length 0.
  void set(const std::string& parameter, double value, const std::string& where);

  /// Whether the scene has anything but lines that acts on the surface.
  bool is_sculpted() const;

  /// The place as "FILE:LINE:COLUMN: ", with which messages begin.
  std::string at(const SourceLocation& location) const {
    return format_location(file.string(), location);
  }
};

/// What a material has to satisfy, in words, so that energies with it have a minimum; "" when they
/// have one.
std::string material_requirement(const SurfaceStiffness& material);

/// Whether the line `run` of a layout is, or is a part of, the line `line` of a scene. The parts of
/// a line that was cut at its corners are called "line.1", "line.2", …
bool is_part_of(const std::string& run, const std::string& line);

}  // namespace batten
