#include "batten/apps/commands/sequences/sequence_info.h"

#include <algorithm>

#include "batten/core/format.h"
#include "batten/io/files/text.h"
#include "batten/mesh/prepared_mesh.h"

namespace batten {

bool is_sequence_file(const std::filesystem::path& file) {
  static const std::vector<std::string> endings{".glb", ".gltf", ".pc2", ".mdd", ".pvd", ".frd"};
  return std::find(endings.begin(), endings.end(), lower_extension(file)) != endings.end();
}

std::string sequence_info(const SequenceSource& source, const std::string& unit) {
  const MeshSequence s = read_sequence(source.path, source.options);
  const MeshDiagnosis mesh = diagnose(s.shells);
  Vec3 low = s.frames.front().colwise().minCoeff(), high = s.frames.front().colwise().maxCoeff();
  double step = 0;
  for (size_t k = 0; k < s.frames.size(); ++k) {
    low = low.cwiseMin(s.frames[k].colwise().minCoeff().transpose());
    high = high.cwiseMax(s.frames[k].colwise().maxCoeff().transpose());
    if (k > 0) step = std::max(step, (s.frames[k] - s.frames[k - 1]).rowwise().norm().maxCoeff());
  }
  const auto jerks = second_differences(s.frames);
  const double size = size_of(s),
               apart = (s.frames.back() - s.frames.front()).rowwise().norm().maxCoeff();
  std::string text =
      std::to_string(s.frame_count()) + " frames from " + format_number(s.times.front()) + " to " +
      format_number(s.times.back()) + ", " + std::to_string(s.node_count()) + " nodes, " +
      std::to_string(s.shells.face_count()) + " faces in " + std::to_string(mesh.components) +
      (mesh.components == 1 ? " part" : " parts") + ", lengths in " + unit + "\n";
  text += "  all frames from " + format_point(low) + " to " + format_point(high) + "\n";
  if (s.frame_count() > 1)
    text += "  nodes move by up to " + format_number(step) +
            " from frame to frame, second difference " +
            format_number(*std::max_element(jerks.begin(), jerks.end())) +
            (apart < 1e-6 * size ? "; the last frame is the first one again" : "") + "\n";
  return text;
}

std::string sequence_info(const SequenceScene& scene) {
  std::string text = "edits '" + scene.name + "' of a sequence, unit " + scene.unit + "\n" +
                     sequence_info(scene.source, scene.unit);
  const auto list = [&](const std::string& what, const auto& things) {
    if (things.empty()) return;
    text += what + ":";
    for (size_t i = 0; i < things.size(); ++i) text += (i ? ", " : " ") + things[i].name;
    text += "\n";
  };
  list("handles", scene.handles);
  list("steps", scene.steps);
  return text;
}

}  // namespace batten
