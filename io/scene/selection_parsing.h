// Functions by which scenes read selections and features. Internal.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/scene/scene_parsing.h"
#include "batten/io/scene/scene_selections.h"

namespace batten {

LocatedString read_string(const TomlTable& table, const std::string& key);
/// Whole numbers of nodes. Throws InputError for others.
long read_label(const TomlTable& table, const std::string& key, double value);
std::vector<long> read_labels(const TomlTable& table, const std::string& key);

/// [proposals]: what features are proposed.
void read_proposals(const TomlTable& root, FeatureDetectionOptions& options);
/// [[select]] and [[cut]], which share their names. Files are relative to `folder`.
void read_selections(const TomlTable& root, const std::filesystem::path& folder,
                     SceneSelections& scene);
/// [[feature]] one by one, and [[features]], many of a kind. `taken`: names that are taken.
std::vector<FeatureSpec> read_features(const TomlTable& root, UniqueNames& taken);

}  // namespace batten
