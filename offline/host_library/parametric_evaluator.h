#ifndef RAYGRID_HOST_LIBRARY_PARAMETRIC_EVALUATOR_H
#define RAYGRID_HOST_LIBRARY_PARAMETRIC_EVALUATOR_H

#include <memory>

#include "camera/camera_model.h"
#include "host_library/evaluator.h"

namespace raygrid::host {

/// For central models whose projections are formulas. They are computed in
/// double precision.
template <typename Scalar>
std::shared_ptr<const Evaluator<Scalar>> MakeParametricEvaluator(
    std::shared_ptr<const CameraModel> model);

}  // namespace raygrid::host

#endif  // RAYGRID_HOST_LIBRARY_PARAMETRIC_EVALUATOR_H
