// `t NAME INTEGERS/REALS/TEXTS …`, as OpenSubdiv has them: integers, reals, then texts.
#include "batten/io/meshes/obj_tags.h"

#include <algorithm>
#include <map>
#include <string>

#include "batten/core/errors.h"
#include "batten/core/isize.h"

namespace batten {
namespace {

/// One record, in its parts.
struct Tag {
  std::string_view name;
  std::vector<long> integers;
  std::vector<double> reals;
  std::vector<std::string_view> texts;
};

class TagReader {
 public:
  explicit TagReader(TextMeshContent& mesh) : mesh_(mesh), file_(mesh.file) {
    for (int f = 0; f < mesh.shells.face_count(); ++f) {
      const auto nodes = mesh.shells.corners(f);
      for (size_t i = 0; i < nodes.size(); ++i) {
        ++faces_at_[nodes[i]];
        ++faces_of_edge_[std::minmax(nodes[i], nodes[(i + 1) % nodes.size()])];
      }
    }
  }

  void read(const std::vector<std::string_view>& words) {
    const Tag tag = parts_of(words);
    if (tag.name == "crease") {
      crease(words, tag);
    } else if (tag.name == "corner") {
      corner(words, tag);
    } else if (tag.name == "interpolateboundary") {
      boundary(words, tag);
    } else if (tag.name == "creasemethod" || tag.name == "smoothtriangles") {
      if (tag.texts.size() != 1 || (tag.texts[0] != "normal" && tag.texts[0] != "catmark"))
        fail(words, "found " + all(words) + ", expected the usual way, 'normal' or 'catmark'");
    } else if (!tag.name.starts_with("facevarying")) {
      fail(words, "found the tag '" + std::string(tag.name) +
                      "', expected crease, corner or interpolateboundary");
    }
  }

 private:
  [[noreturn]] void fail(const std::vector<std::string_view>& words, const std::string& why) const {
    file_.fail(words.front(), why);
  }
  static std::string all(const std::vector<std::string_view>& words) {
    std::string text = "'t";
    for (const std::string_view word : words) text += " " + std::string(word);
    return text + "'";
  }

  Tag parts_of(const std::vector<std::string_view>& words) const {
    if (words.size() < 2)
      fail(words, "found a tag without counts, expected t NAME INTEGERS/REALS/TEXTS");
    std::array<long, 3> counts{};
    std::string_view rest = words[1];
    for (int part = 0; part < 3; ++part) {
      const size_t end = rest.find('/');
      counts[part] = file_.integer(rest.substr(0, end), "counts as 2/1/0");
      if ((end == std::string_view::npos) != (part == 2) || counts[part] < 0 ||
          counts[part] > static_cast<long>(words.size()))
        file_.fail(words[1], "found '" + std::string(words[1]) + "', expected counts as 2/1/0");
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    if (counts[0] + counts[1] + counts[2] != static_cast<long>(words.size()) - 2)
      file_.fail(words[1], "found " + std::to_string(words.size() - 2) + " words behind '" +
                               std::string(words[1]) + "', expected as many as it says");
    Tag tag{words[0], {}, {}, {}};
    for (size_t k = 2; k < words.size(); ++k) {
      const auto at = static_cast<long>(k) - 2;
      if (at < counts[0])
        tag.integers.push_back(file_.integer(words[k], "a whole number"));
      else if (at < counts[0] + counts[1])
        tag.reals.push_back(file_.real(words[k]));
      else
        tag.texts.push_back(words[k]);
    }
    return tag;
  }

  int node(const std::vector<std::string_view>& words, long number) const {
    const int count = mesh_.shells.node_count();
    if (number < 0 || number >= count)
      fail(words, "found the node " + std::to_string(number) + ", expected 0 to " +
                      std::to_string(count - 1) + ": nodes of tags count from 0");
    return static_cast<int>(number);
  }
  double sharpness(const std::vector<std::string_view>& words, double value) const {
    if (value < 0)
      fail(words, "found a sharpness of " + format_number(value) + ", expected 0 or more");
    return value;
  }

  void crease(const std::vector<std::string_view>& words, const Tag& tag) {
    if (tag.integers.size() != 2 || tag.reals.size() != 1)
      fail(words, "found " + all(words) + ", expected two nodes and a sharpness (2/1/0)");
    const int a = node(words, tag.integers[0]), b = node(words, tag.integers[1]);
    if (!faces_of_edge_.contains(std::minmax(a, b)))
      fail(words, "found a crease from node " + std::to_string(a) + " to " + std::to_string(b) +
                      ", expected an edge of a face: nodes of tags count from 0");
    mesh_.cage_tags.creases.push_back({a, b, sharpness(words, tag.reals[0])});
  }

  void corner(const std::vector<std::string_view>& words, const Tag& tag) {
    if (tag.integers.empty() || (tag.reals.size() != 1 && tag.reals.size() != tag.integers.size()))
      fail(words, "found " + all(words) + ", expected nodes, and a sharpness for each or for all");
    for (size_t k = 0; k < tag.integers.size(); ++k)
      mesh_.cage_tags.corners.push_back(
          {node(words, tag.integers[k]),
           sharpness(words, tag.reals.size() == 1 ? tag.reals[0] : tag.reals[k])});
  }

  /// 0: faces at rims are none; 1: rims and their corners are sharp, as ours are; 2: rims only.
  void boundary(const std::vector<std::string_view>& words, const Tag& tag) const {
    const long value = tag.integers.size() == 1 ? tag.integers[0] : -1;
    const bool rims = std::any_of(faces_of_edge_.begin(), faces_of_edge_.end(),
                                  [](const auto& edge) { return edge.second == 1; });
    const bool corners = std::any_of(faces_at_.begin(), faces_at_.end(),
                                     [](const auto& faces) { return faces.second == 1; });
    if (value == 1 || (value == 0 && !rims) || (value == 2 && !corners)) return;
    fail(words, "found " + all(words) +
                    ", expected 't interpolateboundary 1/0/0 1': rims of a cage and their corners "
                    "are sharp");
  }

  TextMeshContent& mesh_;
  const MeshSourceText& file_;
  std::map<std::pair<int, int>, int> faces_of_edge_;
  std::map<int, int> faces_at_;
};

}  // namespace

void ObjTags::finish(TextMeshContent& mesh) const {
  if (records_.empty()) return;
  try {
    TagReader reader(mesh);
    for (const auto& words : records_) reader.read(words);
  } catch (const InputError& problem) {
    // Only a reader that takes the mesh for a cage needs them.
    mesh.cage_problem = problem.what();
  }
}

}  // namespace batten
