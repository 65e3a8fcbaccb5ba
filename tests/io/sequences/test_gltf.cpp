// SPDX-License-Identifier: MPL-2.0
// Animated scenes of glTF: supported motions, and rejected files.
#include <nlohmann/json.hpp>
#include <random>

#include "batten/tests/io/sequences/sequence_file_helpers.h"

using namespace batten_test;
using Catch::Matchers::Contains;
using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace {

fs::path gltf_folder(const std::string& name) { return scratch("gltf/" + name); }

std::string base64(const std::string& bytes) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k)
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? letters[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

/// A scene of one triangle, extended by tests.
struct Scene {
  Json root = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
      "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {}}]}]})");
  std::string data;

  template <class T>
  int add(const std::vector<T>& values, const std::string& type, size_t components, int component) {
    data.resize((data.size() + 3) / 4 * 4, '\0');
    Json& views = root["bufferViews"];
    views.push_back(
        {{"buffer", 0}, {"byteOffset", data.size()}, {"byteLength", values.size() * sizeof(T)}});
    data.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    Json& accessors = root["accessors"];
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"componentType", component},
                         {"count", values.size() / components},
                         {"type", type}});
    return static_cast<int>(accessors.size()) - 1;
  }
  int scalars(const std::vector<float>& v) { return add(v, "SCALAR", 1, 5126); }
  int vectors(const std::vector<float>& v) { return add(v, "VEC3", 3, 5126); }
  int quaternions(const std::vector<float>& v) { return add(v, "VEC4", 4, 5126); }

  Json& primitive() { return root["meshes"][0]["primitives"][0]; }
  void move(int node, const std::string& path, int input, int output, const std::string& between) {
    Json& animation = root["animations"][0];
    animation["samplers"].push_back(
        {{"input", input}, {"output", output}, {"interpolation", between}});
    animation["channels"].push_back({{"sampler", animation["samplers"].size() - 1},
                                     {"target", {{"node", node}, {"path", path}}}});
  }
  fs::path write(const fs::path& path) {
    root["buffers"][0] = {{"byteLength", data.size()},
                          {"uri", "data:application/octet-stream;base64," + base64(data)}};
    put_bytes(path, root.dump());
    return path;
  }
};

Scene triangle() {
  Scene scene;
  scene.primitive()["attributes"]["POSITION"] = scene.vectors({0, 0, 0, 1, 0, 0, 0, 1, 0});
  return scene;
}

MeshSequence read_at(const fs::path& path, double rate, const std::string& animation = "") {
  SequenceOptions options;
  options.frames_per_second = rate;
  options.animation = animation;
  return read_frames(path, options);
}

}  // namespace

TEST_CASE("nodes of a scene move by their keys", "[io][sequences]") {
  const fs::path folder = gltf_folder("nodes");
  Scene scene = triangle();
  // The mesh is a child of a node that rotates by 90 degrees, below one with stepped animation and
  // one that is scaled.
  scene.root["nodes"] = Json::parse(
      R"([{"children": [1], "scale": [2, 2, 2]}, {"children": [2], "translation": [5, 0, 0]},
          {"mesh": 0}])");
  const float h = std::sqrt(0.5f);
  const int times = scene.scalars({0, 1});
  scene.move(2, "rotation", times, scene.quaternions({0, 0, 0, 1, 0, 0, -h, -h}), "LINEAR");
  scene.move(1, "translation", times, scene.vectors({1, 0, 0, 3, 0, 0}), "STEP");
  const MeshSequence s = read_at(scene.write(folder / "a.gltf"), 2);
  REQUIRE(s.times == std::vector<double>{0, 0.5, 1});
  // Vertex 1 at (1, 0, 0), rotated by 0, 45, 90 degrees (the shorter rotation, though the key has
  // the opposite sign), translated by 1, 1, 3, scaled by 2.
  CHECK((s.frames[0].row(1) - Vec3(4, 0, 0).transpose()).norm() < 1e-6);
  CHECK((s.frames[1].row(1) - 2 * Vec3(1 + h, h, 0).transpose()).norm() < 1e-6);
  CHECK((s.frames[2].row(1) - Vec3(6, 2, 0).transpose()).norm() < 1e-6);
  CHECK(read_at(folder / "a.gltf", 0).times == std::vector<double>{0, 1});
}

