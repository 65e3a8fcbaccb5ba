// SPDX-License-Identifier: MPL-2.0
// VTK reads back the same surface, and files are written completely or not at all.
#include "batten/io/vtk/vtk_files.h"

#include <sys/resource.h>
#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <Eigen/Geometry>
#include <cmath>
#include <csignal>
#include <map>
#include <memory>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/error_message.h"
#include "batten/tests/support/sampling.h"
#include "batten/tests/support/test_data.h"
#include "batten/tests/support/trimmed_regions.h"

using namespace batten_test;
namespace fs = std::filesystem;

namespace {

constexpr int kN = 4;

/// A cubic surface over [0,1]², which the elements represent exactly.
SurfaceJet cubic(double u, double v, double height) {
  return {{u, v, height * (u * u * v - v * v)},
          {1, 0, height * 2 * u * v},
          {0, 1, height * (u * u - 2 * v)},
          {0, 0, height * 2 * v},
          {0, 0, height * 2 * u},
          {0, 0, -2 * height}};
}

/// Its curves: the south side, and the reversed diagonal.
SkinnedRegion region(const std::string& name, double height) {
  const auto mesh = std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(kN));
  const Surface surface = interpolated(mesh, TriangleElement::HCT,
                                       [&](const Vec2& p) { return cubic(p.x(), p.y(), height); });
  SkinnedRegion result{name, surface, {}, 1, {}, {}};
  for (const bool diagonal : {false, true}) {
    EdgeAlignedLine aligned_line;
    aligned_line.line.name = diagonal ? "diagonal" : "south";
    for (int i = 0; i <= kN; ++i) {
      aligned_line.vertices.push_back(diagonal ? (kN - i) * (kN + 2) : i);
      aligned_line.parameters.push_back(i);
      if (i > 0)
        aligned_line.edges.push_back(
            mesh->edge_between(aligned_line.vertices[i - 1], aligned_line.vertices[i]));
    }
    result.edge_aligned.push_back(aligned_line);
  }
  return result;
}

Vec3 tuple(vtkDataArray* array, vtkIdType i) {
  REQUIRE(array);
  Vec3 value;
  array->GetTuple(i, value.data());
  return value;
}

/// Points are on the surface at their (u, v), normals are exact, curvatures approximate,
/// displacements exact.
void check_points(vtkPointSet& data, const std::vector<double>& heights, double reference) {
  vtkPointData& values = *data.GetPointData();
  const vtkIdType each = data.GetNumberOfPoints() / static_cast<vtkIdType>(heights.size());
  double position = 0, normal = 0, displacement = 0, mean = 0, gauss = 0, mean_k = 0, gauss_k = 0;
  for (vtkIdType p = 0; p < data.GetNumberOfPoints(); ++p) {
    const double height = heights[static_cast<size_t>(p / each)];
    Vec3 x;
    data.GetPoint(p, x.data());
    const Vec3 uv = tuple(values.GetArray("uv"), p);
    const SurfaceJet j = cubic(uv.x(), uv.y(), height);
    const Curvatures c = curvatures(j);
    position = std::max({position, (x - j.x).norm(), std::abs(uv.z())});
    normal = std::max(normal, (tuple(values.GetNormals(), p) - j.normal()).norm());
    const double H = values.GetArray("Mean_curvature")->GetTuple1(p);
    const double K = values.GetArray("Gauss_curvature")->GetTuple1(p);
    const double k1 = values.GetArray("K1")->GetTuple1(p), k2 = values.GetArray("K2")->GetTuple1(p);
    mean += std::abs(H - c.mean) / data.GetNumberOfPoints();
    gauss += std::abs(K - c.gauss) / data.GetNumberOfPoints();
    mean_k = std::max(mean_k, std::abs((k1 + k2) / 2 - H));
    // If averaging gives H² < K, there are no principal curvatures.
    if (H * H > K) gauss_k = std::max(gauss_k, std::abs(k1 * k2 - K));
    if (vtkDataArray* moved = values.GetArray("Displacement"))
      displacement = std::max(
          displacement, (tuple(moved, p) - (j.x - cubic(uv.x(), uv.y(), reference).x)).norm());
  }
  CHECK(position < 1e-14);
  CHECK(normal < 1e-13);
  CHECK(displacement < 1e-14);
  CHECK(mean < 0.1);
  CHECK(gauss < 0.1);
  CHECK(mean_k < 1e-14);
  CHECK(gauss_k < 1e-14);
}

