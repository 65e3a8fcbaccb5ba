#include "batten/io/pictures/edge_pictures.h"

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>

#include "batten/core/box.h"
#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/pictures/canvas.h"

namespace batten {
namespace {

using namespace detail;

struct EdgeStyle {
  EdgeComb::Kind kind;
  const char* words;
  Colour colour;
};
const std::array<EdgeStyle, 3> looks{
    {{EdgeComb::Kind::Crease, "creases", {0.80, 0.20, 0.14}},
     {EdgeComb::Kind::Tangent, "tangent: curvature jumps", {0.13, 0.40, 0.75}},
     {EdgeComb::Kind::Curvature, "curvature goes on", {0.10, 0.55, 0.30}}}};

/// Chains of points as VTK's data.
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

/// Length of a tooth over its curvature, and of the longest.
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
    if (!(*most * size > 1e-6)) return;  // nothing bends
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

/// Lines of words at the lower left, in the colours of what they count.
void add_legend(vtkRenderer& renderer, const EdgePicture& picture, const Scale& scale,
                const Viewport& viewport) {
  const double text = std::max(11.0, 22 * viewport.unit), left = 28 * viewport.unit;
  std::string words;
  for (const EdgeStyle& look : looks) {
    const auto count = std::count_if(picture.edges.begin(), picture.edges.end(),
                                     [&](const EdgeComb& edge) { return edge.kind == look.kind; });
    const char* colours[] = {"red", "blue", "green"};
    words += (words.empty() ? "" : ",  ") + std::to_string(count) + " " + look.words + " (" +
             colours[&look - looks.data()] + ")";
  }
  if (!picture.free_edges.empty())
    words += ",  " + std::to_string(picture.free_edges.size()) + " rims (grey)";
  add_text(renderer, words, left, 2.2 * text, text, viewport.width - 2 * left, false);
  if (scale.of_curvature > 0)
    add_text(renderer,
             "longest teeth: curvature " + format_number(scale.longest / scale.of_curvature) +
                 " / " + picture.unit + " or more",
             left, 0.8 * text, text, viewport.width - 2 * left, false);
}

}  // namespace

void draw_edge_combs(const std::filesystem::path& path, const EdgePicture& picture,
                     const PictureSize& size) {
  const std::vector<Vec3> points = extent(picture);
  if (points.empty()) throw InputError(path.string() + ": found no edges, expected some to draw");
  const double extent_of_all = bounding_box(points).diagonal().norm();
  const Scale scale(picture, extent_of_all);
  const ViewAxes axes(picture.view.first, picture.view.second);
  std::vector<Vec3> in_view = points;
  for (const EdgeComb& edge : picture.edges)
    for (const auto& curvature_vectors : edge.curvature_vectors)
      for (size_t k = 0; k < curvature_vectors.size(); ++k)
        in_view.push_back(scale.tip(edge.line[k], curvature_vectors[k]));
  const double few = picture.edges.size() > 500 ? 0.5 : 1;  // many edges are drawn with a finer pen
  draw_sheet(path, 1, 1, false, size, [&](vtkRenderer& renderer, int, double width, double height) {
    const Viewport viewport = viewport_of(width, height, picture.title, false, 80);
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
