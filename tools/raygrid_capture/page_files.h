#ifndef RAYGRID_CAPTURE_PAGE_FILES_H
#define RAYGRID_CAPTURE_PAGE_FILES_H

namespace raygrid {

/// The files of page/, as embed.cmake puts them into the program.
extern const char kCaptureHtml[];
extern const char kCaptureStyle[];
extern const char kCaptureScript[];

}  // namespace raygrid

#endif  // RAYGRID_CAPTURE_PAGE_FILES_H
