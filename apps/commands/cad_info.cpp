#include "batten/apps/commands/cad_info.h"

#include "batten/apps/commands/exchange/cad_words.h"
#include "batten/apps/commands/exchange/file_kinds.h"
#include "batten/core/errors.h"
#include "batten/io/cad/cad_text.h"
#include "batten/io/files/in_child.h"
#include "batten/io/files/length_units.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_calls.h"
#include "batten/io/pictures/display.h"
#include "batten/io/pictures/edge_pictures.h"

namespace batten {
namespace {

// "" for a file without faces.
std::string step_text(const std::filesystem::path& file, const std::string& unit) {
  const StepReport step = cad_calls().check_step(file, unit_in_metres(unit), {});
  if (step.faces == 0) return "";
  return std::to_string(step.faces) + " faces in " + std::to_string(step.shells) +
         " shells, lengths in " + unit + "\n  " + (step.valid ? "valid" : "NOT valid") + ", area " +
         number(step.area) + "\n";
}

EdgeComb comb_of(const EdgeContinuity& edge) {
  using Kind = EdgeContinuity::Kind;
  EdgeComb comb;
  comb.kind = edge.kind == Kind::Crease    ? EdgeComb::Kind::Crease
              : edge.kind == Kind::Tangent ? EdgeComb::Kind::Tangent
                                           : EdgeComb::Kind::Curvature;
  for (const EdgeTooth& tooth : edge.teeth) {
    comb.line.push_back(tooth.at);
    for (size_t side = 0; side < 2; ++side) comb.bends[side].push_back(tooth.bend[side]);
  }
  return comb;
}

}  // namespace

std::string cad_info(const std::filesystem::path& file, const std::string& unit,
                     const std::function<std::string()>& lines) {
  const CadContents contents = cad_calls().read_cad_contents(file);
  std::string text = contents_text(contents);
  if (contents.faces == 0) return text + lines();
  const CadFormat format = cad_format(file);
  const ContinuityReport report =
      cad_calls().measure_continuity(file, unit_in_metres(unit), ContinuityOptions{});
  text += format == CadFormat::Step
              ? bytes_from_child(file, "OpenCASCADE", [&] { return step_text(file, unit); })
              : std::to_string(report.faces) + " faces, lengths in " + unit + "\n";
  text += continuity_text(report, ContinuityOptions{}, unit);
  return format == CadFormat::Iges ? text + lines() : text;
}

bool draw_face_edges(const std::filesystem::path& picture, const std::filesystem::path& file,
                     const std::string& unit) {
  if (file_kind(file) != FileKind::Cad ||
      cad_calls().read_cad_surfaces(file, unit_in_metres(unit)).empty())
    return false;
  require_display();
  ContinuityOptions options;
  options.teeth = 40;
  const ContinuityReport report =
      cad_calls().measure_continuity(file, unit_in_metres(unit), options);
  EdgePicture drawing;
  drawing.title = file.filename().string() + ": curvature across edges";
  drawing.unit = unit;
  for (const EdgeContinuity& edge : report.inner) drawing.edges.push_back(comb_of(edge));
  drawing.rims = report.rim_lines;
  draw_edge_combs(picture, drawing);
  return true;
}

}  // namespace batten
