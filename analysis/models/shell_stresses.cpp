// SPDX-License-Identifier: MPL-2.0
#include "batten/analysis/models/shell_stresses.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "batten/analysis/models/triangle_maximum.h"
#include "batten/core/cancellation.h"
#include "batten/core/parallel.h"

namespace batten {
namespace {

// (xx, yy, zz, yz, xz, xy) of a symmetric tensor.
Eigen::Matrix<double, 6, 1> packed(const Mat3& a) {
  Eigen::Matrix<double, 6, 1> p;
  p << a(0, 0), a(1, 1), a(2, 2), a(1, 2), a(0, 2), a(0, 1);
  return p;
}

template <class Six>
Mat3 unpacked(const Six& p) {
  Mat3 a;
  a << p[0], p[5], p[4], p[5], p[1], p[3], p[4], p[3], p[2];
  return a;
}

// Tensor in space from (11, 22, 12) in the local axes of a point.
Mat3 in_space(const Vec3& s, const ShellPoint& at) {
  const Vec3 &a = at.e1(), &b = at.e2();
  return s[0] * a * a.transpose() + s[1] * b * b.transpose() +
         s[2] * (a * b.transpose() + b * a.transpose());
}

Vec3 in_axes(const Mat3& s, const ShellPoint& at) {
  return {at.e1().dot(s * at.e1()), at.e2().dot(s * at.e2()), at.e1().dot(s * at.e2())};
}

const ShellTemperature kNoTemperature;

}  // namespace

ShellStresses::ShellStresses(const ShellModel& shell, const Points& q)
    : ShellStresses(shell.assembler(), q) {}
ShellStresses::ShellStresses(const ShellModel& shell, const Points& q,
                             const ShellTemperature& temperature)
    : ShellStresses(shell.assembler(), q, temperature) {}
ShellStresses::ShellStresses(const ShellAssembler& shell, const Points& q)
    : ShellStresses(shell, q, kNoTemperature) {}

ShellStresses::ShellStresses(const ShellAssembler& shell, const Points& q,
                             const ShellTemperature& temperature)
    : shell_(shell), q_(q), temperature_(temperature) {
  update_progress("stresses", 0);
  take_samples();
  update_progress("stresses", 0.5);
  fit();
  update_progress("stresses", 0.9);
  peak_ = find_peak({});
  update_progress("stresses", 1);
}

ShellStress ShellStresses::raw(const Location& where) const {
  const auto of = shell_.resultants(q_, where, temperature_);
  const ShellPoint at = shell_.point(where);
  const ShellSection& section = shell_.section(where.triangle);
  return {
      in_space(of.forces, at), in_space(of.moments, at), section, section.thickness_at(where.L), at,
      temperature_at(where)};
}

// Samples are at the centroids of sub-triangles; in a cut triangle, at points of its inside.
void ShellStresses::take_samples() {
  const ShellAssembler& shell = shell_;
  TriangleRule centroids{Eigen::Matrix<double, 3, 3>::Constant(4.0 / 9),
                         VecX::Constant(3, 1.0 / 3)};
  for (int i = 0; i < 3; ++i) centroids.L(i, i) = 1.0 / 9;
  const TabulatedRule whole(shell.surface().kind(), centroids);
  constexpr int degree = 2;
  samples_.resize(shell.surface().mesh().triangle_count());
  parallel_for_each<64>(isize(samples_), [&](int t) {
    std::optional<ShellTriangle::Dofs> q;
    shell.for_each_quadrature_point(
        t, whole, degree,
        [&](const ShellTriangle& triangle, const ReferenceTabulation& functions,
            const ShellPoint& at, const Vec3& L, double area) {
          if (!q) q = triangle.reference(shell.dofs_on(q_, t));
          const auto own = resultants(at, t, L, triangle.jet(*q, functions));
          Sample sample{{t, L}, area, Parts::Zero()};
          sample.parts << packed(in_space(own.forces, at)), packed(in_space(own.moments, at));
          samples_[t].push_back(sample);
        });
  });
}

// 1, x, y, x²/2, xy, y²/2 at a position relative to a vertex, in units of the patch size.
ShellStresses::Monomials ShellStresses::monomials(const Vec2& d, double size) {
  const double x = d.x() / size, y = d.y() / size;
  Monomials row;
  row << 1, x, y, 0.5 * x * x, x * y, 0.5 * y * y;
  return row;
}

// Patches: the triangles around each vertex that have samples, extended by their neighbours if
// there are too few.
std::vector<std::vector<int>> ShellStresses::patches() const {
  const ParametricMesh& mesh = shell_.surface().mesh();
  std::vector<std::vector<int>> around(mesh.vertices().size());
  throw_if_cancelled();
  for (int t = 0; t < mesh.triangle_count(); ++t)
    if (!samples_[t].empty())
      for (const int v : mesh.triangles()[t]) around[v].push_back(t);
  std::vector<std::vector<int>> result = around;
  constexpr size_t enough = 5;
  for (size_t v = 0; v < around.size(); ++v) {
    poll_every<4096>(static_cast<long>(v));
    if (around[v].size() >= enough) continue;
    std::set<int> more(around[v].begin(), around[v].end());
    for (const int t : around[v])
      for (const int w : mesh.triangles()[t]) more.insert(around[w].begin(), around[w].end());
    result[v].assign(more.begin(), more.end());
  }
  return result;
}

void ShellStresses::fit() {
  const ParametricMesh& mesh = shell_.surface().mesh();
  const auto patches = this->patches();
  at_vertices_.resize(patches.size());
  parallel_for_each<64>(isize(patches), [&](int v) {
    if (patches[v].empty()) return;
    Polynomial& polynomial = at_vertices_[v].emplace();
    const Vec2& here = mesh.vertices()[v];
    std::vector<std::pair<Vec2, const Sample*>> used;
    for (const int t : patches[v])
      for (const Sample& s : samples_[t])
        used.emplace_back(mesh.image_near(mesh.shape(t).point(s.where.L), here) - here, &s);
    for (const auto& [d, sample] : used) polynomial.size = std::max(polynomial.size, d.norm());
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, kParts> b = Eigen::Matrix<double, 6, kParts>::Zero();
    for (const auto& [d, sample] : used) {
      const Monomials row = monomials(d, polynomial.size);
      A += sample->weight * row * row.transpose();
      b += sample->weight * row * sample->parts.transpose();
    }
    // Regularisation: coefficients that the samples do not determine (slivers, corners with a
    // single triangle) become small.
    constexpr double lean = 1e-6;
    A.diagonal().tail<5>().array() += lean * A(0, 0);
    polynomial.coefficients = solve_symmetric(A, b);
  });
}

ShellStress ShellStresses::stress_of(const Parts& parts, const Location& where,
                                     const ShellPoint& point) const {
  const ShellSection& section = shell_.section(where.triangle);
  const Mat3 flat = Mat3::Identity() - point.normal() * point.normal().transpose();
  return {flat * unpacked(parts.head<6>()) * flat,
          flat * unpacked(parts.tail<6>()) * flat,
          section,
          section.thickness_at(where.L),
          point,
          temperature_at(where)};
}

ShellStress ShellStresses::at(const Location& where) const {
  return at(where, shell_.point(where));
}

ShellStress ShellStresses::at(const Location& where, const ShellPoint& point) const {
  const ParametricMesh& mesh = shell_.surface().mesh();
  const TriangleShape shape = mesh.shape(where.triangle);
  Parts parts = Parts::Zero();
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const auto& polynomial = at_vertices_[mesh.triangles()[where.triangle][i]];
    if (!polynomial) continue;
    const Vec2 d = shape.point(where.L) - shape.point(Vec3::Unit(i));
    parts += where.L[i] * polynomial->coefficients.transpose() * monomials(d, polynomial->size);
    sum += where.L[i];
  }
  if (sum > 0) parts /= sum;
  return stress_of(parts, where, point);
}

