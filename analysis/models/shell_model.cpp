// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "batten/core/cancellation.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

// Ties and supports; throws if they leave motions unconstrained, unless these are allowed.
ShellTies checked_ties(const ModelLayout& layout, const Points& shape,
                       const ShellDefinition& definition, ShellModel::RigidBodyHandling free,
                       RigidBodyModes& motions) {
  ShellTies ties = shell_ties(layout, shape, definition);
  motions = find_rigid_body_modes(layout, shape, ties);
  if (motions.unconstrained.empty() || free == ShellModel::RigidBodyHandling::Shifted) return ties;
  std::string text = "the supports do not constrain the shell: ";
  for (const std::string& motion : motions.unconstrained)
    text += (&motion == &motions.unconstrained[0] ? "" : "; ") + motion;
  throw NoSolutionError(text);
}

VecX stacked(const Points& q) { return Eigen::Map<const VecX>(q.data(), q.size()); }

// K with its springs, and a small multiple of the mass M in each coordinate for unsupported shells.
// One object is returned on all paths: Eigen's sparse matrices cannot be moved.
SparseMatrix stiffness_of(const ShellAssembler& assembler, const ShellSprings& springs,
                          double shift = 0, const SparseMatrix& M = {}) {
  SparseMatrix K = assembler.stiffness();
  if (!springs.empty()) K += springs.stiffness();
  if (shift != 0) {
    SparseMatrix all(K.rows(), K.cols());
    std::vector<Triplet> entries;
    for (long j = 0; j < M.cols(); ++j)
      for (SparseMatrix::InnerIterator it(M, j); it; ++it)
        for (int c = 0; c < 3; ++c) {
          const int offset = c * static_cast<int>(M.rows());
          entries.emplace_back(offset + static_cast<int>(it.row()), offset + static_cast<int>(j),
                               shift * it.value());
        }
    all.setFromTriplets(entries.begin(), entries.end());
    K += all;
  }
  return K;
}

// Energy ½ qᵀKq without that of the springs of supports, whose stiffness K includes.
double strain_energy(const SparseMatrix& K, const ShellSprings& springs, const Points& q) {
  const VecX x = stacked(q);
  double energy = 0.5 * x.dot(K.selfadjointView<Eigen::Lower>() * x);
  for (const ShellSprings::Spring& spring : springs.springs()) {
    if (spring.kind == ShellSprings::Kind::Stiffener) continue;
    double along = 0;
    for (const auto& e : spring.entries) along += e.coefficient.dot(q.row(e.dof));
    energy -= 0.5 * spring.stiffness * along * along;
  }
  return energy;
}

// Roughly (2π f)² of bending waves as long as the shell.
double shift_of(const ShellSection& section, double size) {
  return section.bending_stiffness() / (section.density() * section.thickness * std::pow(size, 4));
}

}  // namespace

ShellModel::ShellModel(ModelLayout layout, Points shape, const ShellDefinition& definition,
                       RigidBodyHandling free, const BackendFactory& backend_factory)
    : layout_(std::move(layout)),
      shape_(std::move(shape)),
      definition_(definition),
      rigid_body_handling_(free),
      sections_(triangle_sections(layout_, definition)),
      supports_(support_names(definition)),
      stiffeners_(layout_, shape_, definition.stiffeners),
      ties_(checked_ties(layout_, shape_, definition, free, rigid_body_modes_)),
      assembler_(layout_.surface(shape_), sections_),
      solver_(ties_.constraints, stiffness(), layout_.dof_order(),
              backend_factory ? backend_factory() : nullptr) {}

void ShellModel::update_shape(Points shape, const ShellDefinition& definition) {
  if (shape.rows() != shape_.rows())
    throw InputError("found a shape of " + std::to_string(shape.rows()) + " dofs, expected " +
                     std::to_string(shape_.rows()) + " of the shell");
  if (&definition != &definition_) {
    definition_ = definition;
    supports_ = support_names(definition_);
    sections_ = triangle_sections(layout_, definition_);
    assembler_.update_sections(sections_);
  }
  shape_ = std::move(shape);
  stiffeners_ = Stiffeners(layout_, shape_, definition_.stiffeners);
  ties_ = checked_ties(layout_, shape_, definition_, rigid_body_handling_, rigid_body_modes_);
  assembler_.update_shape(layout_.surface(shape_));
  solver_.update(ties_.constraints, stiffness());
}

SparseMatrix ShellModel::stiffness() {
  shift_ = rigid_body_modes_.unconstrained.empty() ? 0 : shift_of(section(0), layout_.size());
  if (shift_ == 0) return stiffness_of(assembler_, ties_.springs);
  return stiffness_of(assembler_, ties_.springs, shift_, mass());
}

