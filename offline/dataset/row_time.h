#ifndef RAYGRID_DATASET_ROW_TIME_H
#define RAYGRID_DATASET_ROW_TIME_H

#include <cmath>
#include <string>

namespace raygrid {

/// How much later than the row above it a sensor reads a row of an image.
struct RowTime {
  double seconds = 0;  ///< negative: rows are read from the last to the first
  double deviation_s = 0;  ///< standard; 0: not known

  /// Whether the 0 of a global shutter is within two deviations.
  bool MayBeGlobal() const { return !(std::abs(seconds) > 2 * deviation_s); }
};

/// The largest row time and deviation that files hold: a second for a thousand
/// rows.
constexpr double kLongestRowTimeS = 1e-3;

/// The row time that a calibration found, or why it cannot be told.
struct RowTimeEstimate {
  RowTime value;
  std::string untold;  ///< and what to do; empty: it is told
  /// False: times are none of these images', which says why it is not told.
  bool do_times_fit = true;
  int num_images = 0;  ///< that told it, those with neighbours in time
  /// Whether features were moved to where they would have been seen at once.
  bool is_taken_out = false;
  int num_left_out = 0;  ///< images whose motion is not known, if it was

  bool IsTold() const { return untold.empty(); }
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_ROW_TIME_H
