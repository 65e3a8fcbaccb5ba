#include "batten/analysis/models/shell_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "batten/analysis/models/free_motions.h"
#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/shell_ties.h"
#include "batten/core/errors.h"
#include "batten/elements/c1_triangle.h"

namespace batten {
namespace {

void add_point_support(const ModelLayout& model, const PointSupport& support, ConstraintSet& set) {
  if (support.directions.empty())
    throw InputError("support '" + support.name + "' holds nothing: expected directions");
  const ParametricMesh& mesh = *model.mesh();
  const int t = support.place.where.triangle;
  const Tabulation N = C1Triangle(model.element(), mesh.shape(t)).evaluate(support.place.where.L);
  const auto dofs = DofMap(mesh).triangle(mesh, t);
  for (const Vec3& direction : support.directions) {
    if (!direction.allFinite() || direction.isZero(0))
      throw InputError("support '" + support.name + "' has a direction of length zero");
    const Vec3 along = direction.normalized();
    CoupledEntries row;
    for (int m = 0; m < 12; ++m) row.push_back({dofs[m], N(m, kW) * along});
    add_summed(support.name, row, along.dot(support.displacement), set);
  }
}

ConstraintSet rows_of(const ModelLayout& layout, const Points& shape,
                      const ShellDefinition& definition, ShellModel::Free free, int& free_count) {
  ConstraintSet set = shell_ties(layout, shape, definition.hinges);
  for (const LineSupport& support : definition.lines) add_support(layout, shape, support, set);
  for (const PointSupport& support : definition.points) add_point_support(layout, support, set);
  const std::vector<std::string> motions = free_motions(layout, shape, set);
  free_count = count_of(motions);
  if (motions.empty() || free == ShellModel::Free::Shifted) return set;
  std::string text = "the shell is not held: ";
  for (const std::string& motion : motions) text += (&motion == &motions[0] ? "" : "; ") + motion;
  throw NoSolutionError(text);
}

std::vector<ShellSection> for_triangles(const ModelLayout& layout,
                                        const std::vector<ShellSection>& sections) {
  if (sections.size() == 1) return sections;
  if (count_of(sections) != layout.region_count())
    throw InputError(std::to_string(sections.size()) + " sections for " +
                     std::to_string(layout.region_count()) + " regions");
  std::vector<ShellSection> all;
  for (int t = 0; t < layout.mesh()->triangle_count(); ++t)
    all.push_back(sections[layout.region_of(t)]);
  return all;
}

// Each name once: the parts of a line that is cut at corners are one support.
std::vector<std::string> names_of(const ShellDefinition& definition) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const LineSupport& support : definition.lines) add(support.name);
  for (const PointSupport& support : definition.points) add(support.name);
  return names;
}

VecX stacked(const Points& q) { return Eigen::Map<const VecX>(q.data(), q.size()); }

}  // namespace

namespace {

// K, and of a shell that is not held a little mass in each coordinate.
SparseMatrix stiffness_of(const ShellAssembler& assembler, double shift) {
  SparseMatrix K = assembler.stiffness();
  if (shift == 0) return K;
  const SparseMatrix M = assembler.mass();
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
  return K + all;
}

// (2π f)² of bending waves as long as the shell, or so.
double shift_of(const ShellSection& section, double size) {
  const ShellMaterial& m = section.material;
  return m.Q(0, 0) * std::pow(section.thickness, 2) / (12 * m.density * std::pow(size, 4));
}

}  // namespace

ShellModel::ShellModel(ModelLayout layout, Points shape, const ShellDefinition& definition,
                       Free free)
    : layout_(std::move(layout)),
      shape_(std::move(shape)),
      sections_(definition.sections),
      supports_(names_of(definition)),
      rows_(rows_of(layout_, shape_, definition, free, free_motions_)),
      assembler_(layout_.surface(shape_), for_triangles(layout_, definition.sections)),
      solver_(rows_,
              stiffness_of(assembler_,
                           shift_ = free_motions_ > 0 ? shift_of(sections_[0], layout_.size()) : 0),
              layout_.dof_order()) {}

Points ShellModel::solve(const Points& F) const {
  if (F.rows() != shape_.rows())
    throw InputError("a load of " + std::to_string(F.rows()) + " dofs on a shell of " +
                     std::to_string(shape_.rows()));
  return solver_.solve(F);
}

std::vector<SupportReaction> ShellModel::reactions(const Points& q, const Points& F) const {
  const VecX lambda =
      solver_.reduction().from_right().transpose() * stacked(reaction_forces(solver_.K(), q, F));
  const VecX positions = layout_.position_dofs();
  std::vector<SupportReaction> result;
  std::map<int, size_t> of_name;
  for (const std::string& name : supports_) result.push_back({name, {}});
  for (size_t n = 0; n < rows_.names().size(); ++n)
    for (size_t s = 0; s < supports_.size(); ++s)
      if (supports_[s] == rows_.names()[n]) of_name.emplace(static_cast<int>(n), s);
  const auto first = static_cast<long>(3 * rows_.rows().size());
  for (size_t r = 0; r < rows_.coupled_rows().size(); ++r) {
    const ConstraintSet::CoupledRow& row = rows_.coupled_rows()[r];
    const auto of = of_name.find(row.name);
    if (of == of_name.end()) continue;  // a tie
    Resultant& sum = result[of->second].resultant;
    for (const auto& e : row.entries) {
      const Vec3 force = lambda[first + static_cast<long>(r)] * e.coefficient;
      sum.force += positions[e.dof] * force;
      sum.moment += Vec3(shape_.row(e.dof)).cross(force);
    }
  }
  return result;
}

double ShellModel::energy(const Points& q) const {
  const VecX x = stacked(q);
  return 0.5 * x.dot(solver_.K().selfadjointView<Eigen::Lower>() * x);
}

}  // namespace batten