Points ShellModel::solve(const Points& F) const {
  if (F.rows() != shape_.rows())
    throw InputError("found a load vector of " + std::to_string(F.rows()) + " dofs, expected " +
                     std::to_string(shape_.rows()) + " of the shell");
  return solver_.solve_refined(ties_.springs.empty() ? F : F + ties_.springs.load());
}

Points ShellModel::residual_forces(const Points& q, const Points& F) const {
  return reaction_forces(solver_.K(), q, F + ties_.springs.load());
}

Points ShellModel::adjoint(const Points& G) const {
  const Points a = solver_.solve_refined(G);
  const bool prescribed = !solver_.reduction().d0().isZero(0);
  return prescribed ? Points(a - solver_.solve_refined(Points::Zero(G.rows(), 3))) : a;
}

template <class Visit>
void ShellModel::for_each_constraint_force(const Points& q, const Points& F,
                                           const Visit& visit) const {
  const VecX lambda =
      solver_.reduction().rhs_to_particular().transpose() * stacked(residual_forces(q, F));
  const auto first = static_cast<long>(3 * ties_.constraints.constraints().size());
  for (size_t r = 0; r < ties_.constraints.coupled_constraints().size(); ++r) {
    const ConstraintSet::CoupledConstraint& row = ties_.constraints.coupled_constraints()[r];
    visit(ties_.constraints.names()[row.name], row.entries, lambda[first + static_cast<long>(r)]);
  }
  for (const ShellSprings::Spring& spring : ties_.springs.springs())
    visit(ties_.springs.names()[spring.name], spring.entries, ShellSprings::pull(spring, q));
}

std::vector<SupportReaction> ShellModel::reactions(const Points& q, const Points& F) const {
  std::vector<Points> forces(supports_.size(), Points::Zero(q.rows(), 3));
  for_each_constraint_force(
      q, F, [&](const std::string& name, const ShellSprings::Entries& entries, double factor) {
        const auto found = std::find(supports_.begin(), supports_.end(), name);
        if (found == supports_.end()) return;
        Points& sum = forces[found - supports_.begin()];
        for (const auto& e : entries) sum.row(e.dof) += factor * e.coefficient.transpose();
      });
  std::vector<SupportReaction> result;
  for (size_t s = 0; s < supports_.size(); ++s)
    result.push_back({supports_[s], resultant(layout_, shape_, forces[s]),
                      magnitudes(layout_, shape_, forces[s])});
  return result;
}

Resultant ShellModel::tie_resultant(const Points& q, const Points& F) const {
  Points forces = Points::Zero(q.rows(), 3);
  for_each_constraint_force(
      q, F, [&](const std::string& name, const ShellSprings::Entries& entries, double factor) {
        if (std::find(supports_.begin(), supports_.end(), name) != supports_.end()) return;
        for (const auto& e : entries) forces.row(e.dof) += factor * e.coefficient.transpose();
      });
  return resultant(layout_, shape_, forces);
}

ShellSystem ShellModel::assemble_system(const Points& shape,
                                        const ShellDefinition& definition) const {
  if (shift_ != 0)
    throw InputError(
        "found a shell with unconstrained motions, expected one with a stiffness matrix");
  RigidBodyModes motions;
  ShellTies ties = checked_ties(layout_, shape, definition, rigid_body_handling_, motions);
  ShellAssembler assembler = assembler_;
  if (&definition != &definition_)
    assembler.update_sections(triangle_sections(layout_, definition));
  assembler.update_shape(layout_.surface(shape));
  ShellSystem system{std::move(ties), std::move(assembler), {}};
  stiffness_of(system.assembler, system.ties.springs).swap(system.K);
  return system;
}

std::optional<Points> ShellModel::solve(const ShellSystem& similar,
                                        const AffineReduction& reduction, const Points& F,
                                        const Points& start) const {
  // Beyond this number of iterations, a new factorization takes less time.
  constexpr int iterations = 12;
  constexpr double accuracy = 1e-8;
  const ShellSprings& springs = similar.ties.springs;
  // Springs that prescribe a displacement have far more energy than the shell.
  const double energy = strain_energy(similar.K, springs, start);
  return solver_.solve_similar(reduction, similar.K, springs.empty() ? F : F + springs.load(),
                               start, accuracy * std::sqrt(2 * std::max(0.0, energy)), iterations);
}

