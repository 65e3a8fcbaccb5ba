#include "batten/apps/commands/shapes/shape_series.h"

#include <algorithm>
#include <cmath>

#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/io/pictures/animation.h"
#include "batten/io/vtk/vtk_files.h"
#include "batten/io/vtk/vtk_series.h"

namespace batten {
namespace {

/// A video of 800 pixels is wide enough to see a shape move, and small enough to send.
constexpr int kAnimationWidth = 800;
constexpr double kSeriesSeconds = 4, kLastSeconds = 1;

constexpr int kMostAnimated = 120, kMostPanels = 48;

/// At most so many of `count`, evenly, the last one among them.
bool is_chosen(int i, int count, int most) {
  const int stride = (count + most - 1) / most;
  return (count - 1 - i) % stride == 0;
}

PictureSize animation_size(const PictureSize& size) {
  const double scale = std::min(1.0, static_cast<double>(kAnimationWidth) / size.width);
  const auto scaled = [&](int pixels) {
    return std::max(64, static_cast<int>(std::lround(scale * pixels)));
  };
  return {scaled(size.width), scaled(size.height)};
}

/// About as wide as high for many panels, one row for up to three.
int columns_for(int count) {
  return count <= 3 ? count : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
}

}  // namespace

ShapeSeries::ShapeSeries(const Scene& scene, std::string stem, std::string label,
                         const OutputFolder& out, int most)
    : scene_(scene),
      stem_(std::move(stem)),
      label_(std::move(label)),
      out_(out),
      digits_(std::max<int>(3, static_cast<int>(std::to_string(most).size()))) {}

std::string ShapeSeries::name(int i, const std::string& ending) const {
  const std::string digits = std::to_string(i);
  return stem_ + "_" + std::string(static_cast<size_t>(digits_) - digits.size(), '0') + digits +
         ending;
}

void ShapeSeries::add(Report& report, double value, std::vector<SkinnedRegion> regions) {
  const std::string file = name(count(), ".vtp");
  write_vtp(out_.file(file), pointers(regions));
  report.files.push_back(file);
  files_.emplace_back(value, file);
  shapes_.push_back(std::move(regions));
}

void ShapeSeries::finish(Report& report, bool each, const Progress& progress) {
  if (files_.empty()) return;
  std::vector<SeriesFile> series;
  for (const auto& [value, file] : files_) series.push_back({value, file});
  write_pvd(out_.file(stem_ + ".pvd"), series);
  report.files.push_back(stem_ + ".pvd");

  const ScenePicture picture = scene_.pictures.empty() ? ScenePicture{} : scene_.pictures.front();
  std::vector<PictureScene> frames;
  for (size_t i = 0; i < shapes_.size(); ++i) {
    frames.push_back(picture.look);
    frames.back().regions = pointers(shapes_[i]);
    frames.back().title = label_ + " = " + format_number(files_[i].first);
  }
  share_view(frames);
  const PictureSize size = animation_size(picture.size);
  std::vector<Image> images;
  std::vector<PictureScene> panels;
  for (int i = 0; i < count(); ++i) {
    progress.update("pictures of " + label_, static_cast<double>(i) / count());
    const PictureScene& frame = frames[i];
    const bool animated = is_chosen(i, count(), kMostAnimated);
    if (!each && is_chosen(i, count(), kMostPanels)) panels.push_back(frame);
    if (!animated && !each) continue;
    Image image = picture_image(frame, size);
    if (each) {
      const std::string file = name(i, ".png");
      write_png(out_.file(file), image);
      report.files.push_back(file);
    }
    if (animated) images.push_back(std::move(image));
  }
  if (!each) {
    const int many = isize(panels);
    const int columns = columns_for(many), rows = (many + columns - 1) / columns;
    constexpr double sheet = 1500;
    const double height = sheet / columns * picture.size.height / picture.size.width * rows;
    draw_contact_sheet(out_.file(stem_ + ".png"), panels, columns,
                       {static_cast<int>(sheet), std::clamp(static_cast<int>(height), 64, 4096)});
    report.files.push_back(stem_ + ".png");
  }
  write_gif(out_.file(stem_ + ".gif"), images,
            std::min(0.5, kSeriesSeconds / static_cast<double>(images.size())), kLastSeconds);
  report.files.push_back(stem_ + ".gif");
}

}  // namespace batten
