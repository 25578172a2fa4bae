#include "evaluation/line_delay_text.h"

#include <fmt/format.h>

#include <cmath>

#include "evaluation/rounded_text.h"

namespace raygrid {

std::string FormatLineDelay(const LineDelayEstimate& line_delay, int num_rows) {
  if (!line_delay.IsDetermined())
    return "not observable: " + line_delay.unobservable_reason;
  const LineDelay& value = line_delay.value;
  std::string text =
      FormatWithStdDev(value.seconds * 1e6, value.stddev_s * 1e6) + " us";
  if (value.IsPossiblyGlobalShutter())
    return text +
           ": zero within two standard deviations, consistent with a global "
           "shutter";
  text += fmt::format(", {:.2f} ms for {} rows",
                      std::abs(value.seconds) * num_rows * 1e3, num_rows);
  if (value.seconds < 0) text += ", bottom row first";
  if (line_delay.is_compensated)
    text += "; rolling-shutter distortion was compensated";
  if (line_delay.num_left_out > 0)
    text += fmt::format(
        ", except in {} images of unknown motion (no timestamp or no adjacent "
        "frames)",
        line_delay.num_left_out);
  return text;
}

}  // namespace raygrid
