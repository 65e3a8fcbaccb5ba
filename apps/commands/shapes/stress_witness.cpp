#include "batten/apps/commands/shapes/stress_witness.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__linux__)
#include <sys/prctl.h>
#endif

#include <cmath>
#include <cstdlib>

#include "batten/apps/commands/shapes/stress_files.h"
#include "batten/io/decks/frd_results.h"

namespace batten {
namespace {

// Of a stress in space.
double equivalent(const Mat3& s) {
  const Mat3 deviator = s - s.trace() / 3 * Mat3::Identity();
  return std::sqrt(1.5 * deviator.squaredNorm());
}

void run_ccx(const std::filesystem::path& deck) {
  const char* named = std::getenv("CCX");
  const std::string program = named ? named : "ccx", folder = deck.parent_path().string(),
                    stem = deck.stem().string();
  const pid_t child = fork();
  if (child == 0) {
#if defined(__linux__)
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // it ends with a run that is stopped
#endif
    const int nothing = open("/dev/null", O_WRONLY);
    dup2(nothing, STDOUT_FILENO);
    dup2(nothing, STDERR_FILENO);
    if (chdir(folder.c_str()) == 0)
      execlp(program.c_str(), program.c_str(), "-i", stem.c_str(), nullptr);
    _exit(127);
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) < 0)
    throw InputError("cannot start '" + program + "'");
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
    throw InputError("found no program '" + program +
                     "', expected CalculiX (calculix-ccx); CCX names another one");
  // What ccx leaves beside its results.
  for (const char* ending : {".dat", ".sta", ".cvg", ".12d"})
    std::filesystem::remove(std::filesystem::path(deck).replace_extension(ending));
  std::filesystem::remove(deck.parent_path() / "spooles.out");
}

}  // namespace

void ask_calculix(ShapeRun& run, const Scene& scene, const MadeShape& shape,
                  const Progress& progress) {
  for (StressReport::Case& c : run.report.stress->cases) {
    if (c.combination) continue;
    progress.at("CalculiX, case " + c.name, 0);
    const std::string stem = stress_stem(scene, c.name) + "_ccx";
    const auto deck = run.out.file(stem + ".inp");
    write_calculix(deck, shape.all(), deck_of(scene, *shape.layout, c.name, stem + ".inp"));
    run_ccx(deck);
    StressReport::Witness witness;
    for (const FrdResults::Node& node : read_frd(run.out.file(stem + ".frd")).nodes) {
      witness.displacement = std::max(witness.displacement, node.displacement.norm());
      witness.stress = std::max(witness.stress, equivalent(node.stress));
    }
    c.calculix = witness;
    run.report.files.push_back(stem + ".inp");
    run.report.files.push_back(stem + ".frd");
  }
  run.watch.lap("CalculiX");
}

}  // namespace batten
