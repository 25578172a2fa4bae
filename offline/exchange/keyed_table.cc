#include "exchange/keyed_table.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <sstream>

#include "exchange/opencv_forms.h"
#include "exchange/radial_lens.h"

namespace raygrid {
namespace {

bool HasAllWords(const std::string& text,
                 std::initializer_list<const char*> words) {
  return std::all_of(words.begin(), words.end(), [&](const char* word) {
    return text.find(word) != std::string::npos;
  });
}

// A line of 4, 8 or 9 numbers.
bool IsLineOfNumbers(const std::string& text) {
  constexpr size_t kLongest = 400;
  if (text.size() > kLongest) return false;
  const std::string line = FindNumberLine(text);
  if (line.find_first_not_of("0123456789.+-eE \t\r") != std::string::npos)
    return false;
  std::istringstream words(line);
  size_t count = 0;
  for (double number = 0; words >> number;) ++count;
  return words.eof() && (count == 4 || count == 8 || count == 9);
}

LensForm KeyedPinhole(const char* name, int count) {
  return OpenCvForm(name, count);
}
LensForm KeyedPinhole(const char* name,
                      const std::vector<std::string>& coefficients) {
  LensForm form = MakeForm(name, models::kOpenCv, coefficients);
  form.reach_rad = M_PI / 2;
  return form;
}
LensForm KeyedFisheye(const char* name) {
  LensForm form = OpenCvFisheyeForm(name);
  form.reach_rad = M_PI;
  return form;
}
LensForm KeyedOmni(const char* name) {
  return MakeForm(name, models::kOmniRadtan, {"xi", "k1", "k2", "p1", "p2"});
}
// OpenSfM's pixel origin is the image centre.
LensForm FromMiddle(LensForm form) {
  form.origin = PixelOrigin::kImageMiddle;
  return form;
}

}  // namespace

const std::vector<KeyedFormat>& ListKeyedFormats() {
  static const std::vector<KeyedFormat> table = {
      {"gyroflow",
       "Gyroflow's lens profile .json",
       KeyedSyntax::kJson,
       [](const std::string& text) {
         return HasAllWords(text,
                            {"\"fisheye_params\"", "\"calib_dimension\""});
       },
       "",
       {},
       {{OpenCvFisheyeForm("opencv_fisheye"),
         "distortion_model?=opencv_fisheye",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1,k2,k3,k4"},
        {KeyedPinhole("opencv_standard", 12),
         "distortion_model=opencv_standard",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1,k2,p1,p2,k3,k4,k5,k6,s1,s2,s3,"
         "s4"},
        // Lensfun's polynomials of the radius, in focal lengths.
        {KeyedPinhole("poly3", {"k1"}), "distortion_model=poly3",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1",
         true},
        {KeyedPinhole("poly5", {"k1", "k2"}), "distortion_model=poly5",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=k1,k2",
         true},
        {RadialLensForm("ptlens"), "distortion_model=ptlens",
         "fisheye_params/camera_matrix=K "
         "fisheye_params/distortion_coeffs~=a,b,c",
         true}},
       "calib_dimension/w calib_dimension/h",
       {},
       "",
       "input_horizontal_stretch input_vertical_stretch",
       false,
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
         return HasAllWords(text, {"Camera.fx"}) ||
                HasAllWords(text, {"Camera1.fx"});
       },
       "",
       {"Camera", "Camera1", "Camera2"},
       {{KeyedPinhole("PinHole", 5),
         "Camera.type?=PinHole Camera.model?=perspective",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy @.k1?=k1 @.k2?=k2 @.p1?=p1 @.p2?=p2 "
         "@.k3?=k3"},
        {KeyedPinhole("Rectified", 0), "Camera.type=Rectified",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy", true},
        {KeyedFisheye("KannalaBrandt8"), "Camera.type=KannalaBrandt8",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy @.k1=k1 @.k2=k2 @.k3=k3 @.k4=k4"},
        {OpenCvFisheyeForm("fisheye"), "Camera.model=fisheye",
         "@.fx=fx @.fy=fy @.cx=cx @.cy=cy @.k1=k1 @.k2=k2 @.k3=k3 @.k4=k4",
         true}},
       "Camera.width|Camera.cols Camera.height|Camera.rows",
       {{"Stereo.T_c1_c2", PoseKind::kRigFromCamera, "Camera2"},
        {"Tlr", PoseKind::kRigFromCamera, "Camera2"}},
       "",
       "",
       false,
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
         return HasAllWords(text, {"model_type:", "projection_parameters:"});
       },
       "",
       {},
       {{KeyedPinhole("PINHOLE", 4), "model_type=PINHOLE",
         "projection_parameters/fx=fx projection_parameters/fy=fy "
         "projection_parameters/cx=cx projection_parameters/cy=cy "
         "distortion_parameters/k1=k1 distortion_parameters/k2=k2 "
         "distortion_parameters/p1=p1 distortion_parameters/p2=p2"},
        {KeyedPinhole("PINHOLE_FULL", 8), "model_type=PINHOLE_FULL",
         "projection_parameters/fx=fx projection_parameters/fy=fy "
         "projection_parameters/cx=cx projection_parameters/cy=cy "
         "distortion_parameters/k1=k1 distortion_parameters/k2=k2 "
         "distortion_parameters/k3=k3 distortion_parameters/k4=k4 "
         "distortion_parameters/k5=k5 distortion_parameters/k6=k6 "
         "distortion_parameters/p1=p1 distortion_parameters/p2=p2"},
        {KeyedOmni("MEI"), "model_type=MEI",
         "mirror_parameters/xi=xi projection_parameters/gamma1=fx "
         "projection_parameters/gamma2=fy projection_parameters/u0=cx "
         "projection_parameters/v0=cy distortion_parameters/k1=k1 "
         "distortion_parameters/k2=k2 distortion_parameters/p1=p1 "
         "distortion_parameters/p2=p2"},
        {KeyedFisheye("KANNALA_BRANDT"), "model_type=KANNALA_BRANDT",
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
       false,
       {"fisheye", "fisheye_mask"},
       ".yaml"},
      {"euroc",
       "sensor.yaml of EuRoC, ASL and Kimera",
       KeyedSyntax::kYaml,
       [](const std::string& text) {
         return HasAllWords(
             text,
             {"T_BS", "intrinsics:", "distortion_model:", "camera_model:"});
       },
       "",
       {},
       {{KeyedPinhole("pinhole-radtan", 5),
         "camera_model=pinhole "
         "distortion_model=radial-tangential|radtan|plumb_bob",
         "intrinsics=fx,fy,cx,cy distortion_coefficients~=k1,k2,p1,p2,k3"},
        {KeyedFisheye("pinhole-equidistant"),
         "camera_model=pinhole distortion_model=equidistant|fisheye",
         "intrinsics=fx,fy,cx,cy distortion_coefficients~=k1,k2,k3,k4"},
        {KeyedPinhole("pinhole-none", 0),
         "camera_model=pinhole distortion_model=none", "intrinsics=fx,fy,cx,cy",
         true}},
       "resolution",
       {{"T_BS", PoseKind::kRigFromCamera}},
       "camera_id",
       "",
       false,
       {"sensor_type", "comment", "rate_hz", "sensor_id", "name"},
       ".yaml",
       {{"sensor_type", "camera"}},
       "comment"},
      {"anipose",
       "calibration .toml of anipose, freemocap and Pose2Sim",
       KeyedSyntax::kToml,
       [](const std::string& text) {
         return HasAllWords(text,
                            {"matrix", "distortions", "rotation", "=", "["}) &&
                text.find('{') == std::string::npos;
       },
       "*",
       {},
       {{KeyedPinhole("pinhole", 8), "fisheye?=false",
         "matrix=K distortions~=k1,k2,p1,p2,k3,k4,k5,k6"},
        {OpenCvFisheyeForm("fisheye"), "fisheye=true",
         "matrix=K distortions~=k1,k2,k3,k4"}},
       "size",
       {{"rotation translation", PoseKind::kVectors}},
       "name",
       "",
       false,
       {"world_position", "world_orientation", "extra_dist"},
       ".toml"},
      {"okvis",
       "OKVIS's configuration .yaml",
       KeyedSyntax::kStorage,
       [](const std::string& text) {
         return HasAllWords(text, {"T_SC", "image_dimension", "focal_length",
                                   "distortion_type"});
       },
       "cameras",
       {},
       {{KeyedPinhole("radialtangential", 4),
         "distortion_type=radialtangential",
         "focal_length=fx,fy principal_point=cx,cy "
         "distortion_coefficients=k1,k2,p1,p2"},
        {KeyedPinhole("radialtangential8", 8),
         "distortion_type=radialtangential8",
         "focal_length=fx,fy principal_point=cx,cy "
         "distortion_coefficients=k1,k2,p1,p2,k3,k4,k5,k6"},
        {KeyedFisheye("equidistant"), "distortion_type=equidistant",
         "focal_length=fx,fy principal_point=cx,cy "
         "distortion_coefficients=k1,k2,k3,k4"},
        {KeyedPinhole("none", 0), "distortion_type=none",
         "focal_length=fx,fy principal_point=cx,cy", true}},
       "image_dimension",
       {{"T_SC", PoseKind::kRigFromCamera}},
       "",
       "",
       false,
       {"camera_type", "slam_use", "mapping", "mapping_rectification"},
       ".yaml"},
      {"opensfm",
       "OpenSfM's camera_models.json and reconstruction.json",
       KeyedSyntax::kJson,
       [](const std::string& text) {
         return HasAllWords(text,
                            {"\"projection_type\"", "\"width\"", "\"focal"});
       },
       "*",
       {},
       {{FromMiddle({"perspective", models::kOpenCv, {"f", "k1", "k2"}}),
         "projection_type=perspective", "focal=f k1?=k1 k2?=k2", true},
        {FromMiddle(KeyedPinhole("brown", 5)), "projection_type=brown",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1?=k1 k2?=k2 p1?=p1 p2?=p2 "
         "k3?=k3"},
        {FromMiddle(MakeForm("simple_radial", models::kOpenCv, {"k1"})),
         "projection_type=simple_radial",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1=k1"},
        {FromMiddle(MakeForm("radial", models::kOpenCv, {"k1", "k2"})),
         "projection_type=radial",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1=k1 k2=k2"},
        {FromMiddle({"fisheye", models::kThinPrismFisheye, {"f", "k1", "k2"}}),
         "projection_type=fisheye", "focal=f k1?=k1 k2?=k2", true},
        {FromMiddle(KeyedFisheye("fisheye_opencv")),
         "projection_type=fisheye_opencv",
         "focal_x=fx focal_y=fy c_x=cx c_y=cy k1=k1 k2=k2 k3=k3 k4=k4"}},
       "width height",
       {},
       "",
       "",
       true,
       {"focal_prior", "focal_x_prior", "focal_y_prior", "c_x_prior",
        "c_y_prior", "k1_prior", "k2_prior", "k3_prior", "k4_prior", "p1_prior",
        "p2_prior"},
       ".json"},
      {"kitti",
       "KITTI's calib_cam_to_cam.txt",
       KeyedSyntax::kLines,
       [](const std::string& text) {
         return HasAllWords(text, {"K_00:", "D_00:", "S_00:"});
       },
       "",
       {"00", "01", "02", "03"},
       {{KeyedPinhole("pinhole", 5), "", "K_@=K D_@~=k1,k2,p1,p2,k3"}},
       "S_@",
       {{"R_@ T_@", PoseKind::kRAndT}},
       "",
       "",
       false,
       {"calib_time", "corner_dist", "S_rect_*", "R_rect_*", "P_rect_*"},
       ".txt"},
      {"kitti-rectified",
       "KITTI's calib.txt of rectified cameras",
       KeyedSyntax::kLines,
       [](const std::string& text) {
         return text.rfind("P0:", 0) == 0 || HasAllWords(text, {"\nP0:"});
       },
       "",
       {"P0", "P1", "P2", "P3"},
       {{KeyedPinhole("pinhole", 0), "", "@=P"}},
       "",
       {},
       "",
       "",
       false,
       {"Tr*", "R0_rect", "R_rect", "calib_time", "corner_dist"},
       ".txt"},
      {"svo",
       "cameras .yaml of SVO Pro and maplab",
       KeyedSyntax::kYaml,
       [](const std::string& text) {
         return HasAllWords(text,
                            {"T_B_C:", "cameras:", "camera:", "distortion:"});
       },
       "cameras",
       {},
       {{KeyedPinhole("pinhole-radtan", 4),
         "camera/type=pinhole camera/distortion/type=radial-tangential",
         "camera/intrinsics=fx,fy,cx,cy "
         "camera/distortion/parameters=k1,k2,p1,p2"},
        {OpenCvFisheyeForm("pinhole-equidistant"),
         "camera/type=pinhole camera/distortion/type=equidistant",
         "camera/intrinsics=fx,fy,cx,cy "
         "camera/distortion/parameters=k1,k2,k3,k4"},
        {KeyedPinhole("pinhole-none", 0),
         "camera/type=pinhole camera/distortion/type=none",
         "camera/intrinsics=fx,fy,cx,cy"},
        {KeyedOmni("unified-projection"),
         "camera/type=unified-projection "
         "camera/distortion/type=radial-tangential",
         "camera/intrinsics=xi,fx,fy,cx,cy "
         "camera/distortion/parameters=k1,k2,p1,p2"}},
       "camera/image_width camera/image_height",
       {{"T_B_C", PoseKind::kRigFromCamera}},
       "camera/label",
       "",
       false,
       {"camera/id", "camera/line-delay-nanoseconds", "camera/mask"}},
      // Programs may scale images; the camera belongs to full-size images.
      {"vikit",
       "camera .yaml of vikit: SVO, FAST-LIVO and FAST-LIVO2",
       KeyedSyntax::kYaml,
       [](const std::string& text) {
         return HasAllWords(text, {"cam_model:", "cam_fx:"}) ||
                HasAllWords(text, {"ros__parameters:", "model:", "fx:", "d0:"});
       },
       "",
       {},
       {{KeyedPinhole("Pinhole", 5), "cam_model|model=Pinhole|PinholeRadTan",
         "cam_fx|fx=fx cam_fy|fy=fy cam_cx|cx=cx cam_cy|cy=cy cam_d0|d0?=k1 "
         "cam_d1|d1?=k2 cam_d2|d2?=p1 cam_d3|d3?=p2 cam_d4|d4?=k3"},
        {OpenCvFisheyeForm("EquidistantCamera"),
         "cam_model|model=EquidistantCamera|PinholeEquidistant",
         "cam_fx|fx=fx cam_fy|fy=fy cam_cx|cx=cx cam_cy|cy=cy "
         "cam_d0|d0|k1=k1 cam_d1|d1|k2=k2 cam_d2|d2|k3=k3 cam_d3|d3|k4=k4"}},
       "cam_width|width cam_height|height",
       {},
       "",
       "",
       false,
       {"scale"}},
      // The toolbox has 0-based pixels.
      {"matlab",
       "Calib_Results.m and Calib_Results_stereo.m of the Camera Calibration "
       "Toolbox for MATLAB",
       KeyedSyntax::kAssignments,
       [](const std::string& text) {
         return HasAllWords(text, {"fc = [", "cc = [", "kc = ["}) ||
                HasAllWords(text, {"fc_left = [", "kc_right = ["});
       },
       "",
       {"", "_left", "_right"},
       {{KeyedPinhole("pinhole", 5), "",
         "fc@=fx,fy cc@=cx,cy kc@~=k1,k2,p1,p2,k3"}},
       "nx ny",
       {{"om T", PoseKind::kVectors, "_right"}},
       "",
       "",
       false,
       {"fc_*", "cc_*", "kc_*", "alpha_c_error*", "est_*", "center_optim*",
        "n_ima", "omc_*", "Tc_*", "om_error", "T_error"}},
      {"middlebury",
       "calib.txt of the Middlebury stereo benchmark",
       KeyedSyntax::kAssignments,
       [](const std::string& text) {
         return HasAllWords(text, {"cam0=[", "cam1=[", "baseline="});
       },
       "",
       {"cam0", "cam1"},
       {{KeyedPinhole("pinhole", 0), "", "@=K"}},
       "width height",
       {{"baseline", PoseKind::kBaselineMm, "cam1"}},
       "",
       "",
       false,
       {"doffs", "ndisp", "isint", "vmin", "vmax", "dyavg", "dymax"}},
      {"calib-line",
       "calib.txt of one line, as in DROID-SLAM: fx fy cx cy [k1 k2 p1 p2 "
       "[k3]]",
       KeyedSyntax::kNumbers,
       IsLineOfNumbers,
       "",
       {},
       {{KeyedPinhole("pinhole", 5), "",
         "numbers~=fx,fy,cx,cy,k1,k2,p1,p2,k3"}},
       "",
       {},
       "",
       "",
       false,
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

std::string SubstituteWord(std::string key, const std::string& word) {
  const size_t at = key.find('@');
  return at == std::string::npos ? key : key.replace(at, 1, word);
}

KeyedWord SplitAtMark(const std::string& text, char mark,
                      const std::string& word) {
  const size_t equals = text.find('=');
  KeyedWord parted = {text.substr(0, equals), text.substr(equals + 1)};
  parted.has_mark = parted.key.back() == mark;
  if (parted.has_mark) parted.key.pop_back();
  parted.key = SubstituteWord(parted.key, word);
  return parted;
}

}  // namespace raygrid
