#ifndef RAYGRID_EXCHANGE_FFMPEG_FORMAT_H
#define RAYGRID_EXCHANGE_FFMPEG_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// The pair of maps that ffmpeg's filter remap takes, of a view.
TableFormat FfmpegFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_FFMPEG_FORMAT_H
