#include "evaluation/row_time_text.h"

#include <fmt/format.h>

#include <cmath>

namespace raygrid {

std::string RowTimeText(const RowTimeEstimate& row_time, int num_rows) {
  if (!row_time.IsTold()) return "not observable: " + row_time.untold;
  const RowTime& value = row_time.value;
  std::string text = fmt::format("{:.4f} +- {:.4f} us", value.seconds * 1e6,
                                 value.deviation_s * 1e6);
  if (value.MayBeGlobal())
    return text + ": zero within two deviations, as of a global shutter";
  text += fmt::format(", {:.2f} ms for {} rows",
                      std::abs(value.seconds) * num_rows * 1e3, num_rows);
  if (value.seconds < 0) text += ", the last one first";
  if (row_time.is_taken_out)
    text += "; the camera is calibrated as if frames were read at once";
  if (row_time.num_left_out > 0)
    text += fmt::format(
        ", without {} of unknown motion, which have no time or no neighbours "
        "in time",
        row_time.num_left_out);
  return text;
}

}  // namespace raygrid