namespace {

// (N11, N22, N12, M11, M22, M12) in the local axes of a point.
using Six = Eigen::Matrix<double, 6, 1>;

Six in_axes(const ShellStress& s, const ShellPoint& at) {
  Six six;
  six << in_axes(s.forces, at), in_axes(s.moments, at);
  return six;
}

Six six_of(const ShellAssembler::Resultants& r) {
  Six six;
  six << r.forces, r.moments;
  return six;
}

// (N/t, M/t²) with the moments about the middle of the shell.
Six about_middle(Six six, double offset, double t) {
  six.tail<3>() -= offset * t * six.head<3>();
  six.head<3>() /= t;
  six.tail<3>() /= t * t;
  return six;
}

}  // namespace

// Samples are at points where elements are most accurate. The quadrature of the stiffness also
// captures other errors, such as the spurious membrane forces of locking elements. `adjoint` may be
// this object.
ShellStresses::Energies ShellStresses::energies(const ShellStresses& adjoint) const {
  const ShellAssembler& shell = shell_;
  const int count = shell.surface().mesh().triangle_count();
  Eigen::Matrix<double, Eigen::Dynamic, 3> of_triangles(count, 3);
  parallel_for_each<64>(count, [&](int t) {
    of_triangles.row(t).setZero();
    const ShellSection& section = shell.section(t);
    const Eigen::Matrix<double, 6, 6> compliance = section.compliance();
    std::optional<ShellTriangle::Dofs> here, there;
    shell.for_each_quadrature_point(
        t, [&](const ShellTriangle& triangle, const ReferenceTabulation& functions,
               const ShellPoint& point, const Vec3& L, double area) {
          if (!here) here = triangle.reference(shell.dofs_on(q_, t));
          const auto own_of = [&](const ShellStresses& of, const ShellTriangle::Dofs& q) {
            return six_of(of.resultants(point, t, L, triangle.jet(q, functions)));
          };
          const double thickness = section.thickness_at(L);
          const auto work = [&](const Six& a, const Six& b) {
            return thickness * about_middle(a, section.offset, thickness)
                                   .dot(compliance * about_middle(b, section.offset, thickness));
          };
          const Six own = own_of(*this, *here), jump = in_axes(at({t, L}, point), point) - own;
          Six other = jump;
          if (&adjoint != this) {
            if (!there) there = triangle.reference(shell.dofs_on(adjoint.q_, t));
            other = in_axes(adjoint.at({t, L}, point), point) - own_of(adjoint, *there);
          }
          of_triangles(t, 0) += area * work(jump, other);
          of_triangles(t, 1) += area * work(own, own);
          if (temperature_.empty()) return;
          const Six prevented = six_of(shell.resultants(t, L, {}, temperature_at({t, L})));
          of_triangles(t, 2) += area * work(prevented, prevented);
        });
  });
  return {of_triangles.col(0), of_triangles.col(1), of_triangles.col(2)};
}

