#include "batten/io/vtk/shell_vtk.h"

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataWriter.h>

#include "batten/core/isize.h"
#include "batten/io/vtk/write_vtk_xml.h"

namespace batten {

vtkSmartPointer<vtkPolyData> shell_poly_data(const ShellMesh& shells, const Points& points) {
  vtkNew<vtkPoints> nodes;
  nodes->SetDataTypeToDouble();
  for (long v = 0; v < points.rows(); ++v)
    nodes->InsertNextPoint(points(v, 0), points(v, 1), points(v, 2));
  vtkNew<vtkCellArray> cells;
  for (int f = 0; f < shells.face_count(); ++f) {
    const auto face = shells.face(f);
    const size_t n = shells.corners(f).size();
    cells->InsertNextCell(isize(face));
    for (size_t i = 0; i < n; ++i) {
      cells->InsertCellPoint(face[i]);
      if (shells.second_order(f)) cells->InsertCellPoint(face[n + i]);
    }
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(nodes);
  data->SetPolys(cells);
  return data;
}

void write_deformed_vtp(const std::filesystem::path& path, const ShellMesh& shells,
                        const DeformedData& data) {
  const auto poly = shell_poly_data(shells, shells.points);
  vtkNew<vtkDoubleArray> displacement;
  displacement->SetName("Displacement");
  displacement->SetNumberOfComponents(3);
  for (long v = 0; v < data.displacement.rows(); ++v)
    displacement->InsertNextTuple3(data.displacement(v, 0), data.displacement(v, 1),
                                   data.displacement(v, 2));
  poly->GetPointData()->SetVectors(displacement);
  vtkNew<vtkIntArray> feature;
  feature->SetName("Feature");
  for (const int f : data.feature) feature->InsertNextValue(f);
  poly->GetPointData()->AddArray(feature);
  vtkNew<vtkStringArray> names;
  names->SetName("Feature_names");
  for (const auto& name : data.feature_names) names->InsertNextValue(name.c_str());
  poly->GetFieldData()->AddArray(names);

  vtkNew<vtkXMLPolyDataWriter> writer;
  write_vtk_xml(*writer, poly, path);
}

}  // namespace batten
