// SPDX-License-Identifier: MPL-2.0
#include "batten/io/pictures/comb_pictures.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fairing/curves/fair_curve.h"
#include "batten/io/pictures/canvas.h"
#include "batten/io/pictures/drawing_primitives.h"

namespace batten {
namespace {

using namespace detail;

const Colour kCurve(0.09, 0.20, 0.40), kTooth(0.86, 0.36, 0.22), kDot(0.45, 0.60, 0.72),
    kCircle(0.16, 0.52, 0.44);

/// In parallel projection everything is drawn in one plane (the "paper"), in layers ordered by
/// depth.
constexpr double kLegendRows = 3.6;  // rows of labels below the curves
enum Layer { kBand, kTeeth, kTips, kDots, kCurves, kCircles, kLegend };

/// Lines, triangles or dots of one colour on one layer of the paper.
class Ink {
 public:
  Ink(const ViewAxes& axes, Layer layer, double depth)
      : axes_(axes), height_(static_cast<double>(layer) * depth) {
    points_->SetDataTypeToDouble();
  }
  void line(const std::vector<Vec3>& chain) {
    if (chain.size() < 2) return;
    lines_->InsertNextCell(isize(chain));
    for (const Vec3& p : chain) lines_->InsertCellPoint(add(p));
  }
  void quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const vtkIdType corners[4] = {add(a), add(b), add(c), add(d)};
    faces_->InsertNextCell(4, corners);
  }
  void dot(const Vec3& p) {
    const vtkIdType id = add(p);
    dots_->InsertNextCell(1, &id);
  }
  vtkSmartPointer<vtkPolyData> data() const {
    auto result = vtkSmartPointer<vtkPolyData>::New();
    result->SetPoints(points_);
    result->SetLines(lines_);
    result->SetPolys(faces_);
    result->SetVerts(dots_);
    return result;
  }

 private:
  vtkIdType add(const Vec3& p) {
    return points_->InsertNextPoint(axes_.right.dot(p), axes_.up.dot(p), height_);
  }
  const ViewAxes& axes_;
  double height_;
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> lines_, faces_, dots_;
};

/// A curve prepared for drawing: polyline and comb.
struct Drawn {
  std::vector<Vec3> line;
  std::vector<CurvatureCombSample> teeth;
};

struct Drawing {
  std::vector<std::vector<Drawn>> panels;
  ViewAxes axes{0, 0};
  double size = 0;     // diagonal of everything on the paper
  double scale = 0;    // tooth length over curvature; 0: all curves are straight
  double longest = 0;  // maximum tooth length

  Vec3 tip(const CurvatureCombSample& tooth) const {
    return tooth.point + std::min(longest, scale * tooth.curvature) * tooth.outward;
  }
  bool cut(const CurvatureCombSample& tooth) const { return scale * tooth.curvature > longest; }
};

double diagonal(const std::vector<Vec3>& points) {
  return points.empty() ? 0 : bounding_box(points).diagonal().norm();
}

Drawn drawn(const HermiteCurve& curve, int teeth) {
  Drawn result;
  const int each = std::clamp(2000 / curve.segment_count(), 4, 64);
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = s == 0 ? 0 : 1; k <= each; ++k)
      result.line.push_back(curve.evaluate({s, static_cast<double>(k) / each}));
  result.teeth = curvature_comb(curve, teeth);
  std::erase_if(result.teeth, [](const CurvatureCombSample& t) {
    return !t.point.allFinite() || !t.outward.allFinite() || !std::isfinite(t.curvature);
  });
  return result;
}

/// Smallest value whose cumulative weight reaches the fraction `part` of the total weight.
double percentile(std::vector<std::pair<double, double>> value_and_weight, double part) {
  std::sort(value_and_weight.begin(), value_and_weight.end());
  double whole = 0, sum = 0;
  for (const auto& [value, weight] : value_and_weight) whole += weight;
  for (const auto& [value, weight] : value_and_weight)
    if ((sum += weight) >= part * whole) return value;
  return 0;
}

