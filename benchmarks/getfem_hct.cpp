// SPDX-License-Identifier: MPL-2.0
#include "batten/benchmarks/getfem_hct.h"

#include "bench.h"

#if BATTEN_BENCH_GETFEM

#include <dmumps_c.h>
#include <getfem/getfem_assembling.h>
#include <getfem/getfem_fourth_order.h>
#include <getfem/getfem_generic_assembly.h>
#include <getfem/getfem_mesh.h>
#include <getfem/getfem_models.h>
#include <gmm/gmm_MUMPS_interface.h>

namespace batten::bench {
namespace {

using Matrix = getfem::model_real_sparse_matrix;
using Vector = std::vector<double>;

void copy_mesh(const ParametricMesh& from, getfem::mesh& to) {
  std::vector<size_t> point;
  for (const Vec2& p : from.vertices())
    point.push_back(to.add_point(bgeot::base_node(p.x(), p.y()), 0, false));
  for (const auto& t : from.triangles()) to.add_triangle(point[t[0]], point[t[1]], point[t[2]]);
}

getfem::pintegration_method composite(int degree) {
  return getfem::int_method_descriptor("IM_HCT_COMPOSITE(IM_TRIANGLE(" + std::to_string(degree) +
                                       "))");
}

const char* const clamped_load =
    "4*pow(pi,4)*(4*cos(2*pi*X(1))*cos(2*pi*X(2))-cos(2*pi*X(1))-cos(2*pi*X(2)))";
const char* const squared_error =
    "Norm_sqr(Hess_u-[[2*pi*pi*cos(2*pi*X(1))*sqr(sin(pi*X(2))),"
    "pi*pi*sin(2*pi*X(1))*sin(2*pi*X(2))],[pi*pi*sin(2*pi*X(1))*sin(2*pi*X(2)),"
    "2*pi*pi*cos(2*pi*X(2))*sqr(sin(pi*X(1)))]])";

// One assembly in the weak-form language; order 2: matrix, 1: vector, 0: the integral itself.
double evaluate(const std::string& expression, const getfem::mesh_im& mim,
                const getfem::mesh_fem& mf, int order, const Vector& u, Matrix* K, Vector* F) {
  getfem::ga_workspace workspace;
  workspace.add_fem_variable("u", mf, gmm::sub_interval(0, mf.nb_dof()), u);
  workspace.add_expression(expression, mim);
  if (K) workspace.set_assembled_matrix(*K);
  if (F) workspace.set_assembled_vector(*F);
  workspace.assembly(static_cast<bgeot::size_type>(order));
  return order == 0 ? workspace.assembled_potential() : 0;
}

void positive_solve(const Matrix& K, const dal::bit_vector& fixed, const Vector& F, Vector& u) {
  std::vector<int> number(F.size(), 0), row, column;
  int count = 0;
  for (size_t i = 0; i < F.size(); ++i)
    if (!fixed.is_in(i)) number[i] = ++count;
  Vector entry, rhs(static_cast<size_t>(count));
  for (size_t j = 0; j < F.size(); ++j) {
    if (!number[j]) continue;
    rhs[static_cast<size_t>(number[j] - 1)] = F[j];
    for (const auto& e : K[j])
      if (e.c >= j && number[e.c]) {
        row.push_back(number[e.c]);
        column.push_back(number[j]);
        entry.push_back(e.e);
      }
  }
  DMUMPS_STRUC_C mumps{};
  mumps.job = -1;
  mumps.par = 1;
  mumps.sym = 1;
  mumps.comm_fortran = -987654;
  dmumps_c(&mumps);
  mumps.n = count;
  mumps.nnz = static_cast<MUMPS_INT8>(row.size());
  mumps.irn = row.data();
  mumps.jcn = column.data();
  mumps.a = entry.data();
  mumps.rhs = rhs.data();
  for (const int silent : {0, 1, 2}) mumps.icntl[silent] = -1;
  mumps.icntl[3] = 0;
  mumps.icntl[6] = 0;  // AMD
  mumps.job = 6;
  dmumps_c(&mumps);
  if (mumps.infog[0] != 0) throw std::runtime_error("MUMPS failed");
  for (size_t j = 0; j < F.size(); ++j)
    if (number[j]) u[j] = rhs[static_cast<size_t>(number[j] - 1)];
  mumps.job = -2;
  dmumps_c(&mumps);
}

// Rows and columns of fixed dofs become those of the identity. (gmm's sub_matrix takes ten times as
// long at 25,000 dofs.)
void gmm_solve(Matrix& K, const dal::bit_vector& fixed, Vector& F, Vector& u) {
  for (size_t j = 0; j < F.size(); ++j)
    if (fixed.is_in(j)) {
      gmm::clear(K[j]);
      K[j].w(j, 1);
      F[j] = 0;
    } else {
      for (auto& e : K[j])
        if (fixed.is_in(e.c)) e.e = 0;
    }
  gmm::MUMPS_solve(K, u, F, true);
}

}  // namespace

std::string getfem_version() { return GETFEM_VERSION; }

struct GetfemHct::Data {
  getfem::mesh mesh;
  std::unique_ptr<getfem::mesh_fem> mf, quadratic, cubic;
  std::unique_ptr<getfem::mesh_im> degree2, degree4, degree6;
  Vector b;  // the varying coefficient on the quadratic triangle, which represents it exactly
  Matrix K;
};

GetfemHct::GetfemHct(const ParametricMesh& mesh) : data_(std::make_unique<Data>()) {
  Data& d = *data_;
  gmm::set_warning_level(0);
  copy_mesh(mesh, d.mesh);
  const auto space = [&](const char* name) {
    auto mf = std::make_unique<getfem::mesh_fem>(d.mesh);
    mf->set_finite_element(getfem::fem_descriptor(name));
    return mf;
  };
  const auto rule = [&](int degree) {
    auto mim = std::make_unique<getfem::mesh_im>(d.mesh);
    mim->set_integration_method(composite(degree));
    return mim;
  };
  d.mf = space("FEM_HCT_TRIANGLE");
  d.quadratic = space("FEM_PK(2,2)");
  d.cubic = space("FEM_PK(2,3)");
  d.degree2 = rule(2);
  d.degree4 = rule(4);
  d.degree6 = rule(6);
  for (size_t i = 0; i < d.quadratic->nb_dof(); ++i) {
    const auto p = d.quadratic->point_of_basic_dof(i);
    d.b.push_back(1 + p[0] * p[0] / 2 + p[1]);
  }
  d.K = Matrix(d.mf->nb_dof(), d.mf->nb_dof());
}
GetfemHct::~GetfemHct() = default;

void GetfemHct::stiffness(GetfemAssemblyMode assembly_mode, bool varying) {
  Data& d = *data_;
  const getfem::mesh_im& mim = varying ? *d.degree4 : *d.degree2;
  gmm::scale(d.K, 0.0);
  if (assembly_mode == GetfemAssemblyMode::Language) {
    evaluate(
        varying ? "(1+sqr(X(1))/2+X(2))*(Hess_Test_u:Hess_Test2_u)" : "Hess_Test_u:Hess_Test2_u",
        mim, *d.mf, 2, Vector(d.mf->nb_dof()), &d.K, nullptr);
    return;
  }
  getfem::generic_assembly assembly(
      varying ? "b=data$1(#2);M(#1,#1)+=sym(comp(Hess(#1).Hess(#1).Base(#2))(:,i,j,:,i,j,k).b(k))"
              : "M(#1,#1)+=sym(comp(Hess(#1).Hess(#1))(:,i,j,:,i,j))");
  assembly.push_mi(mim);
  assembly.push_mf(*d.mf);
  if (varying) {
    assembly.push_mf(*d.quadratic);
    assembly.push_data(d.b);
  }
  assembly.push_mat(d.K);
  assembly.assembly();
}

double GetfemHct::energy(const std::function<double(const Vec2&)>& cubic) const {
  const Data& d = *data_;
  const size_t n = d.mf->nb_dof();
  Vector value, F(n), q(n), Kq(n);
  for (size_t i = 0; i < d.cubic->nb_dof(); ++i) {
    const auto p = d.cubic->point_of_basic_dof(i);
    value.push_back(cubic({p[0], p[1]}));
  }
  Matrix M(n, n);
  getfem::asm_mass_matrix(M, *d.degree6, *d.mf);
  getfem::asm_source_term(F, *d.degree6, *d.mf, *d.cubic, value);
  gmm::MUMPS_solve(M, q, F, true);
  gmm::mult(d.K, q, Kq);
  return gmm::vect_sp(q, Kq);
}

PlateRun getfem_plate(const ParametricMesh& mesh, GetfemAssemblyMode assembly_mode,
                      GetfemSolver solver) {
  gmm::set_warning_level(0);
  PlateRun run;
  const double start = seconds();
  getfem::mesh m;
  copy_mesh(mesh, m);
  getfem::mesh_fem mf(m);
  mf.set_finite_element(getfem::fem_descriptor("FEM_HCT_TRIANGLE"));
  const size_t n = mf.nb_dof();
  getfem::mesh_region boundary;
  getfem::outer_faces_of_mesh(m, boundary);
  const dal::bit_vector fixed = mf.basic_dof_on_region(boundary);
  const double meshed = seconds();

  getfem::mesh_im degree2(m), degree4(m);
  degree2.set_integration_method(composite(2));
  degree4.set_integration_method(composite(4));
  Matrix K(n, n);
  Vector F(n), u(n);
  if (assembly_mode == GetfemAssemblyMode::Language) {
    evaluate("Hess_Test_u:Hess_Test2_u", degree2, mf, 2, u, &K, nullptr);
  } else {
    getfem::asm_stiffness_matrix_for_homogeneous_bilaplacian_KL(K, degree2, mf, Vector(1, 1.0),
                                                                Vector(1, 0.0));
  }
  const double assembled = seconds();
  evaluate(std::string(clamped_load) + "*Test_u", degree4, mf, 1, u, nullptr, &F);
  const double loaded = seconds();
  if (solver == GetfemSolver::Gmm)
    gmm_solve(K, fixed, F, u);
  else
    positive_solve(K, fixed, F, u);
  run.solve = seconds() - loaded;
  run.mesh = meshed - start;
  run.stiffness = assembled - meshed;
  run.load = loaded - assembled;

  run.unknowns = static_cast<int>(n - fixed.card());
  getfem::mesh_im fine(m);
  fine.set_integration_method(composite(10));
  run.h2_error = std::sqrt(evaluate(squared_error, fine, mf, 0, u, nullptr, nullptr));
  return run;
}

}  // namespace batten::bench

#else

#include <stdexcept>

namespace batten::bench {

std::string getfem_version() { return ""; }

struct GetfemHct::Data {};
GetfemHct::GetfemHct(const ParametricMesh&) { throw std::logic_error("built without GetFEM"); }
GetfemHct::~GetfemHct() = default;
void GetfemHct::stiffness(GetfemAssemblyMode, bool) {}
double GetfemHct::energy(const std::function<double(const Vec2&)>&) const { return 0; }
PlateRun getfem_plate(const ParametricMesh&, GetfemAssemblyMode, GetfemSolver) {
  throw std::logic_error("built without GetFEM");
}

}  // namespace batten::bench

#endif
