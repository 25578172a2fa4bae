#include "calibration/split_gain.h"

namespace raygrid {

SplitGain::SplitGain(const Adjusted& joint, double huber_px, int num_threads) {
  constexpr int kMaxParameters = 200;
  if (joint.state.camera().NumParameters() > kMaxParameters) return;
  views_ = EquationsByView(joint, huber_px, num_threads);
  for (const CameraEquations& view : views_) squares_ += view.squares;
}

double SplitGain::LeftPart(const std::set<std::string>& first) const {
  constexpr double kRidge = 1e-9;  // of directions that no view determines
  if (views_.empty()) return 0;
  const Eigen::Index size = views_.front().gradient.size();
  double gain = 0;
  for (const bool is_first : {true, false}) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    for (const CameraEquations& view : views_) {
      if ((first.count(view.image) > 0) != is_first) continue;
      hessian += view.hessian;
      gradient += view.gradient;
    }
    gain -= gradient.dot(LeastSquaresChange(hessian, gradient, kRidge));
  }
  return 1 - gain / squares_;
}

}  // namespace raygrid
