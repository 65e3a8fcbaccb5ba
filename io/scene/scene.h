// Scenes: what to make. read_scene.h makes them from files.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/files/toml_table.h"
#include "batten/io/pictures/image.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/scene/fair_stages.h"
#include "batten/sculpting/loads/loads.h"
#include "batten/sculpting/loads/parameters.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten {

/// [[line]] or [[lines]].
struct SceneLine {
  std::string name;  ///< of [[line]]; "": all curves of the file, under their own names
  FilePlace place;
  std::filesystem::path file;  ///< ready to open; empty: the points are in the scene
  std::string unit;            ///< of the file's lengths; "": the scene's, or what the file says
  std::vector<Vec3> points;    ///< scene unit
  bool bezier = false;         ///< the points are four Bézier control points
  CharacterLine::Role role = CharacterLine::Role::Outline;
  CharacterLine::Treatment treatment = CharacterLine::Treatment::Auto;
  std::vector<PlacedWord> only, skip, inner, holes;  ///< of [[lines]]: names of its curves
};

/// [skin]
struct SceneSkin {
  SkinOptions options;
  SurfaceStiffness material = SurfaceStiffness::isotropic(0, 1);
  bool isotropic_alpha = true, isotropic_beta = true;  ///< written as one number
  LoadUnits units = LoadUnits::Relative;
  enum class Hold { Lines, Corners } hold = Hold::Lines;
};

/// [[constraint]]: at the point (Point) or the mesh vertex (Normal, Tangent) of the unloaded
/// surface that is nearest to `at`, or along a line (LineNormal).
struct SceneConstraint {
  enum class Type { Point, Normal, Tangent, LineNormal };
  std::string name;
  FilePlace place;
  Type type = Type::Point;
  Vec3 at = Vec3::Zero();
  Vec3 goal = Vec3::Zero();    ///< Point: where it goes; else the direction
  Vec2 along = Vec2::UnitX();  ///< Tangent: direction in (u, v)
  double range = std::numeric_limits<double>::infinity();  ///< Point: of each coordinate of goal
  Vec3 middle = Vec3::Zero();  ///< Point: goal as the scene says it, the middle of that range
  PlacedWord line;             ///< LineNormal
  bool as_it_is = false;       ///< LineNormal: no direction was given
};

/// Where a load or weight acts: `near` a line, or as painted; in the regions that are named.
struct SceneArea {
  Area area;                        ///< its regions are not set
  PlacedWord line;                  ///< of `near`
  std::vector<PlacedWord> regions;  ///< none: all
};

/// [[load]]; its value is a number or one over time.
struct SceneLoad : NamedValue {
  FilePlace named;  ///< where its name stands
  enum class Type {
    Pressure,
    Uniform,
    Gravity,
    Point,
    Line,
    Scan,  ///< measured points that draw the surface; their feet on it slide
    Pulls  ///< springs from places to points, a curve or a plane
  };
  Type type = Type::Pressure;
  Vec3 direction = Vec3::UnitZ();  ///< unit vector; not for Pressure, Scan and Pulls
  Vec3 at = Vec3::Zero();          ///< Point
  SceneArea area;                  ///< Pressure, Uniform
  PlacedWord line;                 ///< Line
  std::filesystem::path file;      ///< Scan: of its points; Pulls: of their curve, if it is one
  FilePlace place;                 ///< of `file`
  std::string unit;                ///< of the file's numbers; "": the scene's
  Load::Pulls pulls;               ///< Pulls; without the curve
  PlacedWord curve;                ///< Pulls: a line's name, or a file
};

/// [[weight]]: is added to alpha or beta.
struct SceneWeight : NamedValue {
  FilePlace named;
  WeightField::Kind kind = WeightField::Kind::Bending;
  SceneArea area;
  std::optional<std::variant<Vec2, PlacedWord>> along;  ///< direction of (u, v), or a line
};

/// [[move]]: a line that a parameter moves.
struct SceneMove : NamedValue {
  FilePlace named;
  PlacedWord line;
  std::optional<Vec3> direction;
  double fade = 0;
};

/// One entry of drives = [...] of a [[parameter]].
struct SceneRule {
  std::string of, driven;
  FilePlace place;
  double factor = 1;
  std::optional<double> offset;  ///< not given: the driven parameter's own value
};

/// [motion]
struct SceneMotion {
  double density = 1, damping = 1, theta = 1;
};

