// What a result promised and does not keep.
#pragma once

#include <string>

namespace batten {

/// A promise that the result does not keep.
struct MissedPromise {
  std::string what;    ///< "surface.min_jacobian_ratio"
  std::string detail;  ///< "is 0.01, promised at least 0.05"
};

}  // namespace batten
