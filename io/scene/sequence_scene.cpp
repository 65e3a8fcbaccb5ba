// SPDX-License-Identifier: MPL-2.0
#include "batten/io/scene/sequence_scene.h"

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/scene/scene_parsing.h"
#include "batten/io/sequences/sequence_writer.h"

namespace batten {
namespace {

const std::vector<std::string> kSourceKeys{
    "file", "mesh", "frames", "gaps", "animation", "frames_per_second", "weld"};

std::vector<std::string> with(std::vector<std::string> keys, const std::vector<std::string>& more) {
  keys.insert(keys.end(), more.begin(), more.end());
  return keys;
}

std::pair<int, int> frame_range(const TomlTable& t, const std::string& key) {
  const VecX range = t.numbers(key, "first, last");
  if (range[0] < 1 || range[1] < range[0] || range[0] != std::floor(range[0]) ||
      range[1] != std::floor(range[1]))
    t.fail(key, "[" + format_number(range[0]) + ", " + format_number(range[1]) + "]",
           "two frames, the first one not after the last one, counted from 1");
  return {static_cast<int>(range[0]), static_cast<int>(range[1])};
}

SequenceSource read_source(const TomlTable& t, const std::filesystem::path& folder) {
  SequenceSource source;
  source.location = t.location("file");
  source.path = folder / t.text("file");
  if (t.has("mesh")) source.options.mesh = folder / t.text("mesh");
  if (t.has("frames"))
    std::tie(source.options.first, source.options.last) = frame_range(t, "frames");
  source.options.allow_gaps = t.boolean("gaps", false);
  source.options.animation = t.text("animation", "");
  if (t.has("frames_per_second") && t.number("frames_per_second") == 0)
    source.options.frames_per_second = 0;
  else
    source.options.frames_per_second =
        t.positive("frames_per_second", source.options.frames_per_second);
  source.options.weld_seams = t.boolean("weld", true);
  return source;
}

SequenceHandle read_handle(const TomlTable& t) {
  SequenceHandle handle;
  handle.name = t.text("name");
  handle.location = t.location();
  handle.vertices = t.names("vertices");
  if (handle.vertices.empty()) handle.vertices = {{handle.name, t.location("name")}};
  if (t.has("parent")) handle.parent = read_string(t, "parent");
  return handle;
}

KeyframeSpec read_keyframe(const TomlTable& t) {
  KeyframeSpec rule;
  rule.frame = t.integer("frame", 1, 1);
  rule.location = t.location();
  for (const TomlTable& h :
       t.tables("handle", {"name", "translate", "rotate", "about", "rotation"})) {
    KeyframeSpec::Move move;
    move.handle = read_string(h, "name");
    if (h.has("translate")) move.translate = h.vector("translate");
    for (const TomlTable& r : h.table("rotate", {"axis", "angle"})) {
      move.axis = r.direction("axis");
      move.degrees = r.number("angle");
    }
    if (h.has("about")) move.about = h.vector("about");
    move.free_rotation = h.choice("rotation", false, {{"prescribed", false}, {"free", true}});
    if (move.free_rotation && h.has("rotate"))
      h.fail("rotate", "'rotate' for a handle whose rotation is free",
             "rotation = \"prescribed\", or no 'rotate'");
    for (const auto& other : rule.moves)
      if (other.handle.text == move.handle.text)
        h.fail("name", "the handle " + quoted_excerpt(move.handle.text) + " twice in a keyframe",
               "once");
    rule.moves.push_back(std::move(move));
  }
  if (rule.moves.empty()) t.fail("", "a keyframe without handles", "handle = [{ name = …, … }]");
  return rule;
}

FootContactSearch read_search(const TomlTable& t) {
  FootContactSearch search;
  for (const TomlTable& s : t.table("contact_detection", {"distance", "min_frames"})) {
    search.max_spread = s.positive("distance", search.max_spread);
    search.frames = s.integer("min_frames", 1, search.frames);
  }
  return search;
}

SequenceOperation::RootMotion read_root_motion(const TomlTable& t) {
  SequenceOperation::RootMotion step;
  step.cycles = t.integer("cycles", 1, 1);
  step.along = t.direction("direction");
  if (t.has("speed")) step.speed = t.number("speed");
  step.feet = t.names("feet");
  if (step.speed.has_value() != step.feet.empty())
    t.fail("", "the speed given twice or not at all", "one of speed, feet");
  return step;
}

SequenceOperation::FootContacts read_foot_contacts(const TomlTable& t,
                                                   const std::filesystem::path& folder) {
  SequenceOperation::FootContacts step;
  step.feet = t.names("feet");
  if (step.feet.empty()) t.fail("feet", "no names", "handles that stand on the ground");
  step.unrotated = t.names("unrotated");
  step.search = read_search(t);
  if (t.has("translate")) step.translation = t.vector("translate");
  for (const TomlTable& g : t.table("terrain", {"file", "clearance", "ground", "rotate"})) {
    step.terrain = folder / g.text("file");
    step.terrain_location = g.location("file");
    if (g.has("clearance")) step.clearance = g.number("clearance");
    step.ground = g.number("ground", 0);
    step.rotations = g.boolean("rotate", false);
  }
  return step;
}

SequenceOperation::Path read_path(const TomlTable& t) {
  SequenceOperation::Path step;
  step.through = t.points("through");
  if (step.through.size() < 2)
    t.fail("through", std::to_string(step.through.size()) + " points", "two or more");
  step.spans = t.integer("segments", 0, 0);
  step.lengths =
      t.choice("lengths", PathLengths::Absolute,
               {{"absolute", PathLengths::Absolute}, {"normalised", PathLengths::Normalised}});
  step.feet = t.names("feet");
  step.unrotated = t.names("unrotated");
  if (step.feet.empty() && !step.unrotated.empty())
    t.fail("unrotated", "'unrotated' without 'feet'",
           "both: without feet the whole mesh follows the path rigidly");
  step.search = read_search(t);
  return step;
}

SequenceOperation::Filter read_filter(const TomlTable& t) {
  using Kind = SequenceOperation::Filter::Kind;
  SequenceOperation::Filter step;
  step.kind = t.choice<Kind>(
      "filter", {{"low", Kind::Low}, {"high", Kind::High}, {"cartoon", Kind::Cartoon}});
  step.handles = t.names("handles");
  if (step.handles.empty()) t.fail("handles", "no names", "handles whose motion is filtered");
  step.sigma = t.positive("sigma", step.sigma);
  step.amount = t.positive("amount", step.amount);
  step.feet = t.names("feet");
  step.search = read_search(t);
  return step;
}

SequenceOperation::Mix read_mix(const TomlTable& t, const std::filesystem::path& folder) {
  SequenceOperation::Mix step;
  for (const TomlTable& s : t.table("source", with(kSourceKeys, {"select"}))) {
    step.source = read_source(s, folder);
    SceneSelections named;
    read_selections(s, folder, named);
    step.selections = std::move(named.selections);
  }
  if (step.source.path.empty())
    t.fail("source", "no source", "source = { file = …, select = […] }");
  for (const TomlTable& p : t.tables("pair", {"handle", "from"}))
    step.pairs.push_back({read_string(p, "handle"), p.has("from")
                                                        ? read_string(p, "from")
                                                        : LocatedString{"", p.location()}});
  if (step.pairs.empty()) t.fail("pair", "no pairs", "pair = [{ handle = …, from = … }]");
  step.rotations = t.boolean("rotations", true);
  using Align = SequenceOperation::Mix::Align;
  step.align = t.choice("align", Align::All,
                        {{"all", Align::All}, {"each", Align::Each}, {"translate", Align::Shift}});
  return step;
}

SequenceOperation::Morph read_morph(const TomlTable& t, const std::filesystem::path& folder) {
  SequenceOperation::Morph step;
  const auto zero_based = [](std::pair<int, int> range) {
    return MorphInterval{range.first - 1, range.second - 1};
  };
  for (const TomlTable& s : t.table("target", with(kSourceKeys, {"interval"}))) {
    step.target = read_source(s, folder);
    step.options.target =
        s.has("interval") ? zero_based(frame_range(s, "interval")) : MorphInterval{0, -1};
  }
  if (step.target.path.empty())
    t.fail("target", "no target", "target = { file = …, interval = […] }");
  step.options.source =
      t.has("interval") ? zero_based(frame_range(t, "interval")) : MorphInterval{0, -1};
  step.options.frames = t.integer("frames", 2, 0);
  for (const TomlTable& a : t.table("align", {"translate", "rotate"})) {
    RigidMotion motion;
    if (a.has("translate")) motion.translation = a.vector("translate");
    for (const TomlTable& r : a.table("rotate", {"axis", "angle"}))
      motion.rotation = Eigen::AngleAxisd(r.number("angle") * EIGEN_PI / 180, r.direction("axis"))
                            .toRotationMatrix();
    step.options.alignment = motion;
  }
  for (const TomlTable& l : t.tables("landmark", {"from", "to"}))
    step.landmarks.push_back({l.vector("from"), l.vector("to")});
  return step;
}

/// Keys of each kind of step, in addition to the common keys.
const std::vector<std::pair<std::string, std::vector<std::string>>> kKinds{
    {"keyframes", {"keyframe"}},
    {"root_motion", {"cycles", "direction", "speed", "feet"}},
    {"foot_plants", {"feet", "contact_detection", "unrotated", "translate", "terrain"}},
    {"path", {"through", "segments", "lengths", "feet", "contact_detection", "unrotated"}},
    {"filter", {"filter", "handles", "sigma", "amount", "feet", "contact_detection"}},
    {"mix", {"source", "pair", "rotations", "align"}},
    {"morph", {"target", "interval", "frames", "align", "landmark"}}};

/// Keys of steps that solve for handle positions.
const std::vector<std::string> kHoldingKeys{
    "fixed",     "weights",      "iterations",      "tolerance",
    "start",     "trajectories", "extrapolation",   "iterations_between",
    "influence", "penalty",      "preserve_volume", "keyframe_interval"};

void read_step_options(const TomlTable& t, SequenceOperation& step) {
  SequenceEditOptions& o = step.options;
  step.fixed = t.names("fixed");
  using Weights = FrameOptions::Weights;
  o.frames.weights = t.choice("weights", Weights::Uniform,
                              {{"uniform", Weights::Uniform}, {"cotangent", Weights::Cotangent}});
  o.frames.max_iterations = t.integer("iterations", 1, o.frames.max_iterations);
  o.frames.tolerance = t.positive("tolerance", o.frames.tolerance);
  using Start = SequenceEditOptions::Start;
  o.start = t.choice("start", Start::Handles,
                     {{"handles", Start::Handles},
                      {"subspace", Start::Subspace},
                      {"neighbour", Start::Neighbour}});
  using Smoothness = TrajectoryOptions::Smoothness;
  o.trajectories =
      t.choice("trajectories", Smoothness::Smooth,
               {{"smooth", Smoothness::Smooth}, {"piecewise_linear", Smoothness::PiecewiseLinear}});
  o.ends =
      t.choice("extrapolation", KeyframeExtrapolation::None,
               {{"none", KeyframeExtrapolation::None}, {"linear", KeyframeExtrapolation::Linear}});
  o.iterations_between = t.integer("iterations_between", 0, 0);
  if (t.has("influence")) {
    const auto [from, to] = frame_range(t, "influence");
    o.influence = {from - 1, to - 1};
  }
  if (t.has("penalty")) step.penalty_weight = t.positive("penalty");
  step.preserve_volume = t.boolean("preserve_volume", false);
  step.keyframe_interval = t.integer("keyframe_interval", 1, 1);
}

/// Rejects options that would have no effect in this kind of step.
void refuse_options(const TomlTable& t, const std::string& kind, const SequenceOperation& step) {
  const auto* path = std::get_if<SequenceOperation::Path>(&step.what);
  const bool holds = !(kind == "root_motion" || kind == "morph" || (path && path->feet.empty()));
  for (const auto& key : kHoldingKeys)
    if (t.has(key) && !holds)
      t.fail(key,
             "key '" + key + "' in an operation without handles" +
                 (path ? " (a path without 'feet')" : " ('" + kind + "')"),
             "it only in operations that move handles");
  if (t.has("keyframe_interval") && kind == "keyframes")
    t.fail("keyframe_interval", "key 'keyframe_interval' in an operation of type 'keyframes'",
           "it only in operations that prescribe handles in all frames");
}

SequenceOperation read_step(const std::string& kind, const TomlTable& t,
                            const std::filesystem::path& folder, size_t index) {
  SequenceOperation step;
  step.name = t.text("name", "operation-" + std::to_string(index + 1));
  step.location = t.location();
  read_step_options(t, step);
  if (kind == "keyframes") {
    SequenceOperation::Keyframes what;
    for (const TomlTable& k : t.tables("keyframe", {"frame", "handle"}))
      what.keys.push_back(read_keyframe(k));
    if (what.keys.empty()) t.fail("", "no keyframes", "[[operation.keyframe]]");
    step.what = std::move(what);
  } else if (kind == "root_motion") {
    step.what = read_root_motion(t);
  } else if (kind == "foot_plants") {
    step.what = read_foot_contacts(t, folder);
  } else if (kind == "path") {
    step.what = read_path(t);
  } else if (kind == "filter") {
    step.what = read_filter(t);
  } else if (kind == "mix") {
    step.what = read_mix(t, folder);
  } else {
    step.what = read_morph(t, folder);
  }
  refuse_options(t, kind, step);
  return step;
}

void read_steps(const TomlTable& root, const std::filesystem::path& folder, SequenceScene& scene) {
  const std::vector<std::string> common = with({"name", "type"}, kHoldingKeys);
  std::vector<std::string> all = common, names;
  for (const auto& [kind, keys] : kKinds) {
    names.push_back(kind);
    for (const auto& key : keys)
      if (std::find(all.begin(), all.end(), key) == all.end()) all.push_back(key);
  }
  UniqueNames steps("operation");
  for (const TomlTable& t : root.tables("operation", all)) {
    const std::string kind = t.text("type");
    const auto known = std::find(names.begin(), names.end(), kind);
    if (known == names.end()) t.fail("type", quoted_excerpt(kind), expected_one_of(kind, names));
    const auto& own = kKinds[known - names.begin()].second;
    for (const auto& key : all)
      if (t.has(key) && std::find(common.begin(), common.end(), key) == common.end() &&
          std::find(own.begin(), own.end(), key) == own.end())
        t.fail(key, "key '" + key + "' in an operation of type '" + kind + "'",
               "one of: " + comma_separated(with(common, own)));
    scene.steps.push_back(read_step(kind, t, folder, scene.steps.size()));
    steps.add(t, "name", scene.steps.back().name);
  }
}

SequencePicture sequence_picture(const TomlTable& t, UniqueNames& files) {
  using Show = SequencePicture::Show;
  SequencePicture picture;
  picture.file = output_file(t, "file", files, {".png", ".gif"});
  picture.title = t.text("title", "");
  picture.show = t.choice("show", Show::Both,
                          {{"both", Show::Both}, {"before", Show::Before}, {"after", Show::After}});
  const bool animated = picture.file.ends_with(".gif");
  picture.frames = t.integer("frames", 1, animated ? 0 : picture.frames);
  picture.together = t.boolean("together", false);
  if (picture.together && animated) t.fail("together", "an animation of frames together", "a .png");
  picture.mesh = t.boolean("mesh", false);
  picture.seconds = t.positive("seconds", picture.seconds);
  picture.zoom = t.positive("zoom", 1);
  if (animated) picture.size = {640, 400};
  read_view(t, picture.azimuth, picture.elevation, picture.size);
  return picture;
}

/// Reads the keys that do not concern files: vertical axis, selections, handles, features and
/// operations.
void read_sequence_edits(const TomlTable& root, SequenceScene& scene) {
  const std::filesystem::path folder = scene.file.parent_path();
  scene.up = root.choice("up", 2, {{"x", 0}, {"y", 1}, {"z", 2}});
  read_proposals(root, scene.proposals);
  read_selections(root, folder, scene);
  UniqueNames taken("name");
  taken.read(root, "handle", {"name", "vertices", "parent"}, scene.handles, read_handle);
  scene.features = read_features(root, taken);
  read_steps(root, folder, scene);
}

SequenceScene sequence_scene(const toml::table& root_table, const std::filesystem::path& file) {
  refuse_renamed_keys(root_table, SceneKind::Sequence, file.string());
  const TomlTable root(file.string(), root_table, "the scene",
                       {"name", "unit", "sequence", "up", "proposals", "select", "cut", "handle",
                        "feature", "features", "operation", "output", "picture"});
  const std::filesystem::path folder = file.parent_path();
  SequenceScene scene;
  scene.file = file;
  scene.name = root.text("name", file.stem().string());
  scene.unit = read_unit(root, "unit");
  for (const TomlTable& t : root.table("sequence", kSourceKeys))
    scene.source = read_source(t, folder);
  if (scene.source.path.empty()) root.fail("", "no sequence", "[sequence] with file = …");
  read_sequence_edits(root, scene);
  scene.frames_out = "frames/frame_*.obj";
  for (const TomlTable& t : root.table("output", {"frames", "frames_per_second"})) {
    scene.frames_out = t.text("frames", scene.frames_out);
    const std::filesystem::path path = scene.frames_out;
    if (path.is_absolute() || std::distance(path.begin(), path.end()) > 2 ||
        std::find(path.begin(), path.end(), "..") != path.end())
      t.fail("frames", quoted_excerpt(scene.frames_out),
             "a name in the output folder, or one folder and a name: frames/walk_*.obj");
    try {
      SequenceWriter::check_name(path);  // checked before the steps, which may take hours
    } catch (const InputError& e) {
      throw InputError(scene.at(t.location("frames")) + e.what());
    }
    scene.frames_per_second = t.positive("frames_per_second", scene.frames_per_second);
  }
  UniqueNames files("file name");
  for (const TomlTable& t : root.tables("picture", {"file", "title", "show", "frames", "together",
                                                    "mesh", "view", "zoom", "seconds", "size"}))
    scene.pictures.push_back(sequence_picture(t, files));
  return scene;
}

}  // namespace

bool is_sequence_scene(const std::filesystem::path& file) {
  return parse_toml(read_input_file(file, "a scene (.toml)"), file,
                    "a scene or edits of a sequence")
      .contains("sequence");
}

SequenceScene parse_sequence_scene(const std::string& text, const std::filesystem::path& file) {
  return sequence_scene(parse_toml(text, file, "edits of a sequence ([sequence], [[operation]] …)"),
                        file);
}

SequenceScene parse_sequence_edits(const std::string& text, const std::filesystem::path& file) {
  const toml::table table =
      parse_toml(text, file, "edits of a sequence ([[handle]], [[operation]] …)");
  refuse_renamed_keys(table, SceneKind::Sequence, file.string());
  const TomlTable root(file.string(), table, "the edits of a sequence",
                       {"name", "unit", "up", "proposals", "select", "cut", "handle", "feature",
                        "features", "operation"});
  SequenceScene scene;
  scene.file = file;
  scene.name = root.text("name", file.stem().string());
  scene.unit = root.has("unit") ? read_unit(root, "unit") : "model units";
  read_sequence_edits(root, scene);
  return scene;
}

SequenceScene read_sequence_scene(const std::filesystem::path& file) {
  return parse_sequence_scene(read_input_file(file, "edits of a sequence (.toml)"), file);
}

}  // namespace batten
