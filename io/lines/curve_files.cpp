// SPDX-License-Identifier: MPL-2.0
#include "batten/io/lines/curve_files.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataWriter.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <ostream>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/lines/drawing.h"
#include "batten/io/vtk/vtk_files.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

std::string row_of(const Vec3& p, const char* between) {
  return exact_number(p.x()) + between + exact_number(p.y()) + between + exact_number(p.z());
}

void write_curves_text(std::ostream& out, const std::vector<NamedCurve>& lines) {
  for (const NamedCurve& line : lines) {
    const auto points = line.written_points();
    out << "v " << points.size() << "\n";
    for (const Vec3& p : points) out << row_of(p, " ") << "\n";
  }
}

/// A field of a table, in quotes if it contains separators, quotes, or characters that start a
/// comment.
std::string table_field(const std::string& text) {
  if (text.find_first_of("\",;#/") == text.npos && trimmed(text) == text) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? "\"\"" : std::string(1, c);
  return field + "\"";
}

void write_csv(std::ostream& out, const std::vector<NamedCurve>& lines) {
  out << "x,y,z,curve\n";
  for (const NamedCurve& line : lines) {
    // A blank row separates curves that have the same name.
    if (&line != &lines.front()) out << "\n";
    const std::string name = "," + table_field(line.name) + "\n";
    for (const Vec3& p : line.written_points()) out << row_of(p, ",") << name;
  }
}

void write_obj(std::ostream& out, const std::vector<NamedCurve>& lines) {
  size_t number = 0;
  for (const NamedCurve& line : lines) {
    const auto points = line.written_points();
    out << "o " << line.name << "\n";
    for (const Vec3& p : points) out << "v " << row_of(p, " ") << "\n";
    out << "l";
    for (size_t i = 0; i < points.size(); ++i) out << " " << ++number;
    out << "\n";
  }
}

// ---- VTP ------------------------------------------------------------------------------------

/// Curvature vector κ·n, towards the centre of curvature; zero where the derivative of the curve
/// vanishes.
Vec3 curvature_vector(const HermiteCurve& curve, CurveMesh::SegmentPoint at) {
  const Vec3 d = curve.evaluate(at, 1), dd = curve.evaluate(at, 2);
  const double speed = d.squaredNorm();
  return speed > 0 ? ((dd - dd.dot(d) / speed * d) / speed).eval() : Vec3::Zero();
}

class PolylineTable {
 public:
  PolylineTable() {
    points_->SetDataTypeToDouble();
    u_->SetName("u");
    curvature_->SetName("Curvature");
    vector_->SetName("Curvature_vector");
    vector_->SetNumberOfComponents(3);
    name_->SetName("Name");
    closed_->SetName("Closed");
  }

  void add(const NamedCurve& line) {
    const vtkIdType first = points_->GetNumberOfPoints();
    if (line.has_curve())
      add_samples(line.curve);
    else
      for (const Vec3& p : line.points) add_point(p, 0, Vec3::Zero());
    const vtkIdType count = points_->GetNumberOfPoints() - first;
    // VTK polylines need at least two points, so a single one is repeated.
    lines_->InsertNextCell(std::max(2, static_cast<int>(count)));
    for (vtkIdType i = 0; i < count; ++i) lines_->InsertCellPoint(first + i);
    if (count == 1) lines_->InsertCellPoint(first);
    name_->InsertNextValue(line.name.c_str());
    closed_->InsertNextValue(line.has_curve() && line.curve.closed());
  }

  void write(const fs::path& path) {
    vtkNew<vtkPolyData> data;
    data->SetPoints(points_);
    data->SetLines(lines_);
    data->GetPointData()->AddArray(u_);
    data->GetPointData()->SetScalars(curvature_);
    data->GetPointData()->AddArray(vector_);
    data->GetCellData()->AddArray(name_);
    data->GetCellData()->AddArray(closed_);
    vtkNew<vtkXMLPolyDataWriter> writer;
    write_vtk_xml(*writer, data, path);
  }

 private:
  void add_point(const Vec3& p, double u, const Vec3& curvature) {
    points_->InsertNextPoint(p.data());
    u_->InsertNextValue(u);
    curvature_->InsertNextValue(curvature.norm());
    vector_->InsertNextTuple(curvature.data());
  }

  void add_samples(const HermiteCurve& curve) {
    const int segments = curve.segment_count();
    const int each = std::max(4, (400 + segments - 1) / segments);
    Vec3 last = Vec3::Zero();
    for (int s = 0; s < segments; ++s)
      for (int k = 0; k <= each; ++k) {
        const CurveMesh::SegmentPoint at{s, static_cast<double>(k) / each};
        const Vec3 bend = curvature_vector(curve, at);
        const bool same = (bend - last).norm() <= 1e-9 * (bend.norm() + last.norm());
        if (k > 0 || s == 0 || !same)
          add_point(curve.evaluate(at), curve.parameters()[s] + at.s * curve.mesh().length(s),
                    bend);
        last = bend;
      }
  }

  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> lines_;
  vtkNew<vtkDoubleArray> u_, curvature_, vector_;
  vtkNew<vtkStringArray> name_;
  vtkNew<vtkIntArray> closed_;
};

// ---- selection by format ---------------------------------------------------------------------

void check(const fs::path& path, const NamedCurve& line) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(path.string() + ": cannot write the curve '" + line.name + "': " + what);
  };
  const auto finite = [](const Vec3& p) { return p.allFinite(); };
  if (!std::all_of(line.points.begin(), line.points.end(), finite))
    refuse("found a point that is not finite");
  if (!line.has_curve() && line.points.empty()) refuse("found no points, expected at least one");
  for (const double u : line.parameters)
    if (!std::isfinite(u))
      refuse("found the parameter " + format_number(u) + ", expected a finite one");
}

