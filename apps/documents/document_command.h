// SPDX-License-Identifier: MPL-2.0
// Commands on a document, as data and as lines of a script.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/scene/scene_text.h"

namespace batten {

/// One command on a Document. A script has one command per line, with words separated by blanks.
/// Words that contain blanks are quoted ("rib height"); a TOML value or table extends to the end of
/// the line; `#` starts a comment:
///
///     open FILE                    opens a scene, or a curve file as a new network
///     new UNIT                     creates an empty network
///     add KIND { name = "…", … }   adds a table [[KIND]]; KIND [stress]: the one table [stress]
///     set KIND NAME KEY VALUE      sets a key; `-` for no name, `- -` for the top level
///     erase KIND NAME KEY          removes a key
///     remove KIND NAME             removes a table
///     move [[x, y, z], [x, y, z]]  moves a point from one position to another, in all curves that
///                                  contain it, so that they stay connected; consecutive moves of
///                                  a point form one undo step, until a `solve`
///     slide PARAMETER VALUE        moves a slider; `update` or `solve` then computes the shape
///     update                       updates the shape quickly, as during a drag
///     solve                        solves to equilibrium; ends a motion, or a drag (one undo
///                                  step); dragging a load that was just added with value = 0
///                                  belongs to the undo step of adding it
///     step DT                      performs one time step of a motion ([motion] of the scene)
///     undo, redo
///     save [FILE]                  saves the scene
///     recover FILE                 restores changes after a crash (Document::recovery_text())
///     run FOLDER                   writes everything that the scene requests, like `batten run`
///     export FILE                  writes the current shape: .step, .iges, .vtp, .stl, .obj, .ply,
///                                  .glb
///
/// Paths are relative to the folder of the script.
struct DocumentCommand {
  enum class CommandKind {
    Open,
    Recover,
    New,
    Add,
    Set,
    Erase,
    Remove,
    Move,
    SetSlider,
    SolvePreview,
    SolveToEquilibrium,
    Step,
    Undo,
    Redo,
    Save,
    Run,
    Export
  };
  CommandKind kind = CommandKind::SolveToEquilibrium;
  SceneTable table = {};            ///< Add (kind only), Set, Erase, Remove
  std::string key = {};             ///< Set, Erase; SetSlider: parameter; New: unit
  std::string text = {};            ///< Add: inline table; Set: value; Move: both positions
  double value = 0;                 ///< SetSlider; Step: time step
  std::filesystem::path file = {};  ///< Open, Recover, Save, Run, Export

  /// True if it changes the scene's text, and thus can be undone.
  bool edits() const {
    return kind == CommandKind::Add || kind == CommandKind::Set || kind == CommandKind::Erase ||
           kind == CommandKind::Remove || kind == CommandKind::Move;
  }
};

/// The command as a line of a script, without line end. Numbers read back exactly.
std::string script_line(const DocumentCommand& command);
/// Parses a line. Messages begin with `where`. Throws InputError for an unknown command (with the
/// nearest one as a suggestion), missing or extra words, or a number that is not finite.
DocumentCommand parse_command(const std::string& line, const std::string& where);

/// A command with its location.
struct LocatedCommand {
  DocumentCommand command;
  std::string where;  ///< "FILE:LINE:1: "
};
/// Reads a script, skipping empty lines and comments. Throws InputError with the line.
std::vector<LocatedCommand> read_script(const std::filesystem::path& file);

}  // namespace batten
