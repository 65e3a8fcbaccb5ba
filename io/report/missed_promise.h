// The promises that a result does not keep.
#pragma once

#include <string>

namespace batten {

/// A promise that the result does not keep.
struct MissedPromise {
  std::string what;    ///< name of the number in the report: "surface.min_jacobian_ratio"
  std::string detail;  ///< how it is broken: "is 0.01, promised at least 0.05"
};

}  // namespace batten
