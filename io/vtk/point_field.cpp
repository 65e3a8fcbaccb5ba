// SPDX-License-Identifier: MPL-2.0
#include "batten/io/vtk/point_field.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStaticCellLocator.h>
#include <vtkStaticPointLocator.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/vtk/vtk_data.h"

namespace batten {
namespace {

// Tables.

std::vector<std::string> cells_of(std::string_view line) {
  const bool separated = line.find_first_of(",;\t") != std::string_view::npos;
  std::vector<std::string> cells;
  std::string cell;
  bool quoted = false;
  const auto end_cell = [&] {
    cells.emplace_back(trimmed(cell));
    cell.clear();
  };
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (quoted) {
      cell += c;
    } else if (separated ? c == ',' || c == ';' || c == '\t' : is_blank(c)) {
      if (separated || !cell.empty()) end_cell();
    } else {
      cell += c;
    }
  }
  if (separated || !cell.empty()) end_cell();
  return cells;
}

std::optional<double> number_of(const std::string& cell) {
  double value = 0;
  const char* const first = cell.data() + (cell.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(first, cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) return {};
  return value;
}

/// The name of a column without its unit.
std::string column_name(const std::string& cell) {
  return std::string(trimmed(std::string_view(cell).substr(0, cell.find_first_of("[("))));
}

/// Columns of the coordinates and of the values.
std::array<size_t, 4> columns_of(const std::vector<std::string>& header, const std::string& array,
                                 const std::string& where) {
  std::array<size_t, 4> columns = {header.size(), header.size(), header.size(), header.size()};
  std::vector<std::string> values;
  for (size_t k = 0; k < header.size(); ++k) {
    const std::string name = column_name(header[k]), lower = lower_case(name);
    bool is_coordinate = false;
    for (size_t c = 0; c < 3; ++c)
      if (lower == std::string(1, "xyz"[c]) || lower == "points:" + std::to_string(c)) {
        columns[c] = k;
        is_coordinate = true;
      }
    if (is_coordinate) continue;
    values.push_back(name);
    if (name == array || header[k] == array || array.empty()) columns[3] = k;
  }
  for (size_t c = 0; c < 3; ++c)
    if (columns[c] == header.size())
      throw InputError(where + "found no column '" + std::string(1, "xyz"[c]) +
                       "', expected columns x, y, z and values");
  if (values.empty() || (array.empty() && values.size() > 1))
    throw InputError(where + "found " + std::to_string(values.size()) +
                     " columns of values, expected array = one of: " + comma_separated(values));
  if (columns[3] == header.size())
    throw InputError(where + "found no column '" + array + "', expected " +
                     expected_one_of(array, values));
  return columns;
}

vtkSmartPointer<vtkPointSet> read_table(const std::filesystem::path& file,
                                        const std::string& array) {
  const std::string text = read_input_file(file, "a table of points with values");
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkDoubleArray> values;
  values->SetName("values");
  std::optional<std::array<size_t, 4>> columns;
  long line_number = 0;
  for (size_t from = 0; from < text.size();) {
    const size_t to = std::min(text.find('\n', from), text.size());
    const std::string_view line = trimmed(std::string_view(text).substr(from, to - from));
    from = to + 1;
    ++line_number;
    if (line.empty() || line.starts_with('#')) continue;
    const std::string where = format_location(file.string(), {static_cast<int>(line_number), 1});
    const std::vector<std::string> cells = cells_of(line);
    if (!columns) {
      const bool header = !number_of(cells[0]);
      if (!header && cells.size() != 4)
        throw InputError(where + "found " + std::to_string(cells.size()) +
                         " numbers without a header, expected x, y, z and a value");
      columns = header ? columns_of(cells, array, where) : std::array<size_t, 4>{0, 1, 2, 3};
      if (header) continue;
    }
    std::array<double, 4> numbers{};
    for (size_t k = 0; k < 4; ++k) {
      const size_t column = (*columns)[k];
      const auto number = column < cells.size() ? number_of(cells[column]) : std::nullopt;
      if (!number)
        throw InputError(where + "found " +
                         (column < cells.size() ? quoted_excerpt(cells[column])
                                                : format_count(isize(cells), "column")) +
                         ", expected a finite number in column " + std::to_string(column + 1));
      numbers[k] = *number;
    }
    points->InsertNextPoint(numbers[0], numbers[1], numbers[2]);
    values->InsertNextValue(numbers[3]);
  }
  if (points->GetNumberOfPoints() == 0)
    throw InputError(file.string() + ": found no points, expected rows with x, y, z and a value");
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->GetPointData()->AddArray(values);
  return data;
}

vtkDataArray* scalar_named(vtkDataSetAttributes* data, const std::string& array,
                           std::vector<std::string>& names) {
  vtkDataArray* found = nullptr;
  for (int k = 0; k < data->GetNumberOfArrays(); ++k) {
    vtkDataArray* const one = data->GetArray(k);
    if (!one || !one->GetName() || one->GetNumberOfComponents() != 1) continue;
    names.emplace_back(one->GetName());
    if (array.empty() || names.back() == array) found = one;
  }
  return found;
}

}  // namespace

class PointField::Data {
 public:
  Data(const std::filesystem::path& file, const std::string& array) : file_(file.string()) {
    const std::string extension = lower_extension(file);
    if (extension == ".csv" || extension == ".txt" || extension == ".dat") {
      data_ = read_table(file, array);
      values_ = data_->GetPointData()->GetArray(0);
    } else if (extension == ".vtu" || extension == ".vtp" || extension == ".vtk") {
      require_input_file(file, "a VTK file with values");
      data_ = read_vtk_data(file);
      find_array(array);
    } else {
      throw InputError(file_ + ": found the extension '" + extension +
                       "', expected .csv, .txt, .dat, .vtu, .vtp or .vtk");
    }
    if (data_->GetNumberOfPoints() == 0) throw InputError(file_ + ": found no points");
    for (vtkIdType k = 0; k < values_->GetNumberOfTuples(); ++k)
      if (!std::isfinite(values_->GetComponent(k, 0)))
        throw InputError(file_ + ": found a value that is not finite, expected finite numbers");
    double box[6];
    data_->GetBounds(box);
    box_ = Box3(Vec3(box[0], box[2], box[4]), Vec3(box[1], box[3], box[5]));
    if (data_->GetNumberOfCells() > 0) {
      cells_->SetDataSet(data_);
      cells_->BuildLocator();
    } else {
      points_->SetDataSet(data_);
      points_->BuildLocator();
    }
  }

