#ifndef RAYGRID_EVALUATION_ROW_TIME_TEXT_H
#define RAYGRID_EVALUATION_ROW_TIME_TEXT_H

#include <string>

#include "dataset/row_time.h"

namespace raygrid {

/// Describes the estimated line delay, for images of num_rows rows.
std::string RowTimeText(const RowTimeEstimate& row_time, int num_rows);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_ROW_TIME_TEXT_H
