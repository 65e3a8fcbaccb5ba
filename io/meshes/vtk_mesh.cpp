// SPDX-License-Identifier: MPL-2.0
// Reads and writes VTK's XML files (VTP, VTU) and legacy files (VTK). When writing back, the data set
// is kept and gets new points.
#include <vtkCell.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkCellTypes.h>
#include <vtkDataWriter.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkGenericCell.h>
#include <vtkIdList.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <limits>
#include <map>
#include <optional>
#include <ostream>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/mesh_source_text.h"
#include "batten/io/vtk/vtk_data.h"
#include "batten/io/vtk/vtk_files.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// Validated cells of the file; VTK itself does not check connectivity.
class Cells {
 public:
  Cells(vtkCellArray* cells, vtkIdType points, const std::string& file) {
    if (!cells) return;
    vtkDataArray *offsets = cells->GetOffsetsArray(), *nodes = cells->GetConnectivityArray();
    for (vtkIdType i = 0; i < offsets->GetNumberOfTuples(); ++i)
      start_.push_back(static_cast<long>(offsets->GetComponent(i, 0)));
    for (vtkIdType i = 0; i < nodes->GetNumberOfTuples(); ++i) {
      const double node = nodes->GetComponent(i, 0);
      if (!(node >= 0 && node < static_cast<double>(points)))
        throw InputError(file + ": found node number " + format_number(node) +
                         " in a cell, expected 0 to " + std::to_string(points - 1));
      nodes_.push_back(static_cast<int>(node));
    }
    for (size_t i = 0; i < start_.size(); ++i)
      if (start_[i] < (i > 0 ? start_[i - 1] : 0) || start_[i] > static_cast<long>(nodes_.size()))
        throw InputError(file + ": found a cell that starts at " + std::to_string(start_[i]) +
                         " of " + format_count(static_cast<long>(nodes_.size()), "number"));
  }
  int count() const { return start_.empty() ? 0 : isize(start_) - 1; }
  std::vector<int> nodes(int cell) const {
    const auto i = static_cast<size_t>(cell);
    return {nodes_.begin() + start_[i], nodes_.begin() + start_[i + 1]};
  }

 private:
  std::vector<long> start_;
  std::vector<int> nodes_;
};

/// A face of a VTK cell type, by the tables of VTK: its corners, the midside nodes of its edges, and
/// the nodes inside.
struct FaceType {
  size_t nodes = 0;  ///< 0: any number
  std::vector<int> corners, middle, inside;
};

/// The type of a cell by VTK's own tables. Its dimension is -1 for unknown types.
struct CellType {
  int dimension = -1;
  std::optional<FaceType> face;
};

CellType make_cell_type(int type) {
  CellType result;
  const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(type));
  if (!cell) return result;
  result.dimension = cell->GetCellDimension();
  if (result.dimension != 2) return result;
  result.face.emplace();
  if (type == VTK_POLYGON) return result;
  FaceType& face = *result.face;
  face.nodes = static_cast<size_t>(cell->GetNumberOfPoints());
  for (int i = 0; i < cell->GetNumberOfPoints(); ++i) cell->GetPointIds()->SetId(i, i);
  // The edges of some types are neither in order nor directed alike (VTK_PIXEL).
  std::vector<std::vector<int>> edges;
  std::vector<char> used(face.nodes, 0);
  for (int e = 0; e < cell->GetNumberOfEdges(); ++e) {
    vtkIdList* const ids = cell->GetEdge(e)->GetPointIds();
    edges.emplace_back(ids->begin(), ids->end());
    for (const int i : edges.back()) used[static_cast<size_t>(i)] = 1;
  }
  for (int at = edges.empty() ? 0 : edges[0][0]; !edges.empty();) {
    const auto next = std::find_if(edges.begin(), edges.end(), [&](const std::vector<int>& edge) {
      return edge[0] == at || edge[1] == at;
    });
    if (next == edges.end()) break;
    face.corners.push_back(at);
    if (next->size() > 2) face.middle.push_back((*next)[2]);
    at = (*next)[0] == at ? (*next)[1] : (*next)[0];
    edges.erase(next);
  }
  for (size_t i = 0; i < used.size(); ++i)
    if (!used[i]) face.inside.push_back(static_cast<int>(i));
  return result;
}

const CellType& cell_type(int type) {
  static std::map<int, CellType> known;
  const auto found = known.find(type);
  return found != known.end() ? found->second
                              : known.emplace(type, make_cell_type(type)).first->second;
}