double ShellModel::goal_change(const Points& u, const Points& F, const Points& a, const Points& G,
                               const ShellSystem& other, const Points& other_F) const {
  if (other.ties.constraints.constraints().size() != ties_.constraints.constraints().size() ||
      other.ties.constraints.coupled_constraints().size() !=
          ties_.constraints.coupled_constraints().size())
    throw InputError("found another number of constraints, expected that of the shell");
  const Points here = residual_forces(u, F),
               there = reaction_forces(other.K, u, other_F + other.ties.springs.load());
  double change = a.cwiseProduct(here - there).sum();
  // Constraints of the other shape, applied to displacements that satisfy those of this shape.
  const auto& rhs_to_particular = solver_.reduction().rhs_to_particular();
  const VecX of_u = rhs_to_particular.transpose() * stacked(here),
             of_a = rhs_to_particular.transpose() *
                    stacked(Points(residual_forces(a, G) + ties_.springs.load()));
  const auto first = static_cast<long>(3 * other.ties.constraints.constraints().size());
  for (size_t r = 0; r < other.ties.constraints.coupled_constraints().size(); ++r) {
    const ConstraintSet::CoupledConstraint &row = other.ties.constraints.coupled_constraints()[r],
                                           &before = ties_.constraints.coupled_constraints()[r];
    const auto value = [](const ConstraintSet::CoupledConstraint& of, const Points& q) {
      double sum = 0;
      for (const auto& e : of.entries) sum += e.coefficient.dot(q.row(e.dof));
      return sum;
    };
    const long k = first + static_cast<long>(r);
    change +=
        of_u[k] * (value(row, a) - value(before, a)) + of_a[k] * (value(row, u) - value(before, u));
  }
  return change;
}

SparseMatrix ShellModel::mass() const {
  return mass_matrix(layout_, shape_, definition_, assembler_);
}

SparseMatrix ShellModel::geometric_stiffness(const Points& q,
                                             const ShellTemperature& temperature) const {
  SparseMatrix G = assembler_.geometric_stiffness(q, temperature);
  stiffeners_.add_geometric_stiffness(q, temperature, G);
  return G;
}

double ShellModel::energy(const Points& q) const {
  return strain_energy(solver_.K(), ties_.springs, q);
}

namespace {

// (t, ω S): translation of the centre, rotation times size.
using Motion = Eigen::Matrix<double, 6, 1>;

// Rigid bodies, one per region, or one for the whole model.
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

  // Adds the contribution of a constraint to AᵀA, where A maps rigid-body motions to constraint
  // values.
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

// The direction v or -v whose largest component is positive, normalised.
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
    return "can translate along " + format_vector(pointing_up(t));
  const Vec3 axis = pointing_up(rotation_vector);
  Vec3 through = centre + rotation_vector.cross(t) / rotation_vector.squaredNorm();
  through -= axis.dot(through - centre) * axis;
  return "can rotate about the axis along " + format_vector(axis) + " through " +
         format_vector(through);
}

// Orthonormal basis of the part of `space` that is orthogonal to `removed`, a vector in it.
MatX without(const MatX& space, const VecX& removed) {
  const MatX rest = space - removed * (removed.transpose() * space);
  return thin_svd(rest).U.leftCols(space.cols() - 1);
}

// Unit vectors of all bodies moving together.
MatX uniform_motions(int bodies) {
  return Eigen::Matrix<double, 6, 6>::Identity().replicate(bodies, 1) / std::sqrt(bodies);
}

// Describes the motions in a space, first those of all bodies together.
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
      found.push_back("the whole model can translate along " + format_vector(Vec3::Unit(c)));
      space = without(space, all.col(c));
    }
  // Other motions of all bodies together: the intersection of the two spaces.
  while (space.cols() > 0) {
    const VecX shared = thin_svd(space.transpose() * all).V.col(0);
    const VecX v = all * shared;
    if (!holds(v)) break;
    found.push_back("the whole model " + describe(shared, bodies.centre(), bodies.size()));
    space = without(space, v);
  }
  for (long k = 0; k < space.cols(); ++k) {
    int most = 0;
    for (int b = 1; b < bodies.count(); ++b)
      if (space.col(k).segment<6>(6 * b).norm() > space.col(k).segment<6>(6 * most).norm())
        most = b;
    const std::string who =
        bodies.count() > 1 ? "face '" + model.region(most).name() + "' " : "the whole model ";
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
  long next = 0;
  for (const auto& row : ties.constraints.constraints())
    for (int c = 0; c < 3; ++c) {
      poll_every<2048>(next++);
      entries.clear();
      for (const auto& e : row.entries) entries.push_back({e.dof, e.coefficient * Vec3::Unit(c)});
      bodies.add_row(entries, AtA);
    }
  for (const auto& row : ties.constraints.coupled_constraints()) {
    poll_every<2048>(next++);
    bodies.add_row(row.entries, AtA);
  }
  for (const auto& spring : ties.springs.springs()) {
    poll_every<2048>(next++);
    if (spring.kind == ShellSprings::Kind::Stiffener) continue;
    bodies.add_row(spring.entries, AtA);
  }

  const SymmetricEigen eigen = symmetric_eigen(AtA);
  const VecX& values = eigen.values;
  constexpr double none = 1e-10, little = 1e-4;  // squares of the relative resistance
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
