// A line of a model as one of its regions has it, on the numbers of the whole model. Internal.
#pragma once

#include <vector>

#include "batten/skinning/model/join_edge.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

// Keeps what JoinEdge needs of a model; the sides it returns live no longer.
class LineSides {
 public:
  explicit LineSides(const ModelLayout& model)
      : regions_(layouts(model)), numbers_(all_numbers(model)), sides_(regions_, numbers_) {}

  JoinEdge operator()(const JoinSide& side) { return sides_(side); }
  // The first side of a line.
  JoinEdge operator()(const ModelLine& line) {
    const LineSide& first = line.sides[0];
    return sides_({first.region, first.embedded, first.index, true});
  }
  const std::vector<const RegionLayout*>& regions() const { return regions_; }
  const std::vector<RegionNumbers>& numbers() const { return numbers_; }

  // Visits the hats of an embedded line, with the sum of each one's weights.
  template <class Visit>
  static void over_hats(const JoinEdge& a, const JoinEdge& b, const Visit& visit) {
    for (const auto& hat : hats(tie_stations(a, b), a.closed(), {true, true})) {
      double weight = 0;
      for (const HatPoint& p : hat) weight += p.weight;
      visit(hat, weight);
    }
  }

 private:
  static std::vector<const RegionLayout*> layouts(const ModelLayout& model) {
    std::vector<const RegionLayout*> regions;
    for (const auto& region : model.regions()) regions.push_back(region.get());
    return regions;
  }
  static std::vector<RegionNumbers> all_numbers(const ModelLayout& model) {
    std::vector<RegionNumbers> numbers;
    for (int r = 0; r < model.region_count(); ++r) numbers.push_back(model.numbers(r));
    return numbers;
  }

  std::vector<const RegionLayout*> regions_;
  std::vector<RegionNumbers> numbers_;
  JoinEdges sides_;
};

}  // namespace batten
