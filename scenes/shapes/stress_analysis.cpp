// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/stress_analysis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <utility>

#include "batten/analysis/models/shell_stresses.h"
#include "batten/core/errors.h"
#include "batten/io/decks/frd_results.h"
#include "batten/io/files/external_program.h"
#include "batten/io/files/text.h"
#include "batten/io/pictures/image.h"
#include "batten/io/vtk/vtk_files.h"
#include "batten/scenes/shapes/stress_probes.h"
#include "batten/scenes/shapes/stress_setup.h"
#include "batten/scenes/shapes/stress_spectrum.h"
#include "batten/skinning/model/model_shapes.h"

namespace batten {

double deformation_scale(double largest, double size) {
  constexpr double fraction = 0.05;
  if (!(largest > 0)) return 1;
  const double wanted = fraction * size / largest;
  const double power = std::pow(10, std::floor(std::log10(wanted)));
  for (const double digit : {5.0, 2.0})
    if (wanted >= digit * power) return digit * power;
  return power;
}

namespace {

// Files and pictures.

// Components of a symmetric tensor in VTK's order.
VecX in_order(const Mat3& s) {
  VecX six(6);
  six << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2);
  return six;
}

std::string with_digits(int digits, double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}
std::string three_digits(double value) { return with_digits(3, value); }
std::string five_digits(double value) { return with_digits(5, value); }

std::string stress_unit(const Scene& scene) {
  return scene.unit == "mm" ? " [N/mm²]" : scene.unit == "m" ? " [Pa]" : "";
}

/// File name of a load case without extension: NAME_CASE, with NAME of the scene. It consists of
/// letters, digits, '-' and '_'.
std::string stress_stem(const Scene& scene, const std::string& name) {
  return safe_file_name(scene.name) + "_" + safe_file_name(name);
}

/// Writes shell results into the folder of a run, with the prefix NAME_ of the scene, and lists the
/// files in its report. Pictures use the view of the scene's first picture.
class StressFiles : public StressVisitor {
 public:
  StressFiles(RunContext& run, const Scene& scene, bool animations)
      : run_(run), scene_(scene), animations_(animations) {}

  void visit_shell(const ShellModel& shell) override;
  void visit_case(const StressReport::Case& c, const ShellCaseResult& result,
                  const ShellStresses& stresses) override;
  void visit_buckling(const StressReport::Case& c, const std::vector<Points>& shapes) override;
  void visit_harmonic(const StressReport::Case& c, const std::vector<double>& frequencies,
                      const std::vector<std::string>& points,
                      const std::vector<std::vector<Eigen::Vector3cd>>& amplitudes) override;
  void visit_spectrum(const StressReport::Spectrum& report, const SpectrumField& field) override;
  void visit_modes(const std::vector<double>& frequencies,
                   const std::vector<Points>& shapes) override;

 private:
  /// Writes a load case: NAME_CASE.vtu on the undeformed shape and NAME_CASE.png, the equivalent
  /// stress on the deformed shape. The .vtu has Displacement, Von_mises_top, _middle and _bottom,
  /// Stress_top, _middle and _bottom, Forces, Moments and Thickness (tensors as xx, yy, zz, xy, yz,
  /// xz). Colours end at the largest stress outside of singular places.
  void write_case(const StressReport::Case& c, const Points& displacement,
                  const ShellStresses& stresses);

  /// Stresses (σ1, σ2, τ12) on the faces of plies, in their directions, and reserve factors.
  void add_ply_fields(const std::function<ShellStress(int region, const Location& where)>& at,
                      VtkOptions& options) const;

  /// Writes mode shapes: NAME_KIND.pvd, a series NAME_KIND_1.vtu, … with the Displacement of each
  /// mode, normalised to a maximum of 1. NAME_KIND.png is a contact sheet with captions;
  /// NAME_KIND_1.gif, … are animations.
  void write_mode_shapes(const std::string& kind, const std::vector<Points>& shapes,
                         const std::vector<std::string>& captions);
  std::vector<SkinnedRegion> regions_of(const Points& dofs) const;
  PictureScene view() const;
  double largest(const Points& displacement) const;
  const ModelLayout& layout() const { return shell_->layout(); }

