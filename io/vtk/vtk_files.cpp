// SPDX-License-Identifier: MPL-2.0
#include "batten/io/vtk/vtk_files.h"

#include <SMP/Common/vtkSMPToolsAPI.h>  // vtkSMPTools.h of VTK 9.1 is not valid C++20
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/vtk/vtk_message_capture.h"
#include "batten/skinning/facets/facets.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

void check(const std::vector<const SkinnedRegion*>& regions, const VtkOptions& options) {
  if (regions.empty()) throw InputError("found no face to write, expected at least one");
  if (options.references.empty()) return;
  if (options.references.size() != regions.size())
    throw InputError("found " + std::to_string(options.references.size()) +
                     " reference surfaces, expected one for each of the " +
                     std::to_string(regions.size()) + " faces");
  for (size_t r = 0; r < regions.size(); ++r) {
    const ParametricMesh &a = regions[r]->surface.mesh(), &b = options.references[r]->mesh();
    if (a.vertices() != b.vertices() || a.triangles() != b.triangles())
      throw InputError("face '" + regions[r]->name +
                       "': found a reference surface with another mesh, expected the same mesh");
  }
}

template <class Array>
vtkSmartPointer<Array> array(const char* name, int components) {
  auto a = vtkSmartPointer<Array>::New();
  a->SetName(name);
  a->SetNumberOfComponents(components);
  return a;
}

/// The points of one face, with their data.
struct RegionPoints {
  struct Point {
    Vec3 x, normal;
    Vec2 uv;
    Vec3 displacement = Vec3::Zero();
  };
  std::vector<Point> points;
  std::vector<Curvatures> point_curvatures;  // empty, or one per point
  bool moved = false;                        // there is a reference surface
  std::vector<std::vector<VecX>> fields;     // by field, then by point

  RegionPoints() = default;
  RegionPoints(int region, const Surface& surface, const Tessellation& tessellation,
               const VtkOptions& options)
      : moved(!options.references.empty()) {
    const Surface* reference = moved ? options.references[region] : nullptr;
    if (options.curvatures) point_curvatures = recovered_curvatures(surface, tessellation);
    for (const VtkField& field : options.fields) {
      fields.emplace_back();
      for (const Location& where : tessellation.points)
        fields.back().push_back(field.at(region, where));
    }
    for (const Location& where : tessellation.points) {
      const SurfaceJet jet = surface.jet(where);
      Point p{jet.x, jet.normal(), surface.mesh().shape(where.triangle).point(where.L)};
      if (reference) p.displacement = jet.x - reference->position(where);
      points.push_back(p);
    }
  }
};

/// The points of all faces, with their data.
struct PointTable {
  vtkNew<vtkPoints> points;
  vtkSmartPointer<vtkDoubleArray> normals = array<vtkDoubleArray>("Normals", 3);
  vtkSmartPointer<vtkDoubleArray> mean = array<vtkDoubleArray>("Mean_curvature", 1);
  vtkSmartPointer<vtkDoubleArray> gauss = array<vtkDoubleArray>("Gauss_curvature", 1);
  vtkSmartPointer<vtkDoubleArray> k1 = array<vtkDoubleArray>("K1", 1);
  vtkSmartPointer<vtkDoubleArray> k2 = array<vtkDoubleArray>("K2", 1);
  vtkSmartPointer<vtkDoubleArray> uv = array<vtkDoubleArray>("uv", 3);
  vtkSmartPointer<vtkDoubleArray> displacement = array<vtkDoubleArray>("Displacement", 3);

  std::vector<vtkSmartPointer<vtkDoubleArray>> fields;

  explicit PointTable(const VtkOptions& options) {
    points->SetDataTypeToDouble();
    for (const VtkField& field : options.fields)
      fields.push_back(array<vtkDoubleArray>(field.name.c_str(), field.components));
  }

