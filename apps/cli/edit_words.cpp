// The words of `batten deform` and `batten sequence`.
#include "batten/apps/cli/command_words.h"
#include "batten/apps/cli/terminal.h"
#include "batten/apps/commands/meshes/run_deform.h"
#include "batten/apps/commands/runs/run_parts.h"
#include "batten/apps/commands/sequences/run_sequence.h"

namespace batten {
namespace {

struct EditWords {
  std::string file, out;
  std::vector<std::string> settings;
  SequenceTask sequence;
};

}  // namespace

Command add_deform(ProgramWords& program, CommonWords& common) {
  const auto words = std::make_shared<EditWords>();
  EditWords& a = *words;
  const Words sub =
      program.command("deform", "Edit a mesh; its form features keep their shape exactly");
  sub.option("edits", a.file, "Edits of a mesh (.toml)").required();
  sub.option("--out", a.out, "Folder for all files, report.json too").required();
  sub.option("--set", a.settings, "Set a parameter of the edits: name=value").repeated();
  add_common(sub, common);
  return {sub, [words, &common] {
            DeformScene scene = read_deform_scene(words->file);
            apply_settings(scene, words->settings);
            const auto report = run_deform(scene, words->out, terminal_progress(common.quiet));
            return finish(report, summary(report, words->out), common);
          }};
}

Command add_sequence(ProgramWords& program, CommonWords& common) {
  const auto words = std::make_shared<EditWords>();
  EditWords& a = *words;
  const Words sub = program.command(
      "sequence", "Edit a deforming mesh: keyframes, footprints, paths; mix, filter, morph");
  sub.option("edits", a.file, "Edits of a sequence (.toml)").required();
  sub.option("--out", a.out, "Folder for all files, report.json too").required();
  sub.form(
      "--frames",
      [words](const std::string& text) {
        const size_t colon = text.find(':');
        const auto first = stated_number(text.substr(0, colon)),
                   last =
                       colon == std::string::npos ? first : stated_number(text.substr(colon + 1));
        if (!first || !last || !(*first >= 1) || !(*last >= *first) || *last > 1e9)
          return "found " + text + ", expected FIRST:LAST";
        words->sequence.frames = {static_cast<int>(*first), static_cast<int>(*last)};
        return std::string();
      },
      "Make these frames only, FIRST:LAST from 1: runs of a job array share the work");
  add_common(sub, common);
  return {sub, [words, &common] {
            const auto report = run_sequence(read_sequence_scene(words->file), words->out,
                                             words->sequence, terminal_progress(common.quiet));
            return finish(report, summary(report, words->out), common);
          }};
}

}  // namespace batten