TEST_CASE("cubic splines follow their tangents", "[io][sequences]") {
  Scene scene = triangle();
  // x = t³ - t on [0, 2], y = t: tangents 3t² - 1.
  const int times = scene.scalars({0, 2});
  scene.move(0, "translation", times,
             scene.vectors({9, 9, 9, 0, 0, 0, -1, 1, 0, 11, 1, 0, 6, 2, 0, 9, 9, 9}),
             "CUBICSPLINE");
  const MeshSequence s = read_at(scene.write(gltf_folder("cubic") / "a.gltf"), 4);
  REQUIRE(s.frame_count() == 9);
  for (int k = 0; k < 9; ++k) {
    const double t = s.times[k];
    CHECK((s.frames[k].row(0) - Vec3(t * t * t - t, t, 0).transpose()).norm() < 1e-6);
  }
}

TEST_CASE("skins blend joints and ignore the node's own transform", "[io][sequences]") {
  Scene scene = triangle();
  scene.root["nodes"] = Json::parse(
      R"([{"mesh": 0, "skin": 0, "translation": [100, 0, 0]}, {"translation": [1, 0, 0]}, {}])");
  scene.root["scenes"][0]["nodes"] = {0, 1, 2};
  std::vector<float> inverse(32, 0.f);
  for (size_t m = 0; m < 2; ++m)
    for (size_t i = 0; i < 4; ++i) inverse[16 * m + 5 * i] = 1;
  inverse[12] = -1;  // the bind pose of the first joint is x = 1
  scene.root["skins"] = {
      {{"joints", {1, 2}}, {"inverseBindMatrices", scene.add(inverse, "MAT4", 16, 5126)}}};
  scene.primitive()["attributes"]["JOINTS_0"] =
      scene.add(std::vector<std::uint8_t>{0, 0, 0, 0, 0, 1, 0, 0, 1, 7, 0, 0}, "VEC4", 4, 5121);
  // Bytes as fractions; 51 / 255 is a fifth. The unused joint 7 has no weight.
  const int weights = scene.add(
      std::vector<std::uint8_t>{255, 0, 0, 0, 51, 204, 0, 0, 255, 0, 0, 0}, "VEC4", 4, 5121);
  scene.root["accessors"][weights]["normalized"] = true;
  scene.primitive()["attributes"]["WEIGHTS_0"] = weights;
  const int times = scene.scalars({0, 1});
  scene.move(1, "translation", times, scene.vectors({1, 0, 0, 1, 0, 10}), "LINEAR");
  const fs::path file = scene.write(gltf_folder("skin") / "a.gltf");
  const MeshSequence s = read_at(file, 1);
  REQUIRE(s.frame_count() == 2);
  CHECK((s.frames[0] - (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished()).norm() < 1e-6);
  CHECK((s.frames[1] - (Points(3, 3) << 0, 0, 10, 1, 0, 2, 0, 1, 0).finished()).norm() < 1e-6);
}

TEST_CASE("morph targets, sparse ones too, add up", "[io][sequences]") {
  Scene scene = triangle();
  const int first = scene.vectors({0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int rows = scene.add(std::vector<std::uint16_t>{2}, "SCALAR", 1, 5123);
  const int values = scene.vectors({0, 4, 0});
  scene.root["accessors"].push_back({{"componentType", 5126},
                                     {"count", 3},
                                     {"type", "VEC3"},
                                     {"sparse",
                                      {{"count", 1},
                                       {"indices", {{"bufferView", rows}, {"componentType", 5123}}},
                                       {"values", {{"bufferView", values}}}}}});
  const size_t sparse = scene.root["accessors"].size() - 1;
  scene.primitive()["targets"] = {{{"POSITION", first}}, {{"POSITION", sparse}}};
  scene.root["meshes"][0]["weights"] = {0.5, 0};
  const int times = scene.scalars({1, 2});
  scene.move(0, "weights", times, scene.scalars({0, 0, 1, 0.5f}), "LINEAR");
  const fs::path folder = gltf_folder("morph");
  const MeshSequence s = read_at(scene.write(folder / "a.gltf"), 2);
  CHECK(s.times == std::vector<double>{1, 1.5, 2});
  CHECK((s.frames[0].row(2) - Vec3(0, 1, 0).transpose()).norm() < 1e-6);
  CHECK((s.frames[1].row(2) - Vec3(0, 2, 0.5).transpose()).norm() < 1e-6);
  CHECK((s.frames[2].row(2) - Vec3(0, 3, 1).transpose()).norm() < 1e-6);
  scene.root.erase("animations");
  const MeshSequence still = read_at(scene.write(folder / "b.gltf"), 2);
  REQUIRE(still.frame_count() == 1);
  CHECK(still.frames[0](0, 2) == 0.5);
}

TEST_CASE("seams are one chain of nodes while their sides stay together", "[io][sequences]") {
  const fs::path folder = gltf_folder("seams");
  Scene scene;
  // Two triangles with coincident edges, as four plus two vertices.
  scene.primitive()["attributes"]["POSITION"] =
      scene.vectors({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0});
  CHECK(read_frames(scene.write(folder / "a.gltf")).node_count() == 4);
  SequenceOptions apart;
  apart.weld_seams = false;
  CHECK(read_frames(folder / "a.gltf", apart).node_count() == 6);
  // Vertex 3 leaves vertex 2 in the last key: whichever frames are read, these are two nodes.
  scene.primitive()["targets"] = {
      {{"POSITION", scene.vectors({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0})}}};
  const int times = scene.scalars({0, 1, 2});
  scene.move(0, "weights", times, scene.scalars({0, 0, 1}), "LINEAR");
  SequenceOptions first;
  first.last = 1;
  const MeshSequence s = read_frames(scene.write(folder / "b.gltf"), first);
  CHECK(s.frame_count() == 1);
  CHECK(s.node_count() == 5);
  CHECK(faces_of(s.shells) == std::vector<std::vector<int>>{{0, 1, 2}, {3, 1, 4}});
}

TEST_CASE("strips, fans and several parts are one mesh", "[io][sequences]") {
  Scene scene = triangle();
  const int square = scene.vectors({3, 0, 0, 4, 0, 0, 3, 1, 0, 4, 1, 0});
  const int indices = scene.add(std::vector<std::uint8_t>{0, 1, 3, 2}, "SCALAR", 1, 5121);
  Json& primitives = scene.root["meshes"][0]["primitives"];
  primitives.push_back({{"attributes", {{"POSITION", square}}}, {"mode", 5}});
  primitives.push_back({{"attributes", {{"POSITION", square}}}, {"mode", 6}, {"indices", indices}});
  primitives.push_back({{"attributes", {{"POSITION", square}}}, {"mode", 1}});
  SequenceOptions apart;
  apart.weld_seams = false;
  const fs::path file = scene.write(gltf_folder("strips") / "a.gltf");
  const MeshSequence s = read_frames(file, apart);
  CHECK(faces_of(s.shells) ==
        std::vector<std::vector<int>>{{0, 1, 2}, {3, 4, 5}, {5, 4, 6}, {7, 8, 10}, {7, 10, 9}});
}

TEST_CASE("whole numbers stand for fractions where they are normalized", "[io][sequences]") {
  Scene scene = triangle();
  scene.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  // Rows of eight bytes, six of them used.
  const int position = scene.add(
      std::vector<std::int16_t>{0, 0, 0, 9, 32767, 0, 0, 9, -32768, 32767, 0, 9}, "VEC3", 4, 5122);
  scene.root["accessors"][position]["normalized"] = true;
  scene.root["bufferViews"][position]["byteStride"] = 8;
  scene.primitive()["attributes"]["POSITION"] = position;
  const MeshSequence s = read_frames(scene.write(gltf_folder("quantized") / "a.gltf"));
  CHECK(s.frames[0] == (Points(3, 3) << 0, 0, 0, 1, 0, 0, -1, 1, 0).finished());
}

TEST_CASE("clips are chosen by name or number", "[io][sequences]") {
  Scene scene = triangle();
  const int times = scene.scalars({0, 1});
  scene.move(0, "translation", times, scene.vectors({0, 0, 0, 1, 0, 0}), "LINEAR");
  scene.root["animations"].push_back(scene.root["animations"][0]);
  scene.root["animations"][0]["name"] = "Run";
  scene.root["animations"][1]["name"] = "1";
  scene.root["animations"][1]["samplers"][0]["output"] = scene.vectors({0, 0, 0, 2, 0, 0});
  const fs::path file = scene.write(gltf_folder("clips") / "a.gltf");
  CHECK(read_at(file, 1).frames[1](0, 0) == 1);
  CHECK(read_at(file, 1, "Run").frames[1](0, 0) == 1);
  CHECK(read_at(file, 1, "2").frames[1](0, 0) == 2);
  CHECK(read_at(file, 1, "1").frames[1](0, 0) == 2);  // a name takes precedence over a number
  CHECK_THAT(error_message([&] { read_at(file, 1, "Walk"); }),
             Contains("found no animation 'Walk', expected one of: 1 Run, 2 1"));
  CHECK_THAT(error_message([&] { read_at(file, -1); }), Contains("expected a rate above 0"));
  CHECK_THAT(error_message([&] { read_at(file, 1e9); }), Contains("1e+06 at most"));
}

TEST_CASE("buffers are found in files, URIs and GLB", "[io][sequences]") {
  const fs::path folder = gltf_folder("buffers");
  Scene scene = triangle();
  scene.write(folder / "a.gltf");
  CHECK(read_frames(folder / "a.gltf").node_count() == 3);
  scene.root["buffers"][0]["uri"] = "my%20data.bin";
  put_bytes(folder / "b.gltf", scene.root.dump());
  CHECK_THAT(reading(folder / "b.gltf"),
             Contains("b.gltf: ") && Contains("my data.bin: found no such file"));
  put_bytes(folder / "my data.bin", scene.data);
  CHECK(read_frames(folder / "b.gltf").node_count() == 3);
  put_bytes(folder / "my data.bin", scene.data.substr(0, 20));
  CHECK_THAT(reading(folder / "b.gltf"), Contains("found 20 bytes in buffer 0, expected 36"));
  scene.root["buffers"][0]["uri"] = "data:application/octet-stream;base64,!!!!";
  put_bytes(folder / "c.gltf", scene.root.dump());
  CHECK_THAT(reading(folder / "c.gltf"), Contains("expected base64"));
  scene.root["buffers"][0].erase("uri");
  put_bytes(folder / "d.gltf", scene.root.dump());
  CHECK_THAT(reading(folder / "d.gltf"), Contains("found no data for buffer 0"));
}

TEST_CASE("damaged scenes are refused and named", "[io][sequences]") {
  const fs::path folder = gltf_folder("damaged");
  const auto refused = [&](auto change) {
    Scene scene = triangle();
    change(scene);
    return reading(scene.write(folder / "a.gltf"));
  };
  CHECK(refused([](Scene&) {}).empty());
  CHECK_THAT(refused([](Scene& s) { s.root["bufferViews"][0]["byteLength"] = 40; }),
             Contains("buffer view 0 ends at byte 40 of buffer 0, which has 36"));
  CHECK_THAT(refused([](Scene& s) { s.root["accessors"][0]["count"] = 4; }),
             Contains("accessor 0 has 4 elements, more than there is room for in the 36 bytes of "
                      "its buffer view"));
  CHECK_THAT(refused([](Scene& s) { s.root["accessors"][0]["count"] = 4e9; }),
             Contains("accessor 0"));
  CHECK_THAT(refused([](Scene& s) { s.root["accessors"][0]["byteOffset"] = 4; }),
             Contains("accessor 0 ends at byte 40 of its buffer view, which has 36"));
  CHECK_THAT(refused([](Scene& s) { s.root["bufferViews"][0]["byteStride"] = 4; }),
             Contains("found a stride of 4 bytes for accessor 0, expected 12 or more"));
  CHECK_THAT(refused([](Scene& s) { s.root["nodes"][0]["mesh"] = 4294967296; }),
             Contains("found 4294967296 as mesh"));
  CHECK_THAT(refused([](Scene& s) { s.root["accessors"][0]["type"] = "VEC2"; }),
             Contains("found 'VEC2' elements in accessor 0, expected 3 numbers"));
  CHECK_THAT(refused([](Scene& s) { s.root["accessors"][0]["componentType"] = 1; }),
             Contains("componentType 1 in accessor 0"));
  CHECK_THAT(refused([](Scene& s) { s.root["accessors"][0]["bufferView"] = 7; }),
             Contains("found the number 7 for one of 1 bufferViews"));
  CHECK_THAT(refused([](Scene& s) {
               s.primitive()["indices"] = s.scalars({0, 1, 3});
             }),
             Contains("found the vertex 3 in accessor 1"));
  CHECK_THAT(refused([](Scene& s) { s.primitive()["attributes"].erase("POSITION"); }),
             Contains("found no POSITION in primitive 0 of mesh 0"));
  CHECK_THAT(refused([](Scene& s) { s.primitive()["mode"] = 0; }), Contains("found no triangles"));
  CHECK_THAT(refused([](Scene& s) { s.root["nodes"][0]["mesh"] = 5; }),
             Contains("found the number 5 for one of 1 meshes"));
  CHECK_THAT(refused([](Scene& s) { s.root["nodes"][0]["children"] = {0}; }),
             Contains("a cycle of nodes"));
  CHECK_THAT(refused([](Scene& s) {
               s.root["nodes"] = Json::parse(R"([{"children": [1]}, {}, {"children": [1]}])");
             }),
             Contains("node 1 has two parents, 0 and 2"));
  CHECK_THAT(refused([](Scene& s) {
               s.root["nodes"][0]["translation"] = {1, 2};
             }),
             Contains("as translation, expected 3 numbers"));
  CHECK_THAT(refused([](Scene& s) { s.root["asset"]["version"] = "1.0"; }),
             Contains("found version '1.0' of glTF, expected 2.0"));
  for (const std::string name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression"})
    CHECK_THAT(refused([&](Scene& s) { s.root["extensionsRequired"] = {name}; }),
               Contains("needs the extension " + name));
  CHECK(refused([&](Scene& s) { s.root["extensionsRequired"] = {"KHR_materials_unlit"}; }).empty());
  CHECK_THAT(refused([](Scene& s) {
               s.root["accessors"][0].erase("bufferView");
               s.primitive()["extensions"]["KHR_draco_mesh_compression"] = Json::object();
             }),
             Contains("is compressed with KHR_draco_mesh_compression"));
  CHECK_THAT(refused([](Scene& s) {
               s.primitive()["targets"] = {{{"POSITION", s.vectors({0, 0, 0})}}};
             }),
             Contains("found 1 elements of accessor 1") && Contains("expected 3 as its vertices"));
  const auto moved = [&](std::vector<float> times, std::vector<float> values) {
    return refused([&](Scene& s) {
      const int input = s.scalars(times);
      s.move(0, "translation", input, s.vectors(values), "LINEAR");
    });
  };
  CHECK(moved({0, 1}, {0, 0, 0, 1, 1, 1}).empty());
  CHECK_THAT(moved({0, 0}, {0, 0, 0, 1, 1, 1}), Contains("found the time 0 of key 2"));
  CHECK_THAT(moved({0, 1}, {0, 0, 0}), Contains("found 1 values for 2 keys"));
  CHECK_THAT(moved({0, 1}, {0, 0, 0, NAN, 1, 1}), Contains("not finite"));
  put_bytes(folder / "b.gltf", "{");
  CHECK_THAT(reading(folder / "b.gltf"), Contains("found no glTF, expected JSON text or a GLB"));
  put_bytes(folder / "b.gltf", std::string(100000, '['));
  CHECK_THAT(reading(folder / "b.gltf"), Contains("b.gltf"));
}

TEST_CASE("no damage to a GLB brings the reader down", "[io][sequences]") {
  const fs::path folder = gltf_folder("fuzz");
  Scene scene = triangle();
  write_sequence(folder / "a.glb", wave(3));
  const fs::path fox = optional_data("seq-fox/Fox.glb");
  std::vector<std::string> files{bytes_in(folder / "a.glb")};
  if (!fox.empty()) files.push_back(bytes_in(fox));
  std::mt19937 random(7);
  int refused = 0, all = 0;
  for (const std::string& good : files)
    for (int round = 0; round < 400; ++round, ++all) {
      std::string bad = good;
      const size_t begin = 20, json = number_in<std::uint32_t>(good, 12);
      if (round % 8 == 0)
        bad.resize(random() % bad.size());
      else
        // Corrupts digits and punctuation of the JSON, and bytes of the numbers.
        for (int k = 0; k < 3 && !bad.empty(); ++k) {
          const size_t at = round % 2 ? begin + random() % json : random() % bad.size();
          bad[at] = round % 4 == 1 ? static_cast<char>('0' + random() % 10)
                                   : static_cast<char>(random() % 256);
        }
      put_bytes(folder / "b.glb", bad);
      SequenceOptions options;
      options.last = 1;
      options.frames_per_second = 2;
      refused += !error_message([&] { read_frames(folder / "b.glb", options); }).empty();
    }
  INFO(refused << " of " << all);
  CHECK(refused > all / 4);
}

TEST_CASE("real clips are baked as others bake them", "[io][sequences]") {
  struct Clip {
    std::string scene, name, cache;
    double seconds;
    int frames, nodes;
  };
  const Clip clips[] = {
      {"seq-fox/Fox.glb", "Survey", "seq-fox/survey/fox_survey.pc2", 3.4166667461395264, 40, 290},
      {"seq-fox/Fox.glb", "Walk", "seq-fox/walk/fox_walk.pc2", 0.7083333134651184, 24, 290},
      {"seq-fox/Fox.glb", "Run", "seq-fox/run/fox_run.pc2", 1.1583333015441895, 24, 290},
      {"seq-riggedfigure/RiggedFigure.glb", "1", "seq-riggedfigure/frames/figure.pc2", 1.25, 30,
       130}};
  int read = 0;
  for (const Clip& clip : clips) {
    const fs::path scene = optional_data(clip.scene), cache = optional_data(clip.cache);
    if (scene.empty() || cache.empty()) continue;
    INFO(clip.name);
    const MeshSequence ours = read_at(scene, (clip.frames - 1) / clip.seconds, clip.name);
    CHECK(ours.node_count() == clip.nodes);
    CHECK(ours.times.back() == Approx(clip.seconds));
    const MeshSequence theirs = read_frames(cache);
    CHECK(faces_of(ours.shells) == faces_of(theirs.shells));
    CHECK(apart(ours, theirs) < 3e-7 * size_of(theirs));
    ++read;
  }
  if (read == 0) WARN("no real scenes beside the project: skipped");
}
