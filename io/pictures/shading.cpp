// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/shading.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkShaderProperty.h>
#include <vtkTexture.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/io/pictures/drawing_primitives.h"

namespace batten::detail {
namespace {

/// GLSL that replaces VTK's lighting. `gloss` scales the reflections, `contrast` the difference
/// between lit and unlit sides. In parallel projection, the view direction is (0, 0, 1).
const char* const kLighting = R"(
  vec3 n = normalVCVSOutput;
  vec3 mirrored = vec3(2.0 * n.z * n.xy, 2.0 * n.z * n.z - 1.0);
  float key = max(0.0, 0.1 + 0.9 * dot(n, vec3(-0.389, 0.622, 0.680)));
  float fill = max(0.0, dot(n, vec3(0.862, 0.051, 0.507)));
  vec3 light = mix(vec3(0.43, 0.44, 0.47), vec3(0.51, 0.52, 0.54), 0.5 + 0.5 * n.y)
             + 0.20 * n.z * n.z + key * vec3(0.48, 0.47, 0.45) + fill * vec3(0.11, 0.12, 0.14);
  light = mix(vec3(0.96), light, contrast);
  float lamp = smoothstep(0.50, 0.62, mirrored.y) * (1.0 - smoothstep(0.72, 0.88, mirrored.y))
             * smoothstep(-0.95, -0.45, mirrored.x) * (1.0 - smoothstep(0.25, 0.75, mirrored.x));
  float side_lamp = smoothstep(0.70, 0.84, mirrored.x)
                  * (1.0 - smoothstep(0.15, 0.60, abs(mirrored.y - 0.15)));
  float wave = abs(2.0 * fract(1.15 * mirrored.x + 0.3) - 1.0);
  wave = wave * wave * (3.0 - 2.0 * wave);
  float tubes = wave * wave * wave * smoothstep(0.15, 0.60, mirrored.y);
  float ceiling = smoothstep(-0.3, 0.8, mirrored.y);
  float fresnel = 1.0 - clamp(n.z, 0.0, 1.0);
  fresnel *= fresnel * fresnel * fresnel;
  float white = gloss * (0.36 * lamp + 0.20 * side_lamp + 0.13 * tubes + 0.06 * ceiling + 0.35 * ceiling * fresnel);
  vec3 seen = mix(diffuseColor * light, vec3(1.0), clamp(white, 0.0, 0.85));
  gl_FragData[0] = vec4(min(seen, vec3(1.0)), opacity);
)";

}  // namespace

void apply_finish(vtkActor& actor, Finish finish) {
  const auto [gloss, contrast] = finish == Finish::Paint   ? std::pair("1.0", "1.0")
                                 : finish == Finish::Curve ? std::pair("0.5", "0.7")
                                                           : std::pair("0.25", "0.6");
  std::string code = kLighting;
  code = "  const float gloss = " + std::string(gloss) + ", contrast = " + contrast + ";\n" + code;
  actor.GetProperty()->SetInterpolationToPhong();
  actor.GetProperty()->SetDiffuse(1);
  actor.GetProperty()->SetAmbient(0);
  actor.GetShaderProperty()->AddFragmentShaderReplacement("//VTK::Light::Impl", true, code, false);
}

namespace {

/// Grid of darkness values over the floor.
class FloorGrid {
 public:
  static constexpr int kSize = 192;

  /// A square around `box` on the floor, with room for the blurred border of the shadow.
  FloorGrid(const Vec2& low, const Vec2& high) : values_(kSize * kSize, 0.0F) {
    const double width = 1.7 * std::max(high.x() - low.x(), high.y() - low.y());
    cell_ = width / kSize;
    origin_ = (low + high) / 2 - Vec2::Constant(width / 2);
  }
  double width() const { return cell_ * kSize; }
  const Vec2& origin() const { return origin_; }
  const std::vector<float>& values() const { return values_; }

  /// Raises the cells whose centres lie in the triangle, and those of its corners, to `dark`.
  void cover(const std::array<Vec2, 3>& corners, float dark) {
    std::array<Vec2, 3> p;
    Vec2 low = Vec2::Constant(kSize), high = Vec2::Constant(-1);
    for (int i = 0; i < 3; ++i) {
      p[i] = (corners[i] - origin_) / cell_ - Vec2::Constant(0.5);
      low = low.cwiseMin(p[i]);
      high = high.cwiseMax(p[i]);
      raise(static_cast<int>(std::lround(p[i].x())), static_cast<int>(std::lround(p[i].y())), dark);
    }
    const auto side = [&](int i, double x, double y) {
      const Vec2 a = p[i], b = p[(i + 1) % 3];
      return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
    };
    for (int y = static_cast<int>(std::ceil(low.y())); y <= high.y(); ++y)
      for (int x = static_cast<int>(std::ceil(low.x())); x <= high.x(); ++x) {
        const double a = side(0, x, y), b = side(1, x, y), c = side(2, x, y);
        if ((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0)) raise(x, y, dark);
      }
  }