  /// Appends points. Returns the index of the first one.
  vtkIdType add(const RegionPoints& more) {
    const vtkIdType first = points->GetNumberOfPoints();
    for (const Curvatures& bend : more.point_curvatures) {
      mean->InsertNextValue(bend.mean);
      gauss->InsertNextValue(bend.gauss);
      k1->InsertNextValue(bend.k1);
      k2->InsertNextValue(bend.k2);
    }
    for (const RegionPoints::Point& p : more.points) {
      points->InsertNextPoint(p.x.data());
      normals->InsertNextTuple(p.normal.data());
      uv->InsertNextTuple3(p.uv.x(), p.uv.y(), 0);
      if (more.moved) displacement->InsertNextTuple(p.displacement.data());
    }
    for (size_t f = 0; f < fields.size(); ++f)
      for (const VecX& value : more.fields[f]) fields[f]->InsertNextTuple(value.data());
    return first;
  }

  void give_to(vtkPointSet& grid, const VtkOptions& options) {
    grid.SetPoints(points);
    vtkPointData& data = *grid.GetPointData();
    data.SetNormals(normals);
    if (options.curvatures)
      for (const auto& scalars : {mean, gauss, k1, k2}) data.AddArray(scalars);
    data.AddArray(uv);
    for (const auto& field : fields) data.AddArray(field);
    if (!options.references.empty()) data.SetVectors(displacement);
  }
};

/// Face, element and curve index of each cell.
struct CellTable {
  vtkSmartPointer<vtkIntArray> region = array<vtkIntArray>("Face", 1);
  vtkSmartPointer<vtkIntArray> triangle = array<vtkIntArray>("Triangle", 1);
  vtkSmartPointer<vtkIntArray> line = array<vtkIntArray>("Curve", 1);
  vtkSmartPointer<vtkIntArray> join = array<vtkIntArray>("Join", 1);
  vtkSmartPointer<vtkDoubleArray> angle = array<vtkDoubleArray>("Join_angle", 1);
  const std::vector<VtkLine>* of_model;

  explicit CellTable(const VtkOptions& options) : of_model(&options.lines) {}

  void add(size_t region_index, int triangle_index, int line_index) {
    region->InsertNextValue(static_cast<int>(region_index));
    triangle->InsertNextValue(triangle_index);
    line->InsertNextValue(line_index);
    const bool known = line_index >= 0 && !of_model->empty();
    join->InsertNextValue(known ? (*of_model)[line_index].join : -1);
    angle->InsertNextValue(known ? (*of_model)[line_index].angle_deg : -1);
  }

  void append(const CellTable& other) {
    const vtkIdType here = region->GetNumberOfTuples(), there = other.region->GetNumberOfTuples();
    region->InsertTuples(here, there, 0, other.region);
    triangle->InsertTuples(here, there, 0, other.triangle);
    line->InsertTuples(here, there, 0, other.line);
    join->InsertTuples(here, there, 0, other.join);
    angle->InsertTuples(here, there, 0, other.angle);
  }

  void give_to(vtkPointSet& grid, const std::vector<const SkinnedRegion*>& regions) const {
    for (const auto& values : {region, triangle, line}) grid.GetCellData()->AddArray(values);
    if (!of_model->empty()) {
      grid.GetCellData()->AddArray(join);
      grid.GetCellData()->AddArray(angle);
    }
    const auto region_names = array<vtkStringArray>("Face_names", 1);
    const auto line_names = array<vtkStringArray>("Curve_names", 1);
    for (const auto* r : regions) {
      region_names->InsertNextValue(r->name.c_str());
      if (!of_model->empty()) continue;
      for (const EdgeAlignedLine& aligned_line : r->edge_aligned)
        line_names->InsertNextValue(aligned_line.line.name.c_str());
      for (const EmbeddedLine& e : r->embedded) line_names->InsertNextValue(e.line.name.c_str());
    }
    for (const VtkLine& l : *of_model) line_names->InsertNextValue(l.name.c_str());
    grid.GetFieldData()->AddArray(region_names);
    grid.GetFieldData()->AddArray(line_names);
  }
};

