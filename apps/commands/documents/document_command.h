// What can be done to a document, as data and as a line of a script.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/scene/scene_text.h"

namespace batten {

/// One command on a Document. Scripts have one a line, words apart by blanks; a word with blanks is
/// in quotes ("rib height"), a value or table of TOML goes on to the end of the line, `#` begins a
/// comment:
///
///     open FILE                    a scene, or a file of lines as a new network
///     new UNIT                     an empty network
///     add KIND { name = "…", … }   adds a table [[KIND]]; KIND [stress]: the one table [stress]
///     set KIND NAME KEY VALUE      a key of a table; `-` for no name, `- -` for the top
///     erase KIND NAME KEY          removes a key
///     remove KIND NAME             removes a table
///     move [[x, y, z], [x, y, z]]  a point from one place to another, of all lines that have it in
///                                  their points, so that they stay together; moves from one place
///                                  that follow each other are one step to undo, until a `solve_to_equilibrium`
///     slide PARAMETER VALUE        moves a slider; the shape follows by `answer` or `solve_to_equilibrium`
///     answer                       a quick answer, as in a drag
///     settle                       the shape at rest; ends a drag, which is one step to undo, or a motion;
///                                  a drag of a load that was added just before with value = 0 is
///                                  one step with that
///     step DT                      one step of so much time of a motion ([motion] of the scene)
///     undo, redo
///     save [FILE]                  the scene
///     recover FILE                 changes that a killed window left (Document::recovery_text())
///     run FOLDER                   makes everything that the scene asks for: `batten run`
///     export FILE                  the present shape: .step, .iges, .vtp, .stl, .obj, .ply, .glb
///
/// Paths are relative to the script's folder.
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
  SceneTable table = {};            ///< Add (its kind), Set, Erase, Remove
  std::string key = {};             ///< Set, Erase; Slide: the parameter; New: the unit
  std::string text = {};            ///< Add: the table in braces; Set: the value; Move: both places
  double value = 0;                 ///< Slide; Step: of time
  std::filesystem::path file = {};  ///< Open, Recover, Save, Run, Export

  /// Whether it changes the scene's text, and so can be undone.
  bool edits() const {
    return kind == CommandKind::Add || kind == CommandKind::Set || kind == CommandKind::Erase ||
           kind == CommandKind::Remove || kind == CommandKind::Move;
  }
};

/// The command as a line of a script, without the line's end. Numbers read back as they were.
std::string script_line(const DocumentCommand& command);
/// Reads a line. `where` begins the messages. Throws InputError: an unknown word (the nearest is
/// offered), words that are missing or too many, a number that is not finite.
DocumentCommand parse_command(const std::string& line, const std::string& where);

struct LocatedCommand {
  DocumentCommand command;
  std::string where;  ///< "FILE:LINE:1: "
};
/// Reads a script; empty lines and comments are left out. Throws InputError with the line.
std::vector<LocatedCommand> read_script(const std::filesystem::path& file);

}  // namespace batten
