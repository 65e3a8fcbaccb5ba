// SPDX-License-Identifier: MPL-2.0
// Openings between the faces of CAD files, the faces beside them, and files joined along them.

#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepPrimAPI_MakeHalfSpace.hxx>
#include <BRep_Builder.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Shell.hxx>
#include <gp_Pln.hxx>

#include <cmath>
#include <functional>
#include <numbers>

#include "batten/io/cad/cad_contents.h"
#include "batten/io/cad/cad_convert.h"
#include "batten/io/cad/cad_join.h"
#include "batten/io/lines/cad_neighbours.h"
#include "batten/tests/io/cad/bop_faults.h"
#include "batten/tests/io/cad/cad_files.h"

using namespace batten_test;

namespace cad_neighbours {

fs::path part_file(const std::string& name, const TopoDS_Shape& shape) {
  return written(scratch("neighbours") / (name + ".step"), painted(name, shape));
}

// The faces of a shape for which `keep` is true, as one shell.
TopoDS_Shape shell_of(const TopoDS_Shape& shape, const std::function<bool(int number)>& keep) {
  TopoDS_Shell shell;
  BRep_Builder builder;
  builder.MakeShell(shell);
  int number = 0;
  for (TopExp_Explorer f(shape, TopAbs_FACE); f.More(); f.Next())
    if (keep(++number)) builder.Add(shell, f.Current());
  return shell;
}

// A unit-free description: the turning of each opening, degrees, and whether it is filled.
std::vector<std::pair<double, bool>> openings_of(const fs::path& file) {
  std::vector<std::pair<double, bool>> found;
  for (const NeighbourOpening& opening : read_cad_neighbours(file, 1e-3).openings)
    found.emplace_back(opening.turning_deg, !opening.outer_boundary);
  return found;
}

}  // namespace cad_neighbours

using namespace cad_neighbours;

TEST_CASE("openings are told from outer boundaries by their total geodesic curvature",
          "[io][cad][neighbours]") {
  // The end of a box without a lid: straight edges, and corners with two right angles.
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(10, 20, 30).Shape();
  auto found = openings_of(part_file("box", shell_of(box, [](int k) { return k != 6; })));
  REQUIRE(found.size() == 1);
  CHECK(std::abs(found[0].first) < 1e-6);
  CHECK(found[0].second);

  // A cylinder without ends: two openings without geodesic curvature.
  const TopoDS_Shape tube = BRepPrimAPI_MakeCylinder(4, 25).Shape();
  found = openings_of(part_file("tube", shell_of(tube, [](int k) { return k == 1; })));
  REQUIRE(found.size() == 2);
  for (const auto& [turning, fills] : found) {
    CHECK(std::abs(turning) < 1e-6);
    CHECK(fills);
  }

  // A plate with a hole: 360 degrees around it, -360 around the hole.
  found = openings_of(part_file("plate", shell_of(drilled_block(), [](int k) { return k == 6; })));
  bool plate = false;
  for (int k = 1; k <= 7 && !plate; ++k) {
    found =
        openings_of(part_file("plate", shell_of(drilled_block(), [k](int f) { return f == k; })));
    plate = found.size() == 2 && std::abs(found[0].first - 360) < 1e-6;
  }
  REQUIRE(plate);
  CHECK_FALSE(found[0].second);
  CHECK(found[1].first == Approx(-360).margin(0.1));
  CHECK(found[1].second);

  // A sphere with a hole of radius r: -360° √(1 - r²/R²), by Gauss and Bonnet.
  const TopoDS_Shape hollow =
      BRepPrimAPI_MakeSphere(10, -std::numbers::pi / 2, std::asin(0.8)).Shape();
  found = openings_of(part_file("sphere", shell_of(hollow, [](int k) { return k == 1; })));
  REQUIRE(found.size() == 1);
  CHECK(found[0].first == Approx(-360 * 0.8).margin(0.1));
  CHECK(found[0].second);
}

