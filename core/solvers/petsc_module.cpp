// SPDX-License-Identifier: MPL-2.0
// Distributed linear systems with PETSc: Cholesky factorization by MUMPS, distributed over the
// processes of mpirun.
#include <petscksp.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "batten/core/solvers/distributed_solver.h"

namespace {

enum Command : int { kFactorize, kSolve, kForget, kEnd };

struct System {
  Mat A = nullptr;
  KSP solver = nullptr;
  Vec b = nullptr, x = nullptr;
  std::vector<int> first;  // first row of each process, then n
};

int rank = 0, size = 1;
std::map<int, System> systems;
std::string failure;

// Rows first … last - 1 of the upper triangle in compressed-row format. They are the columns of the
// lower triangle.
struct Rows {
  std::vector<PetscInt> start, column;
  std::vector<PetscScalar> value;
};

// Broadcasts a message from process 0. Waiting processes sleep in between, so that process 0 can
// use their cores.
void broadcast(int* message, int count) {
  MPI_Request request;
  MPI_Ibcast(message, count, MPI_INT, 0, PETSC_COMM_WORLD, &request);
  for (int done = 0; MPI_Test(&request, &done, MPI_STATUS_IGNORE), !done;) {
    constexpr int pause = 200;  // microseconds
    if (rank > 0) usleep(pause);
  }
}

void release(System& system) {
  KSPDestroy(&system.solver);
  MatDestroy(&system.A);
  VecDestroy(&system.b);
  VecDestroy(&system.x);
}

Rows receive_rows(int count) {
  Rows rows;
  rows.start.resize(static_cast<size_t>(count) + 1);
  MPI_Recv(rows.start.data(), count + 1, MPIU_INT, 0, 0, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
  const PetscInt entries = rows.start[static_cast<size_t>(count)];
  rows.column.resize(static_cast<size_t>(entries));
  rows.value.resize(static_cast<size_t>(entries));
  MPI_Recv(rows.column.data(), entries, MPIU_INT, 0, 1, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
  MPI_Recv(rows.value.data(), entries, MPIU_SCALAR, 0, 2, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
  return rows;
}

// Called in process 0: sends each process its rows and returns those of process 0.
Rows scatter_rows(const std::vector<int>& first, const int* outer, const int* inner,
                  const double* values) {
  Rows own;
  for (int r = size - 1; r >= 0; --r) {
    const int from = outer[first[r]], to = outer[first[r + 1]];
    std::vector<PetscInt> start(outer + first[r], outer + first[r + 1] + 1);
    for (PetscInt& s : start) s -= from;
    if (r == 0) {
      own = {std::move(start), {inner, inner + to}, {values, values + to}};
      break;
    }
    MPI_Send(start.data(), static_cast<int>(start.size()), MPIU_INT, r, 0, PETSC_COMM_WORLD);
    MPI_Send(inner + from, to - from, MPIU_INT, r, 1, PETSC_COMM_WORLD);
    MPI_Send(values + from, to - from, MPIU_SCALAR, r, 2, PETSC_COMM_WORLD);
  }
  return own;
}

// Called in all processes. Returns whether the matrix is positive definite.
bool factor(System& system, int n, const Rows& rows) {
  const PetscInt own = system.first[rank + 1] - system.first[rank];
  MatCreate(PETSC_COMM_WORLD, &system.A);
  MatSetSizes(system.A, own, own, n, n);
  MatSetType(system.A, size > 1 ? MATMPISBAIJ : MATSEQSBAIJ);
  if (size > 1)
    MatMPISBAIJSetPreallocationCSR(system.A, 1, rows.start.data(), rows.column.data(),
                                   rows.value.data());
  else
    MatSeqSBAIJSetPreallocationCSR(system.A, 1, rows.start.data(), rows.column.data(),
                                   rows.value.data());
  MatSetOption(system.A, MAT_SPD, PETSC_TRUE);
  MatCreateVecs(system.A, &system.x, &system.b);
  KSPCreate(PETSC_COMM_WORLD, &system.solver);
  KSPSetOperators(system.solver, system.A, system.A);
  KSPSetType(system.solver, KSPPREONLY);
  PC pc;
  KSPGetPC(system.solver, &pc);
  PCSetType(pc, PCCHOLESKY);
  PCFactorSetMatSolverType(pc, MATSOLVERMUMPS);
  PCFactorSetUpMatSolverType(pc);
  KSPSetUp(system.solver);
  PCFailedReason reason = PC_NOERROR;
  PCGetFailedReason(pc, &reason);
  int failed = reason != PC_NOERROR, any = 0;
  MPI_Allreduce(&failed, &any, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return any == 0;
}

std::vector<int> shares(int n) {
  std::vector<int> first;
  for (int r = 0; r <= size; ++r)
    first.push_back(static_cast<int>(static_cast<long>(n) * r / size));
  return first;
}

// Called in all processes; `b` is used in process 0 only.
void solve_one(System& system, double* b) {
  std::vector<int> counts, starts(system.first.begin(), system.first.end() - 1);
  for (int r = 0; r < size; ++r) counts.push_back(system.first[r + 1] - system.first[r]);
  PetscScalar* own = nullptr;
  VecGetArray(system.b, &own);
  MPI_Scatterv(b, counts.data(), starts.data(), MPI_DOUBLE, own, counts[rank], MPI_DOUBLE, 0,
               PETSC_COMM_WORLD);
  VecRestoreArray(system.b, &own);
  KSPSolve(system.solver, system.b, system.x);
  VecGetArray(system.x, &own);
  MPI_Gatherv(own, counts[rank], MPI_DOUBLE, b, counts.data(), starts.data(), MPI_DOUBLE, 0,
              PETSC_COMM_WORLD);
  VecRestoreArray(system.x, &own);
}

const char* factorize(int id, int n, const int* outer, const int* inner, const double* values) {
  int message[3] = {kFactorize, id, n};
  broadcast(message, 3);
  System& system = systems[id];
  release(system);
  system.first = shares(n);
  if (factor(system, n, scatter_rows(system.first, outer, inner, values))) return nullptr;
  failure = "PETSc could not factorize the system: a motion is not constrained, or memory ran out";
  return failure.c_str();
}

const char* solve(int id, double* b, int k) {
  int message[3] = {kSolve, id, k};
  broadcast(message, 3);
  System& system = systems[id];
  const int n = system.first.back();
  for (int c = 0; c < k; ++c) solve_one(system, b + static_cast<long>(c) * n);
  return nullptr;
}

void forget_id(int id) {
  int message[3] = {kForget, id, 0};
  broadcast(message, 3);
  release(systems[id]);
  systems.erase(id);
}

void end() {
  int message[3] = {kEnd, 0, 0};
  broadcast(message, 3);
  for (auto& [id, system] : systems) release(system);
  PetscFinalize();
}

void serve() {
  for (int message[3]; broadcast(message, 3), message[0] != kEnd;) {
    System& system = systems[message[1]];
    if (message[0] == kFactorize) {
      release(system);
      system.first = shares(message[2]);
      factor(system, message[2], receive_rows(system.first[rank + 1] - system.first[rank]));
    } else if (message[0] == kSolve) {
      for (int c = 0; c < message[2]; ++c) solve_one(system, nullptr);
    } else {
      release(system);
      systems.erase(message[1]);
    }
  }
  for (auto& [id, system] : systems) release(system);
  PetscFinalize();
}

}  // namespace

const char* batten_distributed(BattenDistributed* module) {
  PetscOptionsSetValue(nullptr, "-no_signal_handler", "");
  if (PetscInitialize(nullptr, nullptr, nullptr, nullptr) != 0)
    return "PETSc cannot be initialized";
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  *module = {rank, size, &serve, &factorize, &solve, &forget_id, &end};
  return nullptr;
}
