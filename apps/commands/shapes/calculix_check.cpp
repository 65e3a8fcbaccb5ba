#include "batten/apps/commands/shapes/calculix_check.h"

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
#include "batten/apps/commands/shapes/stress_setup.h"
#include "batten/io/decks/frd_results.h"

namespace batten {
namespace {

// Von Mises equivalent of a 3D stress tensor.
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
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // ends together with a cancelled run
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
                     "', expected CalculiX (calculix-ccx) or its path in the environment variable "
                     "CCX");
  // Files that ccx leaves beside its results.
  for (const char* ending : {".dat", ".sta", ".cvg", ".12d"})
    std::filesystem::remove(std::filesystem::path(deck).replace_extension(ending));
  std::filesystem::remove(deck.parent_path() / "spooles.out");
}

StressReport::CalculixResult calculix_result(const FrdResults& results,
                                             const StressReport::Case& ours) {
  StressReport::CalculixResult result;
  const FrdResults::Node *moved = nullptr, *stressed = nullptr;
  const auto nearer = [](const Vec3& to, const FrdResults::Node& a, const FrdResults::Node* b) {
    return !b || (a.x - to).squaredNorm() < (b->x - to).squaredNorm();
  };
  for (const FrdResults::Node& node : results.nodes) {
    result.displacement = std::max(result.displacement, node.displacement.norm());
    result.stress = std::max(result.stress, equivalent(node.stress));
    if (nearer(ours.max_displacement_at, node, moved)) moved = &node;
    if (nearer(ours.max_stress_face_point, node, stressed)) stressed = &node;
  }
  if (moved) result.displacement_there = moved->displacement.norm();
  if (stressed) result.stress_there = equivalent(stressed->stress);
  return result;
}

const char* element_name(ShellDeck::Element element) {
  return element == ShellDeck::Element::S3    ? "three-node triangles"
         : element == ShellDeck::Element::S8R ? "eight-node quads"
                                              : "six-node triangles";
}

}  // namespace

void check_with_calculix(RunContext& run, const Scene& scene, const SolvedShape& shape,
                         ShellDeck::Element element, const Progress& progress) {
  for (StressReport::Case& c : run.report.stress->cases) {
    if (c.combination) continue;
    progress.update("CalculiX, case " + c.name, 0);
    const std::string stem = stress_stem(scene, c.name) + "_ccx";
    const auto deck = run.out.file(stem + ".inp");
    ShellDeck shell = deck_of(scene, *shape.layout, c.name, stem + ".inp");
    shell.element = element;
    write_calculix(deck, shape.all(), shell);
    run_ccx(deck);
    c.calculix = calculix_result(read_frd(run.out.file(stem + ".frd")), c);
    c.calculix->elements = element_name(element);
    run.report.files.push_back(stem + ".inp");
    run.report.files.push_back(stem + ".frd");
  }
  run.watch.lap("CalculiX");
}

}  // namespace batten
