// The sections that the reports of a camera and of a rig have in common.
#ifndef RAYGRID_REPORT_REPORT_SECTIONS_H
#define RAYGRID_REPORT_REPORT_SECTIONS_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/pattern.h"
#include "evaluation/calibration_result.h"
#include "report/html.h"

namespace raygrid {

/// A length in pixels, as tables have it.
std::string Px(double value);

std::string VerdictSection(const Verdict& verdict);

/// Rows of reprojection errors, and their table.
HtmlRow FiguresRow(const std::string& name, const ErrorFigures& figures);
std::string ErrorTable(const std::vector<HtmlRow>& rows);

/// Rows of models that were fitted to the same features, and their table.
HtmlRow ModelRow(const std::string& name, int num_parameters,
                 const ErrorFigures& training,
                 const std::optional<ErrorFigures>& held_out,
                 const std::optional<double>& bias_kl);
std::string ModelTable(const std::vector<HtmlRow>& rows);

/// The canvas of cameras and boards in space.
std::string SpaceSection();

/// The meaning of the words of verdict and tables, a line each.
std::string WordsSection();

/// A picture of each board's heights.
std::string BoardSection(const Pattern& pattern);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_REPORT_SECTIONS_H
