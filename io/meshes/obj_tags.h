// The tags of cages in OBJ files. Internal.
#pragma once

#include <string_view>
#include <vector>

#include "batten/io/meshes/text_mesh_content.h"

namespace batten {

/// Collects `t` records, and makes cage_tags and cage_problem of them once the mesh is read.
class ObjTags {
 public:
  /// The words behind the `t`, which stay where they are.
  void add(std::vector<std::string_view> words) {
    if (!words.empty()) records_.push_back(std::move(words));
  }
  void finish(TextMeshContent& mesh) const;

 private:
  std::vector<std::vector<std::string_view>> records_;
};

}  // namespace batten
