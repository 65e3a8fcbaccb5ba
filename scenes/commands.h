// SPDX-License-Identifier: MPL-2.0
// Entry points of the commands, which all front ends call. The source of a command has its name, and
// is in the sub-folder of its subject.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/core/progress.h"
#include "batten/core/solvers/linear_solver_backend.h"
#include "batten/io/decks/calculix_decks.h"
#include "batten/io/report/deform_report.h"
#include "batten/io/report/report.h"
#include "batten/io/report/run_report.h"
#include "batten/io/report/sequence_report.h"
#include "batten/io/scene/deform_scene.h"
#include "batten/io/scene/fair_scene.h"
#include "batten/io/scene/scene.h"
#include "batten/io/scene/sequence_scene.h"

namespace batten {

struct CadContents;

// Surfaces: `batten run`, `skin`, `fit`, `stress` and `view`.

/// Creates a scene from curve files alone, for `batten skin`. `inner`: files of curves that lie on
/// a surface without bounding it.
Scene scene_of_lines(const std::vector<std::filesystem::path>& outline,
                     const std::vector<std::filesystem::path>& inner, const std::string& unit);

/// Computes the shape, measures it and writes all files and report.json into the folder, all or
/// none. A result that violates checks is written, too; report.failed_checks lists them. Throws
/// InputError, ConflictError, NoSolutionError, CancelledError.
Report run_scene(const Scene& scene, const std::filesystem::path& folder,
                 const Progress& progress = {});

/// Options of run_stress().
struct StressTask {
  bool with_calculix = false;  ///< cross-check with CalculiX (check_with_calculix())
  ShellDeck::Element element = ShellDeck::Element::S6;  ///< element type of the CalculiX deck
  /// Linear solver backend; empty: SparseCholesky.
  BackendFactory factors = {};
  /// Relative error of displacements and stresses below which the elements are refined; 0: no
  /// refinement. nullopt: 0.02, with a limited number of unknowns (StressAccuracy).
  std::optional<double> accuracy = {};
  bool animations = false;  ///< draw an animation of each mode shape
};
/// Like run_scene(), and analyses the shape as the shell of [stress]: analyse(). Also throws
/// InputError for a scene without [stress].
Report run_stress(const Scene& scene, const std::filesystem::path& folder, const StressTask& task,
                  const Progress& progress = {});

/// Draws one picture of the scene's shape and writes no other file. The report contains the warnings
/// about the files that were read. Throws the exceptions of
/// run_scene(), and InputError if there is no display.
RunReport view_scene(const Scene& scene, const PictureScene& look,
                     const std::filesystem::path& file, const Progress& progress = {});

/// A summary of the most important results in about a dozen lines, followed by the files.
std::string summary(const Report& report, const std::filesystem::path& folder);
/// Summary for a network: diagnostics, repairs, surfaces and unused edges, with the TOML that
/// changes each decision.
std::string network_summary(const Report& report, const std::filesystem::path& folder);

/// Report of view_cad_faces().
struct ViewReport : RunReport {
  std::string text;  ///< what was drawn, one line
};

/// Draws the faces of a CAD file, shaded, with their edges, and no other surfaces. The result is
/// empty, and nothing is drawn, if the file has no faces. `look`: only the view is used. Throws
/// InputError if `look` requests more than shaded faces, if the file cannot be read, or if there is
/// no display.
std::optional<ViewReport> view_cad_faces(const std::filesystem::path& cad, const PictureScene& look,
                                         const std::filesystem::path& picture);

// Fitting: `batten fit`.

/// Creates a network scene whose shape is fitted to a surface. Its lines come from `lines`; if that
/// is empty, they are the edges of the CAD file or the feature lines of the mesh. STEP and VTP are
/// written.
Scene scene_of_target(const std::filesystem::path& target,
                      const std::vector<std::filesystem::path>& lines, const std::string& unit);

// Openings: `batten fill`.

/// Input of `batten fill`.
struct FillTask {
  std::string unit = "mm";
  /// Names of the faces that are used, and of those that are replaced ("face 1" …); empty: all, none.
  std::vector<std::string> faces, replaced;
  /// Numbers of the openings to fill, from 1, the longest first; empty: all but outer boundaries.
  std::vector<int> openings;
  std::vector<std::string>
      edges;               ///< names of free edges that select openings, or that are connected
  bool bridge = false;     ///< true: one face connects two openings, or the edges
  double tension = 0;      ///< of a face between open edges; 0: 1
  std::string continuity;  ///< "G0", "G1" or "G2"; empty: automatic
  /// Files of curves inside the openings, through which the new faces pass.
  std::vector<std::filesystem::path> inner;
  double edge_length = 0;     ///< length of element edges, model units; 0: automatic
  bool patches_only = false;  ///< true: the STEP file contains only the new faces
  bool step_curves = false, step_ap242 = false;  ///< as Scene::step_lines and Scene::step_ap242
};
/// Fills the openings between the faces of a CAD file with faces that continue these faces:
/// run_scene() with a scene of one [[neighbour]], which is also written, as NAME-filled.toml (with a
/// bridge: NAME-blended.toml). Throws
/// as run_scene() does.
Report run_fill(const std::filesystem::path& part, const FillTask& task,
                const std::filesystem::path& folder, const Progress& progress = {});

// Sculpting: `batten sculpt`.

/// Operations of `batten sculpt`.
struct SculptTask {
  std::vector<std::string> settings;  ///< "name=value"
  std::vector<std::string> sweeps;    ///< "name=from:to:count"
  double time = 0, dt = 0;            ///< duration and time step of a motion; 0: no motion
  /// Maximum number of frames of a motion, besides the first.
  int frames = 60;
  std::string refinement;                ///< "jumps:ROUNDS"; empty: none
  bool stress = false;                   ///< analyse the shell of [stress] at each value of a sweep
  std::filesystem::path record, replay;  ///< log to write, log to read; empty: none
};

/// Solves the scene's shape in a session, then performs the operations of the task in this order:
///
///     replay      applies the operations of a log
///     settings    sets parameters of the session, then solves to equilibrium
///     refinement  bisects triangles at curvature jumps, for the given number of rounds
///     sweeps      solves at each value, starting from the previous shape (and analyses the shell
///                 of [stress] if requested); then resets the parameter
///     motion      dynamic motion from the equilibrium, initially at rest, in steps of dt
///
/// Writes the following files, all or none: those of [output] and [[picture]] with the final shape;
/// per sweep NAME_PARAMETER_000.vtp …, .pvd, .png (contact sheet) and .gif; for a motion the same
/// as NAME_time…, but with one .png per frame; report.json. The log is written last. A value
/// without a solution ends its sweep; the previous results are kept and report.failed_checks tells
/// about it. [[sweep]] is ignored (run_scene() handles it). Throws the exceptions of run_scene().
Report run_sculpt(const Scene& scene, const SculptTask& task, const std::filesystem::path& folder,
                  const Progress& progress = {});

/// A summary of the most important results and the files; each file series takes one line.
std::string sculpt_summary(const Report& report, const std::filesystem::path& folder);

// Curves: `batten fair`.

/// Fairs the lines of a scene and writes all files and report.json into the folder, all or none.
/// report.failed_checks lists pictures that cannot be drawn and violated conditions.
/// report.warnings lists lines that cannot be faired, which are written unchanged. Throws
/// InputError, ConflictError, CancelledError.
FairReport run_fair(const FairScene& scene, const std::filesystem::path& folder,
                    const Progress& progress = {});

/// Paths of the files of one run; empty: not written.
struct FairFiles {
  std::filesystem::path out, picture, report;
};
/// Like run_fair() above, with a separate path per file, each written atomically. `scene.outputs`
/// and `scene.pictures` are ignored.
FairReport run_fair(const FairScene& scene, const FairFiles& files, const Progress& progress = {});

/// A table with one row for each faired curve (the first twenty), and a row for all curves.
std::string summary(const FairReport& report);
/// The same table, followed by the time and the files.
std::string summary(const FairReport& report, const std::filesystem::path& folder);

// Meshes: `batten deform`.

/// Options of a run, beside its scene.
struct MorphTask {
  /// Files of the derivatives of all nodes with respect to the parameters (write_derivatives() in
  /// scenes/meshes/derivative_files.h).
  std::vector<std::filesystem::path> derivatives;
  /// Design of experiments, "lhs:N[:SEED]", "grid" or a table (design_table() in
  /// scenes/meshes/design_table.h); empty: none.
  std::string doe;
  /// Parameters that vary, "NAME=FROM:TO[:COUNT]"; the derivatives are those with respect to them, or
  /// to all parameters if there are none.
  std::vector<std::string> ranges;
};

/// Performs the edits in order, after the parameters have been changed so that the [[require]]
/// conditions hold, measures the result and writes all files and report.json into the folder, all or
/// none. A result that violates checks is written, too; report.failed_checks lists them.
///
/// A design of experiments also writes the mesh of each variant, variant-001/MESH and so on, and
/// variants.csv: the parameters, dimensions, element quality and status of each variant. A variant
/// without a solution is listed with the reason. Throws InputError, ConflictError, NoSolutionError,
/// CancelledError.
DeformReport run_deform(const DeformScene& scene, const std::filesystem::path& folder,
                        const MorphTask& task = {}, const Progress& progress = {});

/// A summary of the most important results in about a dozen lines, followed by the files.
std::string summary(const DeformReport& report, const std::filesystem::path& folder);

// Mesh sequences: `batten sequence`.

/// Options of a run, beside its scene.
struct SequenceTask {
  /// Range of frames to compute (1-based, inclusive), so that several runs can share the work.
  /// Empty: all frames.
  std::optional<std::pair<int, int>> frames;