  /// Three box filters, nearly a Gaussian.
  void blur(double radius) {
    const int half = std::max(1, static_cast<int>(std::lround(radius / cell_)));
    for (int pass = 0; pass < 3; ++pass)
      for (const auto& [along, across] : {std::pair(1, kSize), std::pair(kSize, 1)})
        for (int row = 0; row < kSize; ++row) blur_row(&values_[row * across], along, half);
  }

 private:
  void raise(int x, int y, float dark) {
    if (x < 0 || y < 0 || x >= kSize || y >= kSize) return;
    float& value = values_[y * kSize + x];
    value = std::max(value, dark);
  }
  static void blur_row(float* row, int step, int half) {
    std::array<float, kSize + 1> sums{};
    for (int i = 0; i < kSize; ++i) sums[i + 1] = sums[i] + row[i * step];
    for (int i = 0; i < kSize; ++i)
      row[i * step] = (sums[std::min(kSize, i + half + 1)] - sums[std::max(0, i - half)]) /
                      static_cast<float>(2 * half + 1);
  }

  Vec2 origin_;
  double cell_ = 1;
  std::vector<float> values_;
};

/// A plane on the floor whose opacity is the darkness of a grid.
vtkSmartPointer<vtkActor> shadow_actor(const FloorGrid& grid, double strength, double height,
                                       int up_axis) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(FloorGrid::kSize, FloorGrid::kSize, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  auto* out = static_cast<unsigned char*>(image->GetScalarPointer());
  for (const float value : grid.values()) {
    *out++ = 38;
    *out++ = 46;
    *out++ = 58;
    *out++ = static_cast<unsigned char>(std::lround(255 * strength * value));
  }
  vtkNew<vtkTexture> texture;
  texture->SetInputData(image);
  texture->InterpolateOn();
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> texture_points;
  texture_points->SetNumberOfComponents(2);
  for (const auto& [u, v] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
    Vec3 p;
    p[(up_axis + 1) % 3] = grid.origin().x() + u * grid.width();
    p[(up_axis + 2) % 3] = grid.origin().y() + v * grid.width();
    p[up_axis] = height;
    points->InsertNextPoint(p.data());
    texture_points->InsertNextTuple2(u, v);
  }
  vtkNew<vtkCellArray> quad;
  const vtkIdType corners[4] = {0, 1, 2, 3};
  quad->InsertNextCell(4, corners);
  vtkNew<vtkPolyData> plane;
  plane->SetPoints(points);
  plane->SetPolys(quad);
  plane->GetPointData()->SetTCoords(texture_points);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(plane);
  auto shadow = vtkSmartPointer<vtkActor>::New();
  shadow->SetMapper(mapper);
  shadow->SetTexture(texture);
  shadow->GetProperty()->LightingOff();
  // Drawn behind everything else, without the cost of VTK's translucent pass.
  shadow->ForceOpaqueOn();
  shadow->GetShaderProperty()->AddFragmentShaderReplacement("//VTK::Depth::Impl", true,
                                                            "  gl_FragDepth = 1.0;\n", false);
  return shadow;
}

}  // namespace

void add_floor_shadow(vtkRenderer& renderer, vtkPolyData& facets, const ViewAxes& axes,
                      int up_axis) {
  const double rise = axes.towards[up_axis];  // sine of the elevation
  const double strength =
      0.62 * std::clamp((rise - 0.02) / 0.15, 0.0, 1.0) * std::clamp((0.97 - rise) / 0.2, 0.0, 1.0);
  const std::vector<Vec3> points = points_of(facets);
  if (strength <= 0 || points.empty()) return;
  const auto on_floor = [&](const Vec3& p) {
    return Vec2(p[(up_axis + 1) % 3], p[(up_axis + 2) % 3]);
  };
  const Box3 box = bounding_box(points);
  const double floor = box.min()[up_axis], size = box.diagonal().norm();
  if (!(size > 0)) return;
  FloorGrid grid(on_floor(box.min()), on_floor(box.max()));
  vtkIdType count;
  const vtkIdType* corner;
  for (facets.GetPolys()->InitTraversal(); facets.GetPolys()->GetNextCell(count, corner);)
    for (vtkIdType i = 2; i < count; ++i) {
      const Vec3 &a = points[corner[0]], &b = points[corner[i - 1]], &c = points[corner[i]];
      const double above = ((a + b + c)[up_axis] / 3 - floor) / size;
      grid.cover({on_floor(a), on_floor(b), on_floor(c)}, static_cast<float>(1 / (1 + 14 * above)));
    }
  grid.blur(0.026 * size);
  renderer.AddActor(shadow_actor(grid, strength, floor - 1e-3 * size, up_axis));
}

float OcclusionMap::at(double x, double y) const {
  const float px = std::clamp(static_cast<float>(x) / kOcclusionStep - 0.5F, 0.0F, columns - 1.0F),
              py = std::clamp(static_cast<float>(y) / kOcclusionStep - 0.5F, 0.0F, rows - 1.0F);
  const int i = static_cast<int>(px), j = static_cast<int>(py);
  const float u = px - static_cast<float>(i), v = py - static_cast<float>(j);
  const float* low = &factors[static_cast<size_t>(j) * columns];
  const float* high = j + 1 < rows ? low + columns : low;
  const int next = std::min(i + 1, columns - 1);
  return (1 - v) * ((1 - u) * low[i] + u * low[next]) + v * ((1 - u) * high[i] + u * high[next]);
}

