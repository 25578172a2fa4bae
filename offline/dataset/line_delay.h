#ifndef RAYGRID_DATASET_LINE_DELAY_H
#define RAYGRID_DATASET_LINE_DELAY_H

#include <cmath>
#include <string>

namespace raygrid {

/// Line delay: the readout time per row of a rolling shutter.
struct LineDelay {
  double seconds = 0;   ///< negative: from the last row to the first
  double stddev_s = 0;  ///< standard deviation; 0: unknown

  /// Returns whether 0, a global shutter, is within two standard deviations.
  bool IsPossiblyGlobalShutter() const {
    return !(std::abs(seconds) > 2 * stddev_s);
  }
};

/// The maximum line delay and deviation in files: a second per thousand rows.
constexpr double kMaxLineDelayS = 1e-3;

/// The estimated line delay, or why it is not observable.
struct LineDelayEstimate {
  LineDelay value;
  std::string unobservable_reason;  ///< reason and remedy; empty: estimated
  /// False if timestamps contradict the images (see unobservable_reason).
  bool are_timestamps_consistent = true;
  int num_images = 0;  ///< used images with neighbours in time
  /// Whether the features were compensated for the rolling shutter.
  bool is_compensated = false;
  int num_left_out = 0;  ///< if compensated: images without a motion estimate

  bool IsDetermined() const { return unobservable_reason.empty(); }
};

}  // namespace raygrid

#endif  // RAYGRID_DATASET_LINE_DELAY_H
