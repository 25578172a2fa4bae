#ifndef RAYGRID_EVALUATION_ROUNDED_TEXT_H
#define RAYGRID_EVALUATION_ROUNDED_TEXT_H

#include <string>

namespace raygrid {

/// Formats an estimate and its standard deviation to two significant digits of
/// the latter, with the given separator: "120.041 ± 0.023".
std::string FormatWithStdDev(double value, double deviation,
                             const std::string& separator = " ± ");

/// Formats three significant digits, or all integer digits of larger values:
/// "0.0383", "12.3", "1234".
std::string FormatThreeDigits(double value);

/// Formats a value with its unit as in a JSON schema, where "1" means
/// dimensionless.
std::string FormatMetric(double value, const std::string& unit);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_ROUNDED_TEXT_H
