// The words of `batten convert`.
#include "batten/apps/cli/commands.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/exchange/run_convert.h"
#include "batten/io/files/length_units.h"

namespace batten {

Command add_convert(CommandLine& program, CommonOptions& common) {
  const auto task = std::make_shared<ConvertTask>();
  const Subcommand subcommand = program.command(
      "convert",
      "A file of another kind: CAD to CAD or to triangles, meshes to meshes, lines to lines");
  const auto unit = [&](const char* name, std::string& value, const char* what) {
    subcommand.option(name, value, what).with_alias("inch", "in").one_of(length_units());
  };
  subcommand.option("from", task->from, "STEP, IGES, BREP, a mesh, lines").required();
  subcommand
      .option("to", task->to,
              "Its ending says the kind: .step .iges .brep .glb .3mf .stl .obj .ply .off .vtp .vtu "
              ".csv .curves")
      .required();
  unit("--unit", task->unit, "Unit of the file that is written: it is scaled, and declares it");
  unit("--from-unit", task->from_unit,
       "Unit of a mesh or of points, which state none; .glb and .3mf need it");
  add_schema(subcommand, task->ap242);
  subcommand
      .option("--chord", task->chord,
              "Triangles of CAD faces: their largest distance from the faces; a thousandth of "
              "the size unless given")
      .positive();
  add_common(subcommand, common);
  return {subcommand, [task, &common] {
            const ConvertReport report = run_convert(*task, terminal_progress(common.quiet));
            return print_result(report, report.text, common);
          }};
}

}  // namespace batten
