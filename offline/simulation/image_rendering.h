/// Renders images of boards: anti-aliased, blurred by the lens, with vignetting
/// and noise. Ground truth for feature detection.
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

/// Observation lines of the pixel corners of some rows.
class RayRows {
 public:
  /// Computes rows [first, last). Lines are extrapolated by up to one pixel:
  /// areas end at the centres of the outermost pixels, images at their corners.
  RayRows(const CameraModel& camera, int first, int last, int num_threads);

  /// Returns the line of pixel corner (column - 0.5, row - 0.5); its direction
  /// is NaN if there is none.
  const ObservationLine& Line(int column, int row) const {
    return lines_[static_cast<size_t>(row - first_row_) * columns_ + column];
  }

 private:
  int columns_, first_row_;
  std::vector<ObservationLine> lines_;
};

/// The observation lines of all pixel corners: computed once per camera for
/// many images. For more than 5 million pixels, they are computed row by row on
/// demand, to limit memory.
class PixelRays {
 public:
  PixelRays(const CameraModel& camera, int num_threads);

  const CameraModel& camera() const { return *camera_; }
  const ImageSize& size() const { return camera_->image_size(); }
  /// Returns the lines of rows [first, last), or more.
  std::shared_ptr<const RayRows> Rows(int first, int last) const;

 private:
  std::shared_ptr<const CameraModel> camera_;
  std::shared_ptr<const RayRows> precomputed_rays_;  // NULL for large images
};

/// The imaging process. Grey levels are in units of 1/255, before gamma.
struct ImagingOptions {
  double blur_px = 0.7;  ///< standard deviation of the Gaussian blur
  double black_level = 30, white_level = 220;  ///< ink and paper, image centre
  double background_level = 120;
  double exposure = 1;        ///< scales all levels, which saturate at 255
  double vignetting = 0;      ///< relative loss of light in the corners
  double read_noise = 0;      ///< standard deviation, grey levels
  double shot_noise = 0;      ///< variance per grey level
  double gamma = 1;           ///< stored = 255 (level / 255)^(1 / gamma)
  int samples_per_pixel = 8;  ///< along each axis
  uint64_t seed = 0;          ///< for the noise
};

struct PlacedBoard {
  const BoardSurface* surface = nullptr;
  Pose camera_from_board;
};

/// Linear grey levels without noise, row by row, with vignetting and exposure,
/// not clipped.
struct RenderedImage {
  ImageSize size;
  std::vector<float> levels;

  float at(int column, int row) const {
    return levels[static_cast<size_t>(row) * size.width + column];
  }
};

/// Renders boards, which occlude boards behind them. Outside the image circle,
/// with a soft edge of two pixels, there is no light; pixels without lines show
/// the background. Edge pixels are extended for the blur.
RenderedImage RenderImage(const PixelRays& rays,
                          const std::vector<PlacedBoard>& boards,
                          const ImagingOptions& options, int num_threads);

/// Applies noise, saturation, gamma and rounding.
Image AddNoiseAndQuantize(const RenderedImage& image,
                          const ImagingOptions& options);

/// A 16-bit grey image.
struct Image16 {
  ImageSize size;
  std::vector<uint16_t> pixels;
};
Image16 AddNoiseAndQuantize16(const RenderedImage& image,
                              const ImagingOptions& options);
std::string EncodePng(const Image16& image);

}  // namespace raygrid

#endif  // RAYGRID_SIMULATION_IMAGE_RENDERING_H
