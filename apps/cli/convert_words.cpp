// The words of `batten convert`.
#include "batten/apps/cli/command_words.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/exchange/run_convert.h"
#include "batten/io/files/length_units.h"

namespace batten {

Command add_convert(CLI::App& app, CommonWords& common) {
  const auto task = std::make_shared<ConvertTask>();
  auto* sub = app.add_subcommand(
      "convert",
      "A file of another kind: CAD to CAD or to triangles, meshes to meshes, lines to lines");
  const auto unit = [&](const char* name, std::string& value, const char* what) {
    sub->add_option(name, value, what)
        ->transform(CLI::Transformer({{"inch", "in"}}))
        ->check(CLI::IsMember(length_units()));
  };
  sub->add_option("from", task->from, "STEP, IGES, BREP, a mesh, lines")->required();
  sub->add_option("to", task->to,
                  "Its ending says the kind: .step .iges .brep .glb .stl .obj .ply .off .vtp .vtu "
                  ".csv .curves")
      ->required();
  unit("--unit", task->unit, "Unit of the file that is written: it is scaled, and declares it");
  unit("--from-unit", task->from_unit, "Unit of a mesh or of points, which state none");
  sub->add_option("--schema", "Of STEP: ap214 or ap242")
      ->check(CLI::IsMember({"ap214", "ap242"}, CLI::ignore_case))
      ->each([task](const std::string& word) { task->ap242 = word.ends_with("242"); });
  sub->add_option("--chord", task->chord,
                  "Triangles of CAD faces: their largest distance from the faces; a thousandth of "
                  "the size unless given")
      ->check(kPositive);
  add_common(sub, common);
  return {sub, [task, &common] {
            const ConvertReport report = run_convert(*task, terminal_progress(common.quiet));
            return finish(report, report.text, common);
          }};
}

}  // namespace batten