void write_data(vtkDataObject* data, const fs::path& path) {
  if (vtkPolyData::SafeDownCast(data)) {
    vtkNew<vtkXMLPolyDataWriter> writer;
    write_vtk_xml(*writer, data, path);
  } else {
    vtkNew<vtkXMLUnstructuredGridWriter> writer;
    write_vtk_xml(*writer, data, path);
  }
}

vtkSmartPointer<vtkPoints> vtk_points(const Points& points, int type) {
  auto result = vtkSmartPointer<vtkPoints>::New();
  result->SetDataType(type);
  result->SetNumberOfPoints(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    result->SetPoint(i, points(i, 0), points(i, 1), points(i, 2));
  return result;
}

class VtkMesh : public MeshContent {
 public:
  VtkMesh(const fs::path& path, std::string bytes)
      : file_(path.string()), bytes_(std::move(bytes)), data_(read_vtk_data(path)) {
    const bool surface = vtkPolyData::SafeDownCast(data_) != nullptr;
    const std::string extension = lower_extension(path);
    legacy_ = extension == ".vtk";
    format = legacy_ ? "VTK legacy" : surface ? "VTK surface (VTP)" : "VTK unstructured grid (VTU)";
    extensions = {extension};
    const vtkIdType count = data_->GetNumberOfPoints();
    if (count > std::numeric_limits<int>::max()) throw InputError(file_ + ": found too many nodes");
    shells.points.resize(count, 3);
    for (vtkIdType i = 0; i < count; ++i) {
      double position[3];
      data_->GetPoint(i, position);
      shells.points.row(i) = Vec3(position[0], position[1], position[2]).transpose();
      if (!shells.points.row(i).allFinite())
        throw InputError(file_ + ": a coordinate of node " + std::to_string(i) + " is not finite");
    }
    surface ? read_surface(*vtkPolyData::SafeDownCast(data_))
            : read_grid(*vtkUnstructuredGrid::SafeDownCast(data_));
    node_labels = Labels::counted_from(0, static_cast<int>(count));
    face_labels = labels_of_faces();
    warn();
    drop_normals(*data_->GetPointData(), "point");
    drop_normals(*data_->GetCellData(), "cell");
    read_sets("Set", "Set_names");
    read_sets("Face", "Face_names");
    read_sets("Curve", "Curve_names");
  }

  MeshRounding write(const fs::path& path, const Points& points,
                     const MeshWriteOptions&) const override {
    if (points == shells.points) {
      write_file_atomically(path, [&](std::ostream& stream) { stream << bytes_; });
      return {};
    }
    const bool fits = points.cast<float>().cast<double>() == points;
    const bool single = data_->GetPoints()->GetDataType() == VTK_FLOAT && fits;
    auto moved = vtkSmartPointer<vtkPointSet>::Take(data_->NewInstance());
    moved->ShallowCopy(data_);
    moved->SetPoints(vtk_points(points, single ? VTK_FLOAT : VTK_DOUBLE));
    legacy_ ? write_legacy(moved, path) : write_data(moved, path);
    return {0, -1, dropped_};
  }

 private:
  /// Writes a legacy file with the version, the title and the kind (text or binary) of the file read.
  void write_legacy(vtkDataObject* data, const fs::path& path) const {
    std::vector<std::string> head;
    for (size_t at = 0; head.size() < 3 && at < bytes_.size();) {
      const size_t end = std::min(bytes_.find('\n', at), bytes_.size());
      head.emplace_back(trimmed(std::string_view(bytes_).substr(at, end - at)));
      at = end + 1;
    }
    head.resize(3);
    const std::string version = head[0].substr(std::min(head[0].size(), head[0].rfind(' ') + 1));
    const bool old = !version.empty() && version[0] < '5';
    const std::string text = legacy_vtk_text(data, upper(head[2]) == "BINARY",
                                             old ? vtkDataWriter::VTK_LEGACY_READER_VERSION_4_2
                                                 : vtkDataWriter::VTK_LEGACY_READER_VERSION_5_1,
                                             head[1]);
    write_file_atomically(path, [&](std::ostream& stream) { stream << text; });
  }

  void add(const Cells& cells, int cell, long label, int type) {
    const std::vector<int> nodes = cells.nodes(cell);
    if (type == VTK_TRIANGLE_STRIP) return add_strip(nodes, label);
    const CellType& known = cell_type(type);
    if (!known.face) return add_other(nodes, label, type, known.dimension);
    const FaceType& face = *known.face;
    if (face.nodes > 0 ? nodes.size() != face.nodes : nodes.size() < 3)
      throw InputError(file_ + ": found cell " + std::to_string(label) + " of " +
                       format_count(static_cast<long>(nodes.size()), "node") + ", expected " +
                       (face.nodes > 0 ? std::to_string(face.nodes) : "3 or more"));
    if (face.nodes == 0) return add_face(nodes, false, label);
    std::vector<int> outline;
    for (const int i : face.corners) outline.push_back(nodes[i]);
    const bool second_order = face.middle.size() == face.corners.size();
    for (const int i : face.middle) outline.push_back(nodes[i]);
    if (!second_order && !face.middle.empty()) outline.resize(face.corners.size());
    add_face(outline, second_order, label);
    for (const int i : face.inside) add_follower(nodes[i], outline, label);
    if (!second_order)
      for (const int i : face.middle) add_follower(nodes[i], outline, label);
  }

  void add_face(const std::vector<int>& nodes, bool second_order, long label) {
    shells.add_face(nodes, second_order);
    cell_of_face_.push_back(label);
  }

  /// A node inside a face moves like the nodes around it.
  void add_follower(int node, const std::vector<int>& around, long label) {
    NonShellElement element{NonShellElement::Kind::Interpolation,
                            "inner node of a face",
                            label,
                            {node},
                            std::vector<double>(around.size(), 1)};
    element.nodes.insert(element.nodes.end(), around.begin(), around.end());
    other_elements.push_back(std::move(element));
  }

  void add_strip(const std::vector<int>& nodes, long label) {
    for (size_t i = 0; i + 2 < nodes.size(); ++i)
      add_face(i % 2 == 0 ? std::vector<int>{nodes[i], nodes[i + 1], nodes[i + 2]}
                          : std::vector<int>{nodes[i + 1], nodes[i], nodes[i + 2]},
               false, label);
  }

  /// Cells that are not faces deform with the faces to which they are attached.
  void add_other(const std::vector<int>& nodes, long label, int type, int dimension) {
    ++others_[type];
    if (nodes.size() < 2) return;
    const char* const name = vtkCellTypes::GetClassNameFromTypeId(type);
    const auto kind = dimension == 3   ? NonShellElement::Kind::Solid
                      : dimension == 1 ? NonShellElement::Kind::Beam
                                       : NonShellElement::Kind::Other;
    other_elements.push_back({kind, name ? name : "unknown cell", label, nodes, {}});
  }

  /// Cell indices run through vertices, lines, polygons and strips, in this order.
  void read_surface(vtkPolyData& data) {
    const Cells verts(data.GetVerts(), data.GetNumberOfPoints(), file_),
        lines(data.GetLines(), data.GetNumberOfPoints(), file_),
        polygons(data.GetPolys(), data.GetNumberOfPoints(), file_),
        strips(data.GetStrips(), data.GetNumberOfPoints(), file_);
    const long first = static_cast<long>(verts.count()) + lines.count();
    for (int i = 0; i < polygons.count(); ++i) add(polygons, i, first + i, VTK_POLYGON);
    if (verts.count() > 0) others_[VTK_POLY_VERTEX] = verts.count();
    if (lines.count() > 0) others_[VTK_POLY_LINE] = lines.count();
    for (int i = 0; i < strips.count(); ++i)
      add_strip(strips.nodes(i), first + polygons.count() + i);
  }

  void read_grid(vtkUnstructuredGrid& data) {
    const Cells cells(data.GetCells(), data.GetNumberOfPoints(), file_);
    vtkUnsignedCharArray* const types = data.GetCellTypesArray();
    if (cells.count() > 0 && (!types || types->GetNumberOfTuples() != cells.count()))
      throw InputError(file_ + ": found different numbers of cells and cell types");
    for (int i = 0; i < cells.count(); ++i) add(cells, i, i, types->GetValue(i));
  }

  void warn() {
    const int unused = unused_nodes(shells);
    if (unused == 0 && others_.empty()) return;
    std::string text;
    for (const auto& [type, count] : others_) {
      const char* const name = vtkCellTypes::GetClassNameFromTypeId(type);
      text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + (name ? name : "unknown");
    }
    if (!text.empty()) text += " cells move with their nodes; ";
    warnings.push_back(text + format_count(unused, "node") + " not used by a shell");
  }

  /// Faces of strips share the label of their cell: they are counted instead.
  Labels labels_of_faces() {
    Labels labels(cell_of_face_);
    return labels.duplicate() ? Labels::counted_from(0, labels.count()) : labels;
  }

  void drop_normals(vtkDataSetAttributes& attributes, const std::string& what) {
    for (int i = attributes.GetNumberOfArrays(); i-- > 0;) {
      const vtkAbstractArray* const array = attributes.GetAbstractArray(i);
      const std::string name =
          attributes.GetArrayName(i) ? attributes.GetArrayName(i) : std::string();
      if (array != attributes.GetNormals() && upper(name) != "NORMALS") continue;
      dropped_.push_back("the " + what + " normals '" + name +
                         "' are not written, because the shape has changed");
      attributes.RemoveArray(i);
    }
  }

  /// Sets of faces, or of the nodes of lines: the cell data `values` are indices of `names`. Batten
  /// writes these data for sets, and for the faces and curves of models.
  void read_sets(const char* values, const char* names) {
    vtkDataArray* const index = data_->GetCellData()->GetArray(values);
    auto* const texts =
        vtkStringArray::SafeDownCast(data_->GetFieldData()->GetAbstractArray(names));
    if (!index || !texts || index->GetNumberOfComponents() != 1 ||
        index->GetNumberOfTuples() != data_->GetNumberOfCells())
      return;
    std::vector<MeshSet> found(static_cast<size_t>(texts->GetNumberOfValues()));
    const auto set_of = [&](vtkIdType cell) {
      const double value = index->GetComponent(cell, 0);
      return value >= 0 && value < static_cast<double>(found.size())
                 ? &found[static_cast<size_t>(value)]
                 : nullptr;
    };
    std::vector<char> is_face(static_cast<size_t>(data_->GetNumberOfCells()), 0);
    for (int f = 0; f < isize(cell_of_face_); ++f) {
      is_face[static_cast<size_t>(cell_of_face_[f])] = 1;
      if (MeshSet* const set = set_of(cell_of_face_[f])) set->faces.push_back(f);
    }
    vtkNew<vtkIdList> nodes;
    for (vtkIdType cell = 0; cell < data_->GetNumberOfCells(); ++cell)
      if (MeshSet* const set = set_of(cell); set && !is_face[static_cast<size_t>(cell)]) {
        data_->GetCellPoints(cell, nodes);
        for (vtkIdType i = 0; i < nodes->GetNumberOfIds(); ++i)
          set->nodes.push_back(static_cast<int>(nodes->GetId(i)));
      }
    for (size_t i = 0; i < found.size(); ++i) {
      found[i].name = texts->GetValue(static_cast<vtkIdType>(i));
      found[i].nodes = sorted_unique(std::move(found[i].nodes));
      if (!found[i].faces.empty()) found[i].nodes.clear();  // a set has faces or nodes
      if (!found[i].faces.empty() || !found[i].nodes.empty()) sets.push_back(std::move(found[i]));
    }
  }

  std::string file_, bytes_;          // its name and content
  std::vector<std::string> dropped_;  // notes about data that are not written after a change
  vtkSmartPointer<vtkPointSet> data_;
  bool legacy_ = false;
  std::vector<long> cell_of_face_;
  std::map<int, long> others_;
};

}  // namespace