TEST_CASE("tangent planes and curvatures beside an opening are those of the faces",
          "[io][cad][neighbours]") {
  const TopoDS_Shape tube = BRepPrimAPI_MakeCylinder(4, 25).Shape();
  const fs::path file = part_file("can", shell_of(tube, [](int k) { return k != 2; }));
  const NeighbourFaces found = read_cad_neighbours(file, 1e-2);  // in centimetres
  REQUIRE(found.openings.size() == 1);
  REQUIRE(found.neighbours.size() == 1);
  const double up = found.openings[0].centre.z() > 1 ? -1 : 1;  // into the wall
  for (const NeighbourSample& sample : found.neighbours[0].samples) {
    CHECK((sample.into - up * Vec3::UnitZ()).norm() < 1e-9);
    CHECK(sample.curvature.norm() < 1e-9);
    CHECK(std::hypot(sample.point.x(), sample.point.y()) == Approx(0.4));
  }
  const TopoDS_Shape torus = BRepPrimAPI_MakeTorus(20, 5, 0, std::numbers::pi / 2).Shape();
  const NeighbourFaces ring =
      read_cad_neighbours(part_file("ring", shell_of(torus, [](int k) { return k == 1; })), 1e-3);
  for (const NeighbourCurve& curve : ring.neighbours)
    for (const NeighbourSample& sample : curve.samples) {
      CHECK(sample.into.norm() == Approx(1));
      // Across a circle of the tube: along the ring; across the ring: along the tube.
      const double k = sample.curvature.norm();
      const double r = std::hypot(sample.point.x(), sample.point.y());
      const double along_ring = std::abs(1 - 20 / r) / 5;
      CHECK(std::min(std::abs(k - 0.2), std::abs(k - along_ring)) < 1e-6);
    }
}

TEST_CASE("faces joined to a part become a solid with its faces, names, colours and edges",
          "[io][cad][neighbours]") {
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(10, 20, 30).Shape();
  const fs::path folder = scratch("neighbours");
  const fs::path part =
      written(folder / "open.step", painted("open", shell_of(box, [](int k) { return k <= 5; })));
  const fs::path lid =
      written(folder / "lid.step", painted("lid", shell_of(box, [](int k) { return k == 6; })));
  const fs::path to = folder / "closed.step";
  CadJoinOptions options;
  options.tolerance = 1e-4;
  const CadJoinReport joined = join_cad_files(part, lid, to, options);
  CHECK(joined.faces == 6);
  CHECK(joined.added == 1);
  CHECK(joined.solids == 1);
  CHECK(joined.closed_shells == 1);
  CHECK(joined.valid);
  CHECK(joined.volume == Approx(6000).epsilon(1e-12));
  CHECK(joined.continuity.free_edges == 0);
  CHECK(joined.continuity.edges == 12);
  CHECK(faults(to) == 0);
  const CadContents contents = read_cad_contents(to);
  REQUIRE(contents.colours.size() == 2);
  int faces = 0;
  for (const CadAttribute& colour : contents.colours) faces += colour.faces;
  CHECK(faces == 6);
  int named = 0;
  for (const CadAttribute& name : contents.names) named += name.faces;
  CHECK(named == 6);
}

TEST_CASE("bad requests for given faces are errors with the place", "[io][cad][neighbours]") {
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(10, 20, 30).Shape();
  const fs::path closed = part_file("closed_box", box);
  CHECK(read_cad_neighbours(closed, 1e-3).neighbours.empty());
  const NeighbourFaces without = read_cad_neighbours(closed, 1e-3, {{}, {"face 2"}});
  REQUIRE(without.openings.size() == 1);
  CHECK(without.openings[0].lines.size() == 4);
  CHECK(without.faces == 5);
  CHECK_THROWS_WITH(
      read_cad_neighbours(closed, 1e-3, {{}, {"face 7"}}),
      Catch::Matchers::Contains("no face 'face 7'") && Catch::Matchers::Contains("'face 6'"));
  CHECK_THROWS_WITH(read_cad_neighbours(closed, 0), Catch::Matchers::Contains("model unit"));
  CadJoinOptions options;
  CHECK_THROWS_WITH(join_cad_files(closed, closed, closed.parent_path() / "x.step", options),
                    Catch::Matchers::Contains("tolerance"));
}
