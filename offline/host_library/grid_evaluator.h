#ifndef RAYGRID_HOST_LIBRARY_GRID_EVALUATOR_H
#define RAYGRID_HOST_LIBRARY_GRID_EVALUATOR_H

#include <memory>

#include "camera/camera_model.h"
#include "host_library/evaluator.h"

namespace raygrid::host {

/// For central-generic and noncentral-generic.
template <typename Scalar>
std::shared_ptr<const Evaluator<Scalar>> MakeGridEvaluator(
    std::shared_ptr<const CameraModel> model);

}  // namespace raygrid::host

#endif  // RAYGRID_HOST_LIBRARY_GRID_EVALUATOR_H
