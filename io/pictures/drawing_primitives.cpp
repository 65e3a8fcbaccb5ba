#include "batten/io/pictures/drawing_primitives.h"

#include <vtkCellArray.h>
#include <vtkContourFilter.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace batten::detail {

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
  // A flat surface has no contours, only rounding.
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

}  // namespace batten::detail
