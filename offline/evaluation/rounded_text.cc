#include "evaluation/rounded_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace raygrid {
namespace {

// Returns the number of decimals for the given number of significant digits.
int CountDecimals(double value, int num_digits) {
  constexpr int kMaxDecimals = 9;
  if (value == 0 || !std::isfinite(value)) return num_digits;
  const int exponent = static_cast<int>(std::floor(std::log10(value)));
  return std::clamp(num_digits - 1 - exponent, 0, kMaxDecimals);
}

}  // namespace

std::string FormatWithStdDev(double value, double deviation,
                             const std::string& separator) {
  const int decimals = CountDecimals(std::abs(deviation), 2);
  return fmt::format("{0:.{2}f}{3}{1:.{2}f}", value, deviation, decimals,
                     separator);
}

std::string FormatThreeDigits(double value) {
  return fmt::format("{:.{}f}", value, CountDecimals(std::abs(value), 3));
}

std::string FormatMetric(double value, const std::string& unit) {
  return FormatThreeDigits(value) + (unit == "1" ? "" : " " + unit);
}

}  // namespace raygrid
