// SPDX-License-Identifier: MPL-2.0
#include "batten/benchmarks/cgal_deform.h"

#include <stdexcept>

#if BATTEN_BENCH_CGAL_DEFORM

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_deformation.h>
#include <CGAL/version.h>

#include <Eigen/SparseCholesky>
#if BATTEN_BENCH_CHOLMOD
#include <Eigen/CholmodSupport>
#endif

namespace batten::bench {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Vertex = Mesh::Vertex_index;
using GeneralMatrix = CGAL::Eigen_sparse_matrix<double>;

/// Solver class for CGAL that factors the symmetric part of its matrix: rows and columns of the
/// free vertices.
template <class Factor>
class FreeVerticesSolver {
 public:
  using NT = double;
  using Index = Eigen::Index;
  using Matrix = GeneralMatrix;
  using Vector = CGAL::Eigen_vector<double>;

  bool factor(const Matrix& A, NT& D) {
    D = 1;
    const auto& all = A.eigen_object();  // column-major
    const auto n = static_cast<int>(all.rows());
    std::vector<int> row_size(n, 0);
    const auto each = [&](const auto& use) {
      for (int c = 0; c < n; ++c)
        for (GeneralMatrix::EigenType::InnerIterator e(all, c); e; ++e)
          use(static_cast<int>(e.row()), c, e.value());
    };
    each([&](int r, int, double) { ++row_size[r]; });
    number_.assign(n, -1);
    count_ = 0;
    for (int r = 0; r < n; ++r)
      if (row_size[r] > 1) number_[r] = count_++;
    std::vector<Triplet> free, held;
    each([&](int r, int c, double value) {
      if (number_[r] < 0) return;
      if (number_[c] < 0)
        held.emplace_back(number_[r], c, value);
      else if (number_[r] >= number_[c])
        free.emplace_back(number_[r], number_[c], value);
    });
    SparseMatrix K(count_, count_);
    K.setFromTriplets(free.begin(), free.end());
    held_.resize(count_, n);
    held_.setFromTriplets(held.begin(), held.end());
    factor_.compute(K);
    return factor_.info() == Eigen::Success;
  }

  bool linear_solver(const Vector& B, Vector& X) {
    const VecX& b = B.eigen_object();  // for fixed vertices: the position
    VecX rest = -(held_ * b);
    for (size_t i = 0; i < number_.size(); ++i)
      if (number_[i] >= 0) rest[number_[i]] += b[static_cast<Index>(i)];
    const VecX x = factor_.solve(rest);
    for (size_t i = 0; i < number_.size(); ++i)
      X[static_cast<Index>(i)] = number_[i] < 0 ? b[static_cast<Index>(i)] : x[number_[i]];
    return factor_.info() == Eigen::Success;
  }

 private:
  Factor factor_;
  SparseMatrix held_;        // columns of fixed vertices
  std::vector<int> number_;  // index among the free vertices, or -1
  int count_ = 0;
};

/// One of CGAL's deformations, for any template arguments.
class Deformation {
 public:
  virtual ~Deformation() = default;
  virtual bool preprocess(const std::vector<int>& region, const std::vector<int>& controls) = 0;
  virtual void edit(const std::vector<int>& controls, const Points& targets, int iterations) = 0;
};

template <CGAL::Deformation_algorithm_tag Tag, class Solver>
class DeformationOf : public Deformation {
 public:
  explicit DeformationOf(Mesh& mesh) : cgal_(mesh) {}
  bool preprocess(const std::vector<int>& region, const std::vector<int>& controls) override {
    for (const int v : region) cgal_.insert_roi_vertex(Vertex(v));
    for (const int v : controls) cgal_.insert_control_vertex(Vertex(v));
    return cgal_.preprocess();
  }
  void edit(const std::vector<int>& controls, const Points& targets, int iterations) override {
    for (size_t i = 0; i < controls.size(); ++i) {
      const auto t = targets.row(static_cast<long>(i));
      cgal_.set_target_position(Vertex(controls[i]), {t.x(), t.y(), t.z()});
    }
    cgal_.deform(static_cast<unsigned>(iterations), 0);
  }

