// Shading of the surface: scalar fields and their colours.
#include <vtkCellData.h>
#include <vtkFloatArray.h>
#include <vtkIntArray.h>
#include <vtkLookupTable.h>
#include <vtkPointData.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/apps/studio/view/layer.h"
#include "batten/apps/studio/view/shape_actors.h"

namespace batten::studio {
namespace {

constexpr double kStripes = 28;  // zebra stripes over 180°
constexpr int kBands = 24;

Vec3 triple(const float* values, int number) {
  const float* v = values + 3 * static_cast<long>(number);
  return {v[0], v[1], v[2]};
}

/// Quantile of the magnitudes of values.
double quantile(std::vector<float> values, double fraction) {
  for (float& v : values) v = std::abs(v);
  const auto at =
      values.begin() + static_cast<long>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

void ShapeActors::set_shading(Shading shading) {
  shading_ = shading;
  place_points();
  shade();
}

void ShapeActors::shade() {
  const bool anything = pattern_ && points_->GetNumberOfTuples() > 0;
  if (!anything || (shading_ == Shading::Shaded && !mesh_ && selected_facets_.empty()))
    facets_->mapper->ScalarVisibilityOff();
  else if (shading_ == Shading::Shaded)
    shade_facets(roles_, role_colours(palette_));
  else if ((shading_ == Shading::Stress && !shows_stress()) ||
           (shading_ == Shading::Modes && !mode_shape()))
    facets_->mapper->ScalarVisibilityOff();
  else if (shading_ == Shading::Regions)
    shade_facets(facet_regions_, region_colours(static_cast<int>(regions_.size())));
  else
    shade_points();
}

bool ShapeActors::shows_stress() const {
  return stress_ && stress_->values.size() == static_cast<size_t>(points_->GetNumberOfTuples());
}

bool ShapeActors::has_scalar_field() const {
  return shading_ == Shading::Displacement || shading_ == Shading::Curvature ||
         shading_ == Shading::Strain || (shading_ == Shading::Stress && shows_stress()) ||
         mode_shape();
}

vtkLookupTable* ShapeActors::scale() const { return has_scalar_field() ? table_.Get() : nullptr; }

std::optional<double> ShapeActors::value_at(const Vec3& p) const {
  const int point = has_scalar_field() ? point_near(p) : -1;
  if (point < 0) return std::nullopt;
  return scalars_->GetValue(point);
}

void ShapeActors::shade_facets(vtkIntArray* values, vtkLookupTable* table) {
  vtkPolyDataMapper& mapper = *facets_->mapper;
  facets_->data->GetCellData()->SetScalars(values);
  mapper.ScalarVisibilityOn();
  mapper.SetScalarModeToUseCellData();
  mapper.InterpolateScalarsBeforeMappingOff();
  mapper.SetLookupTable(table);
  mapper.SetScalarRange(table->GetTableRange());
}

// The description of a mesh may arrive before its points.
bool ShapeActors::mesh_is_drawn() const {
  return mesh_ && mesh_->roles.size() == static_cast<size_t>(points_->GetNumberOfTuples());
}

// Colours facets whose corners all have the same role; selected facets get a colour of their own.
void ShapeActors::make_roles() {
  roles_->SetNumberOfTuples(0);
  if (!pattern_) return;
  const auto n = static_cast<vtkIdType>(pattern_->facets.size());
  roles_->SetNumberOfTuples(n);
  const bool fits = mesh_is_drawn();
  for (vtkIdType i = 0; i < n; ++i) {
    const auto& facet = pattern_->facets[static_cast<size_t>(i)];
    int role = 0;
    if (fits) {
      const auto of = [&](int corner) {
        return static_cast<int>(
            mesh_->roles[static_cast<size_t>(facet[static_cast<size_t>(corner)])]);
      };
      if (of(0) == of(1) && of(1) == of(2)) role = of(0);
    }
    roles_->SetValue(i, role);
  }
  for (const int facet : selected_facets_) roles_->SetValue(facet, kSelectedRole);
  roles_->Modified();
}

void ShapeActors::shade_points() {
  const vtkIdType n = points_->GetNumberOfTuples();
  scalars_->SetNumberOfComponents(1);
  scalars_->SetNumberOfTuples(n);
  float* value = scalars_->GetPointer(0);
  const float *x = points_->GetPointer(0), *normal = normals_->GetPointer(0);
  const Vec3 along = Vec3(1, 0.6, 0).normalized();
  if (shading_ == Shading::Curvature)
    measure_curvature(value);
  else if (shading_ == Shading::Strain)
    measure_strain(value);
  else if (shading_ == Shading::Stress)
    std::copy(stress_->values.begin(), stress_->values.end(), value);
  else if (shading_ == Shading::Modes)
    for (vtkIdType i = 0; i < n; ++i)
      value[i] = static_cast<float>(triple(mode_shape()->data(), static_cast<int>(i)).norm());
  else
    for (vtkIdType i = 0; i < n; ++i) {
      const int p = static_cast<int>(i);
      if (shading_ == Shading::Zebra)
        value[i] =
            static_cast<float>(std::acos(std::clamp(triple(normal, p).dot(along), -1.0, 1.0)) *
                               180 / std::numbers::pi);
      else if (shading_ == Shading::Contours)
        value[i] = x[3 * i + 2];
      else
        value[i] = static_cast<float>((triple(x, p) - triple(reference_.data(), p)).norm());
    }
  scalars_->Modified();
  facets_->data->GetPointData()->SetScalars(scalars_);
  table_ = table_of(value, static_cast<size_t>(n));
  vtkPolyDataMapper& mapper = *facets_->mapper;
  mapper.ScalarVisibilityOn();
  mapper.SetScalarModeToUsePointData();
  mapper.InterpolateScalarsBeforeMappingOn();
  mapper.SetLookupTable(table_);
  mapper.SetScalarRange(table_->GetTableRange());
}

vtkSmartPointer<vtkLookupTable> ShapeActors::table_of(const float* value, size_t n) {
  const auto [low, high] = std::minmax_element(value, value + n);
  const Rgb light{0.97, 0.97, 0.97}, ink{0.13, 0.15, 0.19};
  range_ = {*high, std::max(std::abs(*low), std::abs(*high))};
  switch (shading_) {
    case Shading::Zebra:
      range_ = {0, 0};
      return stripes(0, 180, static_cast<int>(2 * kStripes), light, ink);
    case Shading::Contours:
      return stripes(*low, *high > *low ? *high : *low + 1, kBands, palette_.body, light);
    case Shading::Curvature:
    case Shading::Strain: {
      // Clip the scale: values at ends and corners would leave one colour for all the rest.
      const double limit = std::max(quantile(std::vector<float>(value, value + n), 0.98), 1e-30);
      range_[0] = limit;
      return two_sided(limit);
    }
    case Shading::Stress: {
      // Clip the scale: the values at a point load would leave one colour for all the rest.
      const double limit = std::max(quantile(std::vector<float>(value, value + n), 0.995), 1e-30);
      range_ = {limit, stress_->von_mises};
      return distances(limit);
    }
    default:
      return distances(std::max<double>(*high, 1e-30));
  }
}

// Mean curvature at the display points. Per facet, the shape operator is the least-squares fit to
// the changes of the normals along its edges [Rusinkiewicz2004]. Point values are area-weighted
// means over facets. Positive if the surface is concave on the normal's side.
void ShapeActors::measure_curvature(float* value) const {
  const auto n = static_cast<size_t>(points_->GetNumberOfTuples());
  const float *x = points_->GetPointer(0), *normal = normals_->GetPointer(0);
  std::vector<double> sum(n, 0), weight(n, 0);
  for (const auto& facet : pattern_->facets) {
    const Vec3 first = triple(x, facet[1]) - triple(x, facet[0]);
    const Vec3 area = first.cross(triple(x, facet[2]) - triple(x, facet[0]));
    const double size = area.norm();
    if (!(size > 0)) continue;
    const Vec3 u = first.normalized(), v = area.cross(first).normalized();
    Mat3 A = Mat3::Zero();  // of the components uu, uv and vv of the operator
    Vec3 b = Vec3::Zero();
    for (size_t k = 0; k < 3; ++k) {
      const Vec3 edge = triple(x, facet[(k + 1) % 3]) - triple(x, facet[k]);
      const Vec3 change = triple(normal, facet[(k + 1) % 3]) - triple(normal, facet[k]);
      const double eu = edge.dot(u), ev = edge.dot(v);
      const Vec3 rows[] = {{eu, ev, 0}, {0, eu, ev}};
      const double rhs[] = {change.dot(u), change.dot(v)};
      for (int i = 0; i < 2; ++i) {
        A += rows[i] * rows[i].transpose();
        b += rhs[i] * rows[i];
      }
    }
    const Vec3 shape = A.ldlt().solve(b);
    for (const int p : facet) {
      sum[static_cast<size_t>(p)] -= 0.5 * size * (shape[0] + shape[2]);
      weight[static_cast<size_t>(p)] += size;
    }
  }
  for (size_t i = 0; i < n; ++i)
    value[i] = static_cast<float>(weight[i] > 0 ? sum[i] / weight[i] : 0);
}

// Signed principal strain of largest magnitude since meshing, over the facets at each point.
void ShapeActors::measure_strain(float* value) const {
  std::fill(value, value + points_->GetNumberOfTuples(), 0.0F);
  for (const auto& facet : pattern_->facets) {
    const auto frame_of = [&](const float* points) {
      Eigen::Matrix<double, 3, 2> sides;
      sides << triple(points, facet[1]) - triple(points, facet[0]),
          triple(points, facet[2]) - triple(points, facet[0]);
      return sides;
    };
    const auto before = frame_of(reference_.data()), after = frame_of(points_->GetPointer(0));
    // The new metric in a frame that was orthonormal before (RᵀR = old metric).
    const Eigen::Matrix2d metric = before.transpose() * before;
    const Eigen::LLT<Eigen::Matrix2d> factor(metric);
    if (factor.info() != Eigen::Success) continue;
    Eigen::Matrix2d strain = after.transpose() * after;
    factor.matrixL().solveInPlace(strain);
    strain = factor.matrixL().solve(strain.transpose().eval()).eval();
    const Eigen::Vector2d squares =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(strain, Eigen::EigenvaluesOnly)
            .eigenvalues();
    const double low = std::sqrt(std::max(squares[0], 0.0)) - 1,
                 high = std::sqrt(std::max(squares[1], 0.0)) - 1;
    const auto worst = static_cast<float>(std::abs(low) > std::abs(high) ? low : high);
    for (const int p : facet)
      if (std::abs(worst) > std::abs(value[p])) value[p] = worst;
  }
}

}  // namespace batten::studio
