#ifndef RAYGRID_REPORT_PAGE_FILES_H
#define RAYGRID_REPORT_PAGE_FILES_H

namespace raygrid {

/// The files of page/ and Chart.js, as offline/report/embed.cmake puts them
/// into the program.
extern const char kReportStyle[];
extern const char kReportScript[];
extern const char kChartLibrary[];

}  // namespace raygrid

#endif  // RAYGRID_REPORT_PAGE_FILES_H