/// [stress]: shell, material and supports of the CalculiX deck.
struct SceneStress {
  struct Support {
    PlacedWord line;
    bool clamped = true;  ///< else pinned: rotations stay free
  };
  struct Pressure {
    PlacedWord region;
    double pressure = 0;
  };
  double thickness = 0, young = 0, poisson = 0, density = 0, pressure = 0;
  std::vector<Pressure> pressures;  ///< on single regions of a network, beside `pressure` on all
  Vec3 gravity = Vec3::Zero();
  std::vector<Support> supports;
};

/// [[picture]], and the look of a [[sweep]].
struct ScenePicture {
  std::string file;
  PictureScene look;  ///< its regions are not set
  PictureSize size;
};

/// [[sweep]]: one picture with one panel for each value of a parameter.
struct SceneSweep {
  std::string parameter;
  std::vector<double> values;
  int columns = 0;       ///< 0: as square as it can be
  ScenePicture picture;  ///< look.title is that of the panels; the value is put behind it
};

/// [network], [[region]], [[join]]: the lines are one network, and all its surfaces are made.
struct SceneNetwork {
  FilePlace place;
  double tolerance = 0;  ///< where lines meet, model units; 0: NetworkOptions'
  double straight_angle = NetworkOptions{}.straight_angle;    ///< degrees
  int most_at_line = RegionOptions{}.most_at_arc;             ///< regions
  double smooth_below = ModelOptions{}.smooth_below_deg;      ///< degrees
  double join_tolerance = ModelOptions{}.join_tolerance_deg;  ///< degrees
  std::vector<RegionWord> regions;
  std::vector<JoinWord> joins;
};

/// A number of a scene that can be set from outside.
struct Parameter {
  std::string name;
  double value, min, max;
};

struct Scene {
  std::filesystem::path file;  ///< empty for a scene made by a program
  std::string name = "surface", unit = "mm";
  std::vector<SceneLine> lines;
  std::vector<FairStage> fairing;  ///< [[fair]]: what happens to the lines before they are skinned
  std::optional<SceneNetwork> network;  ///< then the model has all regions between the lines
  SceneSkin skin;
  std::vector<SceneConstraint> constraints;
  std::vector<SceneLoad> loads;
  std::vector<SceneWeight> weights;
  std::vector<SceneMove> moves;
  std::vector<NamedValue> sliders;  ///< [[parameter]]
  std::vector<SceneRule> rules;     ///< what these drive
  SceneMotion motion;
  std::optional<SceneStress> stress;
  std::string step, vtu, vtp, calculix;  ///< [output]: file names, "" for none
  enum class StepForm {
    Auto,  ///< exact where nothing embedded bounds the surface and the file stays small, else face
    Face,  ///< one B-spline face a region, within step_tolerance
    Exact  ///< three faces a triangle
  } step_form = StepForm::Auto;
  double step_tolerance = 0;      ///< model units; 0: 1e-4 of the region's size
  std::filesystem::path compare;  ///< [compare]: a CAD file whose faces to measure against
  std::vector<ScenePicture> pictures;
  std::vector<SceneSweep> sweeps;

  /// Loads, weights, moves and [[parameter]] by their names; coordinates of constraints as name.x,
  /// name.y, name.z; alpha and beta, or alpha_uu, alpha_uv, alpha_vv, beta_uu, beta_uv, beta_vv
  /// where the scene gives three numbers; deviations and wavelengths of [[fair]] as
  /// STAGE.deviation, STAGE.wavelength. Values over time: at time 0; driven ones by their rules.
  std::vector<Parameter> parameters() const;
  /// The same with their moments and rules.
  std::vector<NamedValue> named_values() const;
  /// A value over time becomes one that stands. Throws InputError, beginning with `where`: an
  /// unknown name (the nearest is offered), one that is driven, a value out of its range, a
  /// material that is not one.
  void set(const std::string& parameter, double value, const std::string& where);

  /// Whether anything but its lines acts on the surface.
  bool is_sculpted() const;

  /// "FILE:LINE:COLUMN: "
  std::string at(const FilePlace& place) const { return place_prefix(file.string(), place); }
};

/// "" when energies with this material have a minimum, else what is expected of it.
std::string expected_of(const SurfaceStiffness& material);

/// Whether a line of a layout is this line of a scene: one that was cut at its corners is there as
/// "name.1", "name.2", …
bool is_part_of(const std::string& run, const std::string& line);

}  // namespace batten
