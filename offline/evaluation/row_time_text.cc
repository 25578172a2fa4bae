#include "evaluation/row_time_text.h"

#include <fmt/format.h>

#include <cmath>

#include "evaluation/rounded_text.h"

namespace raygrid {

std::string RowTimeText(const RowTimeEstimate& row_time, int num_rows) {
  if (!row_time.IsTold()) return "not observable: " + row_time.untold;
  const RowTime& value = row_time.value;
  std::string text =
      WithDeviation(value.seconds * 1e6, value.deviation_s * 1e6) + " us";
  if (value.MayBeGlobal())
    return text +
           ": zero within two standard deviations, consistent with a global "
           "shutter";
  text += fmt::format(", {:.2f} ms for {} rows",
                      std::abs(value.seconds) * num_rows * 1e3, num_rows);
  if (value.seconds < 0) text += ", bottom row first";
  if (row_time.is_taken_out)
    text += "; rolling-shutter distortion was compensated";
  if (row_time.num_left_out > 0)
    text += fmt::format(
        ", except in {} images of unknown motion (no timestamp or no adjacent "
        "frames)",
        row_time.num_left_out);
  return text;
}

}  // namespace raygrid