/// Removes the curves that the format cannot store, and returns a sentence for each.
std::vector<std::string> leave_out(const fs::path& path, std::vector<NamedCurve>& lines,
                                   const std::function<bool(const NamedCurve&)>& fits,
                                   const std::string& expected) {
  std::vector<std::string> notes;
  std::erase_if(lines, [&](const NamedCurve& line) {
    if (fits(line)) return false;
    notes.push_back(path.filename().string() + ": '" + line.name + "' is not written: files of " +
                    "this type contain " + expected);
    return true;
  });
  if (lines.empty())
    throw InputError(path.string() + ": found no curve to write, expected " + expected);
  return notes;
}

/// True if not all points of a curve coincide.
bool has_length(const NamedCurve& line) {
  return line.has_curve() || std::any_of(line.points.begin(), line.points.end(),
                                         [&](const Vec3& p) { return p != line.points[0]; });
}

/// True if the names are those that a reader gives to curves without names: NAME_1, NAME_2, ….
bool are_numbered(const std::vector<NamedCurve>& lines) {
  const std::string& first = lines.front().name;
  if (lines.size() == 1) return first.empty();
  const std::string stem = first.substr(0, first.rfind('_') + 1);
  for (size_t i = 0; i < lines.size(); ++i)
    if (lines[i].name != stem + std::to_string(i + 1)) return false;
  return true;
}

using Format = std::function<std::vector<std::string>(
    const fs::path& path, const std::vector<NamedCurve>& lines, const CurveFileOptions& options)>;

Format text_format(void (*write)(std::ostream&, const std::vector<NamedCurve>&)) {
  return [write](const fs::path& path, const std::vector<NamedCurve>& lines, const auto&) {
    write_file_atomically(path, [&](std::ostream& out) { write(out, lines); });
    return std::vector<std::string>();
  };
}

std::vector<std::string> write_strokes(const fs::path& path, const std::vector<NamedCurve>& lines,
                                       const CurveFileOptions& options) {
  text_format(write_curves_text)(path, lines, options);
  if (are_numbered(lines)) return {};
  return {path.filename().string() +
          ": the names of the curves are not written, because files of this type contain none"};
}

std::vector<std::string> write_vtp(const fs::path& path, const std::vector<NamedCurve>& lines,
                                   const CurveFileOptions&) {
  PolylineTable table;
  for (const NamedCurve& line : lines) table.add(line);
  table.write(path);
  return {};
}

std::vector<std::string> write_cad(const fs::path& path, const std::vector<NamedCurve>& lines,
                                   const CurveFileOptions& options) {
  cad_plugin().write_cad_curves(path, lines, options);
  return {};
}

/// A file format for curves.
struct CurveFormat {
  std::vector<std::string> endings;
  bool (*fits)(const NamedCurve& line);  ///< whether the format can store a curve
  std::string expected;                  ///< the curves for which `fits` is true
  Format write;
};

const std::vector<CurveFormat>& curve_formats() {
  const auto any = [](const NamedCurve&) { return true; };
  const auto several = [](const NamedCurve& line) { return line.written_points().size() > 1; };
  const auto parametric = [](const NamedCurve& line) { return line.has_curve(); };
  const std::string with_points = "curves with points",
                    with_several_points = "curves with two or more points",
                    with_length = "curves of positive length";
  static const std::vector<CurveFormat> formats = {
      {{".curves"},
       [](const NamedCurve& line) { return !line.written_points().empty(); },
       with_points,
       write_strokes},
      {{".csv"}, several, with_several_points, text_format(write_csv)},
      {{".obj"}, several, with_several_points, text_format(write_obj)},
      {{".vtp"}, any, "curves", write_vtp},
      {{".dxf"},
       has_length,
       with_length,
       [](const fs::path& path, const std::vector<NamedCurve>& lines,
          const CurveFileOptions& options) {
         write_dxf(path, lines, options.unit_in_metres);
         return std::vector<std::string>();
       }},
      {{".svg"},
       has_length,
       with_length,
       [](const fs::path& path, const std::vector<NamedCurve>& lines,
          const CurveFileOptions& options) {
         return write_svg(path, lines, options.unit_in_metres);
       }},
      {{".step", ".stp", ".iges", ".igs"}, parametric, with_length, write_cad}};
  return formats;
}

}  // namespace

const std::vector<std::string>& curve_file_extensions() {
  static const std::vector<std::string> endings = [] {
    std::vector<std::string> all;
    for (const CurveFormat& format : curve_formats())
      all.insert(all.end(), format.endings.begin(), format.endings.end());
    return all;
  }();
  return endings;
}

std::vector<std::string> write_curves(const fs::path& path, const std::vector<NamedCurve>& curves,
                                      const CurveFileOptions& options) {
  const std::string ending = lower_extension(path);
  const auto& formats = curve_formats();
  const auto format = std::find_if(formats.begin(), formats.end(), [&](const CurveFormat& f) {
    return std::find(f.endings.begin(), f.endings.end(), ending) != f.endings.end();
  });
  if (format == formats.end())
    throw InputError(path.string() + ": found " +
                     (ending.empty() ? "no extension" : "the extension '" + ending + "'") +
                     ", expected " + expected_one_of(ending, curve_file_extensions()));
  for (const NamedCurve& line : curves) check(path, line);
  std::vector<NamedCurve> lines = curves;
  for (NamedCurve& line : lines) line.name = single_row(utf8(code_points(line.name)));
  std::vector<std::string> notes = leave_out(path, lines, format->fits, format->expected);
  const std::vector<std::string> more = format->write(path, lines, options);
  notes.insert(notes.end(), more.begin(), more.end());
  return notes;
}

}  // namespace batten