namespace {

constexpr float kFar = 1e9F;       // depth of the background
constexpr float kFallOff = 0.14F;  // loss of light from the upper left to the lower right corner

/// Horizon-based ambient occlusion on a grid of depths, in cells.
class Horizons {
 public:
  Horizons(const std::vector<float>& depths, int columns, int rows)
      : depths_(depths), columns_(columns), rows_(rows) {
    const double size = std::sqrt(static_cast<double>(columns) * rows);
    for (const double part : {0.003, 0.007, 0.015, 0.03, 0.055})
      for (int k = 0; k < kDirections; ++k) {
        const double angle = std::numbers::pi * (k + 0.5) / kDirections;
        const double radius = std::max(1.5, part * size);
        const Vec2 step(std::round(radius * std::cos(angle)), std::round(radius * std::sin(angle)));
        steps_[k].push_back({static_cast<int>(step.x()), static_cast<int>(step.y()),
                             static_cast<float>(1 / step.norm())});
      }
  }

  /// Mean open fraction of the half planes through the line of sight.
  float open(int x, int y) const {
    const float here = depths_[y * columns_ + x];
    float closed = 0;
    for (const auto& steps : steps_) {
      float one = -1.5F, other = -1.5F;
      for (const Step& s : steps) {
        one = std::max(one, slope(x + s.x, y + s.y, here, s.inverse));
        other = std::max(other, slope(x - s.x, y - s.y, here, s.inverse));
      }
      closed += std::max(0.0F, std::atan(one) + std::atan(other) - kBias);
    }
    return 1 - closed / (static_cast<float>(std::numbers::pi) * kDirections);
  }

 private:
  static constexpr int kDirections = 4;
  static constexpr float kBias = 0.05F;       // radians; hides the edges between facets
  static constexpr float kLineHeight = 1.5F;  // cells; lines are drawn in front of the surface

  struct Step {
    int x, y;
    float inverse;  // of its length
  };

  float slope(int x, int y, float here, float inverse) const {
    if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return -1.5F;
    const float there = depths_[y * columns_ + x];
    const float value = (here - there - kLineHeight) * inverse;
    // Something much closer to the camera is another part, which casts no shadow here.
    return there == kFar || value > 4 ? -1.5F : std::min(value, 2.0F);
  }

  const std::vector<float>& depths_;
  int columns_, rows_;
  std::array<std::vector<Step>, kDirections> steps_;
};

/// Mean of 3 × 3 values, without those beyond a step in depth.
std::vector<float> smoothed(const std::vector<float>& values, const std::vector<float>& depths,
                            int columns, int rows) {
  std::vector<float> result = values;
  parallel_for_each<16>(rows, [&](int y) {
    for (int x = 0; x < columns; ++x) {
      const float here = depths[y * columns + x];
      if (here == kFar) continue;
      float sum = 0, weight = 0;
      for (int j = std::max(0, y - 1); j <= std::min(rows - 1, y + 1); ++j)
        for (int i = std::max(0, x - 1); i <= std::min(columns - 1, x + 1); ++i)
          if (std::abs(depths[j * columns + i] - here) < 3) {
            sum += values[j * columns + i];
            weight += 1;
          }
      result[y * columns + x] = sum / weight;
    }
  });
  return result;
}

}  // namespace

OcclusionMap ambient_occlusion(const vtkFloatArray& depths, int window_width, int left, int bottom,
                               int width, int height, double scale) {
  OcclusionMap map{std::max(1, width / kOcclusionStep), std::max(1, height / kOcclusionStep), {}};
  const float* buffer = const_cast<vtkFloatArray&>(depths).GetPointer(0);
  std::vector<float> cells(static_cast<size_t>(map.columns) * map.rows);
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.columns; ++x) {
      const long at =
          static_cast<long>(bottom + y * kOcclusionStep + kOcclusionStep / 2) * window_width +
          left + x * kOcclusionStep + kOcclusionStep / 2;
      const float depth = buffer[at];
      cells[y * map.columns + x] =
          depth < 1 ? static_cast<float>(depth * scale / kOcclusionStep) : kFar;
    }
  map.factors.assign(cells.size(), 1.0F);
  const Horizons horizons(cells, map.columns, map.rows);
  parallel_for_each<8>(map.rows, [&](int y) {
    for (int x = 0; x < map.columns; ++x)
      if (cells[y * map.columns + x] != kFar)
        map.factors[y * map.columns + x] =
            horizons.open(x, y) * (1 - kFallOff * (x * map.rows + (map.rows - y) * map.columns) /
                                           (2.0F * map.columns * map.rows));
  });
  map.factors =
      smoothed(smoothed(map.factors, cells, map.columns, map.rows), cells, map.columns, map.rows);
  return map;
}

}  // namespace batten::detail
