// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/fairing_energy.h"

#include <algorithm>
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/elements/hermite_segment.h"

namespace batten {

FairingEnergy::FairingEnergy(const CurveMesh& mesh, const std::vector<double>& wavelength_factor,
                             double alpha, double mu) {
  const auto fourth = [&](int at) {  // fourth power of r at a parameter of the mesh
    const double r = wavelength_factor.empty() ? 1 : wavelength_factor[static_cast<size_t>(at)];
    return r * r * r * r;
  };
  const auto sixth = [&](int at) {
    const double r = wavelength_factor.empty() ? 1 : wavelength_factor[static_cast<size_t>(at)];
    return r * r * fourth(at);
  };
  const int segments = mesh.segment_count();
  for (int s = 0; s < segments; ++s) {
    const double h = mesh.length(s);
    const HermiteSegment segment(h);
    const auto dofs = mesh.segment_dofs(s);
    Part part;
    std::copy(dofs.begin(), dofs.end(), part.dofs.begin());
    part.free.topRows<4>() << 1, 0, 0, 1, 1, h, 0, 1;
    const HermiteSegment::Vector third = segment.evaluate(0, 3);  // constant along the segment
    part.K.topLeftCorner<4, 4>() = 0.5 * (sixth(s) + sixth(s + 1)) * h * third * third.transpose();
    variation_.push_back(part);
    const HermiteSegment::Linear weight{fourth(s), fourth(s + 1)};
    HermiteSegment::Matrix K = segment.bending(weight);
    if (alpha > 0) K += segment.stretching({alpha * weight.start, alpha * weight.end});
    part.K.topLeftCorner<4, 4>() = K;
    bending_.push_back(part);
    if (alpha > 0) bending_.back().free.col(1).setZero();

    const int after = (s + 1) % segments;  // next segment, and the node before it
    if ((after == 0 && !mesh.closed()) || mesh.is_corner(after)) continue;
    const auto behind = mesh.segment_dofs(after);
    part.count = 6;
    part.free.bottomRows<2>() << 1, h + mesh.length(after), 0, 1;
    std::copy(behind.begin() + 2, behind.end(), part.dofs.begin() + 4);
    Eigen::Matrix<double, 6, 1> jump = Eigen::Matrix<double, 6, 1>::Zero();
    jump.head<4>() = segment.evaluate(1, 2);
    jump.tail<4>() -= HermiteSegment(mesh.length(after)).evaluate(0, 2);
    const double around = 0.5 * (h + mesh.length(after));
    part.K = sixth(s + 1) * mu / around * jump * jump.transpose();
    variation_.push_back(part);
  }
}

void FairingEnergy::subtract(const std::vector<Part>& parts, double factor, const Points& x,
                             Points& f) {
  for (const Part& part : parts) {
    Eigen::Matrix<double, 6, 3> local = Eigen::Matrix<double, 6, 3>::Zero();
    for (int a = 0; a < part.count; ++a) local.row(a) = x.row(part.dof(a));
    local -= part.free * local.topRows<2>().eval();
    const Eigen::Matrix<double, 6, 3> force = factor * part.K * local;
    for (int a = 0; a < part.count; ++a) f.row(part.dof(a)) -= force.row(a);
  }
}

namespace {

// Unit tangents at points inside of segments, thus never at a corner; ascending u.
struct Tangents {
  std::vector<double> u;
  std::vector<Vec3> t;

