#include "batten/io/decks/frd_results.h"

#include <charconv>
#include <fstream>
#include <map>
#include <string>

#include "batten/core/errors.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

// A line is " -1", ten columns of a number, twelve for each value.
constexpr size_t kKey = 3, kNumber = 10, kValue = 12;

// Trimmed, in any locale.
template <class Value>
Value parsed(std::string_view text, const std::string& at) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\r')) text.remove_suffix(1);
  Value value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw InputError(at + "found " + in_quotes(text) + ", expected a number");
  return value;
}

}  // namespace

FrdResults read_frd(const std::filesystem::path& path) {
  require_input_file(path, "results of CalculiX (.frd)");
  std::ifstream in(path);
  std::map<int, FrdResults::Node> nodes;
  enum class Block { None, Nodes, Displacement, Stress } block = Block::None;
  bool any = false;
  int row = 0;
  for (std::string line; std::getline(in, line);) {
    ++row;
    const std::string key = line.substr(0, std::min<size_t>(line.size(), 6));
    if (key == "    2C") {
      block = Block::Nodes;
    } else if (key.starts_with(" -4")) {
      const std::string name = line.substr(std::min<size_t>(line.size(), 5), 8);
      block = name.starts_with("DISP")     ? Block::Displacement
              : name.starts_with("STRESS") ? Block::Stress
                                           : Block::None;
    } else if (key.starts_with(" -3")) {
      block = Block::None;
    } else if (key.starts_with(" -1") && block != Block::None) {
      const std::string at = place_prefix(path.string(), {row, 1});
      const size_t count = block == Block::Stress ? 6 : 3;
      if (line.size() < kKey + kNumber + count * kValue)
        throw InputError(at + "found a short line, expected a node and " + std::to_string(count) +
                         " numbers");
      FrdResults::Node& node = nodes[parsed<int>(std::string_view(line).substr(kKey, kNumber), at)];
      double v[6] = {};
      for (size_t k = 0; k < count; ++k)
        v[k] =
            parsed<double>(std::string_view(line).substr(kKey + kNumber + k * kValue, kValue), at);
      if (block == Block::Nodes) node.x = {v[0], v[1], v[2]};
      if (block == Block::Displacement) node.displacement = {v[0], v[1], v[2]};
      if (block == Block::Stress)
        node.stress << v[0], v[3], v[5], v[3], v[1], v[4], v[5], v[4], v[2];
      any = any || block == Block::Displacement;
    }
  }
  if (!any) throw InputError(path.string() + ": found no displacements, expected those of a step");
  FrdResults results;
  for (const auto& [number, node] : nodes) results.nodes.push_back(node);
  return results;
}

}  // namespace batten
