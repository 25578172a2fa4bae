#ifndef RAYGRID_FEATURES_FEATURE_DETECTION_H
#define RAYGRID_FEATURES_FEATURE_DETECTION_H

#include <functional>
#include <string>
#include <vector>

#include "dataset/dataset.h"
#include "dataset/image_files.h"

namespace raygrid {

/// The inner corners of a whole chessboard, to sub-pixel accuracy; empty if it
/// is not found. Which end of the board is the first follows from its colours
/// where the board has an even and an odd side; it then is the same in all
/// images.
std::vector<Feature> DetectChessboard(const Image& grey, const Board& board);

/// Detects the pattern in all images; told how much is done. Images without a
/// board have no features. Throws InputError: unreadable image, images of
/// different sizes, kinds of board that this version cannot detect.
Dataset DetectFeatures(const std::vector<std::string>& image_paths,
                       const Pattern& pattern, int num_threads,
                       const std::function<void(double)>& progress);

/// The image with the detected features drawn on it.
Image DrawFeatures(const Image& grey, const std::vector<Feature>& features);

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_FEATURE_DETECTION_H
