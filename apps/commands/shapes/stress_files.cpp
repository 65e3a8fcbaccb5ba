#include "batten/apps/commands/shapes/stress_files.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/io/pictures/image.h"
#include "batten/io/vtk/vtk_files.h"

namespace batten {
namespace {

// Components of a symmetric tensor in VTK's order.
VecX in_order(const Mat3& s) {
  VecX six(6);
  six << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2);
  return six;
}

std::string stress_unit(const Scene& scene) {
  return scene.unit == "mm" ? " [N/mm²]" : scene.unit == "m" ? " [Pa]" : "";
}

}  // namespace

std::string stress_stem(const Scene& scene, const std::string& name) {
  return safe_file_name(scene.name) + "_" + safe_file_name(name);
}

std::vector<SkinnedRegion> StressFiles::regions_of(const Points& dofs) const {
  std::vector<SkinnedRegion> regions;
  for (int r = 0; r < shell_.layout().region_count(); ++r)
    regions.push_back(shell_.layout().skinned(r, dofs));
  return regions;
}

PictureScene StressFiles::view() const {
  PictureScene picture;
  if (scene_.pictures.empty()) return picture;
  picture.azimuth = scene_.pictures[0].look.azimuth;
  picture.elevation = scene_.pictures[0].look.elevation;
  return picture;
}

double deformation_scale(double largest, double size) {
  constexpr double fraction = 0.05;
  if (!(largest > 0)) return 1;
  const double wanted = fraction * size / largest;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  for (const double digit : {5.0, 2.0})
    if (wanted >= digit * power) return digit * power;
  return power;
}

double StressFiles::largest(const Points& displacement) const {
  const VecX positions = shell_.layout().position_dofs();
  double most = 0;
  for (long m = 0; m < positions.size(); ++m)
    if (positions[m] > 0) most = std::max(most, displacement.row(m).norm());
  return most;
}

void StressFiles::write_case(const std::string& name, const Points& displacement, double largest,
                             const ShellStresses& stresses) {
  const auto at = [&](int r, const Location& where) {
    return stresses.at(shell_.layout().to_model_location(r, where));
  };
  const Surface moved = shell_.layout().surface(displacement);
  VtkOptions options;
  options.curvatures = false;
  options.fields.push_back({"Displacement", 3, [&](int r, const Location& where) -> VecX {
                              return moved.position(shell_.layout().to_model_location(r, where));
                            }});
  for (const auto& [side, height] :
       {std::pair<const char*, double>{"top", 1}, {"middle", 0}, {"bottom", -1}}) {
    options.fields.push_back({"Von_mises_" + std::string(side), 1,
                              [&at, h = height](int r, const Location& where) -> VecX {
                                return VecX::Constant(1, von_mises(at(r, where).at(h)));
                              }});
    options.fields.push_back(
        {"Stress_" + std::string(side), 6,
         [&at, h = height](int r, const Location& where) { return in_order(at(r, where).at(h)); }});
  }
  options.fields.push_back(
      {"Forces", 6, [&](int r, const Location& where) { return in_order(at(r, where).forces); }});
  options.fields.push_back(
      {"Moments", 6, [&](int r, const Location& where) { return in_order(at(r, where).moments); }});
  options.fields.push_back({"Thickness", 1, [&](int r, const Location& where) -> VecX {
                              return VecX::Constant(1, at(r, where).thickness);
                            }});
  const std::vector<SkinnedRegion> still = regions_of(shell_.shape());
  write_vtu(run_.out.file(stress_stem(scene_, name) + ".vtu"), pointers(still), options);
  run_.report.files.push_back(stress_stem(scene_, name) + ".vtu");

  if (!can_draw(run_.report, stress_stem(scene_, name) + ".png")) return;
  const double times = deformation_scale(largest, shell_.layout().size());
  const std::vector<SkinnedRegion> regions = regions_of(shell_.shape() + times * displacement);
  PictureScene picture = view();
  picture.regions = pointers(regions);
  picture.field = PictureScene::Field::Value;
  picture.title = scene_.name + ": " + name + " (deformation ×" + format_number(times) + ")";
  picture.value = {"von Mises stress" + stress_unit(scene_) + ", max of top and bottom",
                   [&](int r, const Location& where) {
                     const ShellStress stress = at(r, where);
                     return std::max(von_mises(stress.at(1)), von_mises(stress.at(-1)));
                   },
                   0};
  draw_picture(run_.out.file(stress_stem(scene_, name) + ".png"), picture);
  run_.report.files.push_back(stress_stem(scene_, name) + ".png");
}

