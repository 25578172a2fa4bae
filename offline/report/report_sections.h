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

/// Rows of a camera's model and of those that were fitted to the same features,
/// if there are any, and their table. Names follow a prefix.
void AddModelRows(const std::string& prefix, const CalibrationResult& result,
                  std::vector<HtmlRow>* rows);
std::string ModelTable(const std::vector<HtmlRow>& rows);

/// The canvas of cameras and boards in space.
std::string SpaceSection();

/// The meaning of the words of verdict and tables, a line each.
std::string WordsSection();

/// A picture of each board's heights.
std::string BoardSection(const Pattern& pattern);
/// Which boards are fixed to each other; empty if nothing is told of it.
std::string BodySection(const std::vector<std::string>& rigid_target_summary);
/// How boards bend: a bar an image, and the heights of the one that bends most.
std::string BendSection(const BoardBends& bends, const Pattern& pattern);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_REPORT_SECTIONS_H
