#include "exchange/keyed_table.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <sstream>

#include "exchange/opencv_model_list.h"
#include "exchange/radial_model.h"

namespace raygrid {
namespace {

// Newer OpenMVG files store the base class as a separate object.
#define KEYED_MVG                                  \
  "value/ptr_wrapper/data/value0/focal_length|"    \
  "value/ptr_wrapper/data/focal_length=f "         \
  "value/ptr_wrapper/data/value0/principal_point|" \
  "value/ptr_wrapper/data/principal_point=cx,cy"
#define KEYED_OLD_SFM "pxFocalLength=f principalPoint=cx,cy"
#define KEYED_SFM \
  "focalLength=f_mm sensorWidth=sensor_width_mm principalPoint=cx,cy"

bool ContainsAll(const std::string& text,
                 std::initializer_list<const char*> words) {
  return std::all_of(words.begin(), words.end(), [&](const char* word) {
    return text.find(word) != std::string::npos;
  });
}

// Whether any line begins with a word.
bool StartsLine(const std::string& text, const std::string& word) {
  return text.rfind(word, 0) == 0 ||
         text.find("\n" + word) != std::string::npos;
}

// Whether a text has, for two cameras, three lines of 2 numbers each, and then
// three lines of 4 numbers.
bool IsInfiniTam(const std::string& text) {
  constexpr size_t kMaxBytes = 2000;
  if (text.size() > kMaxBytes) return false;
  std::istringstream lines(text);
  std::string counts;
  for (std::string line; std::getline(lines, line) && counts.size() < 9;) {
    std::istringstream words(line);
    size_t count = 0;
    for (double number = 0; words >> number;) ++count;
    if (count > 0 && words.eof()) counts += std::to_string(count);
  }
  return counts == "222222444";
}

// Whether a text is one line of 4, 8 or 9 numbers.
bool IsNumberLine(const std::string& text) {
  constexpr size_t kMaxBytes = 400;
  if (text.size() > kMaxBytes) return false;
  const std::string line = FindNumberLine(text);
  if (line.find_first_not_of("0123456789.+-eE \t\r") != std::string::npos)
    return false;
  std::istringstream words(line);
  size_t count = 0;
  for (double number = 0; words >> number;) ++count;
  return words.eof() && (count == 4 || count == 8 || count == 9);
}

ExternalModel MakeKeyedPinhole(const char* name, int count) {
  return MakeOpenCvModel(name, count);
}
ExternalModel MakeKeyedPinhole(const char* name,
                               const std::vector<std::string>& coefficients) {
  ExternalModel external_model =
      MakeExternalModel(name, models::kOpenCv, coefficients);
  external_model.max_supported_angle_rad = M_PI / 2;
  return external_model;
}
ExternalModel MakeKeyedFisheye(const char* name) {
  ExternalModel external_model = MakeOpenCvFisheyeModel(name);
  external_model.max_supported_angle_rad = M_PI;
  return external_model;
}
ExternalModel MakeKeyedOmni(const char* name) {
  return MakeExternalModel(name, models::kOmniRadtan,
                           {"xi", "k1", "k2", "p1", "p2"});
}
ExternalModel WithOrigin(PixelOrigin origin, ExternalModel external_model) {
  external_model.origin = origin;
  return external_model;
}
// OpenSfM's pixel origin is the image centre.
ExternalModel SetImageCenterOrigin(ExternalModel external_model) {
  return WithOrigin(PixelOrigin::kImageCenter, std::move(external_model));
}
// Makes a model with one focal length, principal point and distortion
// coefficients.
ExternalModel KeyedSingleFocal(const char* name, const char* model,
                               std::vector<std::string> coefficients) {
  coefficients.insert(coefficients.begin(), {"f", "cx", "cy"});
  ExternalModel external_model = {name, model, coefficients};
  external_model.max_supported_angle_rad = M_PI / 2;
  return external_model;
}

}  // namespace

const std::vector<KeyedFormat>& ListKeyedFormats() {
  static const std::vector<KeyedFormat> table = {
      {"gyroflow",
       "Gyroflow's lens profile .json",
       KeyedSyntax::kJson,
       [](const std::string& text) {
         return ContainsAll(text,
                            {"\"fisheye_params\"", "\"calib_dimension\""});
       },
       "",
       {},
       {{MakeOpenCvFisheyeModel("opencv_fisheye"),
         "distortion_model?=opencv_fisheye",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1,k2,k3,k4"},
        {MakeKeyedPinhole("opencv_standard", 12),
         "distortion_model=opencv_standard",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1,k2,p1,p2,k3,k4,k5,k6,s1,s2,s3,"
         "s4"},
        // Lensfun's radial polynomials; the radius is in units of the focal
        // length.
        {MakeKeyedPinhole("poly3", {"k1"}), "distortion_model=poly3",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1",
         true},
        {MakeKeyedPinhole("poly5", {"k1", "k2"}), "distortion_model=poly5",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1,k2",
         true},
        {MakeRadialExternalModel("ptlens"), "distortion_model=ptlens",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=a,b,c",
         true}},
       "calib_dimension/w calib_dimension/h",
       {},
       "",
       "input_horizontal_stretch input_vertical_stretch",
       LengthUnit::kPixel,
       {"name",
        "note",
        "calibrated_by",
        "camera_brand",
        "camera_model",
        "lens_model",
        "camera_setting",
        "orig_dimension",
        "output_dimension",
        "frame_readout_time",
        "frame_readout_direction",
        "gyro_lpf",
        "num_images",
        "fps",
        "crop",
        "official",
        "asymmetrical",
        "use_opencv_fisheye",
        "fisheye_params/RMS_error",
        "fisheye_params/radial_distortion_limit",
        "identifier",
        "calibrator_version",
        "date",
        "compatible_settings",
        "sync_settings",
        "focal_length",
        "crop_factor",
        "global_shutter",
        "per_zoom_level*",
        "digital_lens_params",
        "interpolations",
        "file",
        "lens_profile*"},
       ".json",
       {{"calibrated_by", "raygrid"}},
       "note"},
      {"orbslam",
       "settings .yaml of ORB-SLAM2 and 3, and of OpenVSLAM",
       KeyedSyntax::kStorage,
       [](const std::string& text) {
         return (ContainsAll(text, {"Camera.fx"}) ||
                 ContainsAll(text, {"Camera1.fx"})) &&
                !ContainsAll(text, {"Camera.fxl"});
       },
       "",
       {"Camera", "Camera1", "Camera2"},
       {{MakeKeyedPinhole("PinHole", 5),
         "Camera.type?=PinHole Camera.model?=perspective",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy @.k1?=k1 @.k2?=k2 @.p1?=p1 @.p2?=p2 "
         "@.k3?=k3"},
        {MakeKeyedPinhole("Rectified", 0), "Camera.type=Rectified",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy", true},
        {MakeKeyedFisheye("KannalaBrandt8"), "Camera.type=KannalaBrandt8",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy @.k1=k1 @.k2=k2 @.k3=k3 @.k4=k4"},
        {MakeOpenCvFisheyeModel("fisheye"), "Camera.model=fisheye",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy @.k1=k1 @.k2=k2 @.k3=k3 @.k4=k4",
         true}},
       "Camera.width|Camera.cols Camera.height|Camera.rows",
       {{"Stereo.T_c1_c2", PoseKind::kRigFromCamera, "Camera2"},
        {"Tlr", PoseKind::kRigFromCamera, "Camera2"}},
       "",
       "",
       LengthUnit::kPixel,
       {"Camera.fps",
        "Camera.RGB",
        "Camera.bf",
        "Camera.bFishEye",
        "Camera.name",
        "Camera.setup",
        "Camera.color_order",
        "Camera.newWidth",
        "Camera.newHeight",
        "Camera.imageScale",
        "Camera.lappingBegin",
        "Camera.lappingEnd",
        "Camera2.lapping*",
        "Camera1.overlapping*",
        "Camera2.overlapping*",
        "File.version",
        "ORBextractor.*",
        "Viewer.*",
        "IMU.*",
        "System.*",
        "RGBD.*",
        "Stereo.*",
        "StereoRectifier.model",
        "Feature.*",
        "Initializer.*",
        "Mapping.*",
        "PangolinViewer.*",
        "Preprocessing.*",
        "ThDepth",
        "DepthMapFactor",
        "Tbc",
        "loopClosing",
        "thFarPoints"},
       ".yaml"},
      {"camodocal",
       "camodocal's and VINS's camera .yaml",
       KeyedSyntax::kStorage,
       [](const std::string& text) {
         return ContainsAll(text, {"model_type:", "projection_parameters:"});
       },
       "",
       {},
       {{MakeKeyedPinhole("PINHOLE", 4), "model_type=PINHOLE",
         "projection_parameters/fx=fx projection_parameters/fy=fy "
         "projection_parameters/cx=cx projection_parameters/cy=cy "
         "distortion_parameters/k1=k1 distortion_parameters/k2=k2 "
         "distortion_parameters/p1=p1 distortion_parameters/p2=p2"},
        {MakeKeyedPinhole("PINHOLE_FULL", 8), "model_type=PINHOLE_FULL",
         "projection_parameters/fx=fx projection_parameters/fy=fy "
         "projection_parameters/cx=cx projection_parameters/cy=cy "
         "distortion_parameters/k1=k1 distortion_parameters/k2=k2 "
         "distortion_parameters/k3=k3 distortion_parameters/k4=k4 "
         "distortion_parameters/k5=k5 distortion_parameters/k6=k6 "
         "distortion_parameters/p1=p1 distortion_parameters/p2=p2"},
        {MakeKeyedOmni("MEI"), "model_type=MEI",
         "mirror_parameters/xi=xi projection_parameters/gamma1=fx "
         "projection_parameters/gamma2=fy projection_parameters/u0=cx "
         "projection_parameters/v0=cy distortion_parameters/k1=k1 "
         "distortion_parameters/k2=k2 distortion_parameters/p1=p1 "
         "distortion_parameters/p2=p2"},
        {MakeKeyedFisheye("KANNALA_BRANDT"), "model_type=KANNALA_BRANDT",
         "projection_parameters/mu=fx projection_parameters/mv=fy "
         "projection_parameters/u0=cx projection_parameters/v0=cy "
         "projection_parameters/k2|distortion_parameters/k2=k1 "
         "projection_parameters/k3|distortion_parameters/k3=k2 "
         "projection_parameters/k4|distortion_parameters/k4=k3 "
         "projection_parameters/k5|distortion_parameters/k5=k4"}},
       "image_width image_height",
       {},
       "camera_name",
       "",
       LengthUnit::kPixel,
       {"fisheye", "fisheye_mask"},
       ".yaml"},
      {"euroc",
       "sensor.yaml of EuRoC, ASL and Kimera",
       KeyedSyntax::kYaml,
       [](const std::string& text) {
         return ContainsAll(
             text,
             {"T_BS", "intrinsics:", "distortion_model:", "camera_model:"});
       },
       "",
       {},
       {{MakeKeyedPinhole("pinhole-radtan", 5),
         "camera_model=pinhole "
         "distortion_model=radial-tangential|radtan|plumb_bob",
         "intrinsics=fx,fy,cx,cy distortion_coefficients~=k1,k2,p1,p2,k3"},
        {MakeKeyedFisheye("pinhole-equidistant"),
         "camera_model=pinhole distortion_model=equidistant|fisheye",
         "intrinsics=fx,fy,cx,cy distortion_coefficients~=k1,k2,k3,k4"},
        {MakeKeyedPinhole("pinhole-none", 0),
         "camera_model=pinhole distortion_model=none", "intrinsics=fx,fy,cx,cy",
         true}},
       "resolution",
       {{"T_BS", PoseKind::kRigFromCamera}},
       "camera_id",
       "",
       LengthUnit::kPixel,
       {"sensor_type", "comment", "rate_hz", "sensor_id", "name"},
       ".yaml",
       {{"sensor_type", "camera"}},
       "comment"},
      {"anipose",
       "calibration .toml of anipose, freemocap and Pose2Sim",
       KeyedSyntax::kToml,
       [](const std::string& text) {
         return ContainsAll(text,
                            {"matrix", "distortions", "rotation", "=", "["}) &&
                text.find('{') == std::string::npos;
       },
       "*",
       {},
       {{MakeKeyedPinhole("pinhole", 8), "fisheye?=false",
         "matrix=K distortions~=k1,k2,p1,p2,k3,k4,k5,k6"},
        {MakeOpenCvFisheyeModel("fisheye"), "fisheye=true",
         "matrix=K distortions~=k1,k2,k3,k4"}},
       "size",
       {{"rotation translation", PoseKind::kVectors}},
       "name",
       "",
       LengthUnit::kPixel,
       {"world_position", "world_orientation", "extra_dist"},
       ".toml"},
      {"okvis",
       "OKVIS's configuration .yaml",
       KeyedSyntax::kStorage,
       [](const std::string& text) {
         return ContainsAll(text, {"T_SC", "image_dimension", "focal_length",
                                   "distortion_type"});
       },
       "cameras",
       {},
       {{MakeKeyedPinhole("radialtangential", 4),
         "distortion_type=radialtangential",
         "focal_length=fx,fy principal_point=cx,cy "
         "distortion_coefficients=k1,k2,p1,p2"},
        {MakeKeyedPinhole("radialtangential8", 8),
         "distortion_type=radialtangential8",
         "focal_length=fx,fy principal_point=cx,cy "
         "distortion_coefficients=k1,k2,p1,p2,k3,k4,k5,k6"},
        {MakeKeyedFisheye("equidistant"), "distortion_type=equidistant",
         "focal_length=fx,fy principal_point=cx,cy "
         "distortion_coefficients=k1,k2,k3,k4"},
        {MakeKeyedPinhole("none", 0), "distortion_type=none",
         "focal_length=fx,fy principal_point=cx,cy", true}},
       "image_dimension",
       {{"T_SC", PoseKind::kRigFromCamera}},
       "",
       "",
       LengthUnit::kPixel,
       {"camera_type", "slam_use", "mapping", "mapping_rectification"},
       ".yaml"},
      {"opensfm",
       "OpenSfM's camera_models.json and reconstruction.json",
       KeyedSyntax::kJson,
       [](const std::string& text) {
         return ContainsAll(text,
                            {"\"projection_type\"", "\"width\"", "\"focal"});
       },
       "cameras|*",
       {},
       {{SetImageCenterOrigin(
             {"perspective", models::kOpenCv, {"f", "k1", "k2"}}),
         "projection_type=perspective", "focal=f k1?=k1 k2?=k2", true},
        {SetImageCenterOrigin(MakeKeyedPinhole("brown", 5)),
         "projection_type=brown",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1?=k1 k2?=k2 p1?=p1 p2?=p2 "
         "k3?=k3"},
        {SetImageCenterOrigin(
             MakeExternalModel("simple_radial", models::kOpenCv, {"k1"})),
         "projection_type=simple_radial",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1=k1"},
        {SetImageCenterOrigin(
             MakeExternalModel("radial", models::kOpenCv, {"k1", "k2"})),
         "projection_type=radial",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1=k1 k2=k2"},
        {SetImageCenterOrigin(
             {"fisheye", models::kThinPrismFisheye, {"f", "k1", "k2"}}),
         "projection_type=fisheye", "focal=f k1?=k1 k2?=k2", true},
        {SetImageCenterOrigin(MakeKeyedFisheye("fisheye_opencv")),
         "projection_type=fisheye_opencv",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1=k1 k2=k2 k3=k3 k4=k4"}},
       "width height",
       {},
       "",
       "",
       LengthUnit::kLongerSide,
       {"focal_prior", "focal_x_prior", "focal_y_prior", "c_x_prior",
        "c_y_prior", "k1_prior", "k2_prior", "k3_prior", "k4_prior", "p1_prior",
        "p2_prior"},
       ".json",
       {},
       "",
       {"shots", "points"}},
      {"kitti",
       "KITTI's calib_cam_to_cam.txt",
       KeyedSyntax::kLines,
       [](const std::string& text) {
         return ContainsAll(text, {"K_00:", "D_00:", "S_00:"});
       },
       "",
       {"00", "01", "02", "03"},
       {{MakeKeyedPinhole("pinhole", 5), "", "K_@=K D_@~=k1,k2,p1,p2,k3"}},
       "S_@",
       {{"R_@ T_@", PoseKind::kRAndT}},
       "",
       "",
       LengthUnit::kPixel,
       {"calib_time", "corner_dist", "S_rect_*", "R_rect_*", "P_rect_*"},
       ".txt"},
      {"kitti-rectified",
       "KITTI's calib.txt of rectified cameras",
       KeyedSyntax::kLines,
       [](const std::string& text) {
         return StartsLine(text, "P0:") || StartsLine(text, "P2:");
       },
       "",
       {"P0", "P1", "P2", "P3"},
       {{MakeKeyedPinhole("pinhole", 0), "", "@=P"}},
       "",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {"Tr*", "R0_rect", "R_rect", "calib_time", "corner_dist"},
       ".txt"},
      {"svo",
       "cameras .yaml of SVO Pro and maplab",
       KeyedSyntax::kYaml,
       [](const std::string& text) {
         return ContainsAll(text,
                            {"T_B_C:", "cameras:", "camera:", "distortion:"});
       },
       "cameras",
       {},
       {{MakeKeyedPinhole("pinhole-radtan", 4),
         "camera/type=pinhole camera/distortion/type=radial-tangential",
         "camera/intrinsics=fx,fy,cx,cy "
         "camera/distortion/parameters=k1,k2,p1,p2"},
        {MakeOpenCvFisheyeModel("pinhole-equidistant"),
         "camera/type=pinhole camera/distortion/type=equidistant",
         "camera/intrinsics=fx,fy,cx,cy "
         "camera/distortion/parameters=k1,k2,k3,k4"},
        {MakeKeyedPinhole("pinhole-none", 0),
         "camera/type=pinhole camera/distortion/type=none",
         "camera/intrinsics=fx,fy,cx,cy"},
        {MakeKeyedOmni("unified-projection"),
         "camera/type=unified-projection "
         "camera/distortion/type=radial-tangential",
         "camera/intrinsics=xi,fx,fy,cx,cy "
         "camera/distortion/parameters=k1,k2,p1,p2"}},
       "camera/image_width camera/image_height",
       {{"T_B_C", PoseKind::kRigFromCamera}},
       "camera/label",
       "",
       LengthUnit::kPixel,
       {"camera/id", "camera/line-delay-nanoseconds", "camera/mask"}},
      // Programs may downscale images; the intrinsics refer to full resolution.
      {"vikit",
       "camera .yaml of vikit: SVO, FAST-LIVO and FAST-LIVO2",
       KeyedSyntax::kYaml,
       [](const std::string& text) {
         return ContainsAll(text, {"cam_model:", "cam_fx:"}) ||
                ContainsAll(text, {"ros__parameters:", "model:", "fx:", "d0:"});
       },
       "",
       {},
       {{MakeKeyedPinhole("Pinhole", 5),
         "cam_model|model=Pinhole|PinholeRadTan",
         "cam_fx|fx=fx cam_fy|fy=fy cam_cx|cx=cx cam_cy|cy=cy cam_d0|d0?=k1 "
         "cam_d1|d1?=k2 cam_d2|d2?=p1 cam_d3|d3?=p2 cam_d4|d4?=k3"},
        {MakeOpenCvFisheyeModel("EquidistantCamera"),
         "cam_model|model=EquidistantCamera|PinholeEquidistant",
         "cam_fx|fx=fx cam_fy|fy=fy cam_cx|cx=cx cam_cy|cy=cy "
         "cam_d0|d0|k1=k1 cam_d1|d1|k2=k2 cam_d2|d2|k3=k3 cam_d3|d3|k4=k4"}},
       "cam_width|width cam_height|height",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {"scale"}},
      // The toolbox uses 0-based pixel coordinates.
      {"matlab",
       "Calib_Results.m and Calib_Results_stereo.m of the Camera Calibration "
       "Toolbox for MATLAB",
       KeyedSyntax::kAssignments,
       [](const std::string& text) {
         return ContainsAll(text, {"fc = [", "cc = [", "kc = ["}) ||
                ContainsAll(text, {"fc_left = [", "kc_right = ["});
       },
       "",
       {"", "_left", "_right"},
       {{MakeKeyedPinhole("pinhole", 5), "",
         "fc@=fx,fy cc@=cx,cy kc@~=k1,k2,p1,p2,k3"}},
       "nx ny",
       {{"om T", PoseKind::kVectors, "_right"}},
       "",
       "",
       LengthUnit::kPixel,
       {"fc_*", "cc_*", "kc_*", "alpha_c_error*", "est_*", "center_optim*",
        "n_ima", "omc_*", "Tc_*", "om_error", "T_error"}},
      {"middlebury",
       "calib.txt of the Middlebury stereo benchmark",
       KeyedSyntax::kAssignments,
       [](const std::string& text) {
         return ContainsAll(text, {"cam0=[", "cam1=[", "baseline="});
       },
       "",
       {"cam0", "cam1"},
       {{MakeKeyedPinhole("pinhole", 0), "", "@=K"}},
       "width height",
       {{"baseline", PoseKind::kBaselineMm, "cam1"}},
       "",
       "",
       LengthUnit::kPixel,
       {"doffs", "ndisp", "isint", "vmin", "vmax", "dyavg", "dymax"}},
      // BoofCV interpolates at integer pixel centres.
      {"boofcv",
       "BoofCV's intrinsic and stereo .yaml",
       KeyedSyntax::kYaml,
       [](const std::string& text) {
         return ContainsAll(text, {"pinhole:", "skew:", "model:"}) &&
                !ContainsAll(text, {"model_type:"});
       },
       "",
       {"", "left/", "right/", "intrinsic/"},
       {{MakeKeyedPinhole("pinhole_radial_tangential", 5),
         "@model=pinhole_radial_tangential",
         "@pinhole/fx=fx @pinhole/fy=fy @pinhole/cx=cx @pinhole/cy=cy "
         "@pinhole/skew?=skew @radial_tangential/radial?=k1,k2,k3 "
         "@radial_tangential/t1?=p1 @radial_tangential/t2?=p2"},
        {MakeKeyedPinhole("pinhole", 0), "@model=pinhole",
         "@pinhole/fx=fx @pinhole/fy=fy @pinhole/cx=cx @pinhole/cy=cy "
         "@pinhole/skew?=skew"},
        {MakeKeyedOmni("omnidirectional_universal"),
         "@model=omnidirectional_universal",
         "@mirror_offset=xi @pinhole/fx=fx @pinhole/fy=fy @pinhole/cx=cx "
         "@pinhole/cy=cy @pinhole/skew?=skew @radial_tangential/radial?=k1,k2 "
         "@radial_tangential/t1?=p1 @radial_tangential/t2?=p2"}},
       "@pinhole/width @pinhole/height",
       {{"rightToLeft/rotation rightToLeft/x rightToLeft/y rightToLeft/z",
         PoseKind::kInverseRAndT, "right/"}},
       "",
       "",
       LengthUnit::kPixel,
       {"model", "version", "left/version", "right/version",
        "intrinsic/version", "max_depth", "no_depth", "plane_to_camera"}},
      // Cereal writes the name of a model only at its first occurrence.
      {"openmvg",
       "OpenMVG's sfm_data.json",
       KeyedSyntax::kJson,
       [](const std::string& text) {
         return ContainsAll(text, {"\"sfm_data_version\"", "\"intrinsics\""});
       },
       "intrinsics",
       {},
       {{KeyedSingleFocal("pinhole_radial_k3", models::kOpenCv,
                          {"k1", "k2", "k3"}),
         "value/ptr_wrapper/data/disto_k3",
         KEYED_MVG " value/ptr_wrapper/data/disto_k3=k1,k2,k3"},
        {KeyedSingleFocal("pinhole_radial_k1", models::kOpenCv, {"k1"}),
         "value/ptr_wrapper/data/disto_k1",
         KEYED_MVG " value/ptr_wrapper/data/disto_k1=k1"},
        {KeyedSingleFocal("pinhole_brown_t2", models::kOpenCv,
                          {"k1", "k2", "k3", "p1", "p2"}),
         "value/ptr_wrapper/data/disto_t2",
         KEYED_MVG " value/ptr_wrapper/data/disto_t2=k1,k2,k3,p1,p2"},
        {KeyedSingleFocal("fisheye", models::kThinPrismFisheye,
                          {"k1", "k2", "k3", "k4"}),
         "value/ptr_wrapper/data/fisheye",
         KEYED_MVG " value/ptr_wrapper/data/fisheye=k1,k2,k3,k4"},
        {KeyedSingleFocal("pinhole", models::kOpenCv, {}),
         "value/polymorphic_name=pinhole", KEYED_MVG}},
       "value/ptr_wrapper/data/value0/width|value/ptr_wrapper/data/width "
       "value/ptr_wrapper/data/value0/height|value/ptr_wrapper/data/height",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {"key", "value/polymorphic_id", "value/polymorphic_name",
        "value/ptr_wrapper/id", "value/ptr_wrapper/data/ccdw"},
       "",
       {},
       "",
       {"views", "extrinsics", "structure", "control_points"}},
      // Before version 1.2.0, pixel coordinates are relative to the centre of
      // the first pixel; later, principal points are relative to the image
      // centre.
      {"alicevision",
       "AliceVision's and Meshroom's .sfm",
       KeyedSyntax::kJson,
       [](const std::string& text) {
         return ContainsAll(text, {"\"intrinsics\"", "\"distortionParams\"",
                                   "\"version\"", "\"principalPoint\""});
       },
       "intrinsics",
       {},
       {{KeyedSingleFocal("radial3", models::kOpenCv, {"k1", "k2", "k3"}),
         "pxFocalLength type=radial3|radial1",
         KEYED_OLD_SFM " distortionParams~=k1,k2,k3"},
        {KeyedSingleFocal("brown", models::kOpenCv,
                          {"k1", "k2", "k3", "p1", "p2"}),
         "pxFocalLength type=brown",
         KEYED_OLD_SFM " distortionParams=k1,k2,k3,p1,p2"},
        {KeyedSingleFocal("fisheye4", models::kThinPrismFisheye,
                          {"k1", "k2", "k3", "k4"}),
         "pxFocalLength type=fisheye4",
         KEYED_OLD_SFM " distortionParams=k1,k2,k3,k4"},
        {KeyedSingleFocal("pinhole", models::kOpenCv, {}),
         "pxFocalLength type=pinhole",
         KEYED_OLD_SFM " distortionParams?=0,0,0"},
        {SetImageCenterOrigin(
             KeyedSingleFocal("radial3", models::kOpenCv, {"k1", "k2", "k3"})),
         "focalLength type=radial3|radial1",
         KEYED_SFM " distortionParams~=k1,k2,k3"},
        {SetImageCenterOrigin(
             KeyedSingleFocal("radial3", models::kOpenCv, {"k1", "k2", "k3"})),
         "focalLength type=pinhole distortionType=radialk3|radialk1",
         KEYED_SFM " distortionParams~=k1,k2,k3"},
        {SetImageCenterOrigin(KeyedSingleFocal("brown", models::kOpenCv,
                                               {"k1", "k2", "k3", "p1", "p2"})),
         "focalLength type=brown",
         KEYED_SFM " distortionParams=k1,k2,k3,p1,p2"},
        {SetImageCenterOrigin(KeyedSingleFocal(
             "fisheye4", models::kThinPrismFisheye, {"k1", "k2", "k3", "k4"})),
         "focalLength type=fisheye4",
         KEYED_SFM " distortionParams=k1,k2,k3,k4"},
        {SetImageCenterOrigin(KeyedSingleFocal("pinhole", models::kOpenCv, {})),
         "focalLength type=pinhole distortionType?=none",
         KEYED_SFM " distortionParams?=0,0,0"}},
       "width height",
       {},
       "",
       "pixelRatio",
       LengthUnit::kPixel,
       {"intrinsicId", "serialNumber", "initializationMode",
        "initialFocalLength", "pxInitialFocalLength",
        "distortionInitializationMode", "pixelRatioLocked", "offsetLocked",
        "scaleLocked", "distortionLocked", "sensorWidth", "sensorHeight",
        "locked"},
       "",
       {},
       "",
       {"views", "poses", "rigs", "structure", "featuresFolders",
        "matchesFolders"}},
      // For fisheye cameras, D holds the cv::fisheye coefficients under pinhole
      // key names.
      {"ov2slam",
       "OV2SLAM's parameters .yaml",
       KeyedSyntax::kStorage,
       [](const std::string& text) {
         return ContainsAll(text, {"Camera.fxl", "Camera.model_left"});
       },
       "",
       {"left", "right"},
       {{MakeKeyedPinhole("pinhole", 4), "Camera.model_@=pinhole",
         "Camera.fx%=fx Camera.fy%=fy Camera.cx%=cx Camera.cy%=cy "
         "Camera.k1%=k1 Camera.k2%=k2 Camera.p1%=p1 Camera.p2%=p2"},
        {MakeOpenCvFisheyeModel("fisheye"), "Camera.model_@=fisheye",
         "Camera.fx%=fx Camera.fy%=fy Camera.cx%=cx Camera.cy%=cy "
         "Camera.k1%=k1 Camera.k2%=k2 Camera.p1%=k3 Camera.p2%=k4"}},
       "Camera.@_nwidth Camera.@_nheight",
       {{"body_T_cam0", PoseKind::kRigFromCamera, "left"},
        {"body_T_cam1", PoseKind::kRigFromCamera, "right"}},
       "",
       "",
       LengthUnit::kPixel,
       {"Camera.topic_*", "Camera.model_right",
        "Camera.right_*", "debug",
        "log_timings",    "mono",
        "stereo",         "force_realtime",
        "slam_mode",      "buse_*",
        "bdo_*",          "alpha",
        "finit_*",        "use_*",
        "nmax*",          "nmin*",
        "nfast_th",       "nklt_*",
        "nransac_iter",   "dmaxquality",
        "fclahe_val",     "fmax_*",
        "fransac_err",    "fkf_*",
        "do_*",           "doepipolar",
        "dop3p",          "klt_*",
        "btrack_*",       "robust_mono_th",
        "apply_l2_*"}},
      {"openpose",
       "OpenPose's camera .xml",
       KeyedSyntax::kStorage,
       [](const std::string& text) {
         return ContainsAll(text,
                            {"<CameraMatrix", "<Intrinsics", "<Distortion"});
       },
       "",
       {},
       {{MakeKeyedPinhole("pinhole", 8), "",
         "Intrinsics=K Distortion~=k1,k2,p1,p2,k3,k4,k5,k6"}},
       "",
       {{"CameraMatrix", PoseKind::kCameraFromRig}},
       "",
       "",
       LengthUnit::kPixel,
       {"CameraMatrixInitial"}},
      // Kp is the projector's camera matrix.
      {"slstudio",
       "SLStudio's calibration .xml",
       KeyedSyntax::kStorage,
       [](const std::string& text) {
         return ContainsAll(text, {"<Kc", "<kc", "<frameWidth"});
       },
       "",
       {},
       {{MakeKeyedPinhole("pinhole", 5), "", "Kc=K kc~=k1,k2,p1,p2,k3"}},
       "frameWidth frameHeight",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {"cam_error", "proj_error", "stereo_error", "screenRes*"}},
      {"infinitam",
       "InfiniTAM's calib.txt",
       KeyedSyntax::kBlocks,
       IsInfiniTam,
       "",
       {"0", "1"},
       {{MakeKeyedPinhole("pinhole", 0), "", "@=width,height,fx,fy,cx,cy"}},
       "",
       {{"2", PoseKind::kCameraFromRig, "1"}},
       "",
       "",
       LengthUnit::kPixel,
       {"3"}},
      {"calibanything",
       "calib.txt of CalibAnything",
       KeyedSyntax::kLines,
       [](const std::string& text) {
         return StartsLine(text, "K:") && StartsLine(text, "T:") &&
                text.find_first_of("[{\"") == std::string::npos &&
                text.find("- ") == std::string::npos;  // no list of YAML
       },
       "",
       {},
       {{MakeKeyedPinhole("pinhole", 5), "", "K=K D?=k1,k2,p1,p2,k3"}},
       "",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {"T"}},
      {"scannet",
       "scene .txt of ScanNet",
       KeyedSyntax::kAssignments,
       [](const std::string& text) {
         return ContainsAll(text, {"fx_color", "mx_color", "colorWidth"});
       },
       "",
       {"color", "depth"},
       {{MakeKeyedPinhole("pinhole", 0), "",
         "fx_@=fx fy_@=fy mx_@=cx my_@=cy"}},
       "@Width @Height",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {"axisAlignment", "num*", "device*", "scene*"}},
      {"sens",
       "info.txt of .sens files: ScanNet, 3RScan, 12Scenes",
       KeyedSyntax::kAssignments,
       [](const std::string& text) {
         return ContainsAll(text,
                            {"m_calibrationColorIntrinsic", "m_colorWidth"});
       },
       "",
       {},
       {{MakeKeyedPinhole("pinhole", 0), "", "m_calibrationColorIntrinsic=K"}},
       "m_colorWidth m_colorHeight",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {"m_versionNumber", "m_sensorName", "m_calibrationColorExtrinsic",
        "m_depth*", "m_frames*"}},
      // Each resolution is a separate camera.
      {"zed",
       "SN*.conf of ZED cameras",
       KeyedSyntax::kToml,
       [](const std::string& text) {
         return ContainsAll(text, {"[LEFT_CAM_", "[STEREO]"});
       },
       "",
       {"LEFT_CAM_2K", "RIGHT_CAM_2K", "LEFT_CAM_FHD", "RIGHT_CAM_FHD",
        "LEFT_CAM_HD", "RIGHT_CAM_HD", "LEFT_CAM_VGA", "RIGHT_CAM_VGA"},
       {{MakeKeyedPinhole("pinhole", 5), "",
         "@/fx=fx @/fy=fy @/cx=cx @/cy=cy @/k1=k1 @/k2=k2 @/p1?=p1 @/p2?=p2 "
         "@/k3?=k3"}},
       "2K=2208x1242 FHD=1920x1080 HD=1280x720 VGA=672x376",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {}},
      {"orbbec",
       "camera parameters .ini of Orbbec's viewer",
       KeyedSyntax::kToml,
       [](const std::string& text) {
         return ContainsAll(text, {"[ColorIntrinsic]", "[DepthIntrinsic]"});
       },
       "",
       {"Color", "Depth"},
       {{MakeKeyedPinhole("rational", 8), "",
         "@Intrinsic/fx=fx @Intrinsic/fy=fy @Intrinsic/cx=cx @Intrinsic/cy=cy "
         "@Distortion/k1=k1 @Distortion/k2=k2 @Distortion/k3=k3 "
         "@Distortion/k4=k4 @Distortion/k5=k5 @Distortion/k6=k6 "
         "@Distortion/p1=p1 @Distortion/p2=p2"}},
       "@Intrinsic/width @Intrinsic/height",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {}},
      // Intrinsics are relative to the sensor size, measured from its corner.
      // Video modes crop and scale the sensor image.
      {"azure-kinect",
       "raw calibration .json of Azure Kinect",
       KeyedSyntax::kJson,
       [](const std::string& text) {
         return ContainsAll(
             text, {"\"CalibrationInformation\"", "\"ModelParameters\""});
       },
       "CalibrationInformation/Cameras",
       {},
       {{WithOrigin(PixelOrigin::kImageCorner,
                    MakeKeyedPinhole("BrownConrady", 8)),
         "Intrinsics/ModelType=CALIBRATION_LensDistortionModelBrownConrady",
         "Intrinsics/ModelParameters=cx,cy,fx,fy,k1,k2,k3,k4,k5,k6,0,0,p2,p1"}},
       "SensorWidth SensorHeight",
       {{"Rt/Rotation Rt/Translation", PoseKind::kRAndT}},
       "Purpose",
       "",
       LengthUnit::kImageSides,
       {"Location", "MetricRadius", "Shutter", "ThermalAdjustmentParams",
        "Intrinsics/ModelParameterCount"}},
      {"calib-line",
       "calib.txt of one line, as in DROID-SLAM: fx fy cx cy [k1 k2 p1 p2 "
       "[k3]]",
       KeyedSyntax::kNumbers,
       IsNumberLine,
       "",
       {},
       {{MakeKeyedPinhole("pinhole", 5), "",
         "numbers~=fx,fy,cx,cy,k1,k2,p1,p2,k3"}},
       "",
       {},
       "",
       "",
       LengthUnit::kPixel,
       {},
       ".txt"}};
  return table;
}

std::vector<std::string> SplitText(const std::string& text, char space) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, space);)
    if (!word.empty()) words.push_back(word);
  return words;
}

std::string FindNumberLine(const std::string& text) {
  constexpr char kSpaces[] = " \t\r";
  std::istringstream lines(text);
  std::string found;
  for (std::string line; std::getline(lines, line);) {
    const size_t first = line.find_first_not_of(kSpaces);
    if (first == std::string::npos || line[first] == '#') continue;
    if (!found.empty()) return "another line";
    found = line;
  }
  return found;
}

std::string SubstituteCameraName(std::string key, const std::string& word) {
  for (const auto& [mark, text] :
       {std::pair('@', word), {'%', word.substr(0, 1)}})
    for (size_t at = key.find(mark); at != std::string::npos;
         at = key.find(mark, at + text.size()))
      key.replace(at, 1, text);
  return key;
}

KeyWithMark SplitAtMark(const std::string& text, char mark,
                        const std::string& word) {
  const size_t equals = text.find('=');
  KeyWithMark parted = {text.substr(0, equals), equals == std::string::npos
                                                    ? ""
                                                    : text.substr(equals + 1)};
  parted.has_mark = parted.key.back() == mark;
  if (parted.has_mark) parted.key.pop_back();
  parted.key = SubstituteCameraName(parted.key, word);
  return parted;
}

}  // namespace raygrid
