#include "dataset/target_pose.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/rig_file.h"
#include "dataset/text_encoding.h"

namespace raygrid {
namespace {

constexpr const char* kPoseAxes[] = {"rx", "ry", "rz", "tx", "ty", "tz"};

std::string CovarianceColumn(int i, int k) {
  return fmt::format("cov_{}_{}", kPoseAxes[i], kPoseAxes[k]);
}

PoseCovariance ReadCovariance(const CsvReader& table) {
  PoseCovariance covariance;
  for (int i = 0; i < 6; ++i)
    for (int k = i; k < 6; ++k)
      covariance(i, k) = covariance(k, i) =
          table.Number(CovarianceColumn(i, k));
  const Eigen::Matrix<double, 6, 1> scale =
      covariance.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LLT<PoseCovariance> cholesky(scale.asDiagonal() * covariance *
                                            scale.asDiagonal());
  if (!(covariance.diagonal().minCoeff() > 0) ||
      cholesky.info() != Eigen::Success)
    throw InputError(table.Place() +
                     ": the covariance is not positive definite");
  return covariance;
}

TargetPose ReadTargetPose(const CsvReader& table) {
  const auto number = [&](const char* column) { return table.Number(column); };
  const Eigen::Quaterniond rotation(number("qw"), number("qx"), number("qy"),
                                    number("qz"));
  constexpr double kRounding = 1e-2;
  if (!(std::abs(rotation.norm() - 1) < kRounding))
    throw InputError(table.Place() +
                     ": qw, qx, qy, qz are not a unit quaternion");
  TargetPose target;
  target.pose = {
      table.Text("image"),
      table.Integer("board"),
      {rotation.normalized(), {number("tx"), number("ty"), number("tz")}}};
  target.num_features = table.Integer("features");
  target.rms_px = number("rms_px");
  target.covariance = ReadCovariance(table);
  return target;
}

}  // namespace

double TargetPose::RotationStdDev() const {
  return std::sqrt(covariance.topLeftCorner<3, 3>().trace());
}

double TargetPose::TranslationStdDev() const {
  return std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
}

PoseCovariance RotateCovariance(const Pose& b_from_a,
                                const PoseCovariance& covariance) {
  PoseCovariance rotation = PoseCovariance::Zero();
  rotation.topLeftCorner<3, 3>() = rotation.bottomRightCorner<3, 3>() =
      b_from_a.rotation.toRotationMatrix();
  return rotation * covariance * rotation.transpose();
}

std::string FormatTargetPoses(const std::string& camera,
                              const std::vector<TargetPose>& poses) {
  std::string text = camera.empty() ? "" : "camera,";
  text += "image,board,qw,qx,qy,qz,tx,ty,tz,features,rms_px";
  for (int i = 0; i < 6; ++i)
    for (int k = i; k < 6; ++k) text += "," + CovarianceColumn(i, k);
  text += "\n";
  const auto out = std::back_inserter(text);
  for (const TargetPose& target : poses) {
    Eigen::Quaterniond q = target.pose.camera_from_board.rotation;
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const Eigen::Vector3d& t = target.pose.camera_from_board.translation;
    if (!camera.empty()) text += CsvField(camera) + ",";
    fmt::format_to(
        out, "{},{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{},{:.4f}",
        CsvField(target.pose.image), target.pose.board, q.w(), q.x(), q.y(),
        q.z(), t.x(), t.y(), t.z(), target.num_features, target.rms_px);
    for (int i = 0; i < 6; ++i)
      for (int k = i; k < 6; ++k)
        fmt::format_to(out, ",{:.6g}", target.covariance(i, k));
    text += "\n";
  }
  return text;
}

std::map<std::string, std::vector<TargetPose>> ParseTargetPoses(
    const std::string& path, const std::string& text) {
  std::vector<std::string> columns = {"image", "board",    "qw",    "qx",
                                      "qy",    "qz",       "tx",    "ty",
                                      "tz",    "features", "rms_px"};
  for (int i = 0; i < 6; ++i)
    for (int k = i; k < 6; ++k) columns.push_back(CovarianceColumn(i, k));
  CsvReader table(path, text, columns);
  table.LimitRows(kMaxPoses);
  std::map<std::string, std::vector<TargetPose>> poses;
  std::set<std::pair<std::string, int>> seen;
  while (table.Next()) {
    const std::string camera =
        table.HasColumn("camera") ? table.Text("camera") : "";
    if (!camera.empty() && !IsRigCameraName(camera))
      throw InputError(fmt::format("{}: '{}' is not the name of a camera",
                                   table.Place(), Printable(camera)));
    TargetPose target = ReadTargetPose(table);
    if (target.num_features < 0 || !(target.rms_px >= 0))
      throw InputError(fmt::format(
          "{}: features and rms_px must be non-negative", table.Place()));
    if (!seen.emplace(camera + "\n" + target.pose.image, target.pose.board)
             .second)
      throw InputError(fmt::format("{}: second pose of board {} in {}",
                                   table.Place(), target.pose.board,
                                   Printable(target.pose.image)));
    poses[camera].push_back(std::move(target));
  }
  return poses;
}

}  // namespace raygrid