void check_names(vtkDataObject& data) {
  const auto text = [&](const char* name, vtkIdType i) -> std::string {
    auto* array = vtkStringArray::SafeDownCast(data.GetFieldData()->GetAbstractArray(name));
    REQUIRE(array);
    return array->GetValue(i);
  };
  CHECK(text("Face_names", 0) == "hood");
  CHECK(text("Face_names", 1) == "left wing");
  const char* const expected[] = {"south", "diagonal", "south", "diagonal"};
  for (int i = 0; i < 4; ++i) CHECK(text("Curve_names", i) == expected[i]);
}

std::string bytes(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

size_t files_in(const fs::path& folder) {
  return static_cast<size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

}  // namespace

TEST_CASE("VTP: facets and curves of all faces, read back by VTK", "[io][vtk]") {
  const SkinnedRegion a = region("hood", 0.3), b = region("left wing", -0.2);
  const SkinnedRegion reference = region("flat", 0.1);
  const int n = GENERATE(1, 2, 5);
  const fs::path folder = batten_test::scratch("vtp"), path = folder / "surface.vtp";
  write_vtp(path, {&a, &b}, {{&reference.surface, &reference.surface}, n});
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkPolyData& data = *reader->GetOutput();
  const ParametricMesh& mesh = a.surface.mesh();
  const int facets = mesh.triangle_count() * n * n;
  CHECK(data.GetNumberOfPoints() == 2 * (mesh.vertex_count() + mesh.edge_count() * (n - 1) +
                                         mesh.triangle_count() * (n - 1) * (n - 2) / 2));
  CHECK(data.GetNumberOfLines() == 4);
  CHECK(data.GetNumberOfPolys() == 2 * facets);
  check_points(data, {0.3, -0.2}, 0.1);
  check_names(data);

  vtkCellData& cells = *data.GetCellData();
  REQUIRE(cells.GetArray("Curve"));
  REQUIRE(cells.GetArray("Curve")->GetNumberOfTuples() == 4 + 2 * facets);
  std::map<std::pair<int, int>, int> facets_of;
  for (vtkIdType c = 0; c < data.GetNumberOfCells(); ++c) {
    const int region_index = static_cast<int>(cells.GetArray("Face")->GetTuple1(c));
    const int triangle = static_cast<int>(cells.GetArray("Triangle")->GetTuple1(c));
    const int line = static_cast<int>(cells.GetArray("Curve")->GetTuple1(c));
    vtkCell& cell = *data.GetCell(c);
    if (cell.GetCellDimension() == 1) {
      CHECK(triangle == -1);
      CHECK(line == c);
      CHECK(region_index == c / 2);
      CHECK(cell.GetNumberOfPoints() == kN * n + 1);
      for (vtkIdType p = 0; p < cell.GetNumberOfPoints(); ++p) {
        const Vec3 uv = tuple(data.GetPointData()->GetArray("uv"), cell.GetPointId(p));
        const double along = static_cast<double>(p) / (kN * n);
        const Vec2 expected = line % 2 ? Vec2(1 - along, 1 - along) : Vec2(along, 0);
        CHECK((uv.head<2>() - expected).norm() < 1e-14);
      }
    } else {
      ++facets_of[{region_index, triangle}];
      CHECK(line == -1);
      // Its centroid is in its element.
      Vec3 middle = Vec3::Zero();
      for (int i = 0; i < 3; ++i)
        middle += tuple(data.GetPointData()->GetArray("uv"), cell.GetPointId(i)) / 3;
      CHECK(mesh.shape(triangle).barycentric(middle.head<2>()).minCoeff() > 0);
    }
  }
  CHECK(facets_of.size() == static_cast<size_t>(2 * mesh.triangle_count()));
  for (const auto& [where, count] : facets_of) CHECK(count == n * n);

  write_vtp(folder / "again.vtp", {&a, &b}, {{&reference.surface, &reference.surface}, n});
  CHECK(bytes(path) == bytes(folder / "again.vtp"));
  CHECK(bytes(path).find("vtkLZ4DataCompressor") != std::string::npos);
  CHECK(files_in(folder) == 2);
}

TEST_CASE("VTU: one quadratic triangle for each element", "[io][vtk]") {
  const SkinnedRegion a = region("hood", 0.3), b = region("left wing", -0.2);
  const fs::path path = batten_test::scratch("vtu") / "surface.vtu";
  write_vtu(path, {&a, &b});
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkUnstructuredGrid& data = *reader->GetOutput();
  const ParametricMesh& mesh = a.surface.mesh();
  REQUIRE(data.GetNumberOfPoints() == 2 * (mesh.vertex_count() + mesh.edge_count()));
  REQUIRE(data.GetNumberOfCells() == 2 * mesh.triangle_count() + 4 * kN);
  CHECK(!data.GetPointData()->GetArray("Displacement"));
  check_points(data, {0.3, -0.2}, 0);
  check_names(data);
  vtkDataArray* uv = data.GetPointData()->GetArray("uv");
  const int ends[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  for (vtkIdType c = 0; c < data.GetNumberOfCells(); ++c) {
    vtkCell& cell = *data.GetCell(c);
    const bool element = c < 2 * mesh.triangle_count();
    CHECK(cell.GetCellType() == (element ? VTK_QUADRATIC_TRIANGLE : VTK_QUADRATIC_EDGE));
    const int triangle = static_cast<int>(data.GetCellData()->GetArray("Triangle")->GetTuple1(c));
    const int line = static_cast<int>(data.GetCellData()->GetArray("Curve")->GetTuple1(c));
    const int in = static_cast<int>(data.GetCellData()->GetArray("Face")->GetTuple1(c));
    if (element) {
      CHECK(line == -1);
      CHECK(in == c / mesh.triangle_count());
      REQUIRE(triangle == c % mesh.triangle_count());
      const TriangleShape shape = mesh.shape(triangle);
      for (int i = 0; i < 6; ++i) {
        const Vec2 expected = (shape.vertex[ends[i][0]] + shape.vertex[ends[i][1]]) / 2;
        CHECK((tuple(uv, cell.GetPointId(i)).head<2>() - expected).norm() < 1e-15);
      }
    } else {
      CHECK(triangle == -1);
      CHECK(line == (c - 2 * mesh.triangle_count()) / kN);
      CHECK(in == line / 2);
      const Vec3 middle = (tuple(uv, cell.GetPointId(0)) + tuple(uv, cell.GetPointId(1))) / 2;
      CHECK((tuple(uv, cell.GetPointId(2)) - middle).norm() < 1e-15);
    }
  }
}

TEST_CASE("VTP and VTU of an embedded face end at its boundary", "[io][vtk]") {
  if (!have_delaunay_mesher()) return;
  const SkinnedRegion disc = wavy_disc({}), square = region("square", 0.2);
  const double area = disc.surface.area(), square_area = square.surface.area();
  const fs::path folder = batten_test::scratch("embedded");
  // Area of cells in space with VTK's own triangulation: quadratic cells are divided into four.
  const auto cell_area = [](vtkDataSet& data, int wanted_region) {
    double sum = 0;
    vtkNew<vtkIdList> ids;
    vtkNew<vtkPoints> corners;
    for (vtkIdType c = 0; c < data.GetNumberOfCells(); ++c) {
      if (data.GetCell(c)->GetCellDimension() != 2 ||
          data.GetCellData()->GetArray("Face")->GetTuple1(c) != wanted_region)
        continue;
      data.GetCell(c)->Triangulate(0, ids, corners);
      for (vtkIdType k = 0; k < corners->GetNumberOfPoints(); k += 3) {
        Vec3 x[3];
        for (int i = 0; i < 3; ++i) corners->GetPoint(k + i, x[i].data());
        sum += (x[1] - x[0]).cross(x[2] - x[0]).norm() / 2;
      }
    }
    return sum;
  };
  double before = 0;
  for (const int n : {4, 8}) {
    write_vtp(folder / "surface.vtp", {&square, &disc}, {{}, n});
    vtkNew<vtkXMLPolyDataReader> reader;
    reader->SetFileName((folder / "surface.vtp").c_str());
    reader->Update();
    vtkPolyData& data = *reader->GetOutput();
    const double error = std::abs(cell_area(data, 1) - area);
    CHECK(error < 5e-3);
    if (n == 8) CHECK(std::log2(before / error) == Approx(2).margin(0.15));
    before = error;
    CHECK(cell_area(data, 0) == Approx(square_area).epsilon(2e-3));
    CHECK(data.GetNumberOfLines() == 5);
    auto* names =
        vtkStringArray::SafeDownCast(data.GetFieldData()->GetAbstractArray("Curve_names"));
    REQUIRE(names);
    REQUIRE(names->GetNumberOfValues() == 5);
    const char* const expected[] = {"south", "diagonal", "rim", "hole", "rib"};
    for (int i = 0; i < 5; ++i) CHECK(names->GetValue(i) == expected[i]);
    // Points on the boundary are points of the surface at the curve.
    for (vtkIdType c = 2; c < 5; ++c) {
      CHECK(data.GetCellData()->GetArray("Curve")->GetTuple1(c) == c);
      const HermiteCurve& pcurve = disc.embedded[static_cast<size_t>(c) - 2].pcurve;
      vtkCell& chain = *data.GetCell(c);
      for (vtkIdType p = 0; p < chain.GetNumberOfPoints(); ++p) {
        const Vec3 uv = tuple(data.GetPointData()->GetArray("uv"), chain.GetPointId(p));
        CHECK(pcurve.closest_point(uv).distance < 1e-14);
        Vec3 x;
        data.GetPoint(chain.GetPointId(p), x.data());
        CHECK((x - disc.surface.position(disc.surface.locate(uv.head<2>()))).norm() < 1e-13);
      }
    }
  }
  write_vtu(folder / "surface.vtu", {&disc});
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName((folder / "surface.vtu").c_str());
  reader->Update();
  CHECK(cell_area(*reader->GetOutput(), 0) == Approx(area).epsilon(1e-2));
  for (vtkIdType c = 0; c < reader->GetOutput()->GetNumberOfCells(); ++c) {
    const int triangle =
        static_cast<int>(reader->GetOutput()->GetCellData()->GetArray("Triangle")->GetTuple1(c));
    CHECK(triangle < disc.surface.mesh().triangle_count());
  }
}

TEST_CASE("VTK writers refuse inconsistent data, and leave nothing behind", "[io][vtk]") {
  using Catch::Matchers::Contains;
  const fs::path folder = batten_test::scratch("vtk_errors"), path = folder / "surface.vtp";
  const SkinnedRegion a = region("hood", 0.3);
  const Surface other(std::make_shared<const ParametricMesh>(ParametricMesh::unit_square(1)),
                      TriangleElement::HCT, Points::Zero(17, 3));
  CHECK_THAT(error_message([&] { write_vtp(path, {}); }), Contains("no face"));
  CHECK_THAT(error_message([&] {
               write_vtp(path, {&a}, {{&other}, 4});
             }),
             Contains("'hood'") && Contains("another mesh"));
  CHECK_THAT(error_message([&] {
               write_vtu(path, {&a, &a}, {{&other}, 4});
             }),
             Contains("found 1 reference"));
  CHECK_THAT(error_message([&] { write_vtp(folder / "none" / "a.vtp", {&a}); }),
             Contains("none") && Contains("does not exist"));
  CHECK(files_in(folder) == 0);
}

TEST_CASE("a file is written whole or not at all", "[io][vtk]") {
  using Catch::Matchers::Contains;
  const fs::path folder = batten_test::scratch("whole"), path = folder / "note.tar.txt";
  write_file_atomically(path, [](std::ostream& out) { out << "first\n" << 0.5; });
  CHECK(bytes(path) == "first\n0.5");

  // A writer that fails keeps the old file and leaves no other files.
  CHECK_THROWS_AS(write_file_atomically(path,
                                        [](std::ostream& out) {
                                          out << "half";
                                          throw CancelledError();
                                        }),
                  CancelledError);
  CHECK(bytes(path) == "first\n0.5");
  CHECK(files_in(folder) == 1);
  {
    AtomicFile file(path);
    CHECK(file.temporary().parent_path().parent_path() == folder);
    CHECK(file.temporary().filename() == file.path().filename());
    std::ofstream(file.temporary()) << "second";
    CHECK(bytes(path) == "first\n0.5");
    file.commit();
    CHECK(bytes(path) == "second");
  }
  CHECK(files_in(folder) == 1);
  { AtomicFile abandoned(path); }
  CHECK(files_in(folder) == 1);

  // With a link, the target file changes.
  fs::create_symlink(path, folder / "link.txt");
  write_file_atomically(folder / "link.txt", [](std::ostream& out) { out << "third"; });
  CHECK(fs::is_symlink(folder / "link.txt"));
  CHECK(bytes(path) == "third");

  // A full disk, simulated by a limit on the file size.
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string said = error_message([&] {
    write_file_atomically(path, [](std::ostream& out) { out << std::string(100000, 'x'); });
  });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  CHECK_THAT(said, Contains("note.tar.txt") && Contains("File too large"));
  CHECK(bytes(path) == "third");
  CHECK(files_in(folder) == 2);
}

TEST_CASE("paths where no file can be written are named at the start", "[io][vtk]") {
  using Catch::Matchers::Contains;
  const fs::path folder = batten_test::scratch("places");
  std::ofstream(folder / "file") << "x";
  fs::create_directory(folder / "sub");
  const auto says = [](const fs::path& path) {
    return error_message([&] { AtomicFile file(path); });
  };
  CHECK_THAT(says(folder / "none" / "a.txt"), Contains("does not exist"));
  CHECK_THAT(says(folder / "file" / "a.txt"), Contains("is not a folder"));
  CHECK_THAT(says(folder / "sub"), Contains("found a folder of this name"));
  CHECK_THAT(says(folder / "sub/"), Contains("expected a file name"));
  CHECK_THAT(says("/dev/null"), Contains("not a regular file"));
  CHECK_THAT(says("/proc/none.txt"), Contains("/proc/none.txt: cannot write this file: "));

  const auto make = [](const fs::path& path) {
    return error_message([&] { make_output_folder(path); });
  };
  CHECK(make(folder / "a" / "b" / "c").empty());
  CHECK(fs::is_directory(folder / "a" / "b" / "c"));
  CHECK(fs::is_empty(folder / "a" / "b" / "c"));
  CHECK(make(folder / "a/").empty());
  CHECK_THAT(make(folder / "file"), Contains("found a file of this name"));
  CHECK_THAT(make(folder / "file" / "out"), Contains("Not a directory"));
  CHECK_THAT(make("/proc/none"), Contains("/proc/none: cannot use this output folder: "));
  CHECK_THAT(make(""), Contains("name is empty"));
}
