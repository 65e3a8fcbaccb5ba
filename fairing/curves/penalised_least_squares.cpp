// SPDX-License-Identifier: MPL-2.0
#include "batten/fairing/curves/penalised_least_squares.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"

namespace batten {
namespace {

HermiteSegment::Vector shape(const CurveMesh& mesh, CurveMesh::SegmentPoint at) {
  return HermiteSegment(mesh.length(at.segment)).evaluate(at.s);
}

}  // namespace

HermiteArcLength::HermiteArcLength(const HermiteCurve& curve) : curve_(curve), at_node_{0} {
  for (int s = 0; s < curve.segment_count(); ++s)
    at_node_.push_back(at_node_.back() + inside({s, 1}));
}

double HermiteArcLength::operator()(double u) const {
  const auto at = curve_.mesh().locate(u);
  return at_node_[at.segment] + inside(at);
}

double HermiteArcLength::inside(CurveMesh::SegmentPoint at) const {
  static const SegmentRule rule = gauss_legendre(5);
  double sum = 0;
  for (long p = 0; p < rule.s.size(); ++p)
    sum += rule.weights[p] * curve_.evaluate({at.segment, at.s * rule.s[p]}, 1).norm();
  return sum * at.s * curve_.mesh().length(at.segment);
}

PenalisedLeastSquares::PenalisedLeastSquares(const CurveMesh& mesh,
                                             const std::vector<Spring>& springs,
                                             const FairingEnergy& energy,
                                             std::vector<std::pair<int, Vec3>> fixed_dofs)
    : mesh_(mesh),
      springs_(springs),
      energy_(energy),
      fixed_dofs_(std::move(fixed_dofs)),
      origin_(springs.empty() ? Vec3::Zero() : springs.front().goal),
      density_(static_cast<double>(springs.size()) / (mesh.end() - mesh.start())),
      band_(mesh, true) {
  for (const Spring& spring : springs_) {
    const HermiteSegment::Vector H = shape(mesh_, spring.at);
    FairingEnergy::Part& part = spring_parts_.emplace_back();
    const auto dofs = mesh_.segment_dofs(spring.at.segment);
    std::copy(dofs.begin(), dofs.end(), part.dofs.begin());
    part.K.topLeftCorner<4, 4>() = H * H.transpose();
  }
  const auto fill = [&](BandCholesky& A, const std::vector<FairingEnergy::Part>& parts) {
    band_.reset(A);
    for (const FairingEnergy::Part& part : parts)
      for (int a = 0; a < part.count; ++a)
        for (int b = 0; b <= a; ++b)
          A.add(band_.banded_index(part.dof(a)), band_.banded_index(part.dof(b)), part.K(a, b));
  };
  fill(spring_band_, spring_parts_);
  fill(variation_band_, energy_.variation());
  fill(bending_band_, energy_.bending());
  const Points load = this->load(origin_);
  load_.resize(load.rows(), 3);
  for (int d = 0; d < mesh_.dof_count(); ++d) load_.row(band_.banded_index(d)) = load.row(d);
}

double PenalisedLeastSquares::bending_fraction(double wavelength) const {
  constexpr double beta = 0.5;
  return 1 / (1 + std::pow(beta * (mesh_.end() - mesh_.start()) / wavelength, 2));
}

double PenalisedLeastSquares::variation_weight(double wavelength) const {
  return std::pow(wavelength / (2 * std::numbers::pi), 6) * density_ *
         (1 - bending_fraction(wavelength));
}

double PenalisedLeastSquares::bending_weight(double wavelength) const {
  return std::pow(wavelength / (2 * std::numbers::pi), 4) * density_ * bending_fraction(wavelength);
}

Points PenalisedLeastSquares::load(const Vec3& origin) const {
  Points load = Points::Zero(mesh_.dof_count(), 3);
  for (const Spring& spring : springs_) {
    const HermiteSegment::Vector H = shape(mesh_, spring.at);
    const auto dofs = mesh_.segment_dofs(spring.at.segment);
    for (int a = 0; a < 4; ++a)
      load.row(dofs[static_cast<size_t>(a)]) += H[a] * (spring.goal - origin).transpose();
  }
  return load;
}

SparseMatrix PenalisedLeastSquares::matrix(double wavelength) const {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](const std::vector<FairingEnergy::Part>& parts, double factor) {
    for (const FairingEnergy::Part& part : parts)
      for (int a = 0; a < part.count; ++a)
        for (int b = 0; b < part.count; ++b)
          entries.emplace_back(part.dof(a), part.dof(b), factor * part.K(a, b));
  };
  add(spring_parts_, 1);
  add(energy_.variation(), variation_weight(wavelength));
  add(energy_.bending(), bending_weight(wavelength));
  SparseMatrix K(mesh_.dof_count(), mesh_.dof_count());
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

bool PenalisedLeastSquares::try_solve(double wavelength, Points& q) {
  A_ = spring_band_;
  A_.add(variation_band_, variation_weight(wavelength));
  A_.add(bending_band_, bending_weight(wavelength));
  rhs_ = load_;
  for (const auto& [dof, value] : fixed_dofs_)
    A_.fix(band_.banded_index(dof), value - origin_, rhs_);
  if (!A_.factorize()) return false;
  A_.solve(rhs_);
  q.resize(mesh_.dof_count(), 3);
  for (int d = 0; d < mesh_.dof_count(); ++d) q.row(d) = rhs_.row(band_.banded_index(d));
  for (int n = 0; n < mesh_.node_count(); ++n) q.row(mesh_.position_dof(n)) += origin_.transpose();
  return true;
}

Points PenalisedLeastSquares::solve(double wavelength) {
  Points q;
  if (!try_solve(wavelength, q))
    throw NoSolutionError(
        "a curve cannot be faired: its system of equations is not positive definite");
  return q;
}

Points PenalisedLeastSquares::residual(double wavelength, const Points& q) const {
  Points f = Points::Zero(mesh_.dof_count(), 3);
  for (const Spring& spring : springs_) {
    const HermiteSegment::Vector H = shape(mesh_, spring.at);
    const auto dofs = mesh_.segment_dofs(spring.at.segment);
    const Vec3 pull = spring.goal - at(q, spring);
    for (int a = 0; a < 4; ++a) f.row(dofs[static_cast<size_t>(a)]) += H[a] * pull.transpose();
  }
  FairingEnergy::subtract(energy_.variation(), variation_weight(wavelength), q, f);
  FairingEnergy::subtract(energy_.bending(), bending_weight(wavelength), q, f);
  return f;
}

Vec3 PenalisedLeastSquares::at(const Points& q, const Spring& spring) const {
  const HermiteSegment::Vector H = shape(mesh_, spring.at);
  const auto dofs = mesh_.segment_dofs(spring.at.segment);
  Vec3 x = Vec3::Zero();
  for (int a = 0; a < 4; ++a) x += H[a] * q.row(dofs[static_cast<size_t>(a)]).transpose();
  return x;
}

double PenalisedLeastSquares::effective_dofs() const {
  double trace = A_.trace_of_inverse_times(spring_band_);
  // A fixed dof counts as one degree of freedom, however many springs act there.
  for (const auto& [dof, value] : fixed_dofs_)
    trace += 1 - spring_band_.diagonal(band_.banded_index(dof));
  return trace;
}

double PenalisedLeastSquares::rms_residual(const Points& q) const {
  double rest = 0;
  for (const Spring& spring : springs_) rest += (at(q, spring) - spring.goal).squaredNorm();
  return springs_.empty() ? 0 : std::sqrt(rest / static_cast<double>(springs_.size()));
}

double PenalisedLeastSquares::gcv_score(double wavelength, double most) {
  constexpr double none = std::numeric_limits<double>::infinity();
  const auto points = static_cast<double>(springs_.size());
  const double dof_cost = 1 + 0.3 * std::clamp((points - 6) / 14.0, 0.0, 1.0);
  Points q;
  if (!try_solve(wavelength, q)) return none;
  const double rest = rms_residual(q), left = points - dof_cost * effective_dofs();
  return left > 0 && rest <= most ? rest * rest * points / (left * left) : none;
}

HermiteCurve with_continuous_second_derivative(const HermiteCurve& curve) {
  const CurveMesh& mesh = curve.mesh();
  const int nodes = mesh.node_count(), segments = mesh.segment_count();
  const auto is_free = [&](int node) {
    return !mesh.is_corner(node) && (mesh.closed() || (node > 0 && node + 1 < nodes));
  };
  // A closed curve is folded flat, as in CurveDofOrdering.
  const auto banded = [&](int node) {
    if (!mesh.closed()) return node;
    return 2 * node < nodes ? 2 * node : 2 * (nodes - 1 - node) + 1;
  };
  // The matrix of ∫ |X_uu|² for the slopes: its gradient is the jump of X_uu.
  BandCholesky A;
  A.reset(nodes, mesh.closed() ? 3 : 1);
  for (int s = 0; s < segments; ++s) {
    const int a = s, b = (s + 1) % nodes;
    for (const int node : {a, b}) A.add(banded(node), banded(node), 4 / mesh.length(s));
    A.add(banded(a), banded(b), 2 / mesh.length(s));
  }
  Points ignored = Points::Zero(nodes, 3);
  for (int node = 0; node < nodes; ++node)
    if (!is_free(node)) A.fix(banded(node), Vec3::Zero(), ignored);
  if (!A.factorize()) return curve;
  Points dofs = curve.dofs(), change(nodes, 3);
  constexpr int steps = 2;  // the second one refines the solution
  for (int step = 0; step < steps; ++step) {
    change.setZero();
    for (int s = 0; s < segments; ++s) {
      const double h = mesh.length(s);
      const auto dof = mesh.segment_dofs(s);
      const Eigen::RowVector3d chord = (dofs.row(dof[2]) - dofs.row(dof[0])) / h,
                               start = dofs.row(dof[1]) - chord, end = dofs.row(dof[3]) - chord;
      change.row(banded(s)) -= (4 * start + 2 * end) / h;
      change.row(banded((s + 1) % nodes)) -= (2 * start + 4 * end) / h;
    }
    for (int node = 0; node < nodes; ++node)
      if (!is_free(node)) change.row(banded(node)).setZero();
    A.solve(change);
    for (int node = 0; node < nodes; ++node)
      if (is_free(node)) dofs.row(mesh.slope_out(node)) += change.row(banded(node));
  }
  return {mesh, dofs};
}

double golden_section_minimum(const std::function<double(double)>& f, double low, double high,
                              int samples) {
  double best = low, best_value = std::numeric_limits<double>::infinity();
  // Starts at the largest argument (the fairest curve), so that it wins among equal values.
  for (int i = samples; i >= 0; --i) {
    const double x = low + (high - low) * i / samples, value = f(x);
    if (value < best_value) {
      best = x;
      best_value = value;
    }
  }
  double a = std::max(low, best - (high - low) / samples),
         b = std::min(high, best + (high - low) / samples);
  const double golden = 1 / std::numbers::phi;
  double x = b - golden * (b - a), y = a + golden * (b - a), fx = f(x), fy = f(y);
  for (int i = 0; i < 8; ++i) {
    if (fx < fy) {
      b = y;
      y = x;
      fy = fx;
      fx = f(x = b - golden * (b - a));
    } else {
      a = x;
      x = y;
      fx = fy;
      fy = f(y = a + golden * (b - a));
    }
  }
  return fx < best_value || fy < best_value ? (fx < fy ? x : y) : best;
}

}  // namespace batten