/// Assigns indices to the curves of the faces; -1 if another face has written the curve already.
class LineIndex {
 public:
  explicit LineIndex(const std::vector<VtkLine>& lines) : of_model_(!lines.empty()) {
    for (size_t i = 0; i < lines.size(); ++i) left_.emplace(lines[i].name, static_cast<int>(i));
  }
  int of(const SkinnedRegion& region, size_t line) {
    if (!of_model_) return next_++;
    const std::string& name = line < region.edge_aligned.size()
                                  ? region.edge_aligned[line].line.name
                                  : region.embedded[line - region.edge_aligned.size()].line.name;
    const auto found = left_.find(name);
    if (found == left_.end()) return -1;
    const int index = found->second;
    left_.erase(found);
    return index;
  }

 private:
  bool of_model_;
  int next_ = 0;
  std::map<std::string, int> left_;
};

}  // namespace

void use_vtk_on_calling_thread() {
  vtk::detail::smp::vtkSMPToolsAPI::GetInstance().SetBackend("Sequential");
}

void write_vtk_xml(vtkXMLWriter& writer, vtkDataObject* data, const fs::path& path) {
  writer.SetInputDataObject(data);
  writer.SetDataModeToAppended();
  if (vtkPolyData::SafeDownCast(data)) {
    writer.SetCompressorTypeToLZ4();  // takes a third of zlib's time, for files a fifth larger
  } else {
    writer.SetCompressorTypeToZLib();  // other programs that read VTU support it
    writer.SetCompressionLevel(1);
  }
  writer.WriteToOutputStringOn();  // VTK does not pass on why it cannot write to a file
  {
    const VtkMessageCapture messages;
    if (!writer.Write() || !messages.first_error().empty())
      throw InputError(
          path.string() + ": VTK cannot write this file: " +
          (messages.first_error().empty() ? "it gives no reason" : messages.first_error()));
  }
  write_file_atomically(path, [&](std::ostream& out) { out << writer.GetOutputString(); });
}

std::vector<VtkLine> vtk_lines(const CurveNetwork& network, const SurfaceModel& model) {
  const auto name = [&](int edge) { return network.edges()[edge].name; };
  std::vector<VtkLine> lines;
  for (const ModelJoin& join : model.joins)
    lines.push_back({name(join.edge), static_cast<int>(join.kind), join.max_deg});
  for (const ModelRegion& region : model.regions)
    for (const int edge : region.plan.inner) lines.push_back({name(edge)});
  return lines;
}

vtkSmartPointer<vtkPolyData> to_poly_data(const std::vector<const SkinnedRegion*>& regions,
                                          const VtkOptions& options) {
  check(regions, options);
  PointTable table(options);
  CellTable line_cells(options), facet_cells(options);
  vtkNew<vtkCellArray> lines, facets;
  const double length = mean_facet_length(regions);
  const int per_edge =
      options.facets_per_edge > 0 ? options.facets_per_edge : display_facets_per_edge(regions);
  LineIndex index(options.lines);
  std::vector<DisplayFacets> of_regions(regions.size());
  std::vector<RegionPoints> points(regions.size());
  parallel_for(isize(regions), [&](int r) {
    of_regions[r] = batten::facets(*regions[r], per_edge, length);
    points[r] = {r, regions[r]->surface, of_regions[r].tessellation, options};
  });
  for (size_t r = 0; r < regions.size(); ++r) {
    const SkinnedRegion& region = *regions[r];
    const auto& [tessellation, chains] = of_regions[r];
    const vtkIdType first = table.add(points[r]);
    for (size_t l = 0; l < chains.size(); ++l) {
      const int line = index.of(region, l);
      if (line < 0) continue;
      for (const auto& chain : chains[l]) {
        lines->InsertNextCell(isize(chain));
        for (const int p : chain) lines->InsertCellPoint(first + p);
        line_cells.add(r, -1, line);
      }
    }
    for (size_t f = 0; f < tessellation.facets.size(); ++f) {
      const auto& [a, b, c] = tessellation.facets[f];
      const vtkIdType corners[3] = {first + a, first + b, first + c};
      facets->InsertNextCell(3, corners);
      facet_cells.add(r, tessellation.facet_triangle[f], -1);
    }
  }
  auto result = vtkSmartPointer<vtkPolyData>::New();
  table.give_to(*result, options);
  result->SetLines(lines);
  result->SetPolys(facets);
  line_cells.append(facet_cells);
  line_cells.give_to(*result, regions);
  return result;
}

