/// Files as programs publish them.
#include <string>

#include "exchange/format.h"
#include "exchange/lenses_by_formula.h"
#include "support.h"

namespace raygrid {
namespace {

// Kalibr's coefficients may end with zeros, matrices of ROS may be unknown.
TEST(PublishedCameras, ReadZerosForNothing) {
  const std::string kalibr =
      "cam0:\n  camera_model: pinhole\n  distortion_model: radtan\n"
      "  distortion_coeffs: [-0.21, 0.06, 0.001, -0.002, 0.0]\n"
      "  intrinsics: [410, 411.5, 322.5, 238]\n  resolution: [640, 480]\n"
      "  rostopic: /cam0\n";
  ExpectLens(Read(kalibr).cameras.at(0), kPinholeLens, &Lens::Pinhole);
  ExpectError(ExitCode::kInput, {"f: ", "list of 4 numbers"},
              [&] { Read(TextWith(kalibr, "-0.002, 0.0", "-0.002, 0.1")); });
  const auto ros = Read(
      "header:\n  frame_id: front\nheight: 480.0\nwidth: 640.0\n"
      "distortion_model: plumb_bob\nD: [-0.21, 0.06, 0.001, -0.002, 0]\n"
      "K: [410, 0, 322.5, 0, 411.5, 238, 0, 0, 1]\n"
      "R: [0, 0, 0, 0, 0, 0, 0, 0, 1]\nP: [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, "
      "0]\n");
  ExpectLens(ros.cameras.at(0), kPinholeLens, &Lens::Pinhole);
  EXPECT_FALSE(ros.cameras[0].rectified);
}

}  // namespace
}  // namespace raygrid
