#include "batten/fairing/fairing_energy.h"

#include <algorithm>

#include "batten/elements/hermite_segment.h"

namespace batten {

FairingEnergy::FairingEnergy(const CurveMesh& mesh, const std::vector<double>& wavelength_factor,
                             double alpha, double mu) {
  const auto fourth = [&](int at) {  // power of the ease at a parameter of the mesh
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

    const int after = (s + 1) % segments;  // segment, and the node before it
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

}  // namespace batten
