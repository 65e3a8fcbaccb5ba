// SPDX-License-Identifier: MPL-2.0
// Contents of a Sequence, for the front ends of Batten.
#pragma once

#include <string>
#include <vector>

#include "batten/mesh/sequence/mesh_sequence.h"
#include "batten/scenes/sequence.h"

namespace batten::detail {

/// The frames of a sequence, and the results of the edit that it comes from. Immutable.
struct SequenceData {
  MeshSequence frames;
  std::string report = {};  ///< JSON text; empty: not the result of an edit
  std::vector<std::string> warnings = {}, failed_checks = {};
};

/// Edits as text: tables of operations, and a scene that follows them.
struct SequenceEditText {
  std::string caller = "edited()";  ///< first word of messages
  /// Inline tables, one line each: { type = "filter", … }. Messages name them operations[0], …, or
  /// only the caller if `single`.
  std::vector<std::string> operations = {};
  bool single = false;
  std::string scene = "";  ///< text of a sequence scene, as for Sequence::edited()
  /// Folder of relative paths in the text.
  std::filesystem::path folder = {};
};

/// Sequence::edited() for operations as inline tables. Throws its exceptions.
Sequence edited(const Sequence& sequence, const SequenceEditText& text,
                const SequenceSettings& settings, const Progress& progress);

}  // namespace batten::detail
