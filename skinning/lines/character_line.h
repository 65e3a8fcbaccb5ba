// Lines that carry the design of a surface.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batten/fairing/input_curve.h"

namespace batten {

/// A C1 cubic curve that is used for a line as it is, so that the regions on both sides carry the
/// same one: it is not fitted again, and their meshes have vertices on it at the same places.
struct PrescribedCurve {
  HermiteCurve curve;  ///< over the direction of the line; its parameter runs evenly
  /// Parameters of the mesh's vertices on it, for a region that has it fitted: ascending, from
  /// start to end, with the nodes of the curve among them.
  std::vector<double> vertices;
};

/// A line, as the user gives it.
struct CharacterLine {
  enum class Role {
    Outline,  ///< part of the loop around the region, or of one of the two loops of a ring
    Hole,     ///< part of a loop around a hole
    Inner     ///< runs across the region, or inside of it
  };
  /// How the surface carries the line (docs/theory/domains.md).
  enum class MeshAlignment {
    Auto,         ///< fitted where the domain can have it as a straight run, otherwise embedded
    EdgeAligned,  ///< on a straight run of element edges: the surface is exactly on the line
    Embedded      ///< across the elements: held at points, the gap between them is measured
  };
  std::string name;
  std::shared_ptr<const InputCurve> curve;
  Role role = Role::Outline;
  MeshAlignment mesh_alignment = MeshAlignment::Auto;
  /// The given curve of an outline or hole line, or null. Either all lines of a loop have one or
  /// none has. Two of them that meet make a corner unless their slopes are the same vector.
  std::shared_ptr<const PrescribedCurve> prescribed = {};
  /// False, of a hole line: it trims the surface and does not hold it. Its place on the surface is
  /// nearest to where it was drawn; where that is in space, the surface says.
  bool constrains_surface = true;
};

}  // namespace batten
