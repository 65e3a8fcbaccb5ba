// SPDX-License-Identifier: MPL-2.0
#include "batten/apps/cli/program.h"

#include "batten/apps/cli/version.h"

namespace batten {
namespace {

// The list of docs/conventions.md, in short.
constexpr char kFooter[] = R"(
Exit codes:
  0    finished, and all checks passed
  1    invalid input or command line
  2    contradictory constraints
  3    no solution: singular problem, load beyond its limit, or a limit of the
       system: memory, threads, stack, open files or processor time
  4    finished and written, but a check failed: report.json lists it
  130  cancelled

Examples:
  batten skin examples/05-door/lines/outline.csv --out out/panel
      a smooth surface through curves, as a STEP file
  batten run examples/05-door/scene.toml --out out/door
      everything that a scene describes: surface, loads, pictures
  batten deform examples/11-panel/edit.toml --out out/panel
      an FE mesh with another shape, whose holes stay round
  batten COMMAND --help
      more examples, and all options of a command

The paths of the examples are relative to the source folder or the unpacked
archive of Batten; in an installed package, to a copy of /usr/share/doc/batten.
)";

}  // namespace

Program::Program(CommonOptions& common)
    : line("batten", "Smooth surfaces from curves, morphing of meshes, and shell analysis.",
           version_text(), kFooter),
      commands{add_run(line, common),
               add_skin(line, common),
               add_fit(line, common),
               add_fill(line, common),
               add_blend(line, common),
               add_sculpt(line, common),
               add_stress(line, common),
               add_deform(line, common),
               add_sequence(line, common),
               add_fair(line, common),
               add_convert(line, common),
               add_info(line),
               add_view(line, common),
               add_run_script(line, common)} {}

}  // namespace batten
