// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/drawing_primitives.h"

#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkContourFilter.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkFeatureEdges.h>
#include <vtkLookupTable.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "batten/core/eigen.h"

namespace batten::detail {

std::vector<Vec3> points_of(vtkPolyData& data) {
  std::vector<Vec3> points(static_cast<size_t>(data.GetNumberOfPoints()));
  for (size_t p = 0; p < points.size(); ++p)
    data.GetPoint(static_cast<vtkIdType>(p), points[p].data());
  return points;
}

void complete_normals(vtkPolyData& data, const std::vector<Vec3>& points) {
  vtkDataArray& normals = *data.GetPointData()->GetNormals();
  std::vector<Vec3> sum(points.size(), Vec3::Zero());
  vtkIdType count;
  const vtkIdType* corner;
  for (data.GetPolys()->InitTraversal(); data.GetPolys()->GetNextCell(count, corner);) {
    const Vec3 area =
        (points[corner[1]] - points[corner[0]]).cross(points[corner[2]] - points[corner[0]]);
    for (int i = 0; i < 3; ++i) sum[corner[i]] += area;
  }
  for (size_t p = 0; p < points.size(); ++p) {
    double n[3];
    normals.GetTuple(static_cast<vtkIdType>(p), n);
    if (n[0] == 0 && n[1] == 0 && n[2] == 0)
      normals.SetTuple(static_cast<vtkIdType>(p), sum[p].normalized().eval().data());
  }
}

vtkSmartPointer<vtkPolyData> extract_cells(vtkPolyData& data, vtkCellArray* lines,
                                           vtkCellArray* facets) {
  auto result = vtkSmartPointer<vtkPolyData>::New();
  result->SetPoints(data.GetPoints());
  result->GetPointData()->ShallowCopy(data.GetPointData());
  if (lines) result->SetLines(lines);
  if (facets) result->SetPolys(facets);
  return result;
}

vtkSmartPointer<vtkPolyData> feature_edges(vtkPolyData& facets) {
  vtkNew<vtkFeatureEdges> filter;
  filter->SetInputData(&facets);
  filter->ColoringOff();
  filter->NonManifoldEdgesOff();
  filter->SetFeatureAngle(30);
  filter->Update();
  return filter->GetOutput();
}

vtkSmartPointer<vtkPolyData> element_edges(const std::vector<const SkinnedRegion*>& regions,
                                           int tessellation) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  for (const auto* region : regions) {
    const Surface& surface = region->surface;
    const ParametricMesh& mesh = surface.mesh();
    for (const auto& e : mesh.edges()) {
      const int t = e.triangle[0], a = (e.local[0] + 1) % 3, b = (e.local[0] + 2) % 3;
      const auto at = [&](double s) {
        Location where{t, Vec3::Zero()};
        where.L[a] = 1 - s;
        where.L[b] = s;
        return where;
      };
      const auto inside = [&](double s) {
        return !surface.trim() || surface.trim()->loops().contains(mesh.shape(t).point(at(s).L));
      };
      std::vector<vtkIdType> chain;
      const auto add = [&](double s) {
        chain.push_back(points->InsertNextPoint(surface.position(at(s)).eval().data()));
      };
      const auto finish = [&] {
        if (chain.size() > 1)
          cells->InsertNextCell(static_cast<vtkIdType>(chain.size()), chain.data());
        chain.clear();
      };
      bool before = inside(0);
      if (before) add(0);
      for (int k = 1; k <= tessellation; ++k) {
        const double s = static_cast<double>(k) / tessellation;
        const bool now = inside(s);
        if (now != before) {
          double low = s - 1.0 / tessellation, high = s;
          for (int step = 0; step < 30; ++step) {
            const double middle = 0.5 * (low + high);
            (inside(middle) == before ? low : high) = middle;
          }
          add(low);
          if (before) finish();
        }
        if (now) add(s);
        before = now;
      }
      finish();
    }
  }
  auto result = vtkSmartPointer<vtkPolyData>::New();
  result->SetPoints(points);
  result->SetLines(cells);
  return result;
}

Range range_of(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {*low, *high};
}

vtkSmartPointer<vtkPolyData> iso_lines(vtkPolyData& facets, const std::vector<double>& values,
                                       const Range& range, int count) {
  vtkNew<vtkDoubleArray> scalars;
  for (const double value : values) scalars->InsertNextValue(value);
  const auto surface = extract_cells(facets, nullptr, facets.GetPolys());
  surface->GetPointData()->Initialize();
  surface->GetPointData()->SetScalars(scalars);
  const auto [low, high] = range;
  vtkNew<vtkContourFilter> filter;
  filter->SetInputData(surface);
  filter->ComputeScalarsOff();
  // The contours of a flat surface would show rounding errors only.
  const double size = std::max(std::abs(low), std::abs(high));
  if (high - low > 1e-12 * size)
    for (int i = 0; i < count; ++i) filter->SetValue(i, low + (i + 0.5) / count * (high - low));
  filter->Update();
  return filter->GetOutput();
}

