// SPDX-License-Identifier: MPL-2.0
// Faces with embedded curves: time per phase, the STEP file, and random curves.
// A door panel (examples/05-door) from its curves to the solved shape, phase by phase, on three
// grids; its one-face STEP file at three tolerances, compared with OpenCASCADE's filling of the
// same curves; and 2,000 outlines with holes and ribs, to find surfaces that miss a curve without a
// message.
#include <unistd.h>

#include <array>
#include <cmath>
#include <exception>
#include <filesystem>
#include <map>

#include "batten/constraints/affine_reduction.h"
#include "batten/constraints/constrained_solver.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/surface_assembler.h"
#include "batten/fem/triangle_locator.h"
#include "batten/io/lines/cad_lines.h"
#include "batten/io/scene/scene.h"
#include "batten/io/step/step.h"
#include "batten/scenes/lines/scene_lines.h"
#include "batten/scenes/shapes/solved_shape.h"
#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/domains/domain_input.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/tests/support/random_outlines.h"
#include "bench.h"
#include "occ_filling.h"

namespace {

using namespace batten;
using namespace batten::bench;

struct Grid {
  std::string name;
  double edge_length, tolerance;  ///< mm
  int rounds;
};
// The tolerance is coarse enough for the grid: no triangle is bisected.
const std::vector<Grid> grids = {{"2k", 27, 0.1, 9}, {"10k", 11, 0.1, 9}, {"50k", 4.9, 0.1, 3}};

enum Phase {
  Mesh,
  CutCells,
  LocatePoints,
  BuildConstraints,
  Assemble,
  Eliminate,
  Reduce,
  Analyse,
  Factor,
  Solve,
  Evaluate,
  phases
};
const std::array<const char*, phases> phase_names = {
    "curves + mesh", "trim",    "points on curves", "constraints", "assembly",   "elimination",
    "reduce",        "analyse", "factor",           "solve",       "evaluation",
};

// The steps of RegionLayout and sculpt(), each once: a solved shape on a grid without refinement.
struct SolvePhases {
  std::array<double, phases> seconds{};
  RegionGeometry geometry;
  std::shared_ptr<Surface> surface;
  double gap = 0, worst_residual = 0;
  int rows = 0, free = 0, cut_triangles = 0;
  long factor_entries = 0;
  double ties = 0;  ///< entries of the reduced matrix relative to those of K
};

SolvePhases path(const std::vector<CharacterLine>& lines, const SkinOptions& options, double size) {
  SolvePhases p;
  const auto timed = [&](Phase phase, const auto& work) {
    p.seconds[static_cast<size_t>(phase)] += cpu_seconds_of(work);
  };
  const DomainInput task{options, size, std::max(options.tolerance, 1e-6 * size)};
  timed(Mesh, [&] {
    std::vector<SmoothSegment> around, rims, inner;
    using Role = CharacterLine::Role;
    for (const CharacterLine& line : lines) {
      auto& kind = line.role == Role::Outline ? around : line.role == Role::Hole ? rims : inner;
      for (SmoothSegment& s : split_at_corners(line, options.corner_angle))
        kind.push_back(std::move(s));
    }
    const auto loops = make_loops(around, size, task.gap_tolerance, options.corner_angle);
    const auto holes = make_loops(rims, size, task.gap_tolerance, options.corner_angle);
    p.geometry = make_projected_geometry(loops[0], holes, inner, task);
    refine_by_curvature(p.geometry, task);
  });
  const ParametricMesh uncut = *p.geometry.mesh;
  timed(LocatePoints, [&] { trim_and_collocate(p.geometry, task); });
  // trim_and_collocate() also cuts.
  timed(CutCells, [&] { Trim(uncut, p.geometry.trim->loops()); });
  p.seconds[LocatePoints] = std::max(0.0, p.seconds[LocatePoints] - p.seconds[CutCells]);

  const ParametricMesh& mesh = *p.geometry.mesh;
  std::optional<ConstraintSet> set;
  timed(BuildConstraints, [&] { set = make_line_constraints(p.geometry, options.element); });
  SparseMatrix K, reduced;
  timed(Assemble, [&] {
    const SurfaceAssembler assembler(mesh, options.element, p.geometry.trim);
    K = assembler.stiffness(SurfaceStiffness::isotropic(0, 1));
  });
  std::optional<AffineReduction> reduction;
  timed(Eliminate, [&] { reduction.emplace(*set); });
  timed(Reduce, [&] { reduced = reduction->reduce(K); });
  SparseCholesky cholesky;
  timed(Analyse, [&] {
    // As ConstrainedSolver: the cheaper of the mesh's and the matrix's own ordering.
    constexpr double few_ties = 1.2;
    p.ties = static_cast<double>(reduced.nonZeros()) / static_cast<double>(K.nonZeros());
    const auto order = nested_dissection_order(mesh);
    cholesky.analyze(reduced,
                     p.ties <= few_ties ? reduction->ordering_of_free(order) : std::vector<int>());
  });
  timed(Factor, [&] {
    if (!cholesky.factorize(reduced)) throw NoSolutionError(cholesky.message());
  });
  Points dofs;
  timed(Solve, [&] {
    MatX y = reduction->reduce_load(K, Points::Zero(K.rows(), 3));
    cholesky.solve_in_place(y);
    dofs = reduction->expand(y);
  });
  p.surface = std::make_shared<Surface>(p.geometry.mesh, options.element, dofs, p.geometry.trim);
  timed(Evaluate, [&] {
    Vec3 sum = Vec3::Zero();
    for (const Location& where : tessellate(mesh, 2).points) {
      const SurfaceJet jet = p.surface->jet(where);
      sum += jet.x + jet.normal();
    }
    if (!sum.allFinite()) throw NoSolutionError("a point that is not finite");
  });

  for (const EmbeddedLine& line : p.geometry.embedded)
    p.gap = std::max(p.gap, line_gap(*p.surface, line));
  p.worst_residual = set->max_residual(dofs) / size;
  p.rows = static_cast<int>(set->constraints().size());
  p.free = reduction->free_count();
  p.cut_triangles = static_cast<int>(p.geometry.trim->cut_triangles().size());
  p.factor_entries = cholesky.factor_entries();
  return p;
}

struct Door {
  Scene scene;
  std::vector<CharacterLine> lines;
};

Door read_door() {
  Door door;
  door.scene = read_scene(std::filesystem::path(BATTEN_SOURCE_DIR) / "examples/05-door/scene.toml");
  door.scene.loads.clear();
  door.lines = faired_lines(door.scene, {}).lines;
  return door;
}

void time_solve_phases(const Door& door, const std::filesystem::path& folder, Checks& checks) {
  Table table, sizes;
  std::vector<std::string> head{"milliseconds (fraction)"};
  std::vector<std::vector<std::string>> cells(phases + 2);
  sizes.add({"grid", "edge mm", "tolerance mm", "triangles", "cut", "equations", "free",
             "factor entries", "gap mm", "bisections after the first solve",
             "layout + sculpt, seconds", "over factorization"});
  for (const Grid& grid : grids) {
    Scene scene = door.scene;
    scene.skin.options.edge_length = grid.edge_length;
    scene.skin.options.tolerance = grid.tolerance;
    // As in the program: at least one solve in the layout, one in the sculpting.
    std::vector<double> whole;
    std::optional<BuiltModel> made;
    for (int round = 0; round < std::max(3, grid.rounds / 3); ++round)
      whole.push_back(cpu_seconds_of([&] {
        made.emplace(build_model(scene, door.lines));
        solve_refined_shape(*made, scene);
      }));
    const RegionLayout* layout = &made->model.layout->region(0);
    const double size = layout->size();
    // Tolerance and edge length of the scene, so that the first mesh is that of the layout.
    std::vector<std::array<double, phases>> rounds;
    std::optional<SolvePhases> last;
    for (int round = -1; round < grid.rounds; ++round) {
      last.emplace(path(door.lines, scene.skin.options, size));
      if (round >= 0) rounds.push_back(last->seconds);
    }
    const int first = last->geometry.mesh->triangle_count(), end = layout->mesh()->triangle_count();
    // Refinement as in the layout, with a counter.
    int halvings = 0;
    DomainInput task{scene.skin.options, size, std::max(grid.tolerance, 1e-6 * size)};
    task.options.tolerance = grid.tolerance;
    task.options.edge_length = grid.edge_length;
    RegionGeometry geometry = last->geometry;
    std::shared_ptr<Surface> shape = last->surface;
    while (halvings < 8 && refine_at_gaps(geometry, *shape, 0.5 * grid.tolerance, task)) {
      ++halvings;
      const SurfaceAssembler assembler(*geometry.mesh, scene.skin.options.element, geometry.trim);
      const ConstrainedSolver solver(make_line_constraints(geometry, scene.skin.options.element),
                                     assembler.stiffness(SurfaceStiffness::isotropic(0, 1)),
                                     nested_dissection_order(*geometry.mesh));
      shape = std::make_shared<Surface>(geometry.mesh, scene.skin.options.element,
                                        solver.solve(Points::Zero(assembler.dofs().count(), 3)),
                                        geometry.trim);
    }

    std::array<double, phases> time{};
    double sum = 0;
    for (size_t phase = 0; phase < phases; ++phase) {
      std::vector<double> of_phase;
      for (const auto& r : rounds) of_phase.push_back(r[phase]);
      time[phase] = median(of_phase);
      sum += time[phase];
    }
    head.push_back(grid.name + ": " + std::to_string(first) + " triangles");
    for (size_t phase = 0; phase < phases; ++phase)
      cells[phase].push_back(text("%.2f (%.1f %%)", 1e3 * time[phase], 100 * time[phase] / sum));
    cells[phases].push_back(text("%.1f = %.2f factorizations", 1e3 * sum, sum / time[Factor]));
    StepFaceOptions step;
    step.tolerance = 1e-4 * size;
    const SkinnedRegion region{"door", *last->surface,          {},
                               size,   last->geometry.embedded, last->geometry.boundary};
    std::vector<double> step_times;
    for (int round = 0; round < 3; ++round)
      step_times.push_back(
          cpu_seconds_of([&] { write_step_faces(folder / "path.step", {&region}, 1e-3, step); }));
    cells[phases + 1].push_back(text("%.1f", 1e3 * median(step_times)));
    sizes.add({grid.name, format_number(grid.edge_length), format_number(grid.tolerance),
               std::to_string(first) + (end != first ? " to " + std::to_string(end) : ""),
               std::to_string(last->cut_triangles), std::to_string(last->rows),
               std::to_string(last->free), text("%.2f", last->ties),
               std::to_string(last->factor_entries), text("%.2g", last->gap),
               std::to_string(halvings), text("%.3f", median(whole)),
               text("%.1f", median(whole) / time[Factor])});
    checks.at_most(grid.name + ": residual of the constraints over the size", last->worst_residual,
                   1e-10);
    if (grid.name == "10k") {
      checks.at_least("10k: triangles", first, 9000);
      checks.at_most("10k: iterations of refinement", halvings, 0);
      checks.at_most("10k: largest gap of a curve, mm", last->gap, grid.tolerance);
      checks.at_most("10k: from curves to a solved shape over the factorization alone",
                     sum / time[Factor], 6);
    }
  }
  table.add(head);
  for (size_t phase = 0; phase <= phases + 1; ++phase) {
    std::vector<std::string> row{phase < phases    ? phase_names[phase]
                                 : phase == phases ? "sum"
                                                   : "STEP, one face, 1e-4 of the size"};
    row.insert(row.end(), cells[phase].begin(), cells[phase].end());
    table.add(row);
  }
  table.print();
  sizes.print();
}

// Points of the surface inside the trim, and their distance from the faces of the file.
double distance_of_file(const SkinnedRegion& region, const std::filesystem::path& file,
                        int at_most) {
  const auto faces = read_cad_surfaces(file, 1e-3);
  const Surface& s = region.surface;
  const int step = std::max(1, s.mesh().triangle_count() / at_most);
  double largest = 0;
  for (int t = 0; t < s.mesh().triangle_count(); t += step) {
    const Location where{t, Vec3(0.31, 0.28, 0.41)};
    const Vec2 uv = s.mesh().shape(t).point(where.L);
    if (s.trim() && !s.trim()->loops().contains(uv)) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& face : faces) nearest = std::min(nearest, face.distance(s.position(where)));
    largest = std::max(largest, nearest);
  }
  return largest;
}