void write_vtp(const fs::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options) {
  vtkNew<vtkXMLPolyDataWriter> writer;
  write_vtk_xml(*writer, to_poly_data(regions, options), path);
}

void write_vtu(const fs::path& path, const std::vector<const SkinnedRegion*>& regions,
               const VtkOptions& options) {
  check(regions, options);
  PointTable table(options);
  CellTable cells(options);
  vtkNew<vtkUnstructuredGrid> grid;
  std::vector<vtkIdType> first;
  std::vector<QuadraticElements> elements(regions.size());
  const double length = mean_facet_length(regions);
  std::vector<RegionPoints> points(regions.size());
  parallel_for(isize(regions), [&](int r) {
    elements[r] = quadratic_elements(*regions[r], length);
    points[r] = {r, regions[r]->surface, {elements[r].nodes, {}, {}}, options};
  });
  for (const RegionPoints& more : points) first.push_back(table.add(more));
  const auto insert = [&](int type, size_t r, const auto& nodes) {
    std::array<vtkIdType, 6> ids{};
    for (size_t i = 0; i < nodes.size(); ++i) ids[i] = first[r] + nodes[i];
    grid->InsertNextCell(type, static_cast<vtkIdType>(nodes.size()), ids.data());
  };
  for (size_t r = 0; r < regions.size(); ++r)
    for (size_t t = 0; t < elements[r].triangles.size(); ++t) {
      insert(VTK_QUADRATIC_TRIANGLE, r, elements[r].triangles[t]);
      cells.add(r, elements[r].element[t], -1);
    }
  LineIndex index(options.lines);
  for (size_t r = 0; r < regions.size(); ++r)
    for (size_t l = 0; l < elements[r].lines.size(); ++l) {
      const int line = index.of(*regions[r], l);
      if (line < 0) continue;
      for (const auto& edge : elements[r].lines[l]) {
        insert(VTK_QUADRATIC_EDGE, r, edge);
        cells.add(r, -1, line);
      }
    }
  table.give_to(*grid, options);
  cells.give_to(*grid, regions);
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  write_vtk_xml(*writer, grid, path);
}

namespace {

std::string all_digits(double value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

}  // namespace

void write_pvd(const std::filesystem::path& path, const std::vector<SeriesFile>& files) {
  if (files.empty()) throw InputError(path.string() + ": found no files, expected at least one");
  for (size_t i = 0; i < files.size(); ++i) {
    if (!std::isfinite(files[i].value))
      throw InputError(path.string() + ": found the value " + format_number(files[i].value) +
                       ", expected finite numbers");
    if (i > 0 && !((files[i].value - files[i - 1].value) * (files[1].value - files[0].value) > 0))
      throw InputError(path.string() + ": found the value " + format_number(files[i].value) +
                       " after " + format_number(files[i - 1].value) +
                       ", expected values in one direction");
  }
  write_file_atomically(path, [&](std::ostream& out) {
    out << "<?xml version=\"1.0\"?>\n"
           "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
           "  <Collection>\n";
    for (const SeriesFile& f : files)
      out << "    <DataSet timestep=\"" << all_digits(f.value) << "\" group=\"\" part=\"0\" file=\""
          << escaped(f.file) << "\"/>\n";
    out << "  </Collection>\n</VTKFile>\n";
  });
}

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
