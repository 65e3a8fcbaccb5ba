// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/shapes/stress_probes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>

#include "batten/analysis/models/shell_samples.h"
#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/scenes/shapes/stress_places.h"

namespace batten {
namespace {

using Result = StressReport::Case::Result;

/// Least, largest and mean value of what is added with its weight.
class Statistics {
 public:
  void add(double value, double weight) {
    least_ = std::min(least_, value);
    largest_ = std::max(largest_, value);
    sum_ += weight * value;
    weight_ += weight;
  }
  Result::Range range() const {
    if (!(weight_ > 0)) return {};
    return {least_, sum_ / weight_, largest_};
  }
  double weight() const { return weight_; }

 private:
  double least_ = std::numeric_limits<double>::infinity(), largest_ = -least_;
  double sum_ = 0, weight_ = 0;
};

/// Samples along all pieces of a curve, one after the other.
std::vector<CurveSample> samples_on(const Scene& scene, const ShellModel& shell,
                                    const LocatedString& line) {
  std::vector<CurveSample> all;
  for (const std::string& piece : find_lines(shell.layout(), scene, line)) {
    const double before = all.empty() ? 0 : all.back().length;
    for (CurveSample& sample : sample_curve(shell.layout(), shell.shape(), piece)) {
      sample.length += before;
      all.push_back(sample);
    }
  }
  return all;
}

/// Stresses in the directions of a surface of revolution about the axis of a result.
struct RevolutionStress {
  double hoop, meridional, shear;
};
/// `normal`: of the surface at x. Throws InputError on the axis, where there is no hoop direction.
RevolutionStress about_axis(const Scene& scene, const SceneStress::Result& of, const Vec3& x,
                            const Vec3& normal, const Mat3& stress) {
  const Vec3 around = of.axis->cross(x - of.origin);
  const Vec3 hoop = around - around.dot(normal) * normal;
  constexpr double none = 1e-6;
  if (!(hoop.norm() > none * (x - of.origin).norm()))
    throw InputError(scene.at(of.location) +
                     "found a result on its axis, where there is no hoop "
                     "direction, expected one beside it");
  const Vec3 h = hoop.normalized(), m = normal.cross(h);
  return {h.dot(stress * h), m.dot(stress * m), h.dot(stress * m)};
}

Result at_point(const Scene& scene, const ShellModel& shell, const Surface& moved,
                const ShellStresses& stresses, const SceneStress::Result& of) {
  const ShellLocation place =
      place_of(scene, shell.layout(), shell.shape(), *of.point, of.location);
  const ShellStress stress = stresses.at(place.where);
  Result result;
  result.name = of.name;
  result.kind = "point";
  Result::Point& point = result.point.emplace();
  point.at = shell.assembler().surface().position(place.where);
  point.face = shell.layout().region(shell.layout().region_of(place.where.triangle)).name();
  point.displacement = moved.position(place.where);
  point.forces = stress.forces;
  point.moments = stress.moments;
  const Vec3 normal = shell.assembler().surface().jet(place.where).normal();
  for (const double height : {1.0, 0.0, -1.0}) {
    point.von_mises.push_back(von_mises(stress.at(height)));
    point.principal.push_back(principal(stress.at(height)));
    point.principal_directions.push_back(principal_direction(stress.at(height), normal));
    if (!of.axis) continue;
    const RevolutionStress own = about_axis(scene, of, point.at, normal, stress.at(height));
    point.hoop.push_back(own.hoop);
    point.meridional.push_back(own.meridional);
    point.shear.push_back(own.shear);
  }
  point.membrane = von_mises(stress.membrane());
  point.bending = von_mises(stress.bending());
  return result;
}

}  // namespace

std::vector<Result> requested_results(const Scene& scene, const ShellModel& shell,
                                      const ShellCaseResult& result,
                                      const ShellStresses& stresses) {
  std::vector<Result> results;
  if (scene.stress->results.empty()) return results;
  const Surface moved = shell.layout().surface(result.displacement);
  for (const SceneStress::Result& of : scene.stress->results) {
    if (of.point) {
      results.push_back(at_point(scene, shell, moved, stresses, of));
      continue;
    }
    Statistics displacement, stress;
    const auto add = [&](const Location& where, double weight) {
      displacement.add(moved.position(where).norm(), weight);
      stress.add(stresses.at(where).largest_von_mises().value, weight);
    };
    if (!of.line.text.empty()) {
      const std::vector<CurveSample> samples = samples_on(scene, shell, of.line);
      for (size_t k = 0; k < samples.size(); ++k) {
        const double before = samples[k > 0 ? k - 1 : k].length,
                     after = samples[k + 1 < samples.size() ? k + 1 : k].length;
        add(samples[k].where, (after - before) / 2);
      }
    } else {
      const int region = find_region(shell.layout(), scene, of.region);
      for (const AreaSample& sample : sample_face(shell.layout(), shell.shape(), region))
        add(sample.where, sample.area);
    }
    Result one;
    one.name = of.name;
    one.kind = of.line.text.empty() ? "face" : "curve";
    one.size = displacement.weight();
    one.displacement = displacement.range();
    one.von_mises = stress.range();
    results.push_back(std::move(one));
  }
  return results;
}

void write_curve_values(std::ostream& out, const Scene& scene, const ShellModel& shell,
                        const ShellCaseResult& result, const ShellStresses& stresses,
                        const SceneStress::Result& of) {
  const std::string& unit = scene.unit;
  const bool known = unit == "mm" || unit == "m";
  const std::string length = unit.empty() ? "" : " [" + unit + "]",
                    stress_unit = unit == "mm"  ? " [N/mm²]"
                                  : unit == "m" ? " [Pa]"
                                                : "",
                    force = known ? " [N/" + unit + "]" : "", moment = known ? " [N]" : "";
  out << "s" << length;
  for (const char* name : {"x", "y", "z", "ux", "uy", "uz"}) out << "," << name << length;
  for (const char* side : {"top", "middle", "bottom"}) out << ",von_mises_" << side << stress_unit;
  for (const char* name : {"N_along", "N_across", "N_shear"}) out << "," << name << force;
  for (const char* name : {"M_along", "M_across", "M_twist"}) out << "," << name << moment;
  for (const char* name : {"von_mises_membrane", "von_mises_bending"})
    out << "," << name << stress_unit;
  if (of.axis)
    for (const char* name : {"hoop", "meridional", "shear"})
      for (const char* side : {"top", "middle", "bottom"})
        out << "," << name << "_" << side << stress_unit;
  out << "\n";
  const Surface moved = shell.layout().surface(result.displacement);
  for (const CurveSample& sample : samples_on(scene, shell, of.line)) {
    const ShellStress stress = stresses.at(sample.where);
    const Vec3 normal = shell.assembler().surface().jet(sample.where).normal(),
               across = normal.cross(sample.tangent), u = moved.position(sample.where);
    out << exact_number(sample.length);
    for (const Vec3& v : {sample.at, u})
      for (const double x : v) out << "," << exact_number(x);
    for (const double height : {1.0, 0.0, -1.0})
      out << "," << exact_number(von_mises(stress.at(height)));
    for (const Mat3& tensor : {stress.forces, stress.moments})
      out << "," << exact_number(sample.tangent.dot(tensor * sample.tangent)) << ","
          << exact_number(across.dot(tensor * across)) << ","
          << exact_number(sample.tangent.dot(tensor * across));
    out << "," << exact_number(von_mises(stress.membrane())) << ","
        << exact_number(von_mises(stress.bending()));
    if (of.axis) {
      std::array<RevolutionStress, 3> own;
      for (size_t k = 0; k < 3; ++k)
        own[k] = about_axis(scene, of, sample.at, normal, stress.at(1.0 - static_cast<double>(k)));
      for (const auto component :
           {&RevolutionStress::hoop, &RevolutionStress::meridional, &RevolutionStress::shear})
        for (const RevolutionStress& one : own) out << "," << exact_number(one.*component);
    }
    out << "\n";
  }
}

}  // namespace batten
