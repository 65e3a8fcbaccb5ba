// SPDX-License-Identifier: MPL-2.0
// Writes and reads the log of a sculpting session, for replay: one JSON object per line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/sculpting/session/sculpting_session.h"

namespace batten {

/// Writes the recorded operations of a sculpting session to a log. SculptingSession::apply()
/// replays them; see also SculptingSession::record() and recorded(). Example of a log:
///
///   {"batten":"session","version":2}
///   {"do":"set","parameter":3,"value":0.25}
///   {"do":"solve"}
///   {"do":"add","load":{"name":"swell","type":"pressure"},"parameters":[{"name":"swell","max":9}]}
///   {"do":"update","iterations":4,"tolerance":1e-06}
///
/// Numbers are written with full precision and are read back exactly. A replay in a session that is
/// created from the same input is therefore bit-identical. Parameters are identified by 0-based
/// indices, in the order of the session. An added curve is written as a list of its nodes.
///
/// The file is written atomically. Throws InputError if a number is not finite, an added curve is
/// not piecewise cubic and C1, or the file cannot be written.
void write_session_log(const std::filesystem::path& file, const std::vector<Operation>& operations);
/// The log of a sculpting session as a string. Throws InputError as write_session_log() does.
std::string session_log_text(const std::vector<Operation>& operations);

/// Reads the log of a sculpting session. Throws InputError ("FILE:LINE: found …, expected …") if
/// the log is invalid or has another format version.
std::vector<Operation> read_session_log(const std::filesystem::path& file);
/// Parses the log of a sculpting session from a string. `file` is used in messages only.
std::vector<Operation> parse_session_log(const std::string& text,
                                         const std::filesystem::path& file);

}  // namespace batten
