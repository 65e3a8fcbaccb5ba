// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/stress_spectrum.h"

#include <algorithm>

#include "batten/core/cancellation.h"
#include "batten/scenes/shapes/stress_places.h"

namespace batten {

SpectrumField::SpectrumField(const ShellModel& shell, const SpectrumResponse& response)
    : response_(response) {
  for (const Points& displacement : response.displacements()) {
    throw_if_cancelled();
    moved_.push_back(shell.layout().surface(displacement));
    stresses_.push_back(std::make_unique<const ShellStresses>(shell, displacement));
  }
}

Vec3 SpectrumField::displacement(const Location& where) const {
  MatX parts(isize(moved_), 3);
  for (int k = 0; k < isize(moved_); ++k)
    parts.row(k) = moved_[static_cast<size_t>(k)].position(where).transpose();
  Vec3 sum;
  for (int c = 0; c < 3; ++c) sum[c] = response_.combine(parts.col(c));
  return sum;
}

double SpectrumField::von_mises(const Location& where, double height) const {
  std::vector<Mat3> parts;
  for (const auto& stresses : stresses_) parts.push_back(stresses->at(where).at(height));
  return response_.combined_von_mises(parts);
}

namespace {

void add_reactions(const ShellModel& shell, const SpectrumResponse& response,
                   StressReport::Spectrum& report) {
  std::vector<std::vector<SupportReaction>> of_modes;
  for (size_t k = 0; k < response.loads().size(); ++k)
    of_modes.push_back(shell.reactions(response.displacements()[k], response.loads()[k]));
  VecX values(isize(of_modes));
  for (size_t s = 0; s < of_modes[0].size(); ++s) {
    StressReport::Reaction reaction{of_modes[0][s].support, Vec3::Zero(), Vec3::Zero()};
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < isize(of_modes); ++k)
        values[k] = of_modes[static_cast<size_t>(k)][s].resultant.force[c];
      reaction.force[c] = response.combine(values);
      for (int k = 0; k < isize(of_modes); ++k)
        values[k] = of_modes[static_cast<size_t>(k)][s].resultant.moment[c];
      reaction.moment[c] = response.combine(values);
    }
    report.reactions.push_back(reaction);
  }
}

}  // namespace

StressReport::Spectrum spectrum_report(const Scene& scene, const ShellModel& shell,
                                       const SpectrumResponse& response,
                                       const SpectrumField& field) {
  StressReport::Spectrum report;
  report.modes = isize(response.displacements()) - 1;
  report.mass_fraction = response.mass_fraction();
  const Surface& surface = shell.assembler().surface();
  const Trim* trim = surface.trim().get();
  const auto face_at = [&](const Location& where) {
    return shell.layout().region(shell.layout().region_of(where.triangle)).name();
  };
  const auto look = [&](const Location& where) {
    if (const double u = field.displacement(where).norm(); u > report.displacement) {
      report.displacement = u;
      report.displacement_at = surface.position(where);
      report.displacement_region = face_at(where);
    }
    for (const double height : {1.0, -1.0})
      if (const double stress = field.von_mises(where, height); stress > report.stress) {
        report.stress = stress;
        report.stress_at = surface.position(where);
        report.stress_region = face_at(where);
      }
  };
  std::vector<char> seen(static_cast<size_t>(surface.mesh().vertex_count()), 0);
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    poll_every<256>(t);
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    if (trim && trim->side(t) == Trim::Side::Cut) {
      for (const Vec3& L : trim->boundary_points(t)) look({t, L});
      continue;
    }
    for (int i = 0; i < 3; ++i)
      if (char& one = seen[static_cast<size_t>(surface.mesh().triangles()[t][i])]; !one) {
        one = 1;
        look({t, Vec3::Unit(i)});
      }
  }
  for (const SceneStress::Result& of : scene.stress->results) {
    if (!of.point) continue;
    const Location where =
        place_of(scene, shell.layout(), shell.shape(), *of.point, of.location).where;
    report.points.push_back({of.name, field.displacement(where),
                             std::max(field.von_mises(where, 1), field.von_mises(where, -1))});
  }
  add_reactions(shell, response, report);
  return report;
}

}  // namespace batten
