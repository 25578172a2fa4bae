#ifndef RAYGRID_EXCHANGE_LENS_FORM_H
#define RAYGRID_EXCHANGE_LENS_FORM_H

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera/camera_uncertainty.h"
#include "camera/parametric_model.h"
#include "camera/splined_stereographic.h"
#include "exchange/pixel_origin.h"

namespace raygrid {

/// A program's own camera that stands for one of raygrid's, whose directions it
/// turns.
struct FormGrid {
  std::shared_ptr<const CameraModel> camera;
  Eigen::Quaterniond camera_from_given = Eigen::Quaterniond::Identity();
};

/// A camera model as another program has it: one of raygrid's
/// (camera/lens_models.h), of whose parameters it has some, in an order of its
/// own. Those that it lacks are 0.
struct LensForm {
  std::string name;                     ///< the program's own: "plumb_bob"
  std::string model;                    ///< raygrid's: "opencv"
  std::vector<std::string> parameters;  ///< "fx", "cx", "k1"; "f" is fx and fy
  PixelOrigin origin = PixelOrigin::kFirstPixelCenter;
  /// The program goes no farther from the axis.
  double reach_rad = M_PI;
  /// An export takes it only if it is asked for.
  bool is_explicit_only = false;
  /// The program's camera that is nearest to one of raygrid's, for forms that
  /// are grids; null for those of puzzlepaint.
  FormGrid (*fit_grid)(const CameraModel& camera,
                       const ValidityMask* trusted) = nullptr;

  /// A spline has as many parameters as it likes.
  bool IsSpline() const { return model == models::kSplinedStereographic; }
  /// A grid of another kind than raygrid's, which stands for a camera nearly.
  bool IsGrid() const { return model == models::kCentralGeneric || HasLines(); }
  bool HasLines() const { return model == models::kNonCentralGeneric; }
  bool Has(const std::string& parameter) const;
  /// Parameters of the model that the program lacks.
  std::vector<std::string> Missing() const;
};

/// fx, fy, cx, cy and these coefficients of a model: most forms are like this.
LensForm MakeForm(const std::string& name, const std::string& model,
                  const std::vector<std::string>& coefficients);

/// A lens in the terms of a form: its values in the order of the form's
/// parameters, pixels in the program's convention.
struct ConvertedLens {
  const LensForm* form = nullptr;
  ImageSize size;
  std::vector<double> values;
  /// The lens of a form that is a spline, without values; else null.
  std::shared_ptr<const SplinedStereographic> spline = nullptr;
  /// The camera of a form that is a grid: raygrid's grid if it was read, the
  /// program's if it is to be written. Else null.
  std::shared_ptr<const CameraModel> grid = nullptr;

  /// How far the camera matrix moves a pixel of y = 1 to the right. No model of
  /// raygrid has one: such a lens is read as a grid (exchange/nearest_grid.h).
  double skew_px = 0;

  /// Throws std::out_of_range if the form has no such parameter.
  double Value(const std::string& parameter) const;
  /// The values behind the first so many, which are the coefficients of forms
  /// that MakeForm() makes.
  std::vector<double> ValuesFrom(size_t first) const;
};

/// The lens of a form, over the whole image; or its grid. Throws InputError for
/// numbers that no lens has: such as not finite ones, and focal lengths of 0.
std::unique_ptr<CameraModel> MakeLens(const ConvertedLens& lens);

/// The part of the area that looks nowhere, by 64 x 64 samples.
double ComputeUndefinedFraction(const CameraModel& lens);

/// A lens in a form; nothing if the form cannot hold it exactly, as grids hold
/// none.
std::optional<ConvertedLens> ConvertToForm(const LensForm& form,
                                           const CameraModel& lens);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_LENS_FORM_H
