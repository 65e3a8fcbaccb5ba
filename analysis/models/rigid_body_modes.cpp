#include "batten/analysis/models/rigid_body_modes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "batten/core/dense.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

using Motion = Eigen::Matrix<double, 6, 1>;  // (t, ω S): translation of the centre, turn times size

// Bodies that stay rigid, one for each region, or one of all.
class RigidBodies {
 public:
  RigidBodies(const ModelLayout& model, const Points& shape)
      : shape_(shape), positions_(model.position_dofs()), body_of_(shape.rows(), 0) {
    constexpr int most = 500;
    count_ = model.region_count() > most ? 1 : model.region_count();
    for (int r = 0; r < model.region_count() && count_ > 1; ++r) {
      const int dofs = DofMap(*model.region(r).mesh()).count();
      const DofOffsets& dof_offsets = model.dof_offsets(r);
      for (int d = 0; d < dofs; ++d) body_of_[dof_offsets(d)] = r;
    }
    centre_ = (positions_.transpose() * shape).transpose() / positions_.sum();
    double squares = 0;
    for (long m = 0; m < shape.rows(); ++m)
      if (positions_[m] > 0) squares += (shape.row(m).transpose() - centre_).squaredNorm();
    size_ = std::sqrt(squares / positions_.sum());
  }

  int count() const { return count_; }
  const Vec3& centre() const { return centre_; }
  double size() const { return size_; }

  // Adds a row's part to AᵀA, where A is what rows make of motions.
  void add_row(const std::vector<ConstraintSet::CoupledEntry>& entries, MatX& AtA) const {
    std::map<int, Motion> parts;
    for (const auto& e : entries) {
      const Vec3 lever = shape_.row(e.dof).transpose() - positions_[e.dof] * centre_;
      Motion part;
      part << positions_[e.dof] * e.coefficient, lever.cross(e.coefficient) / size_;
      parts.try_emplace(body_of_[e.dof], Motion::Zero()).first->second += part;
    }
    double largest = 0;
    for (const auto& [body, part] : parts) largest = std::max(largest, part.norm());
    if (!(largest > 0)) return;
    for (const auto& [a, of_a] : parts)
      for (const auto& [b, of_b] : parts)
        AtA.block<6, 6>(6 * a, 6 * b) += of_a * of_b.transpose() / (largest * largest);
  }

 private:
  const Points& shape_;
  VecX positions_;
  std::vector<int> body_of_;
  int count_ = 1;
  Vec3 centre_;
  double size_ = 1;
};

std::string format_vector(Vec3 v) {
  constexpr double digits = 1e4;
  std::string text;
  for (int c = 0; c < 3; ++c)
    text += (c ? ", " : "[") + format_number(std::round(v[c] * digits) / digits + 0.0);
  return text + "]";
}

// Of a unit vector and its opposite the one whose largest component is positive.
Vec3 pointing_up(Vec3 v) {
  v.normalize();
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  return v[largest] < 0 ? Vec3(-v) : v;
}

std::string describe(const Motion& motion, const Vec3& centre, double size) {
  constexpr double none = 1e-6;
  const Vec3 t = motion.head<3>(), rotation_vector = motion.tail<3>() / size;
  if (rotation_vector.norm() * size <= none * t.norm())
    return "can slide along " + format_vector(pointing_up(t));
  const Vec3 axis = pointing_up(rotation_vector);
  Vec3 through = centre + rotation_vector.cross(t) / rotation_vector.squaredNorm();
  through -= axis.dot(through - centre) * axis;
  return "can turn about the axis along " + format_vector(axis) + " through " +
         format_vector(through);
}

// An orthonormal basis of `space` without the direction `removed`, which lies in it.
MatX without(const MatX& space, const VecX& removed) {
  const MatX rest = space - removed * (removed.transpose() * space);
  return thin_svd(rest).U.leftCols(space.cols() - 1);
}

// Unit vectors of all bodies moving as one.
MatX uniform_motions(int bodies) {
  return Eigen::Matrix<double, 6, 6>::Identity().replicate(bodies, 1) / std::sqrt(bodies);
}

// The motions of a space, first those of all bodies as one.
std::vector<std::string> describe_motions(const ModelLayout& model, const RigidBodies& bodies,
                                          MatX space) {
  std::vector<std::string> found;
  const auto holds = [&](const VecX& v) {
    constexpr double inside = 1e-6;
    return (space * (space.transpose() * v) - v).norm() < inside;
  };
  const MatX all = uniform_motions(bodies.count());
  for (int c = 0; c < 3 && space.cols() > 0; ++c)
    if (holds(all.col(c))) {
      found.push_back("all of it can slide along " + format_vector(Vec3::Unit(c)));
      space = without(space, all.col(c));
    }
  // Further motions of all as one: where the two spaces meet.
  while (space.cols() > 0) {
    const VecX shared = thin_svd(space.transpose() * all).V.col(0);
    const VecX v = all * shared;
    if (!holds(v)) break;
    found.push_back("all of it " + describe(shared, bodies.centre(), bodies.size()));
    space = without(space, v);
  }
  for (long k = 0; k < space.cols(); ++k) {
    int most = 0;
    for (int b = 1; b < bodies.count(); ++b)
      if (space.col(k).segment<6>(6 * b).norm() > space.col(k).segment<6>(6 * most).norm())
        most = b;
    const std::string who =
        bodies.count() > 1 ? "region '" + model.region(most).name() + "' " : "all of it ";
    found.push_back(who +
                    describe(space.col(k).segment<6>(6 * most), bodies.centre(), bodies.size()));
  }
  return found;
}

}  // namespace

RigidBodyModes find_rigid_body_modes(const ModelLayout& model, const Points& shape,
                                     const ShellTies& ties) {
  const RigidBodies bodies(model, shape);
  MatX AtA = MatX::Zero(6 * bodies.count(), 6 * bodies.count());
  std::vector<ConstraintSet::CoupledEntry> entries;
  for (const auto& row : ties.constraints.constraints())
    for (int c = 0; c < 3; ++c) {
      entries.clear();
      for (const auto& e : row.entries) entries.push_back({e.dof, e.coefficient * Vec3::Unit(c)});
      bodies.add_row(entries, AtA);
    }
  for (const auto& row : ties.constraints.coupled_constraints()) bodies.add_row(row.entries, AtA);
  for (const auto& spring : ties.springs.springs()) bodies.add_row(spring.entries, AtA);

  const SymmetricEigen eigen = symmetric_eigen(AtA);
  const VecX& values = eigen.values;
  constexpr double none = 1e-10, little = 1e-4;  // squares of what resists
  const auto below = [&](double limit) {
    return std::lower_bound(values.begin(), values.end(), limit) - values.begin();
  };
  const long free = below(none * std::max(1.0, values[values.size() - 1])),
             weak = std::max(free, below(little));
  RigidBodyModes motions;
  motions.unconstrained = describe_motions(model, bodies, eigen.vectors.leftCols(free));
  motions.weakly_constrained =
      describe_motions(model, bodies, eigen.vectors.middleCols(free, weak - free));
  if (weak > free) motions.smallest_lever = std::sqrt(values[free]);
  return motions;
}

}  // namespace batten