  /// Name of an output file that is separate for each partial run: "walk.png", or "walk_3-7.png".
  std::string name_of(const std::filesystem::path& file) const;
};

/// Performs the steps in order, and writes the frames, report.json and pictures into the folder.
///
/// Numbered frame files appear one by one, each written atomically. A run that was interrupted
/// resumes after its existing frames, if scene and input are unchanged. All other files appear at
/// the end, all or none. Throws InputError (also for a range of frames with output to a single
/// file), ConflictError, NoSolutionError, CancelledError.
SequenceReport run_sequence(const SequenceScene& scene, const std::filesystem::path& folder,
                            const SequenceTask& task = {}, const Progress& progress = {});

/// A summary of the most important results in about a dozen lines, followed by the files.
std::string summary(const SequenceReport& report, const std::filesystem::path& folder);

// Files: `batten convert`.

/// Input of run_convert().
struct ConvertTask {
  std::filesystem::path from, to;
  std::string unit;       ///< unit of the output file; empty: that of the input
  std::string from_unit;  ///< unit of an input file that states none; empty: unknown
  /// Chord tolerance of triangles from CAD faces, in the unit of the output file; 0: 1e-3 of the
  /// size.
  double chord = 0;
  bool ap242 = false;  ///< true: STEP AP242 instead of AP214
};

/// Report of a conversion.
struct ConvertReport : RunReport {
  std::string text;  ///< summary of input and output, several lines
};

/// Converts a file. Supported conversions:
///
///   CAD (.step .stp .iges .igs .brep .brp)  to CAD and .glb: convert_cad(); to .stl .obj .ply .off
///                                           .vtp .vtu .3mf: tessellate_cad(); to .csv .curves
///                                           .dxf .svg: only the curves
///   a mesh, or the shells of a deck         to .stl .obj .ply .off .vtp .vtu; also to .glb (always
///                                           in metres) and .3mf (always in millimetres), which
///                                           require `from_unit`
///   curves                                  to the formats of write_curves()
///
/// report.failed_checks lists what the output lacks compared with the input: faces, area,
/// closedness, names. It also lists triangles farther from the faces than the chord tolerance, and
/// cracks between them. Throws InputError like the readers and writers, and for unsupported pairs:
/// a mesh cannot be converted to CAD faces.
ConvertReport run_convert(const ConvertTask& task, const Progress& progress = {});

// Text summaries and pictures of files: `batten info` and `view`.

/// Describes a file in a few lines of text:
/// - a scene (.toml): its curves and parameters;
/// - points, CAD curves, drawings or sketches: the curves with lengths, ends, planes, and how they
///   were interpreted;
/// - a CAD file: unit, products, names, colours and layers, and the continuity of its edges; for
///   STEP also its validity;
/// - a mesh or a mesh sequence: its contents.
///
/// `unit`: length unit of the text and of point files; a scene has its own. Throws InputError.
std::string file_info(const std::filesystem::path& file, const std::string& unit);

/// Draws the curves of a scene or file as they were read, with points and curvature combs, to a
/// PNG. For a CAD file with faces it draws their edges, with the curvature across them. Throws
/// InputError if there are no curves or no display.
void draw_lines(const std::filesystem::path& picture, const std::filesystem::path& file,
                const std::string& unit);

/// Finds the faces of a network scene, and draws every ambiguous face with its alternatives into
/// `folder`: alternatives_1.png, alternatives_2.png, … Each picture shows the location, the current
/// surfaces, and all alternatives. The result describes each decision, with the TOML that selects
/// each alternative. Throws InputError if there is no network or no display, and the exceptions of
/// build_network() and require_regions().
std::string draw_alternatives(const std::filesystem::path& folder, const Scene& scene);

/// One line: "STEP AP214, in mm, 3 products, 1 solid, 12 faces, closed; 5 names, 2 colours".
std::string contents_line(const CadContents& contents);

/// Determines the kind of a file by its extension, or by its contents if curves and meshes share
/// the extension. A `.obj` with faces is a mesh; a `.dat` with grid points is a Nastran deck.
enum class FileKind { None, Scene, Mesh, Sequence, Cad, Lines };
FileKind file_kind(const std::filesystem::path& file);

// Scenes of any kind.

/// Reads a scene file and calls use(scene) with a mutable SequenceScene, DeformScene, FairScene
/// (curves only) or Scene. Throws the exceptions of the reader.
template <class Use>
auto visit_scene(const std::filesystem::path& file, const Use& use) {
  if (is_sequence_scene(file)) {
    SequenceScene scene = read_sequence_scene(file);
    return use(scene);
  }
  if (is_deform_scene(file)) {
    DeformScene scene = read_deform_scene(file);
    return use(scene);
  }
  if (is_fair_scene(file)) {
    FairScene scene = read_fair_scene(file);
    return use(scene);
  }
  Scene scene = read_scene(file);
  return use(scene);
}

/// Runs a scene: writes everything that it requests into the folder `out`. The result is the
/// report.
inline SequenceReport run_any_scene(const SequenceScene& scene, const std::filesystem::path& out,
                                    const Progress& progress) {
  return run_sequence(scene, out, {}, progress);
}
inline DeformReport run_any_scene(const DeformScene& scene, const std::filesystem::path& out,
                                  const Progress& progress) {
  return run_deform(scene, out, {}, progress);
}
inline FairReport run_any_scene(const FairScene& scene, const std::filesystem::path& out,
                                const Progress& progress) {
  return run_fair(scene, out, progress);
}
inline Report run_any_scene(const Scene& scene, const std::filesystem::path& out,
                            const Progress& progress) {
  return run_scene(scene, out, progress);
}

}  // namespace batten
