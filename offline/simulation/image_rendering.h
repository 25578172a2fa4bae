/// Images of boards as a camera sees them: anti-aliased, blurred by the lens,
/// vignetted, noisy. The ground truth of everything that reads images.
#ifndef RAYGRID_SIMULATION_IMAGE_RENDERING_H
#define RAYGRID_SIMULATION_IMAGE_RENDERING_H

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_model.h"
#include "camera/pose.h"
#include "dataset/image_files.h"
#include "simulation/board_surface.h"

namespace raygrid {

/// The observation lines of the corners of some rows of pixels.
class RowsOfRays {
 public:
  /// Makes those of rows [first, last). Up to a pixel beyond the camera's area
  /// lines are extrapolated: areas end at the outermost pixels' centres, images
  /// at their corners.
  RowsOfRays(const CameraModel& camera, int first, int last, int num_threads);

  /// The line of pixel corner (column - 0.5, row - 0.5); its direction is NaN
  /// if there is none.
  const ObservationLine& Line(int column, int row) const {
    return lines_[static_cast<size_t>(row - first_row_) * columns_ + column];
  }

 private:
  int columns_, first_row_;
  std::vector<ObservationLine> lines_;
};

/// The observation lines of all corners of pixels: made once per camera, used
/// for many images. Those of images of more than 5 million pixels would take
/// too much memory, and are made row by row when asked for.
class PixelRays {
 public:
  PixelRays(const CameraModel& camera, int num_threads);

  const CameraModel& camera() const { return *camera_; }
  const ImageSize& size() const { return camera_->image_size(); }
  /// The lines of rows [first, last), at least.
  std::shared_ptr<const RowsOfRays> Rows(int first, int last) const;

 private:
  std::shared_ptr<const CameraModel> camera_;
  std::shared_ptr<const RowsOfRays> all_;  // null where there are too many
};

/// How light becomes numbers. Grey levels are of 255, before gamma.
struct ImagingOptions {
  double blur_px = 0.7;  ///< standard deviation of the lens's Gaussian
  double black_level = 30, white_level = 220;  ///< ink and paper, image centre
  double background_level = 120;
  double exposure = 1;    ///< multiplies all levels; beyond 255 they saturate
  double vignetting = 0;  ///< part of the light that is lost in the corners
  double read_noise = 0;  ///< standard deviation, grey levels
  double shot_noise = 0;  ///< variance per grey level
  double gamma = 1;       ///< stored = 255 (level / 255)^(1 / gamma)
  int samples_per_pixel = 8;  ///< along each axis
  uint64_t seed = 0;          ///< of the noise
};

struct PlacedBoard {
  const BoardSurface* surface = nullptr;
  Pose camera_from_board;
};

/// Grey levels without noise, row by row: vignetted and exposed, linear, not
/// clipped.
struct RenderedImage {
  ImageSize size;
  std::vector<float> levels;

  float at(int column, int row) const {
    return levels[static_cast<size_t>(row) * size.width + column];
  }
};

/// Boards hide those behind them. Beyond the camera's image circle, and a soft
/// edge of two pixels, there is no light; pixels without observation lines show
/// the background. What the blur brings in across the image's edge is taken to
/// be as at the edge.
RenderedImage RenderImage(const PixelRays& rays,
                          const std::vector<PlacedBoard>& boards,
                          const ImagingOptions& options, int num_threads);

/// Noise, saturation, gamma, rounding.
Image AddNoiseAndQuantize(const RenderedImage& image,
                          const ImagingOptions& options);

/// 16-bit grey.
struct Image16 {
  ImageSize size;
  std::vector<uint16_t> pixels;
};
Image16 AddNoiseAndQuantize16(const RenderedImage& image,
                              const ImagingOptions& options);
std::string EncodePng(const Image16& image);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_IMAGE_RENDERING_H
