#ifndef RAYGRID_CAPTURE_PAGE_FILES_H
#define RAYGRID_CAPTURE_PAGE_FILES_H

namespace raygrid {

/// The files of page/, embedded into the program by embed.cmake.
extern const char kCaptureHtml[];
extern const char kCaptureStyle[];
extern const char kCaptureScript[];

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_PAGE_FILES_H
