#ifndef RAYGRID_EXCHANGE_PUZZLEPAINT_DATASET_FORMAT_H
#define RAYGRID_EXCHANGE_PUZZLEPAINT_DATASET_FORMAT_H

#include "exchange/puzzlepaint_files.h"
#include "exchange/table_format.h"

namespace raygrid {

/// dataset.bin of the program of the paper's authors (puzzlepaint's
/// camera_calibration): features and boards.
TableFormat PuzzlepaintDatasetFormat();

/// The images in which a camera saw a board.
std::vector<ImageFeatures> GetCameraFeatures(const PuzzlepaintDataset& dataset,
                                             size_t camera);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_PUZZLEPAINT_DATASET_FORMAT_H
