// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/mesh_pictures.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkLookupTable.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/pictures/canvas.h"
#include "batten/io/pictures/drawing_primitives.h"
#include "batten/io/pictures/shading.h"
#include "batten/io/vtk/vtk_files.h"

namespace batten {
namespace {

using namespace detail;

Colour colour_of(MeshPicture::Part part) {
  switch (part) {
    case MeshPicture::Part::Feature:
      return {0.93, 0.62, 0.22};
    case MeshPicture::Part::Handle:
      return {0.36, 0.66, 0.40};
    case MeshPicture::Part::Fixed:
      return {0.52, 0.55, 0.60};
    case MeshPicture::Part::Body:
      break;
  }
  return kBody;
}

void check(const MeshPicture& picture) {
  const std::string who = "picture '" + picture.title + "': ";
  if (!picture.shells || picture.shells->face_count() == 0)
    throw InputError(who + "found no mesh to draw, expected one with faces");
  const auto count = [&](const std::string& what, long found, long expected) {
    if (found != expected)
      throw InputError(who + "found " + std::to_string(found) + " " + what + ", expected " +
                       std::to_string(expected));
  };
  count("points", picture.points.rows(), picture.shells->node_count());
  if (!picture.parts.empty())
    count("parts", static_cast<long>(picture.parts.size()), picture.shells->face_count());
  if (picture.field.size() > 0)
    count("field values", picture.field.size(), picture.shells->node_count());
  if (!picture.points.allFinite()) throw InputError(who + "found a point that is not finite");
  if (!(picture.zoom > 0) || !std::isfinite(picture.zoom))
    throw InputError(who + "found zoom " + format_number(picture.zoom) +
                     ", expected a number above 0");
  if (!(std::abs(picture.elevation) <= 90) || !std::isfinite(picture.azimuth))
    throw InputError(who + "found elevation " + format_number(picture.elevation) +
                     ", expected -90 to 90 degrees");
}

vtkSmartPointer<vtkPolyData> facets_of(const MeshPicture& picture) {
  const auto data = shell_poly_data(*picture.shells, picture.points);
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetNumberOfComponents(3);
  for (int f = 0; f < picture.shells->face_count(); ++f) {
    const Colour c = colour_of(picture.parts.empty() ? MeshPicture::Part::Body : picture.parts[f]);
    const std::array<unsigned char, 3> bytes{static_cast<unsigned char>(255 * c.x()),
                                             static_cast<unsigned char>(255 * c.y()),
                                             static_cast<unsigned char>(255 * c.z())};
    colours->InsertNextTypedTuple(bytes.data());
  }
  data->GetCellData()->SetScalars(colours);
  if (picture.field.size() > 0) {
    vtkNew<vtkDoubleArray> field;
    field->SetName("field");
    for (const double value : picture.field) field->InsertNextValue(value);
    data->GetPointData()->AddArray(field);
  }
  return data;
}

/// The outlines of all polygons.
vtkSmartPointer<vtkPolyData> edges_of(vtkPolyData& data) {
  vtkNew<vtkCellArray> edges;
  vtkIdType count;
  const vtkIdType* corner;
  for (data.GetPolys()->InitTraversal(); data.GetPolys()->GetNextCell(count, corner);) {
    edges->InsertNextCell(static_cast<int>(count) + 1);
    for (vtkIdType i = 0; i <= count; ++i) edges->InsertCellPoint(corner[i % count]);
  }
  auto lines = vtkSmartPointer<vtkPolyData>::New();
  lines->SetPoints(data.GetPoints());
  lines->SetLines(edges);
  return lines;
}

vtkSmartPointer<vtkPolyData> chains_of(vtkPolyData& data,
                                       const std::vector<std::vector<int>>& chains) {
  vtkNew<vtkCellArray> cells;
  for (const auto& chain : chains) {
    cells->InsertNextCell(isize(chain));
    for (const int v : chain) cells->InsertCellPoint(v);
  }
  auto lines = vtkSmartPointer<vtkPolyData>::New();
  lines->SetPoints(data.GetPoints());
  lines->SetLines(cells);
  return lines;
}

/// Points that belong to a face.
std::vector<Vec3> used_points(const ShellMesh& shells, const Points& points) {
  std::vector<char> used(static_cast<size_t>(shells.node_count()), 0);
  for (int f = 0; f < shells.face_count(); ++f)
    for (const int v : shells.face(f)) used[v] = 1;
  std::vector<Vec3> list;
  for (int v = 0; v < shells.node_count(); ++v)
    if (used[v]) list.emplace_back(points.row(v).transpose());
  return list;
}

void draw(vtkRenderer& renderer, const MeshPicture& picture, double width, double height,
          bool caption_below) {
  const bool coloured = picture.field.size() > 0;
  const Viewport viewport =
      viewport_of(width, height, picture.title, caption_below, coloured ? kScalarBarRows : 0);
  set_stage(renderer);
  const auto data = facets_of(picture);
  std::vector<Vec3> in_view = used_points(*picture.shells, picture.points);
  for (const Points* more : picture.also_in_view) {
    const auto points = used_points(*picture.shells, *more);
    in_view.insert(in_view.end(), points.begin(), points.end());
  }
  const ViewAxes axes(picture.azimuth, picture.elevation, picture.up);
  const Fit view = fit(in_view, axes, viewport, picture.zoom);
  const Vec3 offset = 3 * view.pixel * axes.towards;

  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(data);
  normals->SetFeatureAngle(30);
  normals->SplittingOn();
  normals->ConsistencyOn();
  normals->Update();
  const auto drawn = body(normals->GetOutput(), kBody, coloured ? Finish::Field : Finish::Paint);
  drawn->GetMapper()->ScalarVisibilityOn();
  if (coloured) {
    const double largest = picture.field.maxCoeff();
    const double limit = picture.field_limit > 0 ? picture.field_limit
                         : largest > 0           ? rounded_up(largest)
                                                 : 1;
    const auto table = sequential_colours(limit);
    drawn->GetMapper()->SetScalarModeToUsePointFieldData();
    drawn->GetMapper()->SelectColorArray("field");
    drawn->GetMapper()->SetLookupTable(table);
    drawn->GetMapper()->UseLookupTableScalarRangeOn();
    drawn->GetMapper()->InterpolateScalarsBeforeMappingOn();
    add_scalar_bar(renderer, table, picture.field_title, {picture.field.minCoeff(), largest},
                   viewport);
  } else {
    drawn->GetMapper()->SetScalarModeToUseCellData();
  }
  renderer.AddActor(drawn);
  add_floor_shadow(renderer, *data, axes, picture.up);
  add_thin_lines(renderer, feature_edges(*data), kMesh, 1.1 * viewport.unit, offset);
  if (picture.mesh) add_thin_lines(renderer, edges_of(*data), kMesh, 0.7 * viewport.unit, offset);
  if (!picture.lines.empty())
    add_tubes(renderer, chains_of(*data, picture.lines), kLine, 2.0 * viewport.unit * view.pixel,
              offset);
  add_title(renderer, picture.title, width, height, caption_below);
  set_camera(renderer, axes, view, width, height);
}

/// Calls sheet(count, columns, captions_below, draw) for the pictures.
template <class Sheet>
Image with_sheet(const std::vector<MeshPicture>& pictures, int columns, const Sheet& sheet) {
  if (pictures.empty()) throw InputError("found no picture to draw, expected at least one");
  if (columns < 1)
    throw InputError("found " + std::to_string(columns) + " columns, expected 1 or more");
  for (const auto& picture : pictures) check(picture);
  const auto count = isize(pictures);
  const bool below = count > 1;
  return sheet(count, std::min(columns, count), below,
               [&](vtkRenderer& renderer, int i, double width, double height) {
                 draw(renderer, pictures[i], width, height, below);
               });
}

}  // namespace

std::vector<MeshPicture::Part> parts_of_faces(const ShellMesh& shells,
                                              const std::vector<MeshPicture::Part>& of_node) {
  std::vector<MeshPicture::Part> parts;
  for (int f = 0; f < shells.face_count(); ++f) {
    const auto face = shells.face(f);
    const auto part = of_node[face[0]];
    const bool same =
        std::all_of(face.begin(), face.end(), [&](int v) { return of_node[v] == part; });
    parts.push_back(same ? part : MeshPicture::Part::Body);
  }
  return parts;
}

void draw_meshes(const std::filesystem::path& path, const std::vector<MeshPicture>& pictures,
                 int columns, const PictureSize& size) {
  with_sheet(pictures, columns, [&](int count, int across, bool below, const auto& draw_one) {
    draw_sheet(path, count, across, below, size, draw_one);
    return Image();
  });
}

Image mesh_image(const std::vector<MeshPicture>& pictures, int columns, const PictureSize& size) {
  return with_sheet(pictures, columns,
                    [&](int count, int across, bool below, const auto& draw_one) {
                      return sheet_image(count, across, below, size, draw_one);
                    });
}

}  // namespace batten
