/// @file
/// Camera models of raygrid for C++ programs: SLAM, visual odometry, structure
/// from motion, bundle adjustment.
///
/// Conventions: x right, y down, z forward; pixel (0, 0) is the centre of the
/// top-left pixel; lengths are in metres; J_x is the Jacobian with respect to
/// x.
#ifndef RAYGRID_HOST_CAMERA_H
#define RAYGRID_HOST_CAMERA_H

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// Marks what the shared library exports.
#define RAYGRID_HOST_API __attribute__((visibility("default")))

namespace raygrid {

/// Version of the library.
/// @return "0.2.0"
RAYGRID_HOST_API const char* HostLibraryVersion();

/// A pose: point_b = b_from_a * point_a. Its layout does not depend on the
/// instruction set that a program is compiled for.
using PoseTransform =
    Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;

/// The columns of d pixel / d intrinsics that are not zero: for a grid those of
/// the 16 control points around the pixel, for a parametric model all.
template <typename Scalar>
struct IntrinsicsJacobian {
  /// 16 control points of 5 parameters.
  static constexpr int kMaxColumns = 80;

  /// Number of columns in use.
  int num_columns = 0;
  /// Index in Camera::Parameters() of each column.
  std::array<int, kMaxColumns> parameter;
  /// The columns: d pixel / d parameter.
  Eigen::Matrix<Scalar, 2, kMaxColumns, Eigen::DontAlign> values;

  /// Adds the columns to a dense Jacobian.
  /// @param J 2 x Camera::NumParameters()
  template <typename Derived>
  void AddTo(Eigen::MatrixBase<Derived>* J) const {
    for (int k = 0; k < num_columns; ++k)
      J->col(parameter[k]) +=
          values.col(k).template cast<typename Derived::Scalar>();
  }
};

/// A calibrated camera, in double or float precision.
///
/// Functions that return bool return whether the result is defined, and leave
/// their outputs unchanged otherwise. They neither allocate memory nor throw.
/// All const functions may run in several threads at once. Copies share their
/// data and are cheap.
///
/// Pixels outside the calibrated area (Bounds()) have no bearing, and points
/// whose pixels are outside of it have no projection; results are never
/// extrapolated. Points and pixels that are not finite are undefined.
///
/// A camera of two precisions has the same definition: Cast<float>() rounds
/// results to about 1e-3 px. Parameters are always double.
template <typename Scalar>
class RAYGRID_HOST_API Camera {
 public:
  /// A pixel.
  using Vector2 = Eigen::Matrix<Scalar, 2, 1>;
  /// A point or bearing in the camera frame.
  using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
  /// d pixel / d point.
  using Matrix23 = Eigen::Matrix<Scalar, 2, 3>;
  /// d bearing / d pixel.
  using Matrix32 = Eigen::Matrix<Scalar, 3, 2>;
  /// Pixels, one per column.
  using Pixels = Eigen::Matrix<Scalar, 2, Eigen::Dynamic>;
  /// Points or bearings, one per column.
  using Points = Eigen::Matrix<Scalar, 3, Eigen::Dynamic>;

  /// Reads a camera.yaml of any model.
  /// @param path the file
  /// @param error if not null, receives one line that says what is wrong
  /// @return nullopt if the file is unreadable or malformed
  static std::optional<Camera> Load(const std::string& path,
                                    std::string* error = nullptr);
  /// Reads the text of a camera.yaml.
  /// @param text the contents of the file
  /// @param error as in Load()
  /// @return nullopt if the text is malformed
  static std::optional<Camera> Parse(const std::string& text,
                                     std::string* error = nullptr);
  /// Writes the camera, for Parse().
  /// @return the text of a camera.yaml; control points of grids have 12
  /// decimals, other parameters all digits
  std::string Format() const;

  /// Converts the camera to another precision.
  /// @return the same camera
  template <typename Other>
  Camera<Other> Cast() const;

  /// Name of the model.
  /// @return as in camera.yaml: "central-generic", "opencv"
  std::string Model() const;
  /// Width of the image.
  /// @return in pixels
  int Width() const;
  /// Height of the image.
  /// @return in pixels
  int Height() const;
  /// Whether the camera is central.
  /// @return true if all observation lines start at the origin
  bool IsCentral() const;
  /// The calibrated area.
  /// @return by default from the first pixel's centre to the last pixel's
  Eigen::AlignedBox<Scalar, 2> Bounds() const;
  /// Pose of the camera of an undistorted image (view.camera.yaml) relative to
  /// the camera of the original image.
  /// @return identity if the file has none
  PoseTransform CameraFromView() const;

