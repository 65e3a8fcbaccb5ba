#include "batten/apps/commands/exchange/cad_summary.h"

#include <algorithm>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

constexpr size_t kMost = 20;

std::string describe_closedness(const CadContents& c) {
  if (c.shells == 0) return "";
  return c.closed_shells == c.shells ? ", closed"
                                     : ", " + std::to_string(c.closed_shells) + " of " +
                                           format_count(c.shells, "shell") + " closed";
}

std::string product_row(const CadProduct& product) {
  std::string text(2 + 2 * static_cast<size_t>(product.level), ' ');
  text += product.assembly ? "assembly" : "part";
  text += product.name.empty() ? " without a name" : " '" + product.name + "'";
  if (!product.instance_name.empty()) text += " as '" + product.instance_name + "'";
  if (!product.assembly) {
    if (product.solids) text += ", " + format_count(product.solids, "solid");
    if (product.faces || !product.curves) text += ", " + format_count(product.faces, "face");
    if (product.curves) text += ", " + format_count(product.curves, "curve");
  }
  if (!product.translation.isZero()) text += ", at " + format_point(product.translation);
  if (product.rotation_deg > 1e-9)
    text += ", rotated by " + format_number(product.rotation_deg) + " degrees";
  if (!product.colour.empty()) text += ", " + product.colour;
  return text + "\n";
}

/// "3 faces, 1 curve".
std::string describe_use(const CadAttribute& use) {
  std::string text;
  for (const auto& [count, noun] :
       {std::pair(use.products, "product"), std::pair(use.solids, "solid"),
        std::pair(use.faces, "face"), std::pair(use.edges, "edge"), std::pair(use.curves, "curve")})
    if (count > 0) text += (text.empty() ? "" : ", ") + format_count(count, noun);
  return text;
}

std::string uses_text(const std::string& what, const std::vector<CadAttribute>& uses) {
  std::string text;
  for (size_t i = 0; i < std::min(uses.size(), kMost); ++i)
    text += "  " + what + " '" + uses[i].name + "': " + describe_use(uses[i]) + "\n";
  if (uses.size() > kMost) text += "  and " + std::to_string(uses.size() - kMost) + " more\n";
  return text;
}

}  // namespace

std::string contents_line(const CadContents& c) {
  std::string text = c.format + ", " + (c.unit_stated ? "in " : "no unit, assumed ") +
                     format_unit(c.unit_in_metres) + ": " +
                     format_count(isize(c.products), "product");
  if (c.solids) text += ", " + format_count(c.solids, "solid");
  if (c.faces) text += ", " + format_count(c.faces, "face") + describe_closedness(c);
  if (c.curves) text += ", " + format_count(c.curves, "curve");
  if (!c.names.empty()) text += "; " + format_count(isize(c.names), "name");
  if (!c.colours.empty()) text += "; " + format_count(isize(c.colours), "colour");
  if (!c.layers.empty()) text += "; " + format_count(isize(c.layers), "layer");
  return text;
}

std::string contents_text(const CadContents& c) {
  std::string text = contents_line(c) + "\n";
  for (const std::string& note : c.notes) text += "  " + note + "\n";
  const std::string unit = format_unit(c.unit_in_metres);
  text += "  size " + format_number(c.size) + " " + unit;
  if (c.faces) text += ", area " + format_number(c.area) + " " + unit + "²";
  if (c.solids) text += ", volume " + format_number(c.volume) + " " + unit + "³";
  text += "\n";
  for (size_t i = 0; i < std::min(c.products.size(), kMost); ++i)
    text += product_row(c.products[i]);
  if (c.products.size() > kMost)
    text += "  and " + std::to_string(c.products.size() - kMost) + " more\n";
  return text + uses_text("name", c.names) + uses_text("colour", c.colours) +
         uses_text("layer", c.layers);
}

std::string missing_names(const std::vector<CadAttribute>& before,
                          const std::vector<CadAttribute>& after, bool edges) {
  std::string text;
  size_t lost = 0;
  for (const CadAttribute& use : before) {
    const auto at = std::find_if(after.begin(), after.end(),
                                 [&](const CadAttribute& other) { return other.name == use.name; });
    const auto count = [&](const CadAttribute& one) {
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