 private:
  CGAL::Surface_mesh_deformation<Mesh, CGAL::Default, CGAL::Default, Tag, CGAL::Default, Solver>
      cgal_;
};

template <CGAL::Deformation_algorithm_tag Tag>
std::unique_ptr<Deformation> deformation_by(CgalSolver solver, Mesh& mesh) {
  switch (solver) {
    case CgalSolver::SparseLu:
      return std::make_unique<DeformationOf<Tag, CGAL::Default>>(mesh);
    case CgalSolver::Simplicial:
      return std::make_unique<
          DeformationOf<Tag, FreeVerticesSolver<Eigen::SimplicialLDLT<SparseMatrix>>>>(mesh);
    case CgalSolver::Cholmod:
#if BATTEN_BENCH_CHOLMOD
      return std::make_unique<
          DeformationOf<Tag, FreeVerticesSolver<Eigen::CholmodDecomposition<SparseMatrix>>>>(mesh);
#else
      break;
#endif
  }
  throw std::logic_error("built without CHOLMOD");
}

}  // namespace

std::string cgal_version() { return CGAL_VERSION_STR; }

bool cgal_has(CgalSolver solver) {
#if BATTEN_BENCH_CHOLMOD
  constexpr bool cholmod = true;
#else
  constexpr bool cholmod = false;
#endif
  return cholmod || solver != CgalSolver::Cholmod;
}

struct CgalDeform::Data {
  CgalEnergy energy;
  CgalSolver solver;
  Mesh original, mesh;
  std::vector<int> region, controls;
  std::unique_ptr<Deformation> deformation;
};

CgalDeform::CgalDeform(CgalEnergy energy, CgalSolver solver, const Points& points,
                       const std::vector<std::array<int, 3>>& triangles,
                       const std::vector<int>& region, const std::vector<int>& controls)
    : data_(new Data{energy, solver, {}, {}, region, controls, nullptr}) {
  Mesh& mesh = data_->original;
  for (long i = 0; i < points.rows(); ++i)
    mesh.add_vertex({points(i, 0), points(i, 1), points(i, 2)});
  for (const auto& [a, b, c] : triangles)
    if (mesh.add_face(Vertex(a), Vertex(b), Vertex(c)) == Mesh::null_face())
      throw std::runtime_error("CGAL's mesh rejects a triangle");
}
CgalDeform::~CgalDeform() = default;

void CgalDeform::preprocess() {
  Data& d = *data_;
  d.deformation.reset();
  d.mesh = d.original;
  switch (d.energy) {
    case CgalEnergy::Arap:
      d.deformation = deformation_by<CGAL::ORIGINAL_ARAP>(d.solver, d.mesh);
      break;
    case CgalEnergy::SpokesAndRims:
      d.deformation = deformation_by<CGAL::SPOKES_AND_RIMS>(d.solver, d.mesh);
      break;
    case CgalEnergy::SreArap:
      d.deformation = deformation_by<CGAL::SRE_ARAP>(d.solver, d.mesh);
      break;
  }
  if (!d.deformation->preprocess(d.region, d.controls))
    throw std::runtime_error("CGAL could not factor its matrix");
}

Points CgalDeform::edit(const Points& targets, int iterations) {
  Data& d = *data_;
  d.deformation->edit(d.controls, targets, iterations);
  Points points(static_cast<long>(d.mesh.number_of_vertices()), 3);
  for (const Vertex v : d.mesh.vertices()) {
    const auto& p = d.mesh.point(v);
    points.row(static_cast<long>(v.idx())) << p.x(), p.y(), p.z();
  }
  return points;
}

}  // namespace batten::bench

#else

namespace batten::bench {

std::string cgal_version() { return ""; }
bool cgal_has(CgalSolver) { return false; }

struct CgalDeform::Data {};
CgalDeform::CgalDeform(CgalEnergy, CgalSolver, const Points&,
                       const std::vector<std::array<int, 3>>&, const std::vector<int>&,
                       const std::vector<int>&) {
  throw std::logic_error("built without CGAL");
}
CgalDeform::~CgalDeform() = default;
void CgalDeform::preprocess() {}
Points CgalDeform::edit(const Points& targets, int) { return targets; }

}  // namespace batten::bench

#endif
