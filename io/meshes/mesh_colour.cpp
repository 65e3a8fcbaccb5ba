#include "batten/io/meshes/mesh_colour.h"

#include <cctype>
#include <cstdio>

#include "batten/core/errors.h"

namespace batten {

std::optional<std::array<int, 3>> mesh_colour(const std::string& hex) {
  if (hex.empty()) return std::nullopt;
  const auto digit = [](unsigned char c) { return std::isxdigit(c) != 0; };
  bool sound = hex.size() == 7 && hex[0] == '#';
  for (size_t i = 1; i < hex.size(); ++i)
    sound = sound && digit(static_cast<unsigned char>(hex[i]));
  if (!sound) throw InputError("found the colour '" + hex + "', expected one as '#ff8800'");
  std::array<int, 3> colour{};
  for (size_t c = 0; c < 3; ++c) colour[c] = std::stoi(hex.substr(1 + 2 * c, 2), nullptr, 16);
  return colour;
}

std::string hex_of(const std::array<int, 3>& colour) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", colour[0] & 255, colour[1] & 255,
                colour[2] & 255);
  return text;
}

}  // namespace batten
