#include "batten/fairing/spring_balance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "batten/core/errors.h"
#include "batten/elements/quadrature.h"

namespace batten {
namespace {

HermiteSegment::Vector shape(const CurveMesh& mesh, CurveMesh::Where at) {
  return HermiteSegment(mesh.length(at.segment)).evaluate(at.s);
}

}  // namespace

NodeArc::NodeArc(const HermiteCurve& curve) : curve_(curve), at_node_{0} {
  for (int s = 0; s < curve.segment_count(); ++s)
    at_node_.push_back(at_node_.back() + inside({s, 1}));
}

double NodeArc::operator()(double u) const {
  const auto at = curve_.mesh().where(u);
  return at_node_[at.segment] + inside(at);
}

double NodeArc::inside(CurveMesh::Where at) const {
  static const SegmentRule rule = gauss_legendre(5);
  double sum = 0;
  for (long p = 0; p < rule.s.size(); ++p)
    sum += rule.weights[p] * curve_.evaluate({at.segment, at.s * rule.s[p]}, 1).norm();
  return sum * at.s * curve_.mesh().length(at.segment);
}

SpringBalance::SpringBalance(const CurveMesh& mesh, const std::vector<Spring>& springs,
                             const FairEnergy& energy, std::vector<std::pair<int, Vec3>> held)
    : mesh_(mesh),
      springs_(springs),
      energy_(energy),
      held_(std::move(held)),
      origin_(springs.empty() ? Vec3::Zero() : springs.front().goal),
      density_(static_cast<double>(springs.size()) / (mesh.end() - mesh.start())),
      band_(mesh, true) {
  for (const Spring& spring : springs_) {
    const HermiteSegment::Vector H = shape(mesh_, spring.at);
    FairEnergy::Part& part = spring_parts_.emplace_back();
    const auto dofs = mesh_.segment_dofs(spring.at.segment);
    std::copy(dofs.begin(), dofs.end(), part.dofs.begin());
    part.K.topLeftCorner<4, 4>() = H * H.transpose();
  }
  const auto fill = [&](BandCholesky& A, const std::vector<FairEnergy::Part>& parts) {
    band_.reset(A);
    for (const FairEnergy::Part& part : parts)
      for (int a = 0; a < part.count; ++a)
        for (int b = 0; b <= a; ++b)
          A.add(band_.place(part.dof(a)), band_.place(part.dof(b)), part.K(a, b));
  };
  fill(spring_band_, spring_parts_);
  fill(change_band_, energy_.change());
  fill(bending_band_, energy_.bending());
  const Points load = this->load(origin_);
  load_.resize(load.rows(), 3);
  for (int d = 0; d < mesh_.dof_count(); ++d) load_.row(band_.place(d)) = load.row(d);
}

double SpringBalance::bending_share(double wave) const {
  constexpr double beta = 0.5;
  return 1 / (1 + std::pow(beta * (mesh_.end() - mesh_.start()) / wave, 2));
}

double SpringBalance::of_change(double wave) const {
  return std::pow(wave / (2 * std::numbers::pi), 6) * density_ * (1 - bending_share(wave));
}

double SpringBalance::of_bending(double wave) const {
  return std::pow(wave / (2 * std::numbers::pi), 4) * density_ * bending_share(wave);
}

Points SpringBalance::load(const Vec3& origin) const {
  Points load = Points::Zero(mesh_.dof_count(), 3);
  for (const Spring& spring : springs_) {
    const HermiteSegment::Vector H = shape(mesh_, spring.at);
    const auto dofs = mesh_.segment_dofs(spring.at.segment);
    for (int a = 0; a < 4; ++a)
      load.row(dofs[static_cast<size_t>(a)]) += H[a] * (spring.goal - origin).transpose();
  }
  return load;
}

SparseMatrix SpringBalance::matrix(double wave) const {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](const std::vector<FairEnergy::Part>& parts, double factor) {
    for (const FairEnergy::Part& part : parts)
      for (int a = 0; a < part.count; ++a)
        for (int b = 0; b < part.count; ++b)
          entries.emplace_back(part.dof(a), part.dof(b), factor * part.K(a, b));
  };
  add(spring_parts_, 1);
  add(energy_.change(), of_change(wave));
  add(energy_.bending(), of_bending(wave));
  SparseMatrix K(mesh_.dof_count(), mesh_.dof_count());
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

bool SpringBalance::try_solve(double wave, Points& q) {
  A_ = spring_band_;
  A_.add(change_band_, of_change(wave));
  A_.add(bending_band_, of_bending(wave));
  right_ = load_;
  for (const auto& [dof, value] : held_) A_.fix(band_.place(dof), value - origin_, right_);
  if (!A_.factorize()) return false;
  A_.solve(right_);
  q.resize(mesh_.dof_count(), 3);
  for (int d = 0; d < mesh_.dof_count(); ++d) q.row(d) = right_.row(band_.place(d));
  for (int n = 0; n < mesh_.node_count(); ++n) q.row(mesh_.position_dof(n)) += origin_.transpose();
  return true;
}

Points SpringBalance::solve(double wave) {
  Points q;
  if (!try_solve(wave, q))
    throw NoSolutionError("a curve cannot be faired: its system is not positive definite");
  return q;
}

Points SpringBalance::imbalance(double wave, const Points& q) const {
  Points f = Points::Zero(mesh_.dof_count(), 3);
  for (const Spring& spring : springs_) {
    const HermiteSegment::Vector H = shape(mesh_, spring.at);
    const auto dofs = mesh_.segment_dofs(spring.at.segment);
    const Vec3 pull = spring.goal - at(q, spring);
    for (int a = 0; a < 4; ++a) f.row(dofs[static_cast<size_t>(a)]) += H[a] * pull.transpose();
  }
  FairEnergy::subtract(energy_.change(), of_change(wave), q, f);
  FairEnergy::subtract(energy_.bending(), of_bending(wave), q, f);
  return f;
}

Vec3 SpringBalance::at(const Points& q, const Spring& spring) const {
  const HermiteSegment::Vector H = shape(mesh_, spring.at);
  const auto dofs = mesh_.segment_dofs(spring.at.segment);
  Vec3 x = Vec3::Zero();
  for (int a = 0; a < 4; ++a) x += H[a] * q.row(dofs[static_cast<size_t>(a)]).transpose();
  return x;
}

double SpringBalance::freedom() const {
  double trace = A_.trace_of_quotient(spring_band_);
  // A held place is one degree of freedom, however many springs act there.
  for (const auto& [dof, value] : held_) trace += 1 - spring_band_.diagonal(band_.place(dof));
  return trace;
}

double SpringBalance::moved(const Points& q) const {
  double rest = 0;
  for (const Spring& spring : springs_) rest += (at(q, spring) - spring.goal).squaredNorm();
  return springs_.empty() ? 0 : std::sqrt(rest / static_cast<double>(springs_.size()));
}

double SpringBalance::score(double wave, double most) {
  constexpr double none = std::numeric_limits<double>::infinity();
  const auto points = static_cast<double>(springs_.size());
  const double dearer = 1 + 0.3 * std::clamp((points - 6) / 14.0, 0.0, 1.0);
  Points q;
  if (!try_solve(wave, q)) return none;
  const double rest = moved(q), left = points - dearer * freedom();
  return left > 0 && rest <= most ? rest * rest * points / (left * left) : none;
}

double minimum_of(const std::function<double(double)>& f, double low, double high, int samples) {
  double best = low, best_value = std::numeric_limits<double>::infinity();
  // From the fairest on, so that of equal ones the fairest wins.
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
