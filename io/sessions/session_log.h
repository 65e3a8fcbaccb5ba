// Writes and reads a log of what was done to a sculpting session: one JSON object for each line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/sculpting/session/sculpting_session.h"

namespace batten {

/// Writes the operations that a session recorded, for replay (SculptingSession::record, recorded,
/// apply):
///
///   {"batten":"session","version":1}
///   {"do":"set","parameter":3,"value":0.25}
///   {"do":"settle"}
///   {"do":"add","load":{"name":"swell","type":"pressure"},"parameters":[{"name":"swell","max":9}]}
///   {"do":"answer","iterations":4,"tolerance":1e-06}
///
/// Numbers have all their digits and are read back as the same bits, so that a replay on a session
/// made from the same input gives the same bits, too. Parameters are counted from 0 in the order of
/// the session. Lines that are added must be piecewise cubic and C1; they are written by their
/// nodes.
///
/// Throws InputError: a number that is not finite, a line that is not such a curve, a file that
/// cannot be written. The file appears whole or not at all.
void write_session_log(const std::filesystem::path& file, const std::vector<Operation>& operations);
/// The same log as a text. Throws InputError as write_session_log().
std::string session_log_text(const std::vector<Operation>& operations);

/// Reads a log. Throws InputError: "FILE:LINE: found …, expected …".
std::vector<Operation> read_session_log(const std::filesystem::path& file);
/// Reads the same from a text; messages name `file`.
std::vector<Operation> parse_session_log(const std::string& text,
                                         const std::filesystem::path& file);

}  // namespace batten