  /// Whether a pixel is in the calibrated area and, if the image circle is
  /// known, in the circle.
  /// @param pixel any pixel
  /// @return true if it is
  bool IsIlluminated(const Vector2& pixel) const;
  /// Whether a pixel is in the valid region, in which the predicted uncertainty
  /// is below the limit of the calibration. If the file does not contain the
  /// valid region, this is IsIlluminated().
  /// @param pixel any pixel
  /// @return true if it is
  bool IsInValidRegion(const Vector2& pixel) const;
  /// Predicted uncertainty: the standard deviation (1 sigma) per coordinate of
  /// the projection of a far point.
  /// @param pixel any pixel
  /// @param stddev_px in pixels
  /// @return false if the file does not contain it, or outside the area
  bool Uncertainty(const Vector2& pixel, Scalar* stddev_px) const;

  /// Computes the bearing of a pixel. For a non-central camera, this is the
  /// direction of its observation line.
  /// @param pixel any pixel
  /// @param bearing unit vector
  /// @param J_pixel if not null, d bearing / d pixel
  /// @return whether the bearing is defined
  bool Unproject(const Vector2& pixel, Vector3* bearing,
                 Matrix32* J_pixel = nullptr) const;
  /// Computes the observation line of a pixel: origin + t bearing, t > 0.
  /// @param pixel any pixel
  /// @param origin in metres; zero for a central camera
  /// @param bearing unit vector
  /// @param origin_J_pixel if not null, d origin / d pixel
  /// @param bearing_J_pixel if not null, d bearing / d pixel
  /// @return whether the line is defined
  bool UnprojectLine(const Vector2& pixel, Vector3* origin, Vector3* bearing,
                     Matrix32* origin_J_pixel = nullptr,
                     Matrix32* bearing_J_pixel = nullptr) const;
  /// Computes the pixel of a point. For a central camera, also of a bearing
  /// with a length of 1e-15 to 1e15.
  /// @param point in the camera frame
  /// @param pixel in the calibrated area
  /// @param J_point if not null, d pixel / d point
  /// @param J_intrinsics if not null, d pixel / d Parameters()
  /// @return whether the camera sees the point
  bool Project(const Vector3& point, Vector2* pixel,
               Matrix23* J_point = nullptr,
               IntrinsicsJacobian<Scalar>* J_intrinsics = nullptr) const;

  /// Unproject() of many pixels, at several times its speed. Bearings of
  /// undefined pixels are NaN.
  /// @param pixels one per column
  /// @param bearings of the same number of columns; of fewer, only these
  /// @return the number of defined bearings
  int UnprojectAll(const Eigen::Ref<const Pixels>& pixels,
                   Eigen::Ref<Points> bearings) const;
  /// UnprojectLine() of many pixels. Lines of undefined pixels are NaN.
  /// @param pixels one per column
  /// @param origins of the same number of columns
  /// @param bearings of the same number of columns
  /// @return the number of defined lines
  int UnprojectAllLines(const Eigen::Ref<const Pixels>& pixels,
                        Eigen::Ref<Points> origins,
                        Eigen::Ref<Points> bearings) const;
  /// Project() of many points. Pixels of undefined projections are NaN.
  /// @param points one per column
  /// @param pixels of the same number of columns
  /// @return the number of defined projections
  int ProjectAll(const Eigen::Ref<const Points>& points,
                 Eigen::Ref<Pixels> pixels) const;

  /// Number of the intrinsics.
  /// @return at least 4
  int NumParameters() const;
  /// The intrinsics.
  /// @return of a grid, for each control point, row by row, a and b
  /// (stereographic coordinates) and, if non-central, the point of the line in
  /// metres; of a parametric model, its spline, if any, and its named
  /// parameters
  template <typename Vector = Eigen::VectorXd>
  Vector Parameters() const {
    // Allocated by the caller, whose Eigen may align memory differently.
    Vector parameters(NumParameters());
    CopyParameters(parameters.data());
    return parameters;
  }
  /// Copies the intrinsics.
  /// @param parameters array of NumParameters() numbers
  void CopyParameters(double* parameters) const;
  /// Names of the last parameters.
  /// @return fx, fy, cx, cy and so on; none for grids
  std::vector<std::string> ParameterNames() const;
  /// Replaces the intrinsics, for their optimization; not for hot loops.
  /// Uncertainty and valid region remain those of the file. Copies of this
  /// camera are not changed.
  /// @param parameters as Parameters()
  /// @return false if their number is wrong or one is not finite
  bool SetParameters(const Eigen::Ref<const Eigen::VectorXd>& parameters);

 private:
  template <typename>
  friend class Camera;
  struct Data;
  explicit Camera(std::shared_ptr<const Data> data);

  std::shared_ptr<const Data> data_;
};

static_assert(alignof(IntrinsicsJacobian<double>) == alignof(double) &&
                  alignof(PoseTransform) == alignof(double),
              "types of the interface are not aligned to SIMD registers");

extern template class Camera<double>;
extern template class Camera<float>;

/// A camera in double precision.
using CameraD = Camera<double>;
/// A camera in single precision.
using CameraF = Camera<float>;

}  // namespace raygrid

#endif  // RAYGRID_HOST_CAMERA_H
