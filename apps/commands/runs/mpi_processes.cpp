#include "batten/apps/commands/runs/mpi_processes.h"

#include <cstdlib>
#include <filesystem>

#include "batten/apps/commands/runs/plugins.h"
#include "batten/core/errors.h"
#include "batten/core/solvers/petsc_module.h"

namespace batten {

struct MpiProcesses::Plugin {
  BattenDistributed calls{};
  int next_id = 0;
};

namespace {

// Number of processes of this run, from the environment of Open MPI or MPICH.
int process_count() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* value = std::getenv(name)) return std::atoi(value);
  return 1;
}

class DistributedSolver : public LinearSolverBackend {
 public:
  DistributedSolver(const BattenDistributed& calls, int id) : calls_(calls), id_(id) {}
  ~DistributedSolver() override {
    if (rows_ > 0) calls_.release(id_);
  }
  void factorize(const SparseMatrix& A) override {
    SparseMatrix lower = A.triangularView<Eigen::Lower>();
    lower.makeCompressed();
    rows_ = static_cast<int>(lower.rows());
    if (const char* failed = calls_.factorize(id_, rows_, lower.outerIndexPtr(),
                                              lower.innerIndexPtr(), lower.valuePtr()))
      throw NoSolutionError(failed);
  }
  void solve_in_place(Eigen::Ref<MatX> b) const override {
    MatX columns = b;  // contiguous
    if (const char* failed = calls_.solve(id_, columns.data(), static_cast<int>(columns.cols())))
      throw NoSolutionError(failed);
    b = columns;
  }

 private:
  const BattenDistributed& calls_;
  int id_, rows_ = 0;
};

}  // namespace

std::unique_ptr<MpiProcesses> MpiProcesses::detect() {
  if (process_count() < 2) return nullptr;
  const std::filesystem::path file = find_plugin("batten_petsc.so");
  if (file.empty())
    throw InputError("found " + std::to_string(process_count()) +
                     " MPI processes, expected one: this program was built without PETSc "
                     "(libpetsc-real-dev)");
  // Open MPI's own plugins need its symbols to be global.
  const auto start = reinterpret_cast<decltype(&batten_distributed)>(
      load_plugin(file, "batten_distributed", true));
  auto plugin = std::make_unique<Plugin>();
  if (const char* failed = start(&plugin->calls)) throw InputError(failed);
  return std::unique_ptr<MpiProcesses>(new MpiProcesses(std::move(plugin)));
}

MpiProcesses::MpiProcesses(std::unique_ptr<Plugin> plugin) : plugin_(std::move(plugin)) {}

MpiProcesses::~MpiProcesses() {
  if (!is_worker()) plugin_->calls.end();
}

int MpiProcesses::size() const { return plugin_->calls.size; }
bool MpiProcesses::is_worker() const { return plugin_->calls.rank > 0; }
void MpiProcesses::serve() { plugin_->calls.serve(); }

BackendFactory MpiProcesses::factors() {
  return [plugin = plugin_.get()] {
    return std::make_unique<DistributedSolver>(plugin->calls, plugin->next_id++);
  };
}

}  // namespace batten
