#ifndef RAYGRID_EVALUATION_LINE_DELAY_TEXT_H
#define RAYGRID_EVALUATION_LINE_DELAY_TEXT_H

#include <string>

#include "dataset/line_delay.h"

namespace raygrid {

/// Describes the estimated line delay. num_rows: image height.
std::string FormatLineDelay(const LineDelayEstimate& line_delay, int num_rows);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_LINE_DELAY_TEXT_H