  RunContext& run_;
  const Scene& scene_;
  bool animations_;
  const ShellModel* shell_ = nullptr;
};

void StressFiles::visit_shell(const ShellModel& shell) {
  shell_ = &shell;
  run_.watch.lap("stress");
}

void StressFiles::visit_case(const StressReport::Case& c, const ShellCaseResult& result,
                             const ShellStresses& stresses) {
  write_case(c, result.displacement, stresses);
  for (const SceneStress::Result& of : scene_.stress->results) {
    if (of.line.text.empty()) continue;
    const std::string file = stress_stem(scene_, c.name) + "_" + safe_file_name(of.name) + ".csv";
    write_file_atomically(run_.out.file(file), [&](std::ostream& out) {
      write_curve_values(out, scene_, *shell_, result, stresses, of);
    });
    run_.report.files.push_back(file);
  }
}

void StressFiles::visit_buckling(const StressReport::Case& c, const std::vector<Points>& shapes) {
  std::vector<std::string> captions;
  for (const double factor : c.buckling)
    captions.push_back(c.name + ": buckling at " + five_digits(factor) + " times the load");
  if (!captions.empty()) write_mode_shapes(c.name + " buckling", shapes, captions);
}

/// NAME_CASE_harmonic.csv: amplitudes, and phases in degrees relative to the load.
void StressFiles::visit_harmonic(const StressReport::Case& c,
                                 const std::vector<double>& frequencies,
                                 const std::vector<std::string>& points,
                                 const std::vector<std::vector<Eigen::Vector3cd>>& amplitudes) {
  const std::string file = stress_stem(scene_, c.name) + "_harmonic.csv";
  write_file_atomically(run_.out.file(file), [&](std::ostream& out) {
    out << "frequency";
    for (const std::string& point : points)
      for (const char axis : {'x', 'y', 'z'})
        out << ",\"" << single_row(point) << ": u" << axis << " [" << scene_.unit << "]\",\""
            << single_row(point) << ": phase of u" << axis << " [degrees]\"";
    out << "\n";
    for (size_t k = 0; k < frequencies.size(); ++k) {
      out << exact_number(frequencies[k]);
      for (const Eigen::Vector3cd& u : amplitudes[k])
        for (int axis = 0; axis < 3; ++axis)
          out << "," << exact_number(std::abs(u[axis])) << ","
              << exact_number(std::arg(u[axis]) * 180 / std::numbers::pi);
      out << "\n";
    }
  });
  run_.report.files.push_back(file);
}

/// NAME_spectrum.vtu and NAME_spectrum.png.
void StressFiles::visit_spectrum(const StressReport::Spectrum&, const SpectrumField& field) {
  const auto at = [&](int r, const Location& where) {
    return layout().to_model_location(r, where);
  };
  VtkOptions options;
  options.curvatures = false;
  options.fields.push_back({"Displacement", 3, [&](int r, const Location& where) -> VecX {
                              return field.displacement(at(r, where));
                            }});
  for (const auto& [side, height] :
       {std::pair<const char*, double>{"top", 1}, {"middle", 0}, {"bottom", -1}})
    options.fields.push_back({"Von_mises_" + std::string(side), 1,
                              [&, h = height](int r, const Location& where) -> VecX {
                                return VecX::Constant(1, field.von_mises(at(r, where), h));
                              }});
  const std::vector<SkinnedRegion> still = regions_of(shell_->shape());
  const std::string stem = stress_stem(scene_, "spectrum");
  write_vtu(run_.out.file(stem + ".vtu"), pointers(still), options);
  run_.report.files.push_back(stem + ".vtu");
  if (!can_draw(run_.report, stem + ".png")) return;
  PictureScene picture = view();
  picture.regions = pointers(still);
  picture.field = PictureScene::Field::Value;
  picture.value = {"von Mises stress" + stress_unit(scene_) +
                       ", response to the spectrum, max of top and bottom",
                   [&](int r, const Location& where) {
                     return std::max(field.von_mises(at(r, where), 1),
                                     field.von_mises(at(r, where), -1));
                   },
                   0};
  draw_picture(run_.out.file(stem + ".png"), picture);
  run_.report.files.push_back(stem + ".png");
}

void StressFiles::visit_modes(const std::vector<double>& frequencies,
                              const std::vector<Points>& shapes) {
  std::vector<std::string> captions;
  for (const double f : frequencies) captions.push_back(five_digits(f) + " Hz");
  write_mode_shapes("modes", shapes, captions);
}

std::vector<SkinnedRegion> StressFiles::regions_of(const Points& dofs) const {
  std::vector<SkinnedRegion> regions;
  for (int r = 0; r < layout().region_count(); ++r) regions.push_back(layout().skinned(r, dofs));
  return regions;
}

PictureScene StressFiles::view() const {
  PictureScene picture;
  if (scene_.pictures.empty()) return picture;
  picture.azimuth = scene_.pictures[0].look.azimuth;
  picture.elevation = scene_.pictures[0].look.elevation;
  return picture;
}

double StressFiles::largest(const Points& displacement) const {
  const VecX positions = layout().position_dofs();
  double most = 0;
  for (long m = 0; m < positions.size(); ++m)
    if (positions[m] > 0) most = std::max(most, displacement.row(m).norm());
  return most;
}

void StressFiles::add_ply_fields(
    const std::function<ShellStress(int region, const Location& where)>& at,
    VtkOptions& options) const {
  const ShellSection& section = shell_->section(0);
  if (section.laminate)
    for (int k = 0; k < section.ply_count(); ++k)
      for (const bool top : {false, true})
        options.fields.push_back({"Ply_" + std::to_string(k + 1) + (top ? "_top" : "_bottom"), 3,
                                  [at, k, top](int r, const Location& where) -> VecX {
                                    Vec3 stress = Vec3::Zero();
                                    int face = 0;
                                    at(r, where).for_each_ply_face([&](const PlyStress& one) {
                                      if (face++ == 2 * k + (top ? 1 : 0)) stress = one.stress;
                                    });
                                    return stress;
                                  }});
  if (!section.has_strength()) return;
  for (const auto& [name, criterion] :
       {std::pair{"Reserve_factor_Tsai_Hill", FailureCriterion::TsaiHill},
        std::pair{"Reserve_factor_Hoffman", FailureCriterion::Hoffman}})
    options.fields.push_back(
        {name, 1, [at, c = criterion](int r, const Location& where) -> VecX {
           constexpr double most = 1e6;  // of points without stress
           return VecX::Constant(1, std::min(most, at(r, where).smallest_reserve_factor(c).value));
         }});
}

void StressFiles::write_case(const StressReport::Case& c, const Points& displacement,
                             const ShellStresses& stresses) {
  const auto at = [&](int r, const Location& where) {
    return stresses.at(layout().to_model_location(r, where));
  };
  const Surface moved = layout().surface(displacement);
  VtkOptions options;
  options.curvatures = false;
  options.fields.push_back({"Displacement", 3, [&](int r, const Location& where) -> VecX {
                              return moved.position(layout().to_model_location(r, where));
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
  add_ply_fields(at, options);
  options.fields.push_back({"Thickness", 1, [&](int r, const Location& where) -> VecX {
                              return VecX::Constant(1, at(r, where).thickness);
                            }});
  const std::vector<SkinnedRegion> still = regions_of(shell_->shape());
  write_vtu(run_.out.file(stress_stem(scene_, c.name) + ".vtu"), pointers(still), options);
  run_.report.files.push_back(stress_stem(scene_, c.name) + ".vtu");

  if (!can_draw(run_.report, stress_stem(scene_, c.name) + ".png")) return;
  const double times = deformation_scale(c.displacement, layout().size());
  const std::vector<SkinnedRegion> regions = regions_of(shell_->shape() + times * displacement);
  PictureScene picture = view();
  picture.regions = pointers(regions);
  picture.field = PictureScene::Field::Value;
  picture.value = {
      "von Mises stress" + stress_unit(scene_) +
          (shell_->section(0).laminate ? ", max of all plies" : ", max of top and bottom") +
          "; deformation ×" + format_number(times),
      [&](int r, const Location& where) {
        const ShellStress stress = at(r, where);
        return stress.largest_von_mises().value;
      },
      c.singular_places.empty() ? 0 : c.stress};
  draw_picture(run_.out.file(stress_stem(scene_, c.name) + ".png"), picture);
  run_.report.files.push_back(stress_stem(scene_, c.name) + ".png");
}

void StressFiles::write_mode_shapes(const std::string& kind, const std::vector<Points>& shapes,
                                    const std::vector<std::string>& captions) {
  std::vector<Surface> moved;
  for (const Points& shape : shapes) moved.push_back(layout().surface(shape / largest(shape)));
  const std::vector<SkinnedRegion> still = regions_of(shell_->shape());
  std::vector<SeriesFile> series;
  for (size_t k = 0; k < shapes.size(); ++k) {
    VtkOptions options;
    options.curvatures = false;
    options.fields.push_back({"Displacement", 3, [&](int r, const Location& where) -> VecX {
                                return moved[k].position(layout().to_model_location(r, where));
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
    kept.push_back(regions_of(shell_->shape() + swing * layout().size() * phase * moved[k].dofs()));
    PictureScene picture = view();
    picture.regions = pointers(kept.back());
    picture.field = PictureScene::Field::Value;
    picture.title = captions[k];
    picture.value = {"displacement / max",
                     [&, k, phase](int r, const Location& where) {
                       return std::abs(phase) *
                              moved[k].position(layout().to_model_location(r, where)).norm();
                     },
                     1};
    return picture;
  };
  std::vector<PictureScene> sheet;
  for (size_t k = 0; k < shapes.size(); ++k) sheet.push_back(picture_at(k, 1));
  draw_contact_sheet(run_.out.file(stress_stem(scene_, kind) + ".png"), sheet,
                     static_cast<int>(std::ceil(std::sqrt(static_cast<double>(sheet.size())))));
  run_.report.files.push_back(stress_stem(scene_, kind) + ".png");
  for (size_t k = 0; k < shapes.size() && animations_; ++k) {
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

}  // namespace

void analyse(RunContext& run, const Scene& scene, const RefinedShape& refined,
             const StressAccuracy& accuracy, const BackendFactory& factors, bool animations,
             const Progress& progress) {
  if (!refined.shape.layout) return;
  StressFiles files(run, scene, animations);
  run.report.stress =
      compute_stresses(scene, refined, accuracy, factors, run.report, files, progress);
  run.watch.lap("stress files");
}

namespace {

std::string format_rounded_point(const Vec3& p) {
  std::string text;
  for (int c = 0; c < 3; ++c) text += (c ? ", " : "(") + three_digits(p[c]);
  return text + ")";
}

/// The first and the last mesh of a refinement.
std::string meshes_summary(const std::vector<StressReport::Mesh>& meshes, const std::string& unit) {
  if (meshes.size() < 2) return "";
  std::string text;
  for (const StressReport::Mesh* m : {&meshes.front(), &meshes.back()})
    text += summary_line(
        m == &meshes.front() ? "meshes" : "",
        (m == &meshes.front() ? "first"
                              : "after " + std::to_string(meshes.size() - 1) +
                                    (meshes.size() == 2 ? " refinement" : " refinements")) +
            ": " + std::to_string(m->unknowns) + " unknowns, edge length " +
            three_digits(m->edge_length) + " " + unit + ", displacement " +
            three_digits(m->displacement) + " ± " + three_digits(100 * m->error) +
            " %, von Mises " + three_digits(m->stress) + " ± " +
            three_digits(100 * m->stress_error) + " %");
  return text;
}

}  // namespace

std::string stress_summary(const StressReport& report, const std::string& unit) {
  std::string text =
      summary_line("stress", std::to_string(report.unknowns) + " unknowns" +
                                 (report.material.empty() ? "" : ", " + report.material));
  text += meshes_summary(report.meshes, unit);
  for (const auto& c : report.cases) {
    std::string stress = "von Mises " + three_digits(c.stress) + " at " +
                         format_rounded_point(c.max_stress_at) + ", " + c.side + " of '" +
                         c.max_stress_region + "', ± " + three_digits(c.spread);
    if (c.ply > 0) stress += ", ply " + std::to_string(c.ply);
    if (c.safety > 0) stress += "; safety factor " + three_digits(c.safety);
    text += summary_line(c.combination ? "combination" : "case", "'" + c.name + "': " + stress);
    for (const auto& r : c.reserves)
      text += summary_line("", "reserve factor " + three_digits(r.factor) + " (" + r.criterion +
                                   ") in ply " + std::to_string(r.ply) + " at " +
                                   format_rounded_point(r.at) + " of '" + r.region + "'");
    for (const auto& v : c.vibrations)
      text += summary_line("", "vibration of '" + v.point + "': amplitude " +
                                   three_digits(v.amplitude) + " " + unit + " at " +
                                   five_digits(v.frequency) + " Hz");
    for (const auto& s : c.stiffeners)
      text +=
          summary_line("", "stiffener '" + s.name + "': axial force " + three_digits(s.axial[0]) +
                               " to " + three_digits(s.axial[1]) + ", bending moment " +
                               three_digits(s.bending[0]) + " to " + three_digits(s.bending[1]) +
                               (s.stress == 0 ? ""
                                              : "; stress " + three_digits(s.stress) + " at " +
                                                    format_rounded_point(s.at)));
    for (const auto& r : c.results)
      text += summary_line(
          "", "'" + r.name + "': " +
                  (r.point ? "displacement " + three_digits(r.point->displacement.norm()) + " " +
                                 unit + ", von Mises " + three_digits(r.point->von_mises[0]) +
                                 " top, " + three_digits(r.point->von_mises[1]) + " middle, " +
                                 three_digits(r.point->von_mises[2]) + " bottom"
                           : "displacement " + three_digits(r.displacement.least) + " to " +
                                 three_digits(r.displacement.largest) + " " + unit + ", mean " +
                                 three_digits(r.displacement.mean) + "; von Mises " +
                                 three_digits(r.von_mises.least) + " to " +
                                 three_digits(r.von_mises.largest) + ", mean " +
                                 three_digits(r.von_mises.mean)));
    if (c.calculix)
      text += summary_line("", "CalculiX, " + c.calculix->elements + ": displacement " +
                                   three_digits(c.calculix->displacement) + " " + unit +
                                   ", at the same point " +
                                   three_digits(c.calculix->displacement_there) + "; von Mises " +
                                   three_digits(c.calculix->stress) + ", at the same point " +
                                   three_digits(c.calculix->stress_there) +
                                   (c.calculix->buckling.empty()
                                        ? ""
                                        : "; buckles at " + five_digits(c.calculix->buckling[0])));
    if (c.buckling_requested)
      text += summary_line(
          "", c.buckling.empty() ? "does not buckle under this load"
                                 : "buckles at " + five_digits(c.buckling[0]) + " times its load");
    text += summary_line("", "displacement " + three_digits(c.displacement) + " " + unit + " at " +
                                 format_rounded_point(c.max_displacement_at) + ", ± " +
                                 three_digits(c.displacement_error) + "; error about " +
                                 three_digits(100 * c.error) + " % in energy norm");
  }
  for (const auto& d : report.sensitivities)
    text += summary_line(&d == &report.sensitivities[0] ? "sensitivity" : "",
                         "to '" + d.parameter + "', case '" + d.load_case + "': displacement " +
                             three_digits(d.displacement) + " " + unit + ", work of the loads " +
                             three_digits(d.compliance) + ", per unit of the parameter");
  if (report.spectrum) {
    const StressReport::Spectrum& s = *report.spectrum;
    text += summary_line(
        "spectrum", std::to_string(s.modes) + " modes with " + three_digits(100 * s.mass_fraction) +
                        " % of the mass: displacement " + three_digits(s.displacement) + " " +
                        unit + " at " + format_rounded_point(s.displacement_at) + "; von Mises " +
                        three_digits(s.stress) + " at " + format_rounded_point(s.stress_at));
    for (const auto& point : s.points)
      text += summary_line("", "'" + point.name + "': displacement " +
                                   three_digits(point.displacement.norm()) + " " + unit +
                                   ", von Mises " + three_digits(point.von_mises));
  }
  std::string hertz;
  for (const double f : report.frequencies)
    if (f > 0) hertz += (hertz.empty() ? "" : ", ") + five_digits(f);
  const auto rigid = std::count(report.frequencies.begin(), report.frequencies.end(), 0.0);
  if (!hertz.empty())
    text += summary_line(
        "frequencies",
        hertz + " Hz" +
            (rigid ? ", after " + std::to_string(rigid) + " rigid-body modes at 0 Hz" : ""));
  std::string by_calculix;
  for (const double f : report.calculix_frequencies)
    by_calculix += (by_calculix.empty() ? "" : ", ") + five_digits(f);
  if (!by_calculix.empty()) text += summary_line("", "CalculiX: " + by_calculix + " Hz");
  if (report.mass > 0) {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& factor : report.participation) sum += factor.cwiseAbs2();
    const auto percent = [&](int c) {
      return three_digits(std::round(1e4 * sum[c] / report.mass) / 100) + " %";
    };
    text += summary_line("modal mass", percent(0) + " of " + three_digits(report.mass) + " in x, " +
                                           percent(1) + " in y, " + percent(2) +
                                           " in z (effective masses of these modes)");
  }
  return text;
}

namespace {

// Von Mises equivalent of a 3D stress tensor.
double equivalent(const Mat3& s) {
  const Mat3 deviator = s - s.trace() / 3 * Mat3::Identity();
  return std::sqrt(1.5 * deviator.squaredNorm());
}

void run_ccx(const std::filesystem::path& deck) {
  run_external_program({"ccx", "CCX", "CalculiX (calculix-ccx)"}, {"-i", deck.stem().string()},
                       deck.parent_path());
}

// Removes the files that ccx leaves beside its results.
void remove_leftovers(const std::filesystem::path& deck) {
  for (const char* ending : {".dat", ".sta", ".cvg", ".12d"})
    std::filesystem::remove(std::filesystem::path(deck).replace_extension(ending));
  std::filesystem::remove(deck.parent_path() / "spooles.out");
}

StressReport::CalculixResult calculix_result(const FrdResults& results,
                                             const StressReport::Case& ours) {
  StressReport::CalculixResult result;
  const FrdResults::Node *moved = nullptr, *stressed = nullptr;
  const auto nearer = [](const Vec3& to, const FrdResults::Node& a, const FrdResults::Node* b) {
    return !b || (a.x - to).squaredNorm() < (b->x - to).squaredNorm();
  };
  for (const FrdResults::Node& node : results.nodes) {
    result.displacement = std::max(result.displacement, node.displacement.norm());
    result.stress = std::max(result.stress, equivalent(node.stress));
    if (nearer(ours.max_displacement_at, node, moved)) moved = &node;
    if (nearer(ours.max_stress_face_point, node, stressed)) stressed = &node;
  }
  if (moved) result.displacement_there = moved->displacement.norm();
  if (stressed) result.stress_there = equivalent(stressed->stress);
  return result;
}

const char* element_name(ShellDeck::Element element) {
  return element == ShellDeck::Element::S3    ? "three-node triangles"
         : element == ShellDeck::Element::S8R ? "eight-node quads"
                                              : "six-node triangles";
}

}  // namespace

namespace {

/// Writes decks, runs ccx on them, and reads its results. What ccx does not solve is a warning.
class CalculixRun {
 public:
  CalculixRun(RunContext& run, const Scene& scene, const SolvedShape& shape,
              ShellDeck::Element element)
      : run_(run), scene_(scene), shape_(shape), element_(element) {}

  /// Calls `read` with the path of the deck without extension, after ccx has run on it.
  template <class Read>
  void solve(const std::string& what, const std::string& load_case, ShellDeck::Analysis analysis,
             int count, double load_factor, const Read& read) {
    const std::string stem = stress_stem(scene_, what) + "_ccx";
    const std::filesystem::path deck = run_.out.file(stem + ".inp");
    try {
      ShellDeck shell = deck_of(scene_, *shape_.layout, load_case, stem + ".inp");
      shell.element = element_;
      shell.analysis = analysis;
      shell.count = count;
      shell.load_factor = load_factor;
      write_calculix(deck, shape_.all(), shell);
    } catch (const DeckLimitError& e) {
      run_.report.warnings.push_back("'" + what + "' is not compared with CalculiX: " + e.what());
      return;
    }
    run_.report.files.push_back(stem + ".inp");
    run_ccx(deck);
    try {
      read(run_.out.file(stem));
    } catch (const InputError&) {
      run_.report.warnings.push_back("'" + what +
                                     "' is not compared with CalculiX, which gave no " +
                                     "results: `ccx -i " + stem + "` prints its messages");
    }
    remove_leftovers(deck);
    if (std::filesystem::exists(run_.out.file(stem + ".frd")))
      run_.report.files.push_back(stem + ".frd");
  }

 private:
  RunContext& run_;
  const Scene& scene_;
  const SolvedShape& shape_;
  ShellDeck::Element element_;
};

}  // namespace

void check_with_calculix(RunContext& run, const Scene& scene, const SolvedShape& shape,
                         ShellDeck::Element element, const Progress& progress) {
  StressReport& report = *run.report.stress;
  const SceneStress& stress = *scene.stress;
  CalculixRun ccx(run, scene, shape, element);
  const auto with = [](const std::filesystem::path& stem, const char* ending) {
    return std::filesystem::path(stem.string() + ending);
  };
  using Analysis = ShellDeck::Analysis;
  for (StressReport::Case& c : report.cases) {
    if (c.combination) continue;
    progress.update("CalculiX, case " + c.name, 0);
    ccx.solve(c.name, c.name, Analysis::Static, 0, 1, [&](const std::filesystem::path& stem) {
      c.calculix = calculix_result(read_frd(with(stem, ".frd")), c);
      c.calculix->elements = element_name(element);
    });
    if (stress.buckling == 0 || !c.calculix) continue;
    constexpr double accurate = 5;  // buckling factor at which ccx is accurate
    const double load_factor = c.buckling.empty() ? 1 : c.buckling[0] / accurate;
    ccx.solve(c.name + " buckling", c.name, Analysis::Buckling, stress.buckling, load_factor,
              [&](const std::filesystem::path& stem) {
                for (const double factor : read_ccx_buckling_factors(with(stem, ".dat")))
                  c.calculix->buckling.push_back(load_factor * factor);
              });
    const bool follows =
        stress.follower_pressure &&
        std::any_of(stress.loads.begin(), stress.loads.end(), [&](const SceneStress::Load& load) {
          return load.load_case == c.name && (load.type == SceneStress::Load::Type::Pressure ||
                                              load.type == SceneStress::Load::Type::Hydrostatic);
        });
    if (follows)
      run.report.warnings.push_back(
          "case '" + c.name +
          "': in the buckling analysis of CalculiX, pressures keep their direction; "
          "follower_pressure = false does so in Batten");
  }
  if (stress.modes > 0) {
    progress.update("CalculiX, natural frequencies", 0);
    const int rigid =
        static_cast<int>(std::count(report.frequencies.begin(), report.frequencies.end(), 0.0));
    ccx.solve("modes", "", Analysis::Frequencies, rigid + stress.modes, 1,
              [&](const std::filesystem::path& stem) {
                const std::vector<double> all = read_ccx_frequencies(with(stem, ".dat"));
                report.calculix_frequencies.assign(
                    all.begin() + std::min<long>(rigid, static_cast<long>(all.size())), all.end());
              });
  }
  run.watch.lap("CalculiX");
}

}  // namespace batten
