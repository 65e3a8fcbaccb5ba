// SPDX-License-Identifier: MPL-2.0
// Regions and helpers shared by the tests of sculpting sessions.
#pragma once

#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/fem/surface_assembler.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/tests/support/reference_static_solver.h"
#include "batten/tests/support/sample_lines.h"
#include "batten/tests/support/sampling.h"

namespace batten_test {

using std::numbers::pi;

inline SkinOptions skin(double edge, double tolerance = 0) {
  SkinOptions options;
  options.edge_length = edge;
  options.tolerance = tolerance;
  return options;
}

/// A square in the plane z = 0 from the origin; its size is √2 · side.
inline RegionLayout square_layout(double edge, double side = 1) {
  SkinOptions options = skin(edge);
  options.mesher = SkinOptions::Mesher::Fan;
  return {"square", polygon_lines({{0, 0, 0}, {side, 0, 0}, {side, side, 0}, {0, side, 0}}),
          options};
}

/// Four cubic sides and a rib between two of them, all mesh-aligned.
inline RegionLayout patch_layout(double edge) {
  return {"patch", patch_with_inner_line(), skin(edge)};
}

inline std::shared_ptr<const InputCurve> circle(double z, double radius = 1,
                                                const Vec2& middle = Vec2::Zero()) {
  std::vector<Vec3> points;
  constexpr int n = 96;
  for (int i = 0; i < n; ++i)
    points.emplace_back(middle.x() + radius * std::cos(2 * pi * i / n),
                        middle.y() + radius * std::sin(2 * pi * i / n), z);
  points.push_back(points.front());
  return curve_through_points("circle", points);
}

/// Disc of radius 1 in the plane z = 0 with an embedded boundary.
inline RegionLayout disc_layout(double edge) {
  return {"disc", {{"rim", circle(0)}}, skin(edge, 1e-5)};
}

/// Tube of radius 1 between z = 0 and 2: an annular domain.
inline RegionLayout tube_layout(double edge) {
  return {"tube", {{"low", circle(0)}, {"high", circle(2)}}, skin(edge, 1e-5)};
}

inline std::vector<Vec3> door_points(const std::string& file) {
  std::ifstream in(BATTEN_SOURCE_DIR "/examples/05-door/lines/" + file);
  std::vector<Vec3> points;
  for (std::string line; std::getline(in, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    Vec3 p;
    if (numbers >> p.x() >> p.y() >> p.z()) points.push_back(p);
  }
  return points;
}

/// The door of examples/05-door, mm: outline, window curve, rib, hinge hollow, handle hole.
inline RegionLayout door_layout(double edge, double tolerance = 0.5) {
  using Role = CharacterLine::Role;
  const auto line = [](const std::string& name, const std::string& file, Role role) {
    return CharacterLine{name, curve_through_points(name, door_points(file)), role};
  };
  return {"door",
          {line("outline", "outline.csv", Role::Outline),
           line("window line", "window_line.csv", Role::Inner), line("rib", "rib.csv", Role::Inner),
           line("hinge hollow", "hinge_hollow.csv", Role::Inner),
           line("handle", "handle.csv", Role::Hole)},
          skin(edge, tolerance)};
}

inline ScalarParameter slider(const std::string& name, double value = 0) {
  ScalarParameter p;
  p.name = name;
  p.value = value;
  return p;
}

inline SessionOptions with_material(double alpha, double beta,
                                    LoadUnits units = LoadUnits::Relative) {
  SessionOptions options;
  options.material = SurfaceStiffness::isotropic(alpha, beta);
  options.units = units;
  return options;
}

/// Largest distance of corresponding dofs.
inline double difference(const Points& a, const Points& b) {
  return a.rows() == b.rows() ? (a - b).cwiseAbs().maxCoeff() : 1e300;
}

inline bool same_bits(const Points& a, const Points& b) {
  return a.rows() == b.rows() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<size_t>(a.size())) == 0;
}

inline Surface shape_of(const SculptingSession& session) {
  const ModelLayout& layout = session.layout();
  return {layout.mesh(), layout.element(), session.dofs(), layout.trim()};
}

/// Without redundant constraint equations: where curves meet, each of them fixes the point.
inline ConstraintSet independent_constraints(const ConstraintSet& set) {
  const std::vector<int> dropped = AffineReduction(set).redundant();
  ConstraintSet kept(set.dof_count());
  for (size_t r = 0; r < set.constraints().size(); ++r)
    if (std::find(dropped.begin(), dropped.end(), static_cast<int>(r)) == dropped.end())
      kept.add("line", set.constraints()[r].entries, set.constraints()[r].value);
  return kept;
}

/// Matrices of one coordinate on the domain of size 1, for relative units.
struct Matrices {
  SurfaceAssembler assembler;
  SparseMatrix K, M;
  explicit Matrices(const ModelLayout& layout,
                    const SurfaceStiffness& material = SurfaceStiffness())
      : assembler(*layout.mesh(), layout.element(), layout.trim()),
        K(assembler.stiffness(material)),
        M(assembler.mass()) {}
};

/// All modes of the free unknowns: columns φ with φᵀMφ = 1 and DᵀKD φ = λ DᵀMD φ, λ ascending.
struct Modes {
  VecX lambda;
  MatX phi, mass;
  std::vector<int> free;
  Modes(const ConstraintSet& constraints, const SparseMatrix& K, const SparseMatrix& M);
  /// Modal coordinates of x, modes × 3.
  MatX of(const Points& x) const;
};

/// One mode ρ ẍ + μ ẋ + λ x = 0 in steps of the θ scheme (constraints/theta_integrator.h).
struct ModeSteps {
  double density, damping, lambda, dt, theta;
  double x, v = 0;
  void step() {
    const double mean = (density / (theta * dt) * v - lambda * x) /
                        (density / (theta * dt) + damping + theta * dt * lambda);
    x += dt * mean;
    v = (mean - (1 - theta) * v) / theta;
  }
  /// Exact, from rest at x0.
  static double exact(double density, double damping, double lambda, double x0, double t) {
    const double decay = damping / (2 * density);
    const double omega = std::sqrt(lambda / density - decay * decay);
    return x0 * std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t));
  }
};

}  // namespace batten_test
