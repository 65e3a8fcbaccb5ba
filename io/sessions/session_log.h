// Writes and reads the log of a sculpting session, for replay: one JSON object per line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/sculpting/session/sculpting_session.h"

namespace batten {

/// Writes the operations recorded by a session, for replay (SculptingSession::record(), recorded(),
/// apply()):
///
///   {"batten":"session","version":2}
///   {"do":"set","parameter":3,"value":0.25}
///   {"do":"solve"}
///   {"do":"add","load":{"name":"swell","type":"pressure"},"parameters":[{"name":"swell","max":9}]}
///   {"do":"update","iterations":4,"tolerance":1e-06}
///
/// Numbers are written with full precision, so they are read back exactly. A replay on a session
/// made from the same input is therefore bit-identical. Parameters are 0-based, in the order of the
/// session. Added curves must be piecewise cubic and C1; they are written by their nodes.
///
/// Throws InputError: a non-finite number, a curve that is not piecewise cubic and C1, a file that
/// cannot be written. The file is written atomically.
void write_session_log(const std::filesystem::path& file, const std::vector<Operation>& operations);
/// The same log as a string. Throws InputError as write_session_log().
std::string session_log_text(const std::vector<Operation>& operations);

/// Reads a log. Throws InputError: "FILE:LINE: found …, expected …", also for another version of
/// the format.
std::vector<Operation> read_session_log(const std::filesystem::path& file);
/// Parses a log from a string; `file` is used in messages only.
std::vector<Operation> parse_session_log(const std::string& text,
                                         const std::filesystem::path& file);

}  // namespace batten
