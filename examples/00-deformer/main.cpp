// SPDX-License-Identifier: MPL-2.0
// Mesh morphing with a form feature: bends a plate while its hole keeps its exact shape.
//
// 1. mesh: a square plate with a round hole, with rings of quads between hole and border
// 2. problem: fixed vertices, a handle, and a form feature; factored once
// 3. edits: one per mouse event, with two triangular solves each
// 4. the hole before and after; a file, and a picture if there is a display
//
// Usage: deformer [OUTPUT FOLDER]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <numbers>
#include <numeric>

#include "batten/core/geometry.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/pictures/mesh_pictures.h"
#include "batten/mesh/deform/form_feature_deformer.h"
#include "batten/mesh/features/feature_detection.h"
#include "batten/mesh/prepared_mesh.h"
#include "batten/mesh/selection.h"

namespace {

using namespace batten;

constexpr int around = 96, rings = 20;
constexpr double radius = 30, half = 100;  // mm

// 1. Node i + around·k lies on ring k; ring 0 is the hole, the last ring is the border.
ShellMesh plate() {
  ShellMesh shells;
  shells.points.resize(around * (rings + 1), 3);
  for (int k = 0; k <= rings; ++k)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around,
                   fraction = std::pow(static_cast<double>(k) / rings, 1.3);
      const Vec3 way(std::cos(angle), std::sin(angle), 0);
      const double border = half / std::max(std::abs(way.x()), std::abs(way.y()));
      shells.points.row(i + around * k) = ((1 - fraction) * radius + fraction * border) * way;
      const int next = (i + 1) % around + around * k, here = i + around * k;
      if (k < rings) shells.add_face({{here, here + around, next + around, next}});
    }
  return shells;
}

int run(const std::filesystem::path& out) {
  const ShellMesh shells = plate();
  const TriangleMesh mesh = prepare(shells).mesh;

  // 2. The left border is fixed, the right one is a handle. Two node rings at the hole are rigid.
  DeformProblem problem;
  problem.fixed = vertices_beyond_plane(mesh, {-half + 1e-6, 0, 0}, -Vec3::UnitX());
  problem.handles = {{"right", vertices_beyond_plane(mesh, {half - 1e-6, 0, 0}, Vec3::UnitX())}};
  std::vector<int> rim(around), feature(2 * around);
  std::iota(rim.begin(), rim.end(), 0);
  std::iota(feature.begin(), feature.end(), 0);
  problem.features = {{"hole", feature}};
  FormFeatureDeformer deformer(mesh, problem);

  // 3. The handle moves up and inwards, and rotates about y.
  DeformEdit edit;
  for (int step = 1; step <= 10; ++step) {
    const double turn = -80 * std::numbers::pi / 180 * step / 10;
    edit.handles = {
        {{half, 0, 0}, to_rotation_vector(Vec3::UnitY(), turn), Vec3(-50, 0, 70) * step / 10}};
    deformer.deform(edit);
  }

  // 4. Measurement and output.
  const HoleMeasure before = measure_hole(mesh.points(), rim),
                    after = measure_hole(deformer.positions(), rim);
  ShellMesh bent = shells;
  bent.points = deformer.positions();
  std::filesystem::create_directories(out);
  write_mesh(out / "bent.vtu", bent);
  MeshPicture flat, result;
  flat.shells = result.shells = &shells;
  flat.points = shells.points;
  result.points = bent.points;
  flat.mesh = result.mesh = true;
  for (int f = 0; f < shells.face_count(); ++f)
    flat.parts.push_back(f < around ? MeshPicture::Part::Feature : MeshPicture::Part::Body);
  result.parts = flat.parts;
  draw_meshes(out / "deformer.png", {flat, result}, 2, {1500, 560});
  std::printf("%d unknowns; the hole rotated by %.1f degrees\n", deformer.counts().unknowns,
              180 / std::numbers::pi * std::acos(std::clamp(before.axis.dot(after.axis), -1., 1.)));
  std::printf("radius     %.12f mm before, %.12f mm after\n", before.radius, after.radius);
  std::printf("roundness  %.1g mm, flatness %.1g mm after\n", after.roundness, after.flatness);
  std::printf("residual   %.1g of the size\n", deformer.hard_residual());
  std::printf("bent.vtu in %s\n", out.c_str());
  return std::abs(after.radius - before.radius) < 1e-10 * before.radius &&
                 deformer.hard_residual() < 1e-12
             ? 0
             : 4;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? argv[1] : "out/00-deformer");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "deformer: %s\n", e.what());
    return 1;
  }
}