// Curves that are too long for one edge of OpenCASCADE's filling are split: closed ones into four
// parts.
std::vector<HermiteCurve> in_parts(const HermiteCurve& c, int geometry) {
  std::vector<HermiteCurve> all;
  const int n = c.segment_count();
  for (int p = 0; p < geometry; ++p) {
    const int from = n * p / geometry, to = n * (p + 1) / geometry;
    std::vector<double> u;
    Points x(to - from + 1, 3), d(to - from + 1, 3);
    for (int i = from; i <= to; ++i) {
      u.push_back(c.parameters()[static_cast<size_t>(i)]);
      const int node = i % c.node_count();
      x.row(i - from) = c.position(node);
      d.row(i - from) = i == to ? c.slope_in(node) : c.slope_out(node);
    }
    all.emplace_back(u, x, d);
  }
  return all;
}

void compare_steps(const Door& door, const std::filesystem::path& folder, Checks& checks) {
  Scene scene = door.scene;
  scene.skin.options.edge_length = grids[1].edge_length;
  scene.skin.options.tolerance = grids[1].tolerance;
  const BuiltModel model = build_model(scene, door.lines);
  const SolvedShape made = solve_refined_shape(model, scene);
  const SkinnedRegion& region = made.regions.front();
  const RegionLayout& layout = made.layout->region(0);
  const double size = layout.size();
  std::printf("STEP of the door, size %.4g mm, %d triangles, curves within %g mm.\n\n", size,
              layout.mesh()->triangle_count(), grids[1].tolerance);

  Table table;
  table.add({"requested, of the size", "requested, mm", "deviation of the file, mm", "sampled, mm",
             "edges from the face, mm", "poles", "kB", "seconds", "valid"});
  for (const double share : {1e-3, 1e-4, 1e-5}) {
    StepFaceOptions options;
    options.tolerance = share * size;
    options.file.name = "door";
    const auto file = folder / "door.step";
    std::vector<double> times;
    StepReport report;
    for (int round = 0; round < 3; ++round)
      times.push_back(
          cpu_seconds_of([&] { report = write_step_faces(file, {&region}, 1e-3, options); }));
    const double seen = distance_of_file(region, file, 1500);
    table.add({format_number(share), format_number(options.tolerance),
               text("%.3g", *report.max_deviation), text("%.3g", seen),
               text("%.3g", report.max_gap),
               std::to_string(report.patches[0].poles_u) + " x " +
                   std::to_string(report.patches[0].poles_v),
               std::to_string(report.bytes / 1000), text("%.2f", median(times)),
               report.valid ? "yes" : "no"});
    const std::string name = "STEP at " + format_number(share) + " of the size: ";
    checks.at_most(name + "deviation over requested",
                   std::max(*report.max_deviation, seen) / options.tolerance, 1);
    checks.at_most(name + "megabytes", 1e-6 * static_cast<double>(report.bytes), 5);
    checks.at_least(name + "valid", report.valid ? 1 : 0, 1);
  }
  table.print();

  if (occ_version().empty()) {
    std::printf("OpenCASCADE's filling is missing from this build.\n\n");
    return;
  }
  std::printf(
      "OpenCASCADE's filling of the same curves (outline in four edges, the others as inner "
      "constraints). Distance: from points of a curve to the filling's surface.\n\n");
  std::vector<HermiteCurve> outline, inner;
  for (const EmbeddedLine& line : region.embedded) {
    const bool closed = line.fitted.closed();
    for (HermiteCurve& part : in_parts(line.fitted, closed ? 4 : 1))
      (line.line.role == CharacterLine::Role::Outline ? outline : inner).push_back(std::move(part));
  }
  Table peers;
  peers.add({"setting", "distance from the curves, mm", "poles", "kB", "seconds", "message"});
  const std::vector<OccFillingSettings> settings = {
      {"1e-3 of the size", 1e-3 * size, 15, 9},
      {"1e-4", 1e-4 * size, 15, 9},
      {"1e-5", 1e-5 * size, 15, 9},
      {"1e-5, 60 segments", 1e-5 * size, 15, 60},
      {"1e-5, 60 segments, 60 points", 1e-5 * size, 60, 60}};
  for (const OccFillingSettings& s : settings) {
    std::unique_ptr<OccFilling> filling;
    const double t = cpu_seconds_of([&] {
      filling =
          std::make_unique<OccFilling>(std::vector<std::vector<HermiteCurve>>{outline}, inner, s);
    });
    if (!filling->done()) {
      peers.add({s.name, "-", "-", "-", text("%.2f", t), filling->error_message()});
      continue;
    }
    double largest = 0;
    for (const auto* curves : {&outline, &inner})
      for (const HermiteCurve& c : *curves)
        for (int k = 0; k <= 60; ++k)
          largest = std::max(
              largest, filling->distance(c.evaluate(c.start() + (c.end() - c.start()) * k / 60)));
    const auto file = folder / "filling.step";
    const bool written = filling->write_step(file.string());
    const auto poles = filling->poles();
    peers.add({s.name, text("%.3g", largest),
               std::to_string(poles[0]) + " x " + std::to_string(poles[1]),
               written ? std::to_string(std::filesystem::file_size(file) / 1000) : "-",
               text("%.2f", t), "done"});
  }
  peers.print();
}

