/// The words of figures and changes, for page and terminal alike.
#ifndef RAYGRID_FLEET_FLEET_WORDS_H
#define RAYGRID_FLEET_FLEET_WORDS_H

#include <string>
#include <vector>

#include "fleet/fleet_analysis.h"

namespace raygrid {

/// A figure in words, as sentences have it: "the focal length".
std::string TitleOfFigure(const std::string& name);
/// The unit behind its values, with a space; empty if it has none.
std::string UnitOfFigure(const std::string& name);

/// A piece for each chart in which a unit is unusual: "the focal length
/// (focal_px) is 812.4, usual are 798.1 to 803.2 px". unit is a compared one.
std::vector<std::string> WhatIsUnusual(const FleetStatistics& statistics,
                                       int unit);

/// A sentence for each jump and drift of a mean, names of units in it, and of
/// the batch if a jump is where one begins.
std::vector<std::string> ChangesTold(const FleetAnalysis& fleet);

/// A sentence for each figure whose batches differ.
std::vector<std::string> BatchesTold(const BatchComparison& batches);

/// A sentence on each figure of the gauge, then on what cannot be told.
std::vector<std::string> GaugeTold(const GaugeStudy& gauge);

/// The seconds that units took, in a sentence; empty if none are known.
std::string SecondsTold(const std::vector<UnitRow>& rows);

/// "12.34 px", or "1.2 %" of a part.
std::string GaugeDeviation(const GaugeFigure& figure, double deviation);

/// "< 0.0001", or its figure.
std::string ChanceText(double chance);

}  // namespace raygrid

#endif  // RAYGRID_FLEET_FLEET_WORDS_H