Drawing prepare(const CombPicture& picture) {
  Drawing drawing;
  std::vector<Vec3> all;
  for (const CombPanel& panel : picture.panels) {
    std::vector<Drawn> curves;
    double total = 0;
    std::vector<double> lengths;
    for (const HermiteCurve& curve : panel.curves) lengths.push_back(curve.length());
    for (const double length : lengths) total += length;
    const double most = panel.curves.size() == 1 ? 300 : 1500;
    for (size_t c = 0; c < lengths.size(); ++c)
      curves.push_back(
          drawn(panel.curves[c], std::max(8, static_cast<int>(most * lengths[c] / total))));
    for (const Drawn& curve : curves) all.insert(all.end(), curve.line.begin(), curve.line.end());
    drawing.panels.push_back(std::move(curves));
  }
  drawing.axes =
      picture.view ? ViewAxes(picture.view->first, picture.view->second) : best_view(all);
  drawing.size = diagonal(all);
  std::vector<std::pair<double, double>> curvatures, sizes;
  for (const Drawn& curve : drawing.panels[picture.scale_panel]) {
    // Teeth are weighted by the curve length that they represent.
    for (size_t i = 0; i + 1 < curve.teeth.size(); ++i)
      curvatures.emplace_back(curve.teeth[i].curvature,
                              (curve.teeth[i + 1].point - curve.teeth[i].point).norm());
    sizes.emplace_back(diagonal(curve.line), 1);
  }
  const double typical = percentile(curvatures, 0.95);
  if (typical * drawing.size > 1e-6) {
    // In a sketch with many curves, the tooth length follows the size of the curves, not of the
    // sketch.
    const double tooth = std::min(drawing.size / 8, percentile(sizes, 0.5) / 4);
    drawing.scale = tooth / typical;
    drawing.longest = 1.5 * tooth;
  }
  return drawing;
}

void add_band(vtkRenderer& renderer, const Ink& band) {
  const auto shade = actor(nullptr, band.data(), kTooth);
  shade->GetProperty()->LightingOff();
  shade->GetProperty()->SetOpacity(0.16);
  renderer.AddActor(shade);
}

/// Draws the legend: bars of known length for curvature and for model length.
void add_legend(vtkRenderer& renderer, const CombPicture& picture, const Drawing& drawing,
                const Fit& view, const Viewport& viewport, double bottom) {
  const double text = label_pixels(viewport.width, viewport.height), left = 28 * viewport.unit;
  const double room = viewport.width / 2 - left;
  const auto bar = [&](double x, double y, double length, const Colour& colour) {
    // The point of the paper at a pixel.
    const auto at = [&](double px, double py) {
      return Vec3(view.focus.x() + (px - viewport.width / 2) * view.pixel,
                  view.focus.y() + (py - viewport.height / 2) * view.pixel, 0);
    };
    const ViewAxes paper(0, 90);
    Ink ink(paper, kLegend, 0);
    ink.line({at(x, y), at(x + length, y)});
    const double tick = 5 * viewport.unit;
    for (const double end : {x, x + length}) ink.line({at(end, y - tick), at(end, y + tick)});
    add_thin_lines(renderer, ink.data(), colour, 2 * viewport.unit, Vec3::Zero());
  };
  const auto entry = [&](int row, double length, const Colour& colour, const std::string& label) {
    const double y = bottom + (0.8 + 1.6 * row) * text;
    bar(left, y, length, colour);
    const double x = left + length + 0.7 * text;
    add_text(renderer, label, x, y, text, viewport.width - x, false);
  };
  const double length = round_step(0.6 * room * view.pixel);
  entry(0, length / view.pixel, kCurve, format_number(length) + " " + picture.unit);
  if (drawing.scale == 0) return;
  const double curvature = round_step(0.6 * room * view.pixel / drawing.scale);
  entry(1, curvature * drawing.scale / view.pixel, kTooth,
        "curvature " + format_number(curvature) + " / " + picture.unit + " (radius " +
            format_number(1 / curvature) + " " + picture.unit + ")");
}

class Panel {
 public:
  Panel(vtkRenderer& renderer, const Drawing& drawing, const Viewport& viewport, const Fit& view)
      : renderer_(renderer),
        drawing_(drawing),
        viewport_(viewport),
        view_(view),
        depth_(drawing.size > 0 ? 1e-3 * drawing.size : 1e-3) {}

