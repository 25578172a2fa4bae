#ifndef RAYGRID_CAMERA_MODEL_NAMES_H
#define RAYGRID_CAMERA_MODEL_NAMES_H

/// Names of camera models used in the code, as in camera.yaml.
namespace raygrid::models {

constexpr char kCentralGeneric[] = "central-generic";
constexpr char kNonCentralGeneric[] = "noncentral-generic";
constexpr char kCentralRadial[] = "central-radial";
constexpr char kThinPrismFisheye[] = "thin-prism-fisheye";
constexpr char kOpenCv[] = "opencv";
constexpr char kOpenCv14[] = "opencv-14";
constexpr char kOmniRadtan[] = "omni-radtan";
constexpr char kDoubleSphere[] = "double-sphere";
constexpr char kEucm[] = "eucm";
constexpr char kSplinedStereographic[] = "splined-stereographic";

}  // namespace raygrid::models

#endif  // RAYGRID_CAMERA_MODEL_NAMES_H
