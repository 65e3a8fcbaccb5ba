#include "batten/io/pictures/loop_pictures.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/box.h"
#include "batten/core/dense.h"
#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/pictures/canvas.h"
#include "batten/io/pictures/drawing_primitives.h"

namespace batten {
namespace {

using namespace detail;

using Loop = std::vector<HermiteCurve>;

std::vector<Vec3> points_along(const Loop& loop) {
  std::vector<Vec3> points;
  for (const Vec3& p : points_of(*polylines(loop))) points.push_back(p);
  return points;
}

/// The loop as one closed chain of points at even shares of its length.
std::vector<Vec3> chain(const Loop& loop, int count) {
  std::vector<Vec3> points;
  for (size_t k = 0; k < loop.size(); ++k) {
    std::vector<Vec3> more = points_along({loop[k]});
    const std::vector<Vec3> next = points_along({loop[(k + 1) % loop.size()]});
    const auto gap = [](const Vec3& p, const std::vector<Vec3>& ends) {
      return std::min((p - ends.front()).norm(), (p - ends.back()).norm());
    };
    const bool turned =
        k == 0 ? loop.size() > 1 && gap(more.front(), next) < gap(more.back(), next)
               : (more.back() - points.back()).norm() < (more.front() - points.back()).norm();
    if (turned) std::reverse(more.begin(), more.end());
    points.insert(points.end(), more.begin(), more.end());
  }
  std::vector<double> at(1, 0.0);
  for (size_t i = 1; i < points.size(); ++i)
    at.push_back(at.back() + (points[i] - points[i - 1]).norm());
  std::vector<Vec3> even;
  size_t i = 1;
  for (int k = 0; k < count; ++k) {
    const double s = at.back() * k / count;
    while (i + 1 < points.size() && at[i] < s) ++i;
    const double length = at[i] - at[i - 1];
    even.push_back(points[i - 1] +
                   (length > 0 ? (s - at[i - 1]) / length : 0) * (points[i] - points[i - 1]));
  }
  return even;
}

/// Triangles as VTK's data.
class Sheet {
 public:
  void triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
    const vtkIdType corners[3] = {add(a), add(b), add(c)};
    triangles_->InsertNextCell(3, corners);
  }
  vtkSmartPointer<vtkPolyData> data() const {
    auto result = vtkSmartPointer<vtkPolyData>::New();
    result->SetPoints(points_);
    result->SetPolys(triangles_);
    return result;
  }

 private:
  vtkIdType add(const Vec3& p) { return points_->InsertNextPoint(p.data()); }
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> triangles_;
};

constexpr int kAround = 240;  // points of a loop

/// A fan from the middle of the loop to its lines.
vtkSmartPointer<vtkPolyData> fan(const Loop& loop) {
  const std::vector<Vec3> rim = chain(loop, kAround);
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : rim) middle += p / kAround;
  Sheet sheet;
  for (size_t i = 0; i < rim.size(); ++i) sheet.triangle(middle, rim[i], rim[(i + 1) % kAround]);
  return sheet.data();
}

/// A band from loop to loop, turned so that it is as short as possible.
vtkSmartPointer<vtkPolyData> band(const Loop& one, const Loop& other) {
  const std::vector<Vec3> a = chain(one, kAround);
  std::vector<Vec3> b = chain(other, kAround), best;
  double least = std::numeric_limits<double>::infinity();
  for (int way = 0; way < 2; ++way) {
    for (int shift = 0; shift < kAround; shift += 4) {
      std::vector<Vec3> turned = b;
      std::rotate(turned.begin(), turned.begin() + shift, turned.end());
      double sum = 0;
      for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - turned[i]).squaredNorm();
      if (sum >= least) continue;
      least = sum;
      best = turned;
    }
    std::reverse(b.begin(), b.end());
  }
  Sheet sheet;
  for (size_t i = 0; i < a.size(); ++i) {
    const size_t next = (i + 1) % kAround;
    sheet.triangle(a[i], a[next], best[i]);
    sheet.triangle(a[next], best[next], best[i]);
  }
  return sheet.data();
}

