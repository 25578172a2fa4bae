#ifndef RAYGRID_EXCHANGE_FFMPEG_FORMAT_H
#define RAYGRID_EXCHANGE_FFMPEG_FORMAT_H

#include "exchange/table_format.h"

namespace raygrid {

/// The x and y maps of a view for ffmpeg's remap filter.
TableFormat MakeFfmpegFormat();

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_FFMPEG_FORMAT_H
