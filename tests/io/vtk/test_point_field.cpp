// SPDX-License-Identifier: MPL-2.0
// Fields of values from tables and VTK files.
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataWriter.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "batten/core/errors.h"
#include "batten/io/scene/formula.h"
#include "batten/io/vtk/point_field.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

using namespace batten_test;
using namespace batten;
using Catch::Matchers::Contains;

namespace {

std::filesystem::path with_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
  return file;
}

}  // namespace

TEST_CASE("a table gives the value of the nearest point, whatever its columns", "[io][field]") {
  const std::filesystem::path folder = scratch("point_field");
  const auto value = [&](const std::string& text, const std::string& array, const Vec3& x) {
    return PointField(with_text(folder / "f.csv", text), array).at(x);
  };
  const std::string plain = "0 0 0 1\n10 0 0 2\n0 10 0 3\n";
  CHECK(value(plain, "", {9, 1, 0.5}) == 2);
  CHECK(value("# points\nx,y,z,p\n0,0,0,1\n10,0,0,2\n\n0,10,0,3\n", "p", {1, 8, 0}) == 3);
  CHECK(value("p [Pa];Z [mm];X [mm];Y [mm];T\n1;0;0;0;5\n2;0;10;0;6\n", "T", {9, 0, 0}) == 6);
  CHECK(value("\"p\",\"Points:0\",\"Points:1\",\"Points:2\"\n1,0,0,0\n2,10,0,0\n", "", {9, 0, 0}) ==
        2);
  CHECK(value("x,y,z,p\r\n0,0,0,-1.5e3\r\n10,0,0,+2\r\n", "", {0, 0, 0}) == -1500);

  const auto refused = [&](const std::string& text, const std::string& array,
                           const std::string& part) {
    CHECK_THROWS_WITH(value(text, array, Vec3::Zero()), Contains(part));
  };
  refused("x,y,p\n0,0,1\n", "", "no column 'z'");
  refused("x,y,z,p,q\n0,0,0,1,2\n", "", "one of: p, q");
  refused("x,y,z,pressure\n0,0,0,1\n", "presure", "did you mean 'pressure'");
  refused("x,y,z,p\n0,0,0,nan\n", "", ":2:1: found 'nan'");
  refused("x,y,z,p\n0,0,0\n", "", "found 3 columns");
  refused("0 0 0\n", "", "3 numbers without a header");
  refused("x,y,z,p\n", "", "found no points");
  CHECK_THROWS_WITH(PointField(folder / "none.csv", ""), Contains("none.csv"));
  CHECK_THROWS_WITH(PointField(folder / "f.xls", ""), Contains(".xls"));
  // A file in m for a model in mm.
  CHECK_THROWS_WITH(value(plain, "", {5000, 0, 0}), Contains("check the unit"));
}

TEST_CASE("values of a VTK file are interpolated on its cells", "[io][field]") {
  const std::filesystem::path folder = scratch("point_field_vtk");
  // 4 × 4 squares.
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> squares;
  for (int j = 0; j <= 4; ++j)
    for (int i = 0; i <= 4; ++i) points->InsertNextPoint(2.5 * i, 2.5 * j, 0);
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      squares->InsertNextCell({5 * j + i, 5 * j + i + 1, 5 * j + i + 6, 5 * j + i + 5});
  data->SetPoints(points);
  data->SetPolys(squares);
  vtkNew<vtkDoubleArray> linear, constant, vectors;
  linear->SetName("p");
  constant->SetName("cell");
  vectors->SetName("v");
  vectors->SetNumberOfComponents(3);
  for (vtkIdType k = 0; k < data->GetNumberOfPoints(); ++k) {
    const double* const x = data->GetPoint(k);
    linear->InsertNextValue(2 * x[0] - x[1] + 1);
    vectors->InsertNextTuple3(1, 2, 3);
  }
  for (vtkIdType k = 0; k < data->GetNumberOfCells(); ++k)
    constant->InsertNextValue(static_cast<double>(k));
  data->GetPointData()->AddArray(linear);
  data->GetPointData()->AddArray(vectors);
  data->GetCellData()->AddArray(constant);
  const auto file = folder / "plane.vtp";
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(data);
  writer->SetFileName(file.c_str());
  writer->Write();

  const PointField p(file, "p"), cell(file, "cell");
  for (const Vec3& x : {Vec3(1.3, 2.7, 0), Vec3(9.9, 0.1, 0.5), Vec3(5, 5, -0.3)})
    CHECK(p.at(x) == Approx(2 * x.x() - x.y() + 1).epsilon(1e-12));
  CHECK(cell.at({9, 1, 0}) == 3);
  CHECK_THROWS_WITH(PointField(file, ""), Contains("several arrays"));
  CHECK_THROWS_WITH(PointField(file, "v"), Contains("no array 'v'"));
  CHECK_THROWS_WITH(p.at({5, 5, 50}), Contains("check the unit"));

  // In a formula, a field is a name like a coordinate.
  const NamedFields fields = {{"p", p}, {"q_2", cell}};
  CHECK(Formula("3 * p + x", fields)({1, 2, 0}) == Approx(3 * 1 + 1));
  CHECK(Formula("p and q_2 > 2", fields)({9, 1, 0}) == 1);
  CHECK_THROWS_WITH(Formula("r + 1", fields), Contains("found 'r'"));
  CHECK(Formula::is_field_name("q_2"));
  for (const char* name : {"x", "sin", "2p", "p q", "", "p-q"})
    CHECK_FALSE(Formula::is_field_name(name));
}
