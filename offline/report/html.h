/// Building blocks of an HTML page.
#ifndef RAYGRID_REPORT_HTML_H
#define RAYGRID_REPORT_HTML_H

#include <string>
#include <vector>

#include "camera/area.h"
#include "dataset/image_files.h"
#include "report/color_scale.h"

namespace raygrid {

std::string EscapeHtml(const std::string& text);
std::string Base64(const std::string& bytes);

/// Cells of a table row, in HTML; the first is the row's name.
using HtmlRow = std::vector<std::string>;
std::string MakeHtmlTable(const HtmlRow& head,
                          const std::vector<HtmlRow>& rows);

/// The labels of a picture's axes and colours.
struct HtmlImageAxes {
  std::string x_label, y_label;
  std::vector<std::string> x_ticks, y_ticks;  ///< evenly spaced
};
/// Makes the axes of a picture that shows exactly an area, in its pixels.
HtmlImageAxes AreaAxes(const Area& area);
/// A colour bar from low to high, with labels.
struct ColorBar {
  ColorScale scale = ColorScale::kEven;
  std::string label, low, high;
};
std::string MakeHtmlColorBar(const ColorBar& bar);

/// Formats a picture with axes; view: name for zooming by the script.
std::string EmbedHtmlImage(const Image& picture, const std::string& caption,
                           const HtmlImageAxes& axes, const std::string& legend,
                           const std::string& view);

/// Formats a picture without axes.
std::string MakeHtmlImage(const Image& picture, const std::string& alt);

/// Format the page's style and heading, and its end with the data for the
/// script. has_trial: whether the page runs the runtime.
std::string PageStart(const std::string& heading,
                      const std::string& title = "raygrid calibration");
std::string PageEnd(const std::string& data_json, bool has_trial = false);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_HTML_H
