#ifndef RAYGRID_REPORT_PAGE_FILES_H
#define RAYGRID_REPORT_PAGE_FILES_H

namespace raygrid {

/// The files of page/, Chart.js and the npm package of runtime/wasm, embedded
/// by offline/report/embed.cmake.
extern const char kReportStyle[];
extern const char kReportScript[];
extern const char kChartLibrary[];
extern const char kRuntimeLibrary[];
extern const char kTrialScript[];

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PAGE_FILES_H