vtkSmartPointer<vtkPolyData> polylines(const std::vector<HermiteCurve>& curves) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  for (const HermiteCurve& curve : curves) {
    const int n = 12 * curve.segment_count();
    cells->InsertNextCell(n + 1);
    for (int i = 0; i <= n; ++i) {
      const int segment = std::min(i / 12, curve.segment_count() - 1);
      const Vec3 x = curve.evaluate({segment, i / 12.0 - segment});
      cells->InsertCellPoint(points->InsertNextPoint(x.data()));
    }
  }
  auto result = vtkSmartPointer<vtkPolyData>::New();
  result->SetPoints(points);
  result->SetLines(cells);
  return result;
}

double rounded_up(double x) {
  const double power = std::pow(10, std::floor(std::log10(x)));
  for (const double digit : {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0})
    if (x <= digit * power * (1 + 1e-9)) return digit * power;
  return 10 * power;
}

double round_step(double x) {
  const double power = std::pow(10, std::floor(std::log10(x) + 1e-9)), digit = x / power;
  return power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

vtkSmartPointer<vtkLookupTable> diverging_colours(double limit) {
  vtkNew<vtkColorTransferFunction> colours;
  colours->SetColorSpaceToDiverging();
  colours->AddRGBPoint(-1, 0.230, 0.299, 0.754);
  colours->AddRGBPoint(0, 0.865, 0.865, 0.865);
  colours->AddRGBPoint(1, 0.706, 0.016, 0.150);
  auto table = vtkSmartPointer<vtkLookupTable>::New();
  constexpr int entries = 511;
  table->SetNumberOfTableValues(entries);
  for (int i = 0; i < entries; ++i) {
    double rgb[3];
    colours->GetColor(2.0 * i / (entries - 1) - 1, rgb);
    table->SetTableValue(i, rgb[0], rgb[1], rgb[2]);
  }
  table->SetRange(-limit, limit);
  return table;
}

namespace {

/// The sRGB colour of CIELAB lightness, chroma and hue (degrees), for the white point D65.
Vec3 from_lightness(double lightness, double chroma, double hue) {
  const double angle = hue * std::numbers::pi / 180;
  const double lab[3] = {lightness, chroma * std::cos(angle), chroma * std::sin(angle)};
  double rgb[3];
  vtkMath::LabToRGB(lab, rgb);
  return Vec3(rgb[0], rgb[1], rgb[2]).cwiseMax(0).cwiseMin(1);
}

}  // namespace

vtkSmartPointer<vtkLookupTable> sequential_colours(double limit) {
  auto table = vtkSmartPointer<vtkLookupTable>::New();
  constexpr int entries = 256;
  table->SetNumberOfTableValues(entries);
  for (int i = 0; i < entries; ++i) {
    const double t = static_cast<double>(i) / (entries - 1);
    const double chroma = 8 + 66 * std::pow(std::sin(std::numbers::pi * std::pow(t, 0.8)), 0.9);
    const Vec3 c = from_lightness(92 - 72 * t, chroma, 100 - 115 * std::pow(t, 0.9));
    table->SetTableValue(i, c.x(), c.y(), c.z());
  }
  table->SetRange(0, limit);
  return table;
}

vtkSmartPointer<vtkLookupTable> striped_colours(double low, double high, double from,
                                                double width) {
  auto table = vtkSmartPointer<vtkLookupTable>::New();
  const int entries = static_cast<int>(std::clamp(128 * (high - low) / width, 256.0, 65536.0));
  table->SetNumberOfTableValues(entries);
  const Vec3 light(0.95, 0.96, 0.97), dark(0.15, 0.18, 0.23);
  constexpr double soft = 0.08;  // width of the transition, as a fraction of a stripe
  for (int i = 0; i < entries; ++i) {
    const double place = (low + (i + 0.5) / entries * (high - low) - from) / width;
    const double nearest = std::round(place),
                 after = std::clamp((place - nearest) / soft, -0.5, 0.5);
    const double share = 0.5 + (std::fmod(nearest, 2) == 0 ? after : -after);
    const Vec3 c = share * light + (1 - share) * dark;
    table->SetTableValue(i, c[0], c[1], c[2]);
  }
  table->SetRange(low, high);
  return table;
}

Range finite_range(vtkDataArray& values) {
  Range range{kInfinity, -kInfinity};
  for (vtkIdType i = 0; i < values.GetNumberOfTuples(); ++i)
    if (const double v = values.GetTuple1(i); std::isfinite(v))
      range = {std::min(range.first, v), std::max(range.second, v)};
  return range.first <= range.second ? range : Range{0, 0};
}

double field_limit(vtkDataArray& values) {
  std::vector<double> sorted;
  for (vtkIdType i = 0; i < values.GetNumberOfTuples(); ++i)
    if (const double v = values.GetTuple1(i); std::isfinite(v)) sorted.push_back(v);
  if (sorted.empty()) return 1;
  std::sort(sorted.begin(), sorted.end());
  const size_t cut = sorted.size() / 50;
  const double limit = std::max(std::abs(sorted[cut]), std::abs(sorted[sorted.size() - 1 - cut]));
  return limit > 1e-300 ? rounded_up(limit) : 1;
}

}  // namespace batten::detail
