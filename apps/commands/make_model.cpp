#include "batten/apps/commands/make_model.h"

#include <algorithm>

#include "batten/fem/assembly.h"

namespace batten {
namespace {

double fit_tolerance(const Scene& scene, double size) {
  constexpr double usual = 1e-4;
  return scene.skin.options.tolerance > 0 ? scene.skin.options.tolerance : usual * size;
}

// The model's energy is that of the network scaled to size 1: a region of size s and the network's
// size S have U = u s / S, so that ∬ |x_UU|² dU dV = (S / s)² ∬ |x_uu|² du dv; all over S².
double bending_energy(const MadeModel& made, const Vec3& beta) {
  SurfaceStiffness material;
  material.alpha = Mat2::Zero();
  material.beta = beta;
  double sum = 0;
  for (const ModelRegion& r : made.model.regions) {
    if (!r.skinned) continue;
    const Surface& s = r.skinned->surface;
    const SparseMatrix K = SurfaceAssembler(s.mesh(), s.kind(), s.trim()).stiffness(material);
    // About a point of its own: what is far away would lose its digits.
    VecX ones = VecX::Zero(s.dof_map().count());
    for (int v = 0; v < s.mesh().vertex_count(); ++v) ones[s.dof_map().vertex(v)] = 1;
    const Points q = s.dofs() - ones * s.dofs().row(s.dof_map().vertex(0));
    for (int i = 0; i < 3; ++i)
      sum += q.col(i).dot(K.selfadjointView<Eigen::Lower>() * q.col(i)) /
             (r.skinned->size * r.skinned->size);
  }
  return std::max(sum, 0.0);  // of flat regions only rounding is left
}

}  // namespace

CharacterLineNetwork network_of(const Scene& scene, const std::vector<CharacterLine>& lines,
                                const Progress& progress) {
  NetworkOptions options;
  options.tolerance = scene.network->tolerance;
  options.fit_tolerance = scene.skin.options.tolerance;
  options.corner_angle = scene.skin.options.corner_angle;
  options.straight_angle = scene.network->straight_angle;
  try {
    return CharacterLineNetwork(lines, options, progress);
  } catch (const InputError& e) {
    throw InputError(scene.at(scene.network->place) + e.what());
  }
}

FoundRegions regions_of(const Scene& scene, const CharacterLineNetwork& network,
                        const Progress& progress) {
  RegionOptions options;
  options.words = scene.network->regions;
  options.most_at_arc = scene.network->most_at_line;
  FoundRegions found = find_regions(network, options, progress);
  if (!found.regions.empty()) return found;
  std::string text = scene.at(scene.network->place) + "found no loop of lines that bounds a " +
                     "surface, expected one or more (lines meet within " +
                     number(network.tolerance()) + " " + scene.unit + ")";
  int more = 0;
  for (const NetworkFinding& finding : network.findings()) {
    if (finding.repaired) continue;
    constexpr int most = 5;
    if (++more <= most) text += "; " + finding.text;
  }
  throw InputError(text);
}

MadeModel make_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                     const Progress& progress) {
  progress.at("network", 0);
  CharacterLineNetwork network = network_of(scene, lines, progress);
  progress.at("regions", 0);
  FoundRegions found = regions_of(scene, network, progress);
  ModelOptions options;
  options.skin = scene.skin.options;
  options.material = scene.skin.material;
  options.joins = scene.network->joins;
  options.smooth_below_deg = scene.network->smooth_below;
  options.join_tolerance_deg = scene.network->join_tolerance;
  SurfaceModel model = skin_network(network, found, options, progress);
  const double tolerance = fit_tolerance(scene, network.size());
  MadeModel made{std::move(network), std::move(found), std::move(model), tolerance, 0};
  made.bending_energy = bending_energy(made, scene.skin.material.beta);
  return made;
}

}  // namespace batten
