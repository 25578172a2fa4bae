#include "exchange/opencv_format.h"

#include <string>
#include <vector>

#include "dataset/error.h"
#include "exchange/file_storage.h"
#include "exchange/opencv_boards.h"
#include "exchange/opencv_cameras.h"
#include "exchange/opencv_models.h"

namespace raygrid {
namespace {

using opencv_file::kFisheye;
using opencv_file::kOmnidir;

ExchangeContents ReadOpenCv(const ReadRequest& request) {
  const YAML::Node root = ParseFileStorage(request.path, request.text);
  if (!root.IsMap()) throw InputError("contains no camera: expected a mapping");
  return opencv_file::ReadTree(root, request);
}

void AddFit(const ModelFit& fit, FileStorageText* text) {
  const Eigen::Quaterniond& q = fit.fitted_from_camera;
  text->BeginMap("raygrid_fit");
  text->Add("rms_px", fit.rms_px);
  text->Add("p99_px", fit.p99_px);
  text->Add("max_px", fit.max_px);
  text->Add("pixels", static_cast<int>(fit.num_pixels));
  text->Add("pixels_beyond", static_cast<int>(fit.num_unrepresentable));
  text->Add("lens_from_camera_wxyz",
            StoredMatrix{1, 4, {q.w(), q.x(), q.y(), q.z()}});
  text->EndMap();
}

std::string WriteOpenCv(const WriteRequest& request) {
  const OutputCamera& camera = request.cameras.front();
  const ConvertedCamera& lens = camera.lens;
  FileStorageText text(FileStorageText::KindOf(request.path));
  if (!camera.name.empty()) text.Add("camera_name", camera.name);
  if (!camera.serial.empty()) text.Add("serial", camera.serial);
  text.Add("image_width", lens.size.width);
  text.Add("image_height", lens.size.height);
  if (lens.external_model->name != kOmnidir)
    text.Add("fisheye_model", lens.external_model->name == kFisheye ? 1 : 0);
  if (camera.fit) AddFit(*camera.fit, &text);
  text.Add("camera_matrix",
           StoredMatrix{3,
                        3,
                        {lens.Value("fx"), 0, lens.Value("cx"), 0,
                         lens.Value("fy"), lens.Value("cy"), 0, 0, 1}});
  std::vector<double> coefficients = lens.ValuesFrom(4);
  if (lens.external_model->name == kOmnidir) {
    coefficients.pop_back();
    text.Add("xi", lens.Value("xi"));
  }
  text.Add(
      "distortion_coefficients",
      StoredMatrix{1, static_cast<int>(coefficients.size()), coefficients});
  if (camera.camera_from_rig) {
    const Eigen::Matrix3d r =
        camera.camera_from_rig->rotation.toRotationMatrix();
    const Eigen::Vector3d& t = camera.camera_from_rig->translation;
    text.Add("R", StoredMatrix{3,
                               3,
                               {r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1),
                                r(1, 2), r(2, 0), r(2, 1), r(2, 2)}});
    text.Add("T", StoredMatrix{3, 1, {t.x(), t.y(), t.z()}});
  }
  opencv_file::AddPoses(camera.poses, &text);
  return text.Finish();
}

}  // namespace

Format OpenCvFormat() {
  Format format;
  format.name = "opencv";
  format.holds =
      "FileStorage .yaml, .xml or .json: pinhole with 4, 5, 8, 12 or 14 "
      "coefficients, cv::fisheye or cv::omnidir; stereo pairs as in "
      "stereo_calib; one file per camera of a rig, with R and T; poses and "
      "corners of boards";
  format.external_models = opencv_file::GetOpenCvModels();
  format.supports_poses = true;
  format.accepts_model = true;
  format.accepts_board_size = true;
  format.recognizes = IsFileStorage;
  format.read = ReadOpenCv;
  format.write = WriteOpenCv;
  return format;
}

}  // namespace raygrid
