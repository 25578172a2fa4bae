#ifndef RAYGRID_EXCHANGE_PUZZLEPAINT_DATASET_FORMAT_H
#define RAYGRID_EXCHANGE_PUZZLEPAINT_DATASET_FORMAT_H

#include "exchange/puzzlepaint_files.h"
#include "exchange/table_format.h"

namespace raygrid {

/// dataset.bin of puzzlepaint's camera_calibration, the program of the paper's
/// authors: features and boards.
TableFormat MakePuzzlepaintDatasetFormat();

/// Returns the features of all images of a camera.
std::vector<ImageFeatures> GetCameraFeatures(const PuzzlepaintDataset& dataset,
                                             size_t camera);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PUZZLEPAINT_DATASET_FORMAT_H
