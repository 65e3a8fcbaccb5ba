// SPDX-License-Identifier: MPL-2.0
// A shell as the contents of a CalculiX (ccx) input deck.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"

namespace batten {

/// Exception for a support, load or section that a CalculiX deck cannot represent.
struct DeckLimitError : InputError {
  using InputError::InputError;
};

/// A linear shell problem on a model of one or more faces. Any consistent system of units
/// can be used (for example mm, N and MPa, with the density in t/mm³ and gravity in mm/s²).
struct ShellDeck {
  /// Shell element type of the deck.
  enum class Element {
    S6,  ///< six-node triangles, one per triangle of the surface mesh
    S3,  ///< three-node triangles, four per triangle of the surface mesh
    S8R  ///< eight-node quadrilaterals, three per triangle of the surface mesh
  };
  /// A support (displacement boundary condition) on a curve, an area or at a point.
  struct Support {
    /// Rotations that a support prevents, in addition to `rotation_axes`.
    enum class Rotations {
      None,
      Tangent  ///< rotation about the tangent of `line`
    };
    std::string line;  ///< name of a curve of the model; "": the support is on an area
    /// Directions along which the displacement is prescribed.
    std::vector<Vec3> directions = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    std::vector<Vec3> rotation_axes = {};  ///< axes about which nodes do not rotate
    Rotations rotations = Rotations::None;
    std::string region = {};         ///< name of the face of an area support; "": all faces
    std::optional<Box3> box = {};    ///< if set, only nodes inside this box are supported
    std::optional<Vec3> point = {};  ///< if set, only the node nearest to this point
    /// Prescribed displacement; only its components along `directions` are used.
    Vec3 displacement = Vec3::Zero();
    /// Base vectors (columns) to which all vectors of the support refer at a point, such as the
    /// radial, hoop and axial directions; empty: x, y and z.
    std::function<Mat3(const Vec3& x)> axes = {};

    static Support pinned(const std::string& line) { return {line}; }
    /// Without rotations about any axis.
    static Support clamped(const std::string& line) { return {line, all_axes(), all_axes()}; }
    static std::vector<Vec3> all_axes() { return {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}; }
  };
  /// Springs between a curve, an area or a point and the ground.
  struct Spring {
    std::string line;  ///< name of a curve; "": the springs are on an area or at a point
    std::string region = {};
    std::optional<Box3> box = {};
    std::optional<Vec3> point = {};
    /// Stiffness along x, y, z: force per displacement at a point, per length, or per area.
    Vec3 stiffness = Vec3::Zero();
    double foundation = 0;  ///< stiffness along the normal, per area
  };
  struct PointForce {
    Vec3 at;  ///< point of application; the force acts on the nearest node
    Vec3 force;
  };
  struct PointMass {
    Vec3 at;
    double mass = 0;
  };

  struct Pressure {
    std::string region;  ///< name of a face of the model
    /// Force per unit area; a positive pressure acts along the normal x_u × x_v of the face.
    double pressure = 0;
  };
  /// Thickness of one face of the model.
  struct Thickness {
    std::string region;
    double thickness = 0;
  };
  /// A point of a curve, with the tangent in the direction of the curve and the unit vector in the
  /// tangent plane of one adjacent face that points away from it.
  struct CurvePoint {
    Vec3 x, tangent, outwards;
  };
  /// Force and moment per unit length along a curve, optionally only inside a box.
  struct LineLoad {
    std::string line;
    std::function<Vec3(const CurvePoint&at)> force = {}, moment = {};  ///< empty: none
    std::optional<Box3> box = {};

    static LineLoad constant(const std::string& line, const Vec3& per_length) {
      return {line, [per_length](const CurvePoint&) { return per_length; }};
    }
  };
  /// A force and a moment about its centroid, spread evenly over a curve or an area (spread_load()).
  struct SpreadLoad {
    std::vector<std::string> lines;  ///< names of curves; empty: the load is on an area
    std::string region;
    std::optional<Box3> box;
    Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  };
  /// Centrifugal load of a rotation about an axis through `origin`.
  struct Rotation {
    double angular_velocity = 0;  ///< radians per time
    Vec3 axis = Vec3::UnitZ(), origin = Vec3::Zero();
  };
  /// An orthotropic layer; the angle, in radians, counts from `along` towards the cross product of
  /// the normal and `along`.
  struct Ply {
    double thickness = 0, angle = 0;
    double young = 0, young_across = 0, poisson = 0, shear = 0;
    double expansion = 0, expansion_across = 0, density = 0;
  };
  /// What the deck computes.
  enum class Analysis {
    Static,
    Buckling,    ///< `count` buckling factors of the loads
    Frequencies  ///< `count` natural frequencies; loads are left out
  };

  Element element = Element::S6;
  Analysis analysis = Analysis::Static;
  int count = 1;
  /// Factor of all loads and prescribed displacements. The eigenvalue solver of ccx is accurate for
  /// buckling factors a little above 1 only: it found 227 for 177, but 1.760 for 1.770.
  double load_factor = 1;
  double thickness = 0, young = 0, poisson = 0;
  std::vector<Ply> plies;  ///< from the bottom to the top, instead of the material; S6 and S8R only
  Vec3 along = Vec3::UnitX();  ///< direction, projected onto the surface, from which angles count
  std::vector<Thickness> thicknesses;  ///< faces whose thickness differs from `thickness`
  double density = 0;                  ///< mass density; 0: none
  std::string units;              ///< names of the units for a comment in the deck: "mm, N, MPa"
  std::vector<Support> supports;  ///< at least one is required, but for frequencies
  std::vector<Spring> springs;
  std::vector<PointMass> masses;
  double pressure = 0;  ///< force per unit area on all faces, positive along the normals
  std::vector<Pressure> pressures;  ///< pressures on single faces, added to `pressure`
  /// Force per unit area at the point x, with unit normal n, of the face `region`; empty: none.
  std::function<Vec3(const std::string& region, const Vec3& x, const Vec3& n)> area_force;
  std::vector<LineLoad> line_loads;
  std::vector<SpreadLoad> spread_loads;
  std::vector<PointForce> point_forces;
  Vec3 gravity = Vec3::Zero();  ///< gravitational acceleration
  std::vector<Rotation> rotations;
  double expansion = 0;  ///< thermal expansion per degree
  /// Change of temperature at a point: in the middle of the shell, and from bottom to top; empty: none.
  std::function<std::array<double, 2>(const Vec3& x)> temperature;
};

}  // namespace batten