namespace {

// Compares the counts in the XML part of a file with its size: VTK allocates memory by the counts
// before it reads the data. Compressed data have fewer bytes than numbers, but not this few.
void check_counts(const std::string& text, const fs::path& path) {
  constexpr double most_per_byte = 8, most_numbers_per_byte = 64, always = 4096;
  const auto size = static_cast<double>(text.size());
  const auto fail = [&](const std::string& found, const std::string& expected) -> void {
    throw InputError(path.string() + ": found " + found + ", expected " + expected);
  };
  const std::string_view xml = std::string_view(text).substr(0, text.find("<AppendedData"));
  if (xml.find("<!DOCTYPE") != xml.npos) fail("a document type", "a VTK file, which has none");
  std::map<std::string, double> sums;  // over all pieces
  double components = 1;
  constexpr std::string_view prefix = "NumberOf";
  for (size_t at = xml.find(prefix); at != xml.npos; at = xml.find(prefix, at + 1)) {
    const size_t name_end = std::min(xml.find_first_of("= \t\r\n", at), xml.size()),
                 quote = std::min(xml.find_first_of("\"'", at), xml.size() - 1),
                 end = std::min(xml.find(xml[quote], quote + 1), xml.size());
    const std::string name(xml.substr(at, name_end - at));
    const bool is_attribute = at > 0 && std::string_view(" \t\r\n").find(xml[at - 1]) != xml.npos &&
                              trimmed(xml.substr(name_end, quote - name_end)).starts_with('=');
    if (!is_attribute) continue;  // part of a name or of a text
    const std::string_view number = trimmed(xml.substr(quote + 1, end - quote - 1));
    long count = -1;
    if (!parse_integer(number, count) || count < 0)
      fail(name + " = " + quoted_excerpt(number), "a number from 0");
    double& sum = sums[name];
    sum = name == "NumberOfComponents" ? std::max(sum, static_cast<double>(count))
                                       : sum + static_cast<double>(count);
    if (sum > most_per_byte * size + always)
      fail(name + " = " + quoted_excerpt(number) + " in " + std::to_string(text.size()) + " bytes",
           "as many numbers as there are data");
    components = std::max(components, sums["NumberOfComponents"]);
  }
  for (const auto& [name, sum] : sums)
    if (name != "NumberOfComponents" && sum * components > most_numbers_per_byte * size + always)
      fail(format_number(components) + " components of " + format_number(sum) + " tuples in " +
               std::to_string(text.size()) + " bytes",
           "as many numbers as there are data");
}

}  // namespace

