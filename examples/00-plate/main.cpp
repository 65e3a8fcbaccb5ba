// SPDX-License-Identifier: MPL-2.0
// A clamped plate under pressure: the nine steps that the kernel performs for every surface.
//
// A square plate with side a = 1 m is clamped along its boundary and loaded by a pressure q. Its
// deflection w minimises the energy  ½ ∬ D (w_uu² + 2 w_uv² + w_vv²) du dv - ∬ q w du dv.  The
// series solution of [Timoshenko1959] is w = 0.00126532 q a⁴ / D at the centre, with a moment
// D w_nn = 0.0513 q a² at the middle of a side.
//
// Usage: plate [OUTPUT FOLDER] [SQUARES PER SIDE]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/errors.h"
#include "batten/fem/surface.h"
#include "batten/fem/surface_assembler.h"
#include "batten/io/pictures/pictures.h"
#include "batten/io/vtk/vtk_files.h"

namespace {

using namespace batten;

int run(const std::filesystem::path& out, int squares) {
  const double E = 210e9, nu = 0.3, thickness = 0.005, q = 1000;  // N/m², -, m, N/m²: steel
  const double D = E * std::pow(thickness, 3) / (12 * (1 - nu * nu));

  // 1. Mesh: u and v are in metres. An even number of squares puts a vertex at the centre.
  const auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(squares));

  // 2. Dofs: x, x_u, x_v at each vertex and x_n at each edge; x, y and z share the numbering.
  const DofMap dofs(*mesh);

  // 3. K and F of the energy ½ xᵀ K x - Fᵀ x. The pressure is along z.
  const SurfaceAssembler assembler(*mesh, TriangleElement::HCT);
  const SparseMatrix K = assembler.stiffness(SurfaceStiffness::isotropic(0, D));
  const Points F = assembler.load(Vec3(0, 0, q));

  // 4. Constraints: the boundary keeps its position (u, v, 0) and slopes at vertices and midpoints.
  ConstraintSet rim(dofs.count());
  for (int e = 0; e < mesh->edge_count(); ++e) {
    if (!mesh->edges()[e].boundary()) continue;
    const Vec2 n = mesh->edge_normal(e);
    rim.fix("rim", dofs.edge(e), {n.x(), n.y(), 0});
    const int v = mesh->edges()[e].low, w = mesh->edges()[e].high;
    for (const int end : {v, w}) {  // vertices come twice; redundant constraints are dropped
      rim.fix("rim", dofs.vertex(end), {mesh->vertices()[end].x(), mesh->vertices()[end].y(), 0});
      rim.fix("rim", dofs.vertex(end, 1), Vec3::UnitX());
      rim.fix("rim", dofs.vertex(end, 2), Vec3::UnitY());
    }
  }

  // 5. D and d0: every x that satisfies the constraints is D y + d0, with free unknowns y.
  const AffineReduction reduction(rim);
  const SparseMatrix reduced = reduction.reduce(K);

  // 6. Factorization: once for all loads.
  SparseCholesky cholesky;
  cholesky.analyze(reduced);
  if (!cholesky.factorize(reduced)) throw NoSolutionError(cholesky.message());

  // 7. Solve: two triangular solves for x, y and z together.
  MatX y = reduction.reduce_load(K, F);
  cholesky.solve_in_place(y);

  // 8. Expand: the dofs of the whole plate define a C1 surface, which can be evaluated anywhere.
  const SkinnedRegion plate{"plate", {mesh, TriangleElement::HCT, reduction.expand(y)}, {}, 1};
  const double w = plate.surface.position(plate.surface.locate({0.5, 0.5})).z();
  const double moment = D * plate.surface.jet(plate.surface.locate({0.5, 0})).x_vv.z();

  // 9. Write: a file for ParaView, and a picture.
  std::filesystem::create_directories(out);
  write_vtp(out / "plate.vtp", {&plate});
  Points drawn = plate.surface.dofs();
  drawn.col(2) *= 0.15 / w;
  const SkinnedRegion bent{"plate", {mesh, TriangleElement::HCT, drawn}, {}, 1};
  PictureScene picture;
  picture.regions = {&bent};
  picture.contours = 12;
  picture.mesh = true;
  picture.elevation = 25;
  draw_picture(out / "plate.png", picture, {1400, 700});

  const double closed_w = 0.00126532 * q / D, closed_moment = 0.0513 * q;
  std::printf("%d triangles, %d free unknowns\n", mesh->triangle_count(), reduction.free_count());
  std::printf("deflection in the middle  %.4g mm, closed form %.4g mm\n", 1e3 * w, 1e3 * closed_w);
  std::printf("moment at the boundary    %.4g N, closed form %.4g N\n", moment, closed_moment);
  std::printf("constraint residual       %.1g m\n", rim.max_residual(plate.surface.dofs()));
  std::printf("plate.vtp in              %s\n", out.c_str());
  return std::abs(w / closed_w - 1) < 0.002 && std::abs(moment / closed_moment - 1) < 0.05 ? 0 : 4;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? argv[1] : "out/00-plate", argc > 2 ? std::atoi(argv[2]) : 16);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "plate: %s\n", e.what());
    return 1;
  }
}
