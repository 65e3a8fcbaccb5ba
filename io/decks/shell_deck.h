// Writes a linear static shell problem as a CalculiX (ccx) input deck.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/eigen.h"
#include "batten/core/geometry.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// A linear static shell problem on a model of one or more faces. The units are up to the user
/// but must be consistent (mm, N and MPa need the density in t/mm³ and gravity in mm/s²).
struct ShellDeck {
  /// Shell element type of the deck.
  enum class Element {
    S6,  ///< six-node triangles
    S3,  ///< each triangle is split into four three-node triangles
    S8R  ///< each triangle is split into three eight-node quads
  };
  /// Support (displacement boundary condition) on a curve or on an area.
  struct Support {
    enum class Kind {
      Pinned,  ///< no displacement
      Clamped  ///< no displacement, no rotation
    };
    std::string line;  ///< name of a curve of the model; "": the support is on an area
    Kind kind = Kind::Pinned;
    std::string region = {};       ///< face of an area support; "": all faces
    std::optional<Box3> box = {};  ///< restricts the support to nodes in this box
    /// Constrained components x, y, z of the displacement.
    std::array<bool, 3> constrained = {true, true, true};
    /// Prescribed value of the constrained components.
    Vec3 displacement = Vec3::Zero();
  };
  struct PointForce {
    Vec3 at;  ///< applied at the closest node
    Vec3 force;
  };

  struct Pressure {
    std::string region;   ///< name of a face of the model
    double pressure = 0;  ///< force per area; positive acts along the face's x_u × x_v
  };
  /// Thickness of one face.
  struct Thickness {
    std::string region;
    double thickness = 0;
  };
  /// Force per length along a curve, optionally only inside a box.
  struct LineForce {
    std::string line;
    Vec3 per_length;
    std::optional<Box3> box;
  };

  Element element = Element::S6;
  double thickness = 0, young = 0, poisson = 0;
  std::vector<Thickness> thicknesses;  ///< override `thickness` for individual faces
  double density = 0;                  ///< needed for gravity only
  std::string units;                   ///< units, for a comment in the deck: "mm, N, MPa"
  std::vector<Support> supports;       ///< at least one
  double pressure = 0;              ///< force per area on all faces; positive acts along x_u × x_v
  std::vector<Pressure> pressures;  ///< additional pressures on individual faces
  /// Force per area at point x with normal n in the named face; empty: no such force.
  std::function<Vec3(const std::string& region, const Vec3& x, const Vec3& n)> area_force;
  std::vector<LineForce> line_forces;
  std::vector<PointForce> point_forces;
  Vec3 gravity = Vec3::Zero();  ///< acceleration
};

// Writes skinned faces as shell elements.

/// Writes `path` (.inp) for `ccx -i <path without .inp>`. The file is written atomically.
///
/// Each element becomes one S6 triangle (or is split, for other types). Its nodes are the vertices
/// and the surface points at the parametric midpoints of the edges. The surface is the mid-surface
/// of the shell; normals have the direction of each face's x_u × x_v. In a deck with one face, node
/// numbers are mesh vertex + 1, then vertex_count + edge + 1; element numbers are triangle + 1. The
/// elements of a face with embedded curves are its quadratic_elements(): they cover the face inside
/// its boundary and have nodes on its curves.
///
/// Several faces form one shell (model_elements()). They share the nodes on their common curves.
/// These lie where a face to which the curve is edge-aligned has them. If curves meet at a point,
/// there is one node. Nodes and elements are numbered face by face; a shared node is numbered at
/// its first occurrence. If faces meet at a crease, ccx joins the thick elements of both sides
/// rigidly. Loads act on all faces.
///
/// The deck has the node set NALL, the element set ALL, and one node set for each curve of the
/// model (including boundaries of holes, and ribs). With several faces it also has one element set
/// per face. Names of sets are in capitals, with '_' for every character other than letters and
/// digits, the prefix CURVE_ or FACE_ if they do not begin with a letter, and a number appended if
/// two would be equal. Area and line forces become consistent nodal loads, with the quadratic shape
/// functions on the true surface. Supports in boxes have node sets SUPPORT_1, …. Numbers have the
/// 20 characters that ccx reads, so their relative error is at most 1e-13.
///
/// Throws InputError: no face; thickness or Young's modulus not above 0; Poisson's ratio not in
/// (-1, 0.5); a density below 0, or gravity without density; non-finite numbers; no support, or one
/// without nodes; an unknown curve or face (with the most similar name); the errors of
/// model_elements(); a file that cannot be written.
void write_calculix(const std::filesystem::path& path,
                    const std::vector<const SkinnedRegion*>& regions, const ShellDeck& deck);

}  // namespace batten
