#include "batten/apps/commands/runs/distributed.h"

#include <cstdlib>
#include <filesystem>

#include "batten/apps/commands/runs/module_file.h"
#include "batten/core/errors.h"
#include "batten/distributed/module.h"

namespace batten {

struct Distributed::Module {
  BattenDistributed calls{};
  int next_id = 0;
};

namespace {

// Processes of this run, as Open MPI and MPICH tell them.
int process_count() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* value = std::getenv(name)) return std::atoi(value);
  return 1;
}

class SharedFactor : public OtherFactor {
 public:
  SharedFactor(const BattenDistributed& calls, int id) : calls_(calls), id_(id) {}
  ~SharedFactor() override {
    if (rows_ > 0) calls_.forget(id_);
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
    MatX columns = b;  // without gaps
    if (const char* failed = calls_.solve(id_, columns.data(), static_cast<int>(columns.cols())))
      throw NoSolutionError(failed);
    b = columns;
  }

 private:
  const BattenDistributed& calls_;
  int id_, rows_ = 0;
};

}  // namespace

std::unique_ptr<Distributed> Distributed::of_this_run() {
  if (process_count() < 2) return nullptr;
  const std::filesystem::path file = module_file("batten_petsc.so");
  if (file.empty())
    throw InputError("found " + std::to_string(process_count()) +
                     " processes, expected one: this batten was built without PETSc "
                     "(libpetsc-real-dev)");
  // Open MPI's own parts look for its symbols among all.
  const auto start = reinterpret_cast<decltype(&batten_distributed)>(
      module_entry(file, "batten_distributed", true));
  auto module = std::make_unique<Module>();
  if (const char* failed = start(&module->calls)) throw InputError(failed);
  return std::unique_ptr<Distributed>(new Distributed(std::move(module)));
}

Distributed::Distributed(std::unique_ptr<Module> module) : module_(std::move(module)) {}

Distributed::~Distributed() {
  if (!helps()) module_->calls.end();
}

int Distributed::size() const { return module_->calls.size; }
bool Distributed::helps() const { return module_->calls.rank > 0; }
void Distributed::serve() { module_->calls.serve(); }

FactorMaker Distributed::factors() {
  return [module = module_.get()] {
    return std::make_unique<SharedFactor>(module->calls, module->next_id++);
  };
}

}  // namespace batten
