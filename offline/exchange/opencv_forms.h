/// Forms that several programs share with OpenCV.
#ifndef RAYGRID_EXCHANGE_OPENCV_FORMS_H
#define RAYGRID_EXCHANGE_OPENCV_FORMS_H

#include <string>
#include <vector>

#include "exchange/lens_form.h"

namespace raygrid {

/// OpenCV's pinhole with so many of its coefficients, in its order: k1, k2, p1,
/// p2, k3, k4, k5, k6, s1, s2, s3, s4, tx, ty. Count is 0, 4, 5, 8, 12 or 14.
inline LensForm OpenCvForm(const std::string& name, int count) {
  const std::vector<std::string> all = {"k1", "k2", "p1", "p2", "k3",
                                        "k4", "k5", "k6", "s1", "s2",
                                        "s3", "s4", "tx", "ty"};
  LensForm form = FormOf(name, count > 8 ? "opencv-14" : "opencv",
                         {all.begin(), all.begin() + count});
  form.reach_rad = M_PI / 2;
  return form;
}

/// The fisheye of OpenCV, and of all that call it equidistant: k1, k2, k3, k4.
/// It divides by z: the half space before the camera is its reach.
inline LensForm OpenCvFisheyeForm(const std::string& name) {
  LensForm form = FormOf(name, "thin-prism-fisheye", {"k1", "k2", "k3", "k4"});
  form.reach_rad = M_PI / 2;
  return form;
}

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_OPENCV_FORMS_H
