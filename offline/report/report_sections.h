// Sections shared by the reports of cameras and rigs.
#ifndef RAYGRID_REPORT_REPORT_SECTIONS_H
#define RAYGRID_REPORT_REPORT_SECTIONS_H

#include <optional>
#include <string>
#include <vector>

#include "dataset/pattern.h"
#include "evaluation/calibration_result.h"
#include "report/html.h"

namespace raygrid {

/// Formats a length in pixels for tables.
std::string FormatPixels(double value);

std::string MakeAssessmentSection(const Assessment& assessment);

/// Formats a row of reprojection errors, and a table of such rows.
HtmlRow FormatMetricsRow(const std::string& name, const ErrorMetrics& metrics);
std::string MakeErrorTable(const std::vector<HtmlRow>& rows);

/// Adds rows of a camera's model and of other models fitted to the same
/// features, if any; formats their table. Names begin with prefix.
void AddModelRows(const std::string& prefix, const CalibrationResult& result,
                  std::vector<HtmlRow>* rows);
std::string MakeModelTable(const std::vector<HtmlRow>& rows);

/// Formats the canvas for the 3D view of cameras and boards.
std::string MakeSceneSection();

/// Formats explanations of the terms of status and tables, one per line.
std::string MakeGlossarySection();

/// Formats a picture of each board's heights.
std::string MakeBoardSection(const Pattern& pattern);
/// Describes rigid multi-board targets; empty if there is no summary.
std::string MakeRigidTargetSection(
    const std::vector<std::string>& rigid_target_summary);
/// Formats the per-view deformation: a bar per image, heights of the largest.
std::string MakeDeformationSection(const BoardDeformation& bends,
                                   const Pattern& pattern);

}  // namespace raygrid

#endif  // RAYGRID_REPORT_REPORT_SECTIONS_H
