#include "batten/apps/commands/cad_info.h"

#include "batten/apps/commands/exchange/cad_summary.h"
#include "batten/apps/commands/exchange/file_kinds.h"
#include "batten/core/errors.h"
#include "batten/io/cad/cad_format.h"
#include "batten/io/files/length_units.h"
#include "batten/io/files/sandboxed_read.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/io/pictures/display.h"
#include "batten/io/pictures/edge_pictures.h"

namespace batten {
namespace {

// "" for a file without faces.
std::string step_text(const std::filesystem::path& file, const std::string& unit) {
  const StepReport step = cad_plugin().check_step(file, unit_in_metres(unit), {});
  if (step.faces == 0) return "";
  return std::to_string(step.faces) + " faces in " + std::to_string(step.shells) +
         " shells, lengths in " + unit + "\n  " + (step.valid ? "valid" : "NOT valid") + ", area " +
         format_number(step.area) + "\n";
}

EdgeComb comb_of(const EdgeContinuity& edge) {
  using Kind = EdgeContinuity::Kind;
  EdgeComb comb;
  comb.kind = edge.kind == Kind::Crease    ? EdgeComb::Kind::Crease
              : edge.kind == Kind::Tangent ? EdgeComb::Kind::Tangent
                                           : EdgeComb::Kind::Curvature;
  for (const EdgeCombSample& sample : edge.comb_samples) {
    comb.line.push_back(sample.at);
    for (size_t side = 0; side < 2; ++side)
      comb.curvature_vectors[side].push_back(sample.curvature_vectors[side]);
  }
  return comb;
}

}  // namespace

std::string cad_info(const std::filesystem::path& file, const std::string& unit,
                     const std::function<std::string()>& lines) {
  const CadContents contents = cad_plugin().read_cad_contents(file);
  std::string text = contents_text(contents);
  if (contents.faces == 0) return text + lines();
  const CadFormat format = cad_format(file);
  const ContinuityReport report =
      cad_plugin().measure_continuity(file, unit_in_metres(unit), ContinuityOptions{});
  text += format == CadFormat::Step
              ? sandboxed_read(file, "OpenCASCADE", [&] { return step_text(file, unit); })
              : std::to_string(report.faces) + " faces, lengths in " + unit + "\n";
  text += continuity_text(report, ContinuityOptions{}, unit);
  return format == CadFormat::Iges ? text + lines() : text;
}

bool draw_face_edges(const std::filesystem::path& picture, const std::filesystem::path& file,
                     const std::string& unit) {
  if (file_kind(file) != FileKind::Cad ||
      cad_plugin().read_cad_surfaces(file, unit_in_metres(unit)).empty())
    return false;
  require_display();
  ContinuityOptions options;
  options.comb_samples = 40;
  const ContinuityReport report =
      cad_plugin().measure_continuity(file, unit_in_metres(unit), options);
  EdgePicture drawing;
  drawing.title = file.filename().string() + ": curvature across edges";
  drawing.unit = unit;
  for (const EdgeContinuity& edge : report.inner) drawing.edges.push_back(comb_of(edge));
  drawing.free_edges = report.free_edge_lines;
  draw_edge_combs(picture, drawing);
  return true;
}

}  // namespace batten
