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
#include <array>
#include <charconv>
#include <cmath>
#include <ostream>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/vtk/vtk_files.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// The shortest decimal representation that reads back as the same number.
std::string exact(double value) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

std::string row_of(const Vec3& p, const char* between) {
  return exact(p.x()) + between + exact(p.y()) + between + exact(p.z()) + "\n";
}

/// Replaces control characters by blanks: a name must fit on one line of a text file.
std::string one_row(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 32 || c == 127; }, ' ');
  return name;
}

void write_curves_text(std::ostream& out, const std::vector<NamedCurve>& lines) {
  for (const NamedCurve& line : lines) {
    const auto points = line.written_points();
    out << "v " << points.size() << "\n";
    for (const Vec3& p : points) out << row_of(p, " ");
  }
}

void write_csv(std::ostream& out, const std::vector<NamedCurve>& lines) {
  out << "x,y,z\n";
  for (const NamedCurve& line : lines) {
    out << (&line == &lines.front() ? "" : "\n") << "# " << one_row(line.name) << "\n";
    for (const Vec3& p : line.written_points()) out << row_of(p, ",");
  }
}

void write_obj(std::ostream& out, const std::vector<NamedCurve>& lines) {
  size_t number = 0;
  for (const NamedCurve& line : lines) {
    const auto points = line.written_points();
    out << "o " << one_row(line.name) << "\n";
    for (const Vec3& p : points) out << "v " << row_of(p, " ");
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

}  // namespace

const std::vector<std::string>& curve_file_extensions() {
  static const std::vector<std::string> endings = {".curves", ".csv", ".obj",  ".vtp",
                                                   ".step",   ".stp", ".iges", ".igs"};
  return endings;
}

std::vector<std::string> write_curves(const fs::path& path, const std::vector<NamedCurve>& curves,
                                      const CurveFileOptions& options) {
  const std::string ending = lower_extension(path);
  const auto& endings = curve_file_extensions();
  if (std::find(endings.begin(), endings.end(), ending) == endings.end())
    throw InputError(path.string() + ": found " +
                     (ending.empty() ? "no extension" : "the extension '" + ending + "'") +
                     ", expected " + expected_one_of(ending, endings));
  for (const NamedCurve& line : curves) check(path, line);
  std::vector<NamedCurve> lines = curves;
  if (ending == ".vtp") {
    leave_out(
        path, lines, [](const auto&) { return true; }, "curves");
    PolylineTable table;
    for (const NamedCurve& line : lines) table.add(line);
    table.write(path);
    return {};
  }
  const bool cad = ending.starts_with(".st") || ending.starts_with(".ig");
  const size_t least = cad || ending == ".curves" ? 1 : 2;
  const auto fits = [&](const NamedCurve& line) {
    return cad ? line.has_curve() : line.written_points().size() >= least;
  };
  const auto notes = leave_out(path, lines, fits,
                               cad          ? "curves of positive length"
                               : least == 2 ? "curves with two or more points"
                                            : "curves with points");
  if (cad)
    cad_plugin().write_cad_curves(path, lines, options);
  else
    write_file_atomically(path, [&](std::ostream& out) {
      ending == ".csv"   ? write_csv(out, lines)
      : ending == ".obj" ? write_obj(out, lines)
                         : write_curves_text(out, lines);
    });
  return notes;
}

}  // namespace batten
