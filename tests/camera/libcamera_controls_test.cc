#include "libcamera_controls.h"

#include <gtest/gtest.h>
#include <libcamera/control_ids.h>

#include "camera_error.h"

namespace raygrid {
namespace {

namespace controls = libcamera::controls;
using libcamera::ControlInfo;
using libcamera::ControlInfoMap;

// A camera that focuses.
ControlInfoMap ListedControls() {
  return ControlInfoMap(
      ControlInfoMap::Map{
          {&controls::ExposureTime, ControlInfo(100, 33333)},
          {&controls::LensPosition, ControlInfo(0.0f, 12.0f)},
          {&controls::AeEnable, ControlInfo(false, true)},
          {&controls::AfMode, ControlInfo(controls::AfModeValues)},
          {&controls::ScalerCrop,
           ControlInfo(libcamera::Rectangle(0, 0, 64, 64),
                       libcamera::Rectangle(0, 0, 3280, 2464))}},
      controls::controls);
}

TEST(LibcameraControls, HaveTheTypesOfTheCamera) {
  const ControlInfoMap camera = ListedControls();
  const libcamera::ControlList list =
      MakeControlList(camera, {{"ExposureTime", "5000"},
                               {"LensPosition", "2.5"},
                               {"AeEnable", "false"},
                               {"AfMode", "Continuous"},
                               {"ScalerCrop", "8,-4,640x480"}});
  EXPECT_EQ(list.size(), 5u);
  EXPECT_EQ(list.get(controls::ExposureTime), 5000);
  EXPECT_EQ(list.get(controls::LensPosition), 2.5f);
  EXPECT_EQ(list.get(controls::AeEnable), false);
  EXPECT_EQ(list.get(controls::AfMode), controls::AfModeContinuous);
  EXPECT_EQ(list.get(controls::ScalerCrop),
            libcamera::Rectangle(8, -4, 640, 480));
  EXPECT_EQ(MakeControlList(camera, {{"AfMode", "0"}}).get(controls::AfMode),
            controls::AfModeManual);
}

TEST(LibcameraControls, OnesThatTheCameraDoesNotTakeAreRefused) {
  const ControlInfoMap camera = ListedControls();
  for (const ControlValue& control :
       ControlValues{{"Sharpness", "1"},
                     {"exposuretime", "5000"},
                     {"ExposureTime", "99"},
                     {"ExposureTime", "33334"},
                     {"ExposureTime", "5000.5"},
                     {"ExposureTime", "99999999999"},
                     {"LensPosition", "12.1"},
                     {"LensPosition", "nan"},
                     {"LensPosition", "near"},
                     {"AeEnable", "yes"},
                     {"AfMode", "Sometimes"},
                     {"ScalerCrop", "640x480"}}) {
    try {
      MakeControlList(camera, {control});
      ADD_FAILURE() << control.first << "=" << control.second;
    } catch (const CameraError& error) {
      EXPECT_EQ(error.code(), CameraExit::kUsage);
      EXPECT_NE(std::string(error.what()).find(control.first),
                std::string::npos);
      EXPECT_NE(std::string(error.what()).find(';'), std::string::npos);
    }
  }
}

TEST(LibcameraControls, AreListedWithWhatTheyTake) {
  EXPECT_EQ(DescribeControls(ListedControls()),
            "  --control AeEnable=false to true\n"
            "  --control AfMode=0 to 2\n"
            "  --control ExposureTime=100 to 33333\n"
            "  --control LensPosition=0.000000 to 12.000000\n"
            "  --control ScalerCrop=(0, 0)/64x64 to (0, 0)/3280x2464\n");
}

}  // namespace
}  // namespace raygrid
