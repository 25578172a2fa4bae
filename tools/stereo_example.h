#ifndef RAYGRID_TOOLS_STEREO_EXAMPLE_H
#define RAYGRID_TOOLS_STEREO_EXAMPLE_H

#include <optional>
#include <vector>

#include "calibration_input.h"
#include "evaluation/rig_result.h"
#include "report/stereo_figures.h"

namespace raygrid {

/// Rectifies the two cameras of a rig that share the most boards, with the
/// frame in which they share the most features; nullopt without images, or if
/// no two cameras can be rectified.
std::optional<StereoExample> MakeStereoExample(
    const std::vector<Measurements>& cameras, const RigResult& result,
    int num_threads);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_STEREO_EXAMPLE_H
