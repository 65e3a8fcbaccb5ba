#include "batten/apps/commands/lines/comb_panels.h"

#include "batten/core/index.h"

namespace batten {
namespace {

/// The counts of extrema and inflections, as words for a caption.
std::string counts(const std::vector<HermiteCurve>& curves) {
  int extrema = 0, inflections = 0;
  for (const HermiteCurve& curve : curves) {
    const Fairness f = fairness(curve);
    extrema += f.extrema;
    inflections += f.inflections;
  }
  const auto said = [](int n, const std::string& noun, const std::string& many) {
    return std::to_string(n) + " " + (n == 1 ? noun : many);
  };
  return said(extrema, "extremum", "extrema") + ", " +
         said(inflections, "inflection", "inflections");
}

}  // namespace

CombPicture comb_panels(const std::vector<FairedResult>& results, const FairScene& scene,
                        const CombPictureRule& rule) {
  CombPicture picture;
  picture.unit = scene.unit;
  picture.view = rule.view;
  const auto add = [&](size_t state, const std::string& title) -> CombPanel& {
    CombPanel panel;
    for (const FairedResult& result : results) {
      if (result.has_curve()) panel.curves.push_back(result.states[state]);
      if (rule.points || !result.has_curve())
        panel.points.insert(panel.points.end(), result.points.begin(), result.points.end());
    }
    panel.title =
        (rule.title.empty() ? "" : rule.title + ", ") + title + ": " + counts(panel.curves);
    picture.panels.push_back(std::move(panel));
    return picture.panels.back();
  };
  const auto& stages = scene.stages;
  if (rule.show == CombPictureRule::Show::Combs) {
    add(0, "before");
    add(stages.size(), "after");
  } else {
    add(0, "as given");
    for (size_t s = 0; s < stages.size(); ++s) {
      std::string names = stages[s].name;
      const size_t first = s;
      while (stages[s].local() && s + 1 < stages.size() && stages[s + 1].local())
        names += ", " + stages[++s].name;
      CombPanel& panel = add(s + 1, names);
      for (size_t k = first; k <= s; ++k)
        if (stages[k].brush)
          panel.spheres.emplace_back(stages[k].brush->at, stages[k].brush->radius);
    }
  }
  picture.scale_panel = count_of(picture.panels) - 1;
  return picture;
}

}  // namespace batten
