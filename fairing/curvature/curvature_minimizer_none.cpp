#include "batten/core/errors.h"
#include "batten/fairing/curvature/curvature_minimizer.h"

namespace batten {

bool have_curvature_fairing() { return false; }

CurvatureMinimizationResult minimize(const CurvatureMinimization&) {
  throw InputError(
      "Batten was built without Ceres: curves of least curvature need it (BATTEN_WITH_CERES)");
}

}  // namespace batten
