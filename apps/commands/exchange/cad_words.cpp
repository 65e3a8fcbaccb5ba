#include "batten/apps/commands/exchange/cad_words.h"

#include <algorithm>

#include "batten/core/index.h"
#include "batten/core/words.h"
#include "batten/io/files/length_units.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

constexpr size_t kMost = 20;

std::string closed_words(const CadContents& c) {
  if (c.shells == 0) return "";
  return c.closed_shells == c.shells ? ", closed"
                                     : ", " + std::to_string(c.closed_shells) + " of " +
                                           counted(c.shells, "shell") + " closed";
}

std::string product_row(const CadProduct& product) {
  std::string text(2 + 2 * static_cast<size_t>(product.level), ' ');
  text += product.assembly ? "assembly" : "part";
  text += product.name.empty() ? " without a name" : " '" + product.name + "'";
  if (!product.place.empty()) text += " as '" + product.place + "'";
  if (!product.assembly) {
    if (product.solids) text += ", " + counted(product.solids, "solid");
    if (product.faces || !product.curves) text += ", " + counted(product.faces, "face");
    if (product.curves) text += ", " + counted(product.curves, "curve");
  }
  if (!product.shift.isZero()) text += ", at " + at(product.shift);
  if (product.turn_deg > 1e-9) text += ", turned by " + number(product.turn_deg) + " degrees";
  if (!product.colour.empty()) text += ", " + product.colour;
  return text + "\n";
}

/// "3 faces, 1 curve".
std::string use_words(const CadUse& use) {
  std::string text;
  for (const auto& [count, noun] :
       {std::pair(use.products, "product"), std::pair(use.solids, "solid"),
        std::pair(use.faces, "face"), std::pair(use.edges, "edge"), std::pair(use.curves, "curve")})
    if (count > 0) text += (text.empty() ? "" : ", ") + counted(count, noun);
  return text;
}

std::string uses_text(const std::string& what, const std::vector<CadUse>& uses) {
  std::string text;
  for (size_t i = 0; i < std::min(uses.size(), kMost); ++i)
    text += "  " + what + " '" + uses[i].name + "': " + use_words(uses[i]) + "\n";
  if (uses.size() > kMost) text += "  and " + std::to_string(uses.size() - kMost) + " more\n";
  return text;
}

}  // namespace

std::string contents_words(const CadContents& c) {
  std::string text = c.format + ", " + (c.unit_stated ? "in " : "taken as ") +
                     unit_words(c.unit_in_metres) + ": " + counted(count_of(c.products), "product");
  if (c.solids) text += ", " + counted(c.solids, "solid");
  if (c.faces) text += ", " + counted(c.faces, "face") + closed_words(c);
  if (c.curves) text += ", " + counted(c.curves, "curve");
  if (!c.names.empty()) text += "; " + counted(count_of(c.names), "name");
  if (!c.colours.empty()) text += "; " + counted(count_of(c.colours), "colour");
  if (!c.layers.empty()) text += "; " + counted(count_of(c.layers), "layer");
  return text;
}

std::string contents_text(const CadContents& c) {
  std::string text = contents_words(c) + "\n";
  for (const std::string& note : c.notes) text += "  " + note + "\n";
  const std::string unit = unit_words(c.unit_in_metres);
  text += "  size " + number(c.size) + " " + unit;
  if (c.faces) text += ", area " + number(c.area) + " " + unit + "²";
  if (c.solids) text += ", volume " + number(c.volume) + " " + unit + "³";
  text += "\n";
  for (size_t i = 0; i < std::min(c.products.size(), kMost); ++i)
    text += product_row(c.products[i]);
  if (c.products.size() > kMost)
    text += "  and " + std::to_string(c.products.size() - kMost) + " more\n";
  return text + uses_text("name", c.names) + uses_text("colour", c.colours) +
         uses_text("layer", c.layers);
}

std::string lost_words(const std::vector<CadUse>& before, const std::vector<CadUse>& after,
                       bool edges) {
  std::string text;
  size_t lost = 0;
  for (const CadUse& use : before) {
    const auto at = std::find_if(after.begin(), after.end(),
                                 [&](const CadUse& other) { return other.name == use.name; });
    const auto count = [&](const CadUse& one) {
      return one.solids + one.faces + one.curves + (edges ? one.edges : 0);
    };
    const int all = count(use), kept = at == after.end() ? 0 : count(*at);
    if (kept >= all) continue;
    if (++lost <= 5)
      text += (text.empty() ? "'" : ", '") + use.name + "' (" + std::to_string(kept) + " of " +
              std::to_string(all) + ")";
  }
  return lost > 5 ? text + " and " + std::to_string(lost - 5) + " more" : text;
}

}  // namespace batten