void StressFiles::write_mode_shapes(const std::string& kind, const std::vector<Points>& shapes,
                                    const std::vector<std::string>& captions) {
  std::vector<Surface> moved;
  for (const Points& shape : shapes)
    moved.push_back(shell_.layout().surface(shape / largest(shape)));
  const std::vector<SkinnedRegion> still = regions_of(shell_.shape());
  std::vector<SeriesFile> series;
  for (size_t k = 0; k < shapes.size(); ++k) {
    VtkOptions options;
    options.curvatures = false;
    options.fields.push_back({"Displacement", 3, [&](int r, const Location& where) -> VecX {
                                return moved[k].position(
                                    shell_.layout().to_model_location(r, where));
                              }});
    const std::string file = stress_stem(scene_, kind) + "_" + std::to_string(k + 1) + ".vtu";
    write_vtu(run_.out.file(file), pointers(still), options);
    run_.report.files.push_back(file);
    series.push_back({static_cast<double>(k + 1), file});
  }
  write_pvd(run_.out.file(stress_stem(scene_, kind) + ".pvd"), series);
  run_.report.files.push_back(stress_stem(scene_, kind) + ".pvd");

  if (!can_draw(run_.report, stress_stem(scene_, kind) + ".png")) return;
  constexpr double swing = 0.07;  // amplitude, relative to the model size
  constexpr int frames = 16;
  const PictureSize small{640, 400};
  std::vector<std::vector<SkinnedRegion>> kept;
  const auto picture_at = [&](size_t k, double phase) {
    kept.push_back(
        regions_of(shell_.shape() + swing * shell_.layout().size() * phase * moved[k].dofs()));
    PictureScene picture = view();
    picture.regions = pointers(kept.back());
    picture.field = PictureScene::Field::Value;
    picture.title = captions[k];
    picture.value = {"Displacement / max",
                     [&, k, phase](int r, const Location& where) {
                       return std::abs(phase) *
                              moved[k].position(shell_.layout().to_model_location(r, where)).norm();
                     },
                     1};
    return picture;
  };
  std::vector<PictureScene> sheet;
  for (size_t k = 0; k < shapes.size(); ++k) sheet.push_back(picture_at(k, 1));
  draw_contact_sheet(run_.out.file(stress_stem(scene_, kind) + ".png"), sheet,
                     static_cast<int>(std::ceil(std::sqrt(static_cast<double>(sheet.size())))));
  run_.report.files.push_back(stress_stem(scene_, kind) + ".png");
  for (size_t k = 0; k < shapes.size(); ++k) {
    kept.clear();
    std::vector<PictureScene> phases;
    for (int i = 0; i < frames; ++i)
      phases.push_back(picture_at(k, std::sin(2 * std::numbers::pi * i / frames)));
    share_view(phases);
    std::vector<Image> images;
    for (const PictureScene& phase : phases) images.push_back(picture_image(phase, small));
    const std::string file = stress_stem(scene_, kind) + "_" + std::to_string(k + 1) + ".gif";
    constexpr double seconds = 0.06;
    write_gif(run_.out.file(file), images, seconds, seconds);
    run_.report.files.push_back(file);
  }
}

}  // namespace batten