  explicit Tangents(const HermiteCurve& curve) {
    constexpr int least = 64;
    const int segments = curve.segment_count(), each = 1 + (least - 1) / segments;
    for (int s = 0; s < segments; ++s)
      for (int k = 0; k < each; ++k) {
        const double f = (k + 0.5) / each;
        u.push_back(curve.parameters()[static_cast<size_t>(s)] + f * curve.mesh().length(s));
        t.push_back(curve.evaluate(CurveMesh::SegmentPoint{s, f}, 1).normalized());
      }
  }
  // For a closed curve without corners: repeats the tangents before and after.
  void repeat(double length) {
    const std::vector<double> own = u;
    const std::vector<Vec3> tangents = t;
    u.clear();
    t.clear();
    for (const double shift : {-length, 0.0, length})
      for (size_t i = 0; i < own.size(); ++i) {
        u.push_back(own[i] + shift);
        t.push_back(tangents[i]);
      }
  }
};

// Turning angle between two tangents per parameter length, as a sum of two halves so that a half
// circle is not mistaken for no turn.
double turning_rate(const Tangents& tangents, size_t from, size_t to) {
  const double parameter_length = tangents.u[to] - tangents.u[from];
  const size_t middle = (from + to) / 2;
  return parameter_length > 0 ? (degrees_between(tangents.t[from], tangents.t[middle]) +
                                 degrees_between(tangents.t[middle], tangents.t[to])) /
                                    parameter_length
                              : 0;
}

}  // namespace

CurvatureAdaptiveWavelength::CurvatureAdaptiveWavelength(
    const HermiteCurve& curve, double wavelength, const CurvatureAdaptiveWavelength& before) {
  Tangents tangents(curve);
  u_ = tangents.u;
  const double length = curve.end() - curve.start();
  std::vector<double> stops = {-INFINITY};  // parameters at which averaging windows end
  for (const int corner : curve.mesh().corners())
    stops.push_back(curve.parameters()[static_cast<size_t>(corner)]);
  stops.push_back(INFINITY);
  if (curve.closed() && stops.size() == 2) tangents.repeat(length);
  const auto first_from = [&](double u) {
    return std::lower_bound(tangents.u.begin(), tangents.u.end(), u) - tangents.u.begin();
  };
  double sum = 0;
  for (const double u : u_) {
    const double reach = 0.25 * wavelength * before.at((u - curve.start()) / length);
    const auto stop = std::upper_bound(stops.begin(), stops.end(), u);
    // Always includes at least one tangent on either side.
    constexpr long fewest = 1;
    const long here = first_from(u);
    const long from = std::max(std::min(first_from(u - reach), here - fewest),
                               static_cast<long>(first_from(*(stop - 1))));
    const long to = std::min(std::max(first_from(u + reach) - 1, here + fewest),
                             static_cast<long>(first_from(*stop)) - 1);
    factors_.push_back(
        to > from ? turning_rate(tangents, static_cast<size_t>(from), static_cast<size_t>(to)) : 0);
  }
  for (size_t i = 0; i < u_.size(); ++i) {
    const double a = i > 0 ? u_[i - 1] : curve.start();
    const double b = i + 1 < u_.size() ? u_[i + 1] : curve.end();
    sum += factors_[i] * (b - a) / 2;
  }
  const double mean = sum / length;
  constexpr double usual = 1.2;  // ratio that noise produces on a curve of constant curvature
  for (double& e : factors_)
    e = mean > 0 ? std::pow(std::max(1.0, e / (usual * mean)), -5 / 12.0) : 1;
  if (std::all_of(factors_.begin(), factors_.end(), [](double e) { return e == 1; }))
    factors_.clear();
  for (double& u : u_) u = (u - curve.start()) / length;
}

double CurvatureAdaptiveWavelength::at(double fraction) const {
  if (factors_.empty()) return 1;
  const auto above = std::upper_bound(u_.begin(), u_.end(), fraction);
  if (above == u_.begin()) return factors_.front();
  if (above == u_.end()) return factors_.back();
  const auto i = static_cast<size_t>(above - u_.begin());
  return factors_[i - 1] +
         (fraction - u_[i - 1]) / (u_[i] - u_[i - 1]) * (factors_[i] - factors_[i - 1]);
}

std::vector<double> CurvatureAdaptiveWavelength::of(const CurveMesh& mesh) const {
  std::vector<double> wavelength_factor;
  if (even()) return wavelength_factor;
  const double length = mesh.end() - mesh.start();
  for (const double u : mesh.parameters())
    wavelength_factor.push_back(at((u - mesh.start()) / length));
  // On a closed curve, first and last parameter are the same point.
  if (mesh.closed())
    wavelength_factor.front() = wavelength_factor.back() =
        (wavelength_factor.front() + wavelength_factor.back()) / 2;
  return wavelength_factor;
}

}  // namespace batten
