// SPDX-License-Identifier: MPL-2.0
// batten: the command-line program.
#include <csignal>
#include <iostream>

#include "batten/apps/cli/commands.h"
#include "batten/core/memory.h"
#include "batten/core/parallel.h"
#include "batten/io/files/input_file.h"

namespace {

using namespace batten;

const char* const kVersion = "batten " BATTEN_VERSION
#ifdef BATTEN_HAVE_CHOLMOD
                             "\nfactorization: CHOLMOD"
#else
                             "\nfactorization: Eigen (built without CHOLMOD)"
#endif
#ifdef BATTEN_HAVE_CGAL
                             "\nmeshes: CGAL Mesh_2 and fan"
#else
                             "\nmeshes: fan only (built without CGAL)"
#endif
#ifdef BATTEN_HAVE_CERES
                             "\nminimum-energy curves: Ceres";
#else
                             "\nminimum-energy curves: none (built without Ceres)";
#endif

const char* const kExamples = R"(
Examples:
  batten skin outline.csv --out result          smooth surface through curves: STEP, VTK, report
  batten skin sketch.json --unit m --out result all surfaces of a curve network
  batten run hood.toml --out result             all outputs of a scene
  batten run hood.toml --out result --set crown=4
  batten stress hood.toml --out result          the same, and a stress analysis on the same mesh
  batten sculpt bowl.toml --out result --sweep swell=0:250:9
  batten fair sketch.csv --out fair.step        fair drawn curves
  batten deform edit.toml --out result          morph a mesh; holes and beads keep their shape
  batten sequence edit.toml --out result        edit a mesh sequence: paths, foot plants, keyframes
  batten convert part.step part.iges --unit in  CAD to CAD, with names and colours
  batten convert part.step part.stl --chord 0.1 CAD to a watertight triangle mesh
  batten info hood.toml                         curves and parameters of a scene
  batten info panel.bdf                         holes, creases and quality of a mesh
  batten view hood.toml --screenshot hood.png   picture (needs a display, or xvfb-run)

Exit codes:
  0 done   1 invalid input   2 contradictory constraints   3 no solution
  4 done, but a check failed (which one and by how much: see the report)   130 cancelled
)";

/// Parses the command line and runs the subcommand. Returns the exit code.
int command(int argc, char** argv) {
  CommonOptions common;
  CommandLine program("batten", "Batten: continuous surfaces that shape themselves", kVersion,
                      kExamples);
  const std::vector<Command> commands = {
      add_run(program, common),    add_stress(program, common),   add_sculpt(program, common),
      add_deform(program, common), add_sequence(program, common), add_fair(program, common),
      add_skin(program, common),   add_convert(program, common),  add_fit(program, common),
      add_info(program),           add_view(program, common),     add_run_script(program, common)};
  const CommandLine::ParseResult parse = program.parse(argc, argv);
  if (parse != CommandLine::ParseResult::Command)
    return parse == CommandLine::ParseResult::HelpShown ? kDone : kBadInput;
  catch_interrupts(kCancelled);
  std::signal(SIGXFSZ, SIG_IGN);  // writers then report files that exceed the size limit
  enable_sandboxed_read(true);
  set_thread_count(common.threads);
  set_memory_limit(1e9 * common.memory);
  for (const Command& one : commands)
    if (one.subcommand.given()) return one.run();
  return kBadInput;  // not reached: a subcommand is required
}

}  // namespace

int main(int argc, char** argv) {
  int code = kBadInput;
  std::string message;
  try {
    code = command(argc, argv);
  } catch (const ConflictError& e) {
    code = kConflict;
    message = e.what();
  } catch (const NoSolutionError& e) {
    code = kNoSolution;
    message = e.what();
  } catch (const CancelledError& e) {
    code = kCancelled;
    message = e.what();
  } catch (const InputError& e) {
    message = e.what();
  } catch (const std::bad_alloc&) {
    code = kNoSolution;
    message = "not enough memory";
  } catch (const std::exception& e) {
    code = kNoSolution;
    message = std::string("unexpected error: ") + e.what();
  }
  // The error may only be due to a file removed after the interrupt.
  if (interrupted() && !message.empty()) {
    code = kCancelled;
    message = CancelledError().what();
  }
  end_progress();
  if (!message.empty()) std::cerr << "batten: " << message << "\n";
  return code;
}