namespace {

/// The same for the counts of legacy files.
void check_legacy_counts(const std::string& text, const fs::path& path) {
  constexpr double most_per_byte = 8, always = 4096;
  for (const char* word : {"POINTS", "CELLS", "CELL_TYPES", "POLYGONS", "LINES", "VERTICES",
                           "TRIANGLE_STRIPS", "POINT_DATA", "CELL_DATA"}) {
    const std::string start = "\n" + std::string(word) + " ";
    for (size_t at = text.find(start); at != text.npos; at = text.find(start, at + 1)) {
      std::string_view rest = std::string_view(text).substr(at + start.size(), 80);
      rest = rest.substr(0, rest.find('\n'));
      for (std::string_view token = next_token(rest); !token.empty(); token = next_token(rest)) {
        long count = 0;
        if (parse_integer(token, count) &&
            (count < 0 || static_cast<double>(count) >
                              most_per_byte * static_cast<double>(text.size()) + always))
          throw InputError(path.string() + ": found " + word + " " + std::string(token) + " in " +
                           std::to_string(text.size()) +
                           " bytes, expected as many numbers as there are data");
      }
    }
  }
}

}  // namespace

std::unique_ptr<MeshContent> read_vtk_mesh(const fs::path& path) {
  const MeshSourceText file(path, true);  // checks that the file exists and is not empty
  if (lower_extension(path) == ".vtk")
    check_legacy_counts(file.text(), path);
  else
    check_counts(file.text(), path);
  return std::make_unique<VtkMesh>(path, file.text());
}

