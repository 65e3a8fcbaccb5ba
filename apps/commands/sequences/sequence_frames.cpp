#include "batten/apps/commands/sequences/sequence_frames.h"

#include "batten/core/errors.h"

namespace batten {

PreparedSequence prepared_sequence(MeshSequence sequence, const std::string& where,
                                   std::vector<std::string>& notes) {
  try {
    PreparedMesh prepared = prepare(sequence.shells);
    notes.insert(notes.end(), prepared.notes.begin(), prepared.notes.end());
    return {std::move(sequence), std::move(prepared.mesh)};
  } catch (const InputError& e) {
    throw InputError(where + e.what());
  }
}

SequenceParts find_sequence_parts(const SequenceScene& scene, VertexSelector& select) {
  SequenceParts parts;
  for (const auto& h : scene.handles) {
    parts.handles.push_back({h.name, select.of(h.vertices)});
    if (parts.handles.back().vertices.empty())
      throw InputError(scene.at(h.location) + "the handle '" + h.name + "' has no nodes");
  }
  for (const auto& h : scene.handles)
    parts.parents.push_back(h.parent.text.empty() ? -1 : parts.handle(scene, h.parent));
  for (const FeatureSpec& rule : scene.features) {
    if (!rule.name.empty()) {
      parts.features.push_back({rule.name, select.of(rule.vertices), rule.kind});
      continue;
    }
    for (const LocatedString& word : rule.vertices)
      for (const LocatedString& name : select.matching(word))
        parts.features.push_back({name.text, select.of(name), rule.kind});
  }
  return parts;
}

StepResult unchanged_result(std::shared_ptr<const PreparedSequence> s) {
  StepResult result;
  result.shells = s->sequence.shells;
  result.times = s->sequence.times;
  result.frames = [s](int first, int last, const auto& take, const Progress&) {
    for (int k = first; k <= last; ++k) take(k, s->sequence.frames[k]);
  };
  return result;
}

StepResult run_step(const SequenceScene& scene, const SequenceOperation& step,
                    const PreparedSequence& from, const SequenceParts& parts,
                    VertexSelector& select, const FrameReader& read, const Progress& progress) {
  const VertexFinder vertices_of = [&](const std::vector<LocatedString>& names) {
    return select.of(names);
  };
  return with_step_context(scene, step, [&] {
    return apply_step(scene, step, from, parts, vertices_of, read, progress);
  });
}

std::shared_ptr<const PreparedSequence> collect_frames(const StepResult& result,
                                                       const TriangleMesh& mesh,
                                                       const Progress& progress) {
  MeshSequence sequence;
  sequence.shells = result.shells;
  sequence.times = result.times;
  result.frames(
      0, isize(result.times) - 1, [&](int, const Points& p) { sequence.frames.push_back(p); },
      progress);
  sequence.shells.points = sequence.frames.front();
  const MeshTopology& topology = mesh.topology();
  Points vertices(topology.vertex_count(), 3);
  for (int v = 0; v < topology.vertex_count(); ++v)
    vertices.row(v) = sequence.frames.front().row(topology.node_of(v));
  return std::make_shared<const PreparedSequence>(
      PreparedSequence{std::move(sequence), mesh.with_points(std::move(vertices))});
}

}  // namespace batten
