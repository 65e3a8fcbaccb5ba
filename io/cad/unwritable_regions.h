// What the writers of STEP files say of regions that they cannot write.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/core/errors.h"
#include "batten/skinning/region/skinned_region.h"

namespace batten {

/// Regions whose faces no reader would find in the file as they are.
class UnwritableRegions : public Error {
 public:
  UnwritableRegions(const std::string& what, std::vector<const SkinnedRegion*> regions)
      : Error(what), regions_(std::move(regions)) {}
  const std::vector<const SkinnedRegion*>& regions() const { return regions_; }

 private:
  std::vector<const SkinnedRegion*> regions_;
};

}  // namespace batten
