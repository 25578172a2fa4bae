/// The images of a camera that were taken in other sensor modes.
#ifndef RAYGRID_TOOLS_MODE_IMAGES_H
#define RAYGRID_TOOLS_MODE_IMAGES_H

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "calibration_input.h"
#include "features/refinement/camera_refinement.h"

namespace raygrid {

/// The image folders of a camera: those as calibrated, and those of --mode,
/// each with its text, FOLDER:WORDS.
struct FoldersByMode {
  std::vector<std::string> calibrated;
  std::vector<std::pair<std::string, std::string>> modes;
};

/// Throws Error(kUsage) if a mode's folder is none of the images, or no images
/// are as calibrated.
FoldersByMode GroupByMode(const std::vector<std::string>& images,
                          const std::vector<std::string>& modes);

/// Appends measurements in frames of a mode, in calibrated pixels. Throws
/// InputError if the mode has another size, or an image a name that is taken.
void AppendModeMeasurements(const SensorMode& mode, const std::string& folder,
                            Measurements more, Measurements* measurements);

/// Measures all images again, those of other modes in frames of their own.
Dataset RefineModes(const Measurements& measurements,
                    const EstimatedScene& scene, int num_threads,
                    const std::function<void(double)>& go_on);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_MODE_IMAGES_H