VecX ShellStresses::goal_error_per_triangle(const ShellStresses& adjoint) const {
  return energies(adjoint).goal_error;
}

double ShellStresses::goal_error(const ShellStresses& adjoint) const {
  return goal_error_per_triangle(adjoint).sum();
}

double ShellStresses::energy_norm_error() const {
  const Energies e = energies(*this);
  const double all = e.all.sum();
  constexpr double rounding = 1e-16;  // of shells that expand freely
  return all > rounding * e.thermal.sum() ? std::sqrt(e.goal_error.sum() / all) : 0;
}

double ShellStresses::energy() const { return 0.5 * energies(*this).all.sum(); }

template <class Visit>
void ShellStresses::for_each_sample_location(const Visit& visit) const {
  const Trim* trim = shell_.surface().trim().get();
  for (int t = 0; t < isize(samples_); ++t) {
    poll_every<1024>(t);
    if (samples_[t].empty()) continue;
    if (!trim || trim->side(t) != Trim::Side::Cut) {
      for (int i = 0; i < 3; ++i) visit(Location{t, Vec3::Unit(i)});
      continue;
    }
    for (const Sample& s : samples_[t]) visit(s.where);
    for (const Vec3& L : trim->boundary_points(t)) visit(Location{t, L});
  }
}

ShellStresses::Peak ShellStresses::largest_outside(const std::vector<SingularPlace>& places) const {
  const Peak peak = find_peak(places);
  return peak.value > 0 ? peak : peak_;
}

ShellStresses::Peak ShellStresses::find_peak(const std::vector<SingularPlace>& places) const {
  const Surface& surface = shell_.surface();
  const Trim* trim = surface.trim().get();
  const auto largest_at = [&](const Location& where) {
    const bool singular = std::any_of(places.begin(), places.end(), [&](const SingularPlace& p) {
      return p.contains(surface.position(where));
    });
    return singular ? 0.0 : at(where).largest_von_mises().value;
  };
  LargestSamples largest;
  for_each_sample_location([&](const Location& where) { largest.take(where, largest_at(where)); });
  if (largest.empty()) return {};
  constexpr double accuracy = 1e-2;
  const Location where = largest.climb(
      accuracy, largest_at, [&](int t) { return !trim || trim->side(t) != Trim::Side::Cut; });
  const ShellStress::Largest found = at(where).largest_von_mises();
  Peak peak{found.value, found.height, found.ply, 0, where, surface.position(where)};
  for (const Sample& s : samples_[where.triangle]) {
    const ShellStress own = stress_of(s.parts, s.where, shell_.point(s.where));
    peak.spread = std::max(peak.spread, std::abs(von_mises(own.at(peak.height)) -
                                                 von_mises(at(s.where).at(peak.height))));
  }
  return peak;
}

std::optional<ShellStresses::Reserve> ShellStresses::smallest_reserve_factor(
    FailureCriterion criterion) const {
  std::optional<Reserve> smallest;
  for_each_sample_location([&](const Location& where) {
    if (!shell_.section(where.triangle).has_strength()) return;
    const ShellStress::Largest here = at(where).smallest_reserve_factor(criterion);
    if (std::isfinite(here.value) && !(smallest && here.value >= smallest->factor))
      smallest = {here.value, here.height, here.ply, where, Vec3::Zero()};
  });
  if (smallest) smallest->at = shell_.surface().position(smallest->where);
  return smallest;
}

}  // namespace batten