  double size() const { return box_.diagonal().norm(); }

  double at(const Vec3& x) {
    constexpr double far = 0.1;
    if (const double outside = std::sqrt(box_.squaredExteriorDistance(x)); outside > far * size())
      throw InputError(file_ + ": found its values " + format_number(outside) + " away from " +
                       format_point(x) +
                       ", expected values at the surface: check the unit and the position");
    Vec3 closest = Vec3::Zero();
    double value = 0;
    if (data_->GetNumberOfCells() > 0) {
      vtkIdType cell = -1;
      int part = 0;
      double squared = 0;
      cells_->FindClosestPoint(x.data(), closest.data(), cell_, cell, part, squared);
      value = of_cells_ ? values_->GetComponent(cell, 0) : interpolated(closest, cell);
    } else {
      const vtkIdType point = points_->FindClosestPoint(x.data());
      data_->GetPoint(point, closest.data());
      value = values_->GetComponent(point, 0);
    }
    return value;
  }

 private:
  void find_array(const std::string& array) {
    std::vector<std::string> names;
    values_ = scalar_named(data_->GetPointData(), array, names);
    vtkDataArray* const of_cells = scalar_named(data_->GetCellData(), array, names);
    if (!values_ && of_cells) {
      values_ = of_cells;
      of_cells_ = true;
    }
    if (names.empty())
      throw InputError(file_ + ": found no scalar data, expected an array with one component");
    if (array.empty() && names.size() > 1)
      throw InputError(
          file_ + ": found several arrays, expected array = one of: " + comma_separated(names));
    if (!values_)
      throw InputError(file_ + ": found no array '" + array + "', expected " +
                       expected_one_of(array, names));
  }
  double interpolated(const Vec3& closest, vtkIdType cell) {
    data_->GetCell(cell, cell_);
    weights_.resize(static_cast<size_t>(std::max(1, static_cast<int>(cell_->GetNumberOfPoints()))));
    double pcoords[3], distance = 0, unused[3];
    int part = 0;
    cell_->EvaluatePosition(closest.data(), unused, part, pcoords, distance, weights_.data());
    double sum = 0;
    for (int k = 0; k < isize(weights_); ++k)
      sum += weights_[static_cast<size_t>(k)] * values_->GetComponent(cell_->GetPointId(k), 0);
    return sum;
  }

  std::string file_;
  vtkSmartPointer<vtkPointSet> data_;
  vtkDataArray* values_ = nullptr;
  bool of_cells_ = false;
  Box3 box_;
  vtkNew<vtkStaticCellLocator> cells_;
  vtkNew<vtkStaticPointLocator> points_;
  vtkNew<vtkGenericCell> cell_;
  std::vector<double> weights_;
};

PointField::PointField(const std::filesystem::path& file, const std::string& array)
    : data_(std::make_shared<Data>(file, array)) {}

double PointField::at(const Vec3& x) const { return data_->at(x); }

double PointField::size() const { return data_->size(); }

}  // namespace batten
