#ifndef RAYGRID_EVALUATION_ROUNDED_TEXT_H
#define RAYGRID_EVALUATION_ROUNDED_TEXT_H

#include <string>

namespace raygrid {

/// An estimate and its standard deviation, both to two significant digits of
/// the latter: "120.041 +- 0.023", with the separator given.
std::string WithDeviation(double value, double deviation,
                          const std::string& separator = " +- ");

/// Three significant digits, and at most the integer digits of large values:
/// "0.0383", "12.3", "1234".
std::string ThreeDigits(double value);

}  // namespace raygrid

#endif  // RAYGRID_EVALUATION_ROUNDED_TEXT_H
