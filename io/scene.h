// Scenes: what to make, in one small TOML file (docs/scenes.md has every key). Big data stays in
// its own files beside it; this reads the scene only, not those files.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "batten/io/fair_stages.h"
#include "batten/io/pictures.h"
#include "batten/io/toml_table.h"
#include "batten/sculpting/static_sculpt.h"

namespace batten {

/// [[line]] or [[lines]].
struct SceneLine {
  std::string name;  ///< of [[line]]; "": all curves of the file, under their own names
  Place place;
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
/// surface that is nearest to `at`.
struct SceneConstraint {
  enum class Type { Point, Normal, Tangent };
  std::string name;
  Place place;
  Type type = Type::Point;
  Vec3 at = Vec3::Zero();
  Vec3 goal = Vec3::Zero();    ///< Point: where it goes; else the direction
  Vec2 along = Vec2::UnitX();  ///< Tangent: direction in (u, v)
  double range = std::numeric_limits<double>::infinity();  ///< Point: of each coordinate of goal
  Vec3 middle = Vec3::Zero();  ///< Point: goal as the scene says it, the middle of that range
};

/// [[load]]
struct SceneLoad {
  enum class Type { Pressure, Uniform, Point, Springs };
  std::string name;
  Type type = Type::Pressure;
  double value = 0;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  Vec3 direction = Vec3::UnitZ();  ///< unit vector; not for Pressure
  Vec3 at = Vec3::Zero();          ///< Point
  std::filesystem::path file;      ///< Springs: of their points
  Place place;                     ///< of `file`
  std::string unit;                ///< of the file's numbers; "": the scene's
  /// `points`: of Springs, model units.
  Load load(std::vector<Vec3> points = {}) const;
};

/// [stress]: shell, material and supports of the CalculiX deck.
struct SceneStress {
  struct Support {
    PlacedWord line;
    bool clamped = true;  ///< else pinned: rotations stay free
  };
  double thickness = 0, young = 0, poisson = 0, density = 0, pressure = 0;
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
  SceneSkin skin;
  std::vector<SceneConstraint> constraints;
  std::vector<SceneLoad> loads;
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

  /// Loads by their names; coordinates of constraints as name.x, name.y, name.z; alpha and beta, or
  /// alpha_uu, alpha_uv, alpha_vv, beta_uu, beta_uv, beta_vv where the scene gives three numbers;
  /// deviations and wavelengths of [[fair]] as STAGE.deviation, STAGE.wavelength.
  std::vector<Parameter> parameters() const;
  /// Throws InputError, beginning with `where`: an unknown name (the nearest is offered), a value
  /// out of its range, a material that is not one.
  void set(const std::string& parameter, double value, const std::string& where);

  /// "FILE:LINE:COLUMN: "
  std::string at(const Place& place) const { return place_prefix(file.string(), place); }
};

/// Throws InputError: "FILE:LINE:COLUMN: found …, expected …; did you mean …?"
Scene read_scene(const std::filesystem::path& file);
/// The same from a text; `file` is what messages call it and where its files are looked for.
Scene parse_scene(const std::string& text, const std::filesystem::path& file);

/// Length units: mm, cm, m, in, ft.
const std::vector<std::string>& length_units();
/// Throws InputError for another word.
double unit_in_metres(const std::string& unit);

}  // namespace batten