void skin_random_lines(int count, Checks& checks) {
  using namespace batten_test;
  std::map<std::string, int> refusals;
  int surfaces = 0, reported = 0, unreported = 0, understated = 0, others = 0, not_finite = 0;
  double worst = 0;
  const double seconds_taken = cpu_seconds_of([&] {
    for (int seed = 1; seed <= count; ++seed) {
      Random random(static_cast<unsigned>(seed));
      RandomResult r;
      try {
        try {
          r = skin_at_random(random_lines(random));
        } catch (const Error& e) {
          r.error_message = e.what();
          r.kind = error_kind(e);
        }
      } catch (const std::exception& e) {
        ++others;
        std::printf("seed %d: %s\n", seed, e.what());
        continue;
      }
      if (!r.error_message.empty()) {
        ++refusals[r.kind];
        continue;
      }
      ++surfaces;
      if (!r.finite) ++not_finite;
      worst = std::max(worst, r.found / r.reported);
      if (r.reported > r.tolerance) {
        ++reported;
      } else if (!(r.found <= r.tolerance)) {
        ++unreported;
        std::printf("seed %d: found %g, reported %g, tolerance %g\n", seed, r.found, r.reported,
                    r.tolerance);
      }
      if (!(r.found <= 1.2 * r.reported + 1e-9)) ++understated;
    }
  });
  Table table;
  table.add({text("%d random outlines, %.0f s", count, seconds_taken), "count"});
  table.add({"surfaces", std::to_string(surfaces)});
  table.add({"  with a reported gap", std::to_string(reported)});
  table.add({"  with a gap that is not reported", std::to_string(unreported)});
  table.add({"  with a gap above 1.2 times the reported one", std::to_string(understated)});
  table.add({"  with values that are not finite", std::to_string(not_finite)});
  for (const auto& [kind, number_of] : refusals)
    table.add({"rejected: " + kind, std::to_string(number_of)});
  table.add({"other exceptions", std::to_string(others)});
  table.print();
  std::printf("Largest gap at independent points over the reported one: %.3f.\n\n", worst);
  checks.at_least("random outlines: surfaces", surfaces, 0.5 * count);
  checks.at_most("random outlines: gaps not reported", unreported, 0);
  checks.at_most("random outlines: not finite", not_finite, 0);
  checks.at_most("random outlines: other exceptions", others, 0);
}

}  // namespace

int main(int argc, char** argv) {
  one_thread();
  const int outlines = argc > 1 ? std::atoi(argv[1]) : 2000;
  std::printf("Processor time on one thread, medians.\n\n");
  const auto folder =
      std::filesystem::temp_directory_path() / ("batten_bench_skin_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  Checks checks;
  try {
    const Door door = read_door();
    time_solve_phases(door, folder, checks);
    compare_steps(door, folder, checks);
  } catch (const Error& e) {
    std::printf("the door failed: %s\n", e.what());
    checks.at_most("the door failed", std::nullopt, 0);
  }
  skin_random_lines(outlines, checks);
  std::filesystem::remove_all(folder);
  checks.print("skin");
}