  void add(const CombPanel& panel, const std::vector<Drawn>& curves) {
    Ink band = ink(kBand), teeth = ink(kTeeth), tips = ink(kTips), dots = ink(kDots),
        lines = ink(kCurves), circles = ink(kCircles);
    for (const Drawn& curve : curves) {
      lines.line(curve.line);
      if (drawing_.scale > 0) comb(curve.teeth, band, teeth, tips);
    }
    for (const Vec3& p : panel.points) dots.dot(p);
    for (const auto& [centre, radius] : panel.spheres) circles.line(circle(centre, radius));
    const double few = curves.size() > 8 ? 0.6 : 1;  // sketches with many curves get thinner lines
    add_band(renderer_, band);
    add_thin_lines(renderer_, teeth.data(), kTooth, 0.8 * few * viewport_.unit, Vec3::Zero());
    add_thin_lines(renderer_, tips.data(), kTooth, 1.5 * few * viewport_.unit, Vec3::Zero());
    add_dots(renderer_, dots.data(), kDot, 3.4 * few * viewport_.unit);
    add_thin_lines(renderer_, lines.data(), kCurve, 2.8 * few * viewport_.unit, Vec3::Zero());
    add_thin_lines(renderer_, circles.data(), kCircle, 2 * viewport_.unit, Vec3::Zero());
  }

 private:
  Ink ink(Layer layer) const { return {drawing_.axes, layer, depth_}; }

  /// Draws the comb of a curve. Two teeth at the same point are the two sides of a corner or a
  /// curvature jump, and a cut tooth has no tip; the tip line is interrupted there.
  void comb(const std::vector<CurvatureCombSample>& all, Ink& band, Ink& teeth, Ink& tips) const {
    std::vector<Vec3> chain;
    Vec3 last = Vec3::Constant(1e300);
    for (size_t i = 0; i < all.size(); ++i) {
      const Vec3 tip = drawing_.tip(all[i]);
      if (drawing_.cut(all[i]) || (i > 0 && all[i].u <= all[i - 1].u)) {
        tips.line(chain);
        chain.clear();
      }
      if (!drawing_.cut(all[i])) {
        if (!chain.empty() && all[i].outward.dot(all[i - 1].outward) > 0)
          band.quad(all[i - 1].point, all[i].point, tip, chain.back());
        chain.push_back(tip);
      }
      // Closely spaced knots give more teeth than the picture can resolve.
      if ((all[i].point - last).norm() < 2.5 * view_.pixel && i + 1 < all.size()) continue;
      last = all[i].point;
      teeth.line({all[i].point, tip});
    }
    tips.line(chain);
  }

  std::vector<Vec3> circle(const Vec3& centre, double radius) const {
    std::vector<Vec3> chain;
    constexpr int sides = 72;
    for (int i = 0; i <= sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      chain.push_back(centre + radius * (std::cos(angle) * drawing_.axes.right +
                                         std::sin(angle) * drawing_.axes.up));
    }
    return chain;
  }

  vtkRenderer& renderer_;
  const Drawing& drawing_;
  const Viewport& viewport_;
  const Fit& view_;
  double depth_;
};

/// All points that must be in view, in paper coordinates.
std::vector<Vec3> extent(const CombPicture& picture, const Drawing& drawing) {
  std::vector<Vec3> points;
  const auto add = [&](const Vec3& p) {
    points.emplace_back(drawing.axes.right.dot(p), drawing.axes.up.dot(p), 0);
  };
  for (const auto& panel : drawing.panels)
    for (const Drawn& curve : panel) {
      for (const Vec3& p : curve.line) add(p);
      for (const CurvatureCombSample& tooth : curve.teeth) add(drawing.tip(tooth));
    }
  for (const CombPanel& panel : picture.panels) {
    for (const Vec3& p : panel.points) add(p);
    for (const auto& [centre, radius] : panel.spheres)
      for (const double r : {-radius, radius}) {
        add(centre + r * drawing.axes.right);
        add(centre + r * drawing.axes.up);
      }
  }
  return points;
}

/// Default size: 1600 pixels wide; the height of the panels follows their content.
PictureSize natural_size(const std::vector<Vec3>& in_view, int count, int columns) {
  const Box3 box = bounding_box(in_view);
  const int rows = (count + columns - 1) / columns;
  const double width = 1600.0 / columns, text = 110;
  const double shape = box.sizes().x() > 0 ? box.sizes().y() / box.sizes().x() : 1;
  const double height = std::clamp(width * std::clamp(shape, 0.3, 1.4) + text, 320.0, 1200.0);
  return {1600, std::min(4096, static_cast<int>(rows * height))};
}

std::string title_of(const CombPanel& panel, const Drawing& drawing,
                     const std::vector<Drawn>& curves) {
  size_t cut = 0, all = 0;
  for (const Drawn& curve : curves)
    for (const CurvatureCombSample& tooth : curve.teeth) {
      cut += drawing.scale > 0 && drawing.cut(tooth);
      ++all;
    }
  if (cut == 0) return panel.title;
  const double part = static_cast<double>(cut) / static_cast<double>(all);
  const std::string how_many = cut == all    ? "all"
                               : part < 0.01 ? "under 1 % of"
                                             : format_number(std::floor(100 * part)) + " % of";
  return panel.title + (panel.title.empty() ? "" : "  ") + "(" + how_many + " comb lines clipped)";
}

