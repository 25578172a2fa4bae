/// Images of a camera in other sensor modes.
#ifndef RAYGRID_TOOLS_MODE_IMAGES_H
#define RAYGRID_TOOLS_MODE_IMAGES_H

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "calibration_input.h"
#include "features/refinement/camera_refinement.h"

namespace raygrid {

/// Image folders of a camera: as calibrated, and of each --mode with its text
/// FOLDER:WORDS.
struct ModeFolders {
  std::vector<std::string> calibrated;
  std::vector<std::pair<std::string, std::string>> modes;
};

/// Groups folders by sensor mode. Throws Error(kUsage) if a mode's folder is
/// not among the images, or no images have the calibrated mode.
ModeFolders GroupByMode(const std::vector<std::string>& images,
                        const std::vector<std::string>& modes);

/// Appends measurements in frames of a mode, converted to calibrated pixels.
/// Throws InputError if the image size or an image name conflicts.
void AppendModeMeasurements(const SensorMode& mode, const std::string& folder,
                            Measurements more, Measurements* measurements);

/// Refines the features of all images, in the pixels of each image's mode.
Dataset RefineModes(const Measurements& measurements,
                    const EstimatedScene& scene, int num_threads,
                    const std::function<void(double)>& go_on);

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_MODE_IMAGES_H