namespace {

void add_sets(vtkDataSet& data, const ShellMesh& mesh, const std::vector<MeshSet>& sets) {
  vtkNew<vtkIntArray> numbers;
  numbers->SetName("Set");
  for (const int set : set_of_faces(mesh, sets)) numbers->InsertNextValue(set);
  data.GetCellData()->AddArray(numbers);
  vtkNew<vtkStringArray> names;
  names->SetName("Set_names");
  for (const MeshSet& set : sets) names->InsertNextValue(set.name.c_str());
  data.GetFieldData()->AddArray(names);
}

}  // namespace

void write_vtk_mesh(const MeshOutput& output) {
  const ShellMesh& mesh = output.mesh;
  const bool surface = lower_extension(output.path) == ".vtp";
  vtkNew<vtkPolyData> polygons;
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkCellArray> cells;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const std::vector<int> outline = outline_of(mesh, f);
    const bool second_order = mesh.second_order(f) && !surface;
    const std::vector<vtkIdType> nodes =
        second_order ? std::vector<vtkIdType>(face.begin(), face.end())
                     : std::vector<vtkIdType>(outline.begin(), outline.end());
    const auto count = static_cast<vtkIdType>(nodes.size());
    const int type = second_order ? (count == 6 ? VTK_QUADRATIC_TRIANGLE : VTK_QUADRATIC_QUAD)
                     : count == 3 ? VTK_TRIANGLE
                     : count == 4 ? VTK_QUAD
                                  : VTK_POLYGON;
    if (surface)
      cells->InsertNextCell(count, nodes.data());
    else
      grid->InsertNextCell(type, count, nodes.data());
  }
  const auto points = vtk_points(mesh.points, VTK_DOUBLE);
  polygons->SetPoints(points);
  polygons->SetPolys(cells);
  grid->SetPoints(points);
  if (!output.sets.empty())
    add_sets(surface ? static_cast<vtkDataSet&>(*polygons) : *grid, mesh, output.sets);
  write_data(surface ? static_cast<vtkDataObject*>(polygons) : grid, output.path);
}

}  // namespace batten