std::vector<vtkSmartPointer<vtkPolyData>> sheets(const LoopAlternative& panel) {
  std::vector<vtkSmartPointer<vtkPolyData>> all;
  if (panel.one_surface && panel.loops.size() == 2) return {band(panel.loops[0], panel.loops[1])};
  for (const Loop& loop : panel.loops) all.push_back(fan(loop));
  return all;
}

Colour sheet_colour(int index) {
  constexpr double golden = 0.6180339887498949;
  Colour rgb;
  vtkMath::HSVToRGB(std::fmod(0.58 + index * golden, 1.0), 0.5, 0.9, &rgb[0], &rgb[1], &rgb[2]);
  return rgb;
}

/// The points of the loops, and of a box around them half as large again.
std::vector<Vec3> near(const std::vector<Vec3>& loops) {
  const Box3 box = bounding_box(loops);
  std::vector<Vec3> seen = loops;
  for (const Vec3& p : {box.min(), box.max()})
    seen.push_back(box.center() + 1.5 * (p - box.center()));
  return seen;
}

/// Looks at right angles onto loops that are nearly flat, from afar's direction onto others.
ViewAxes near_axes(const std::vector<Vec3>& loops, const ViewAxes& afar) {
  constexpr double flat = 0.05;  // of the largest spread, a square
  const Vec3 sizes = principal_axes(loops).values;
  return sizes[0] <= flat * sizes[2] ? best_view(loops) : afar;
}

void draw(vtkRenderer& renderer, const LoopPicture& picture, const LoopAlternative& panel,
          const ViewAxes& axes, const std::vector<Vec3>& visible_points, double width,
          double height) {
  add_lights(renderer);
  const Viewport viewport = viewport_of(width, height, panel.title, true, 0);
  const Fit view = fit(visible_points, axes, viewport, 1);
  const Vec3 offset = 4 * view.pixel * axes.towards;
  int index = 0;
  for (const auto& data : sheets(panel)) {
    const auto sheet = actor(nullptr, data, sheet_colour(index++));
    sheet->GetProperty()->LightingOff();
    sheet->GetProperty()->SetOpacity(0.55);
    renderer.AddActor(sheet);
  }
  for (const Loop& loop : panel.loops)
    add_tubes(renderer, polylines(loop), kLine, 2.6 * viewport.unit * view.pixel, offset);
  add_thin_lines(renderer, polylines(picture.lines), kMesh, 1.6 * viewport.unit, Vec3::Zero());
  add_title(renderer, panel.title, width, height, true);
  set_camera(renderer, axes, view, width, height);
}

}  // namespace

void draw_loops(const std::filesystem::path& path, const LoopPicture& picture) {
  if (picture.alternatives.empty())
    throw InputError(path.string() + ": found no way to have surfaces");
  LoopAlternative everywhere{"where", {}, picture.alternatives.front().one_surface};
  std::vector<Vec3> all, of_loops;
  for (const HermiteCurve& line : picture.lines)
    for (const Vec3& p : points_along({line})) all.push_back(p);
  for (const LoopAlternative& way : picture.alternatives)
    for (const Loop& loop : way.loops) {
      everywhere.loops.push_back(loop);
      for (const Vec3& p : points_along(loop)) of_loops.push_back(p);
    }
  if (of_loops.empty()) throw InputError(path.string() + ": found ways without a loop of lines");
  const ViewAxes afar(picture.azimuth, picture.elevation), close = near_axes(of_loops, afar);
  const std::vector<Vec3> nearby = near(of_loops);
  const int panels = 1 + isize(picture.alternatives), columns = std::min(panels, 3);
  const int rows = (panels + columns - 1) / columns;
  constexpr int wide = 700, high = 600;
  draw_sheet(path, panels, columns, true, {wide * columns, high * rows},
             [&](vtkRenderer& renderer, int i, double width, double height) {
               if (i == 0)
                 draw(renderer, picture, everywhere, afar, all, width, height);
               else
                 draw(renderer, picture, picture.alternatives[static_cast<size_t>(i - 1)], close,
                      nearby, width, height);
             });
}

}  // namespace batten
