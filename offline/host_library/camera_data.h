#ifndef RAYGRID_HOST_LIBRARY_CAMERA_DATA_H
#define RAYGRID_HOST_LIBRARY_CAMERA_DATA_H

#include <raygrid_host/camera.h>

#include <memory>

#include "dataset/camera_file.h"
#include "host_library/evaluator.h"

namespace raygrid {

template <typename Scalar>
struct Camera<Scalar>::Data {
  std::shared_ptr<const CameraFile> file;
  std::shared_ptr<const CameraModel> model;  ///< the file's, or optimized
  std::shared_ptr<const host::Evaluator<Scalar>> evaluator;

  static std::shared_ptr<const Data> Make(
      std::shared_ptr<const CameraFile> file,
      std::shared_ptr<const CameraModel> model) {
    auto evaluator = host::MakeEvaluator<Scalar>(model);
    return std::make_shared<const Data>(
        Data{std::move(file), std::move(model), std::move(evaluator)});
  }
};

}  // namespace raygrid

#endif  // RAYGRID_HOST_LIBRARY_CAMERA_DATA_H