void check(const CombPicture& picture) {
  if (picture.panels.empty()) throw InputError("found no panel to draw, expected at least one");
  for (const CombPanel& panel : picture.panels) {
    if (panel.curves.empty())
      throw InputError("panel '" + panel.title +
                       "': found no curve to draw, expected at least one");
    for (const HermiteCurve& curve : panel.curves)
      if (curve.segment_count() < 1)
        throw InputError("panel '" + panel.title + "': found a curve without segments");
  }
  const int count = isize(picture.panels);
  if (picture.scale_panel < 0 || picture.scale_panel >= count)
    throw InputError("found the scale panel " + std::to_string(picture.scale_panel) +
                     ", expected 0 to " + std::to_string(count - 1));
  if (picture.view &&
      (!std::isfinite(picture.view->first) || !(std::abs(picture.view->second) <= 90)))
    throw InputError("found elevation " + format_number(picture.view->second) +
                     ", expected -90 to 90 degrees");
}

}  // namespace

void draw_combs(const std::filesystem::path& path, const CombPicture& picture,
                const std::optional<PictureSize>& given) {
  check(picture);
  const int count = isize(picture.panels);
  const bool below = count > 1;
  const int columns = std::min(count, picture.columns > 0 ? picture.columns : 3);
  const Drawing drawing = prepare(picture);
  const std::vector<Vec3> in_view = extent(picture, drawing);
  const ViewAxes paper(0, 90);
  const PictureSize size = given.value_or(natural_size(in_view, count, columns));
  draw_sheet(path, count, columns, below, size,
             [&](vtkRenderer& renderer, int i, double width, double height) {
               const auto index = static_cast<size_t>(i);
               const CombPanel& panel = picture.panels[index];
               const auto& curves = drawing.panels[index];
               const std::string title = title_of(panel, drawing, curves);
               // All panels get the same drawing area, with or without a caption.
               const Viewport viewport = viewport_of(width, height, "x", below, kLegendRows);
               const Fit view = fit(in_view, paper, viewport, 1);
               renderer.SetBackground(0.985, 0.985, 0.98);
               Panel(renderer, drawing, viewport, view).add(panel, curves);
               const double text = label_pixels(width, height);
               if (i == 0)
                 add_legend(renderer, picture, drawing, view, viewport,
                            viewport.bottom - kLegendRows * text);
               add_title(renderer, title, width, height, below);
               set_camera(renderer, paper, view, width, height);
             });
}

namespace {

using namespace detail;

struct EdgeStyle {
  EdgeComb::Kind kind;
  const char* label;
  Colour colour;
};
const std::array<EdgeStyle, 3> looks{
    {{EdgeComb::Kind::Crease, "creases (G0)", {0.80, 0.20, 0.14}},
     {EdgeComb::Kind::Tangent, "tangent (G1)", {0.13, 0.40, 0.75}},
     {EdgeComb::Kind::Curvature, "curvature-continuous (G2)", {0.10, 0.55, 0.30}}}};

/// Polylines as VTK data.
class Chains {
 public:
  void add(const std::vector<Vec3>& chain) {
    if (chain.size() < 2) return;
    cells_->InsertNextCell(isize(chain));
    for (const Vec3& p : chain) cells_->InsertCellPoint(points_->InsertNextPoint(p.data()));
  }
  vtkSmartPointer<vtkPolyData> data() const {
    auto result = vtkSmartPointer<vtkPolyData>::New();
    result->SetPoints(points_);
    result->SetLines(cells_);
    return result;
  }

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> cells_;
};

/// Tooth length per unit of curvature, and the maximum length of a tooth.
struct Scale {
  double of_curvature = 0, longest = 0;

  Scale(const EdgePicture& picture, double size) {
    std::vector<double> curvatures;
    for (const EdgeComb& edge : picture.edges)
      for (const auto& curvature_vectors : edge.curvature_vectors)
        for (const Vec3& bend : curvature_vectors) curvatures.push_back(bend.norm());
    if (curvatures.empty()) return;
    const auto most = curvatures.begin() + static_cast<long>(0.95 * (isize(curvatures) - 1));
    std::nth_element(curvatures.begin(), most, curvatures.end());
    if (!(*most * size > 1e-6)) return;  // no face is curved
    of_curvature = size / 10 / *most;
    longest = 1.5 * size / 10;
  }
  Vec3 tip(const Vec3& at, const Vec3& bend) const {
    const double length = std::min(longest, of_curvature * bend.norm());
    return length > 0 ? Vec3(at - length * bend.normalized()) : at;
  }
};

std::vector<Vec3> extent(const EdgePicture& picture) {
  std::vector<Vec3> points;
  for (const EdgeComb& edge : picture.edges)
    points.insert(points.end(), edge.line.begin(), edge.line.end());
  for (const auto& rim : picture.free_edges) points.insert(points.end(), rim.begin(), rim.end());
  return points;
}

/// Draws the legend at the lower left, in the colours of the edge kinds that it counts.
void add_legend(vtkRenderer& renderer, const EdgePicture& picture, const Scale& scale,
                const Viewport& viewport) {
  const double text = label_pixels(viewport.width, viewport.height), left = 28 * viewport.unit;
  std::string label;
  for (const EdgeStyle& look : looks) {
    const auto count = std::count_if(picture.edges.begin(), picture.edges.end(),
                                     [&](const EdgeComb& edge) { return edge.kind == look.kind; });
    const char* colours[] = {"red", "blue", "green"};
    label += (label.empty() ? "" : ",  ") + std::to_string(count) + " " + look.label + " (" +
             colours[&look - looks.data()] + ")";
  }
  if (!picture.free_edges.empty())
    label += ",  " + std::to_string(picture.free_edges.size()) + " free edges (grey)";
  add_text(renderer, label, left, 2.2 * text, text, viewport.width - 2 * left, false);
  if (scale.of_curvature > 0)
    add_text(renderer,
             "longest comb lines: curvature " + format_number(scale.longest / scale.of_curvature) +
                 " / " + picture.unit + " or more",
             left, 0.8 * text, text, viewport.width - 2 * left, false);
}

}  // namespace

void draw_edge_combs(const std::filesystem::path& path, const EdgePicture& picture,
                     const PictureSize& size) {
  const std::vector<Vec3> points = extent(picture);
  if (points.empty())
    throw InputError(path.string() + ": found no edges to draw, expected at least one");
  const double extent_of_all = bounding_box(points).diagonal().norm();
  const Scale scale(picture, extent_of_all);
  const ViewAxes axes(picture.view.first, picture.view.second);
  std::vector<Vec3> in_view = points;
  for (const EdgeComb& edge : picture.edges)
    for (const auto& curvature_vectors : edge.curvature_vectors)
      for (size_t k = 0; k < curvature_vectors.size(); ++k)
        in_view.push_back(scale.tip(edge.line[k], curvature_vectors[k]));
  const double few = picture.edges.size() > 500 ? 0.5 : 1;  // many edges are drawn thinner
  draw_sheet(path, 1, 1, false, size, [&](vtkRenderer& renderer, int, double width, double height) {
    const Viewport viewport = viewport_of(width, height, picture.title, false, kLegendRows);
    const Fit view = fit(in_view, axes, viewport, 1);
    renderer.SetBackground(0.985, 0.985, 0.98);
    const auto draw = [&](const Chains& chains, const Colour& colour, double pixels) {
      add_thin_lines(renderer, chains.data(), colour, pixels * few * viewport.unit, Vec3::Zero());
    };
    Chains free_edges;
    for (const auto& rim : picture.free_edges) free_edges.add(rim);
    draw(free_edges, kParameter, 2);
    for (const EdgeStyle& look : looks) {
      Chains lines, teeth, tips;
      for (const EdgeComb& edge : picture.edges) {
        if (edge.kind != look.kind) continue;
        lines.add(edge.line);
        for (const auto& curvature_vectors : edge.curvature_vectors) {
          std::vector<Vec3> chain;
          for (size_t k = 0; k < curvature_vectors.size(); ++k) {
            chain.push_back(scale.tip(edge.line[k], curvature_vectors[k]));
            teeth.add({edge.line[k], chain.back()});
          }
          tips.add(chain);
        }
      }
      draw(teeth, look.colour, 0.7);
      draw(tips, look.colour, 1.6);
      draw(lines, look.colour, 3.4);
    }
    add_legend(renderer, picture, scale, viewport);
    add_title(renderer, picture.title, width, height, false);
    set_camera(renderer, axes, view, width, height);
  });
}

}  // namespace batten
