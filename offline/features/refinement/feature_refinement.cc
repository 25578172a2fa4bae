#include "features/refinement/feature_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "features/board_view/feature_lattice.h"
#include "features/board_view/image_noise.h"
#include "features/refinement/outliers.h"
#include "features/refinement/symmetry_refinement.h"
#include "features/refinement/tag_corner_refinement.h"
#include "features/refinement/window_mapping.h"

namespace raygrid {
namespace {

constexpr int kRoughSamplesPerPixel = 1, kSamplesPerPixel = 8;
constexpr int kRefinementRadius = 3;  // columns and rows of neighbours in
                                      // Predicted()
constexpr int kRefinementDegree = 3;

// Thresholds for rejecting features.
constexpr double kMinCircleWidthPx = 5.5;
constexpr double kMaxMovePx = 2;
constexpr double kMaxMoveSquares = 0.03;  // for large squares
constexpr double kMaxAsymmetry = 0.6;     // fraction of the contrast
constexpr double kMaxUnlikeness = 0.35;   // fraction of the contrast, for tag
                                          // corners
constexpr double kMinTagCornerInsidePx = 2;
constexpr double kMinRefinedContrast = 0.5;  // grey levels
// Maximum standard deviation along the less certain direction: an error of 0.5
// px would be eight standard deviations.
constexpr double kMaxStdDevPx = 0.06;
constexpr int kMaxIsolatedOutliers = 2;  // more indicate misnumbered features

constexpr Tolerance kCoarseTolerance = {2, 0.1}, kFineTolerance = {0.25, 0.03};

// Predicts the position of a feature from its neighbours.
bool PredictPosition(const FeatureLattice& lattice, const Feature& feature,
                     LocalMapping* mapping) {
  return FitLocalMapping(lattice.Around(feature.column, feature.row,
                                        kRefinementRadius, false),
                         kRefinementDegree, mapping) > 0;
}

void RejectIsolatedFeatures(const Board& board, FeatureLattice* lattice,
                            ImageDetection* detection) {
  for (const Feature& f : lattice->Features()) {
    const int c = f.column, r = f.row;
    const int neighbours = lattice->Has(c - 1, r) + lattice->Has(c + 1, r) +
                           lattice->Has(c, r - 1) + lattice->Has(c, r + 1);
    if (neighbours < 1) Reject(board, c, r, "alone", lattice, detection);
  }
}

using Place = Eigen::Vector2i;  // column, row

bool Has(const FeatureLattice& lattice, const Place& p) {
  return lattice.Has(p.x(), p.y());
}

// The next detected feature in a row or column.
struct LatticeStep {
  Place to;
  bool is_consistent;  // consistent with the adjacent steps
};

// Returns nullopt if there is no feature within kMaxSteps, or if the length of
// a gap cannot be verified by steps on both sides.
std::optional<LatticeStep> FindStep(const FeatureLattice& lattice,
                                    const Place& from, const Place& step) {
  constexpr int kMaxSteps = 3;
  constexpr double kToleranceSteps = 0.5;
  const auto at = [&](const Place& p) { return lattice.at(p.x(), p.y()); };
  int num_steps = 1;
  while (!Has(lattice, from + num_steps * step))
    if (++num_steps > kMaxSteps) return std::nullopt;
  const Place to = from + num_steps * step;
  Eigen::Vector2d one_step(0, 0);
  int count = 0;
  for (const Place& p : {Place(from - step), to}) {
    if (!Has(lattice, p) || !Has(lattice, p + step)) continue;
    one_step += at(p + step) - at(p);
    ++count;
  }
  if (count < 2 && num_steps > 1) return std::nullopt;
  if (count == 0) return LatticeStep{to, true};
  one_step /= count;
  const double stddev_px = (at(to) - at(from) - num_steps * one_step).norm();
  return LatticeStep{to, stddev_px <= kToleranceSteps * one_step.norm()};
}

const std::array<Place, 4> kSteps = {Place(1, 0), Place(-1, 0), Place(0, 1),
                                     Place(0, -1)};

// Returns the connected components of features that are linked by consistent
// steps, in descending order of size.
std::vector<std::vector<Place>> Groups(const FeatureLattice& lattice) {
  std::vector<std::vector<Place>> groups;
  FeatureLattice left = lattice;
  const auto take = [&left](const Place& p, std::vector<Place>* group) {
    left.Remove(p.x(), p.y());
    group->push_back(p);
  };
  for (const Feature& first : lattice.Features()) {
    if (!left.Has(first.column, first.row)) continue;
    std::vector<Place> group;
    take({first.column, first.row}, &group);
    for (size_t i = 0; i < group.size(); ++i) {
      for (const Place& step : kSteps) {
        const auto way = FindStep(lattice, group[i], step);
        if (way && way->is_consistent && Has(left, way->to))
          take(way->to, &group);
      }
    }
    groups.push_back(std::move(group));
  }
  std::stable_sort(
      groups.begin(), groups.end(),
      [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return groups;
}

bool IsAtDiscontinuity(const FeatureLattice& lattice, const Place& p) {
  return std::any_of(kSteps.begin(), kSteps.end(), [&](const Place& step) {
    const auto way = FindStep(lattice, p, step);
    return way && !way->is_consistent;
  });
}

// Rejects features that are not connected to the largest group. Inconsistent
// steps indicate that lattice growth skipped or repeated a row or column: the
// features on one side are then consistent with each other, but misnumbered.
void RejectIsolatedGroups(const Board& board, FeatureLattice* lattice,
                          ImageDetection* detection) {
  // The corners of an AprilGrid are not evenly spaced and are identified by
  // their own tags.
  if (board.IsTagGrid()) return;
  const auto groups = Groups(*lattice);
  bool is_in_doubt =
      std::count_if(detection->rejected.begin(), detection->rejected.end(),
                    [](const auto& r) { return r.reason == kNotCollinear; }) >
      kMaxIsolatedOutliers;
  for (const auto& group : groups)
    for (const Place& p : group) is_in_doubt |= IsAtDiscontinuity(*lattice, p);
  if (!is_in_doubt) return;
  for (size_t g = 1; g < groups.size(); ++g)
    for (const Place& p : groups[g])
      Reject(board, p.x(), p.y(), "inconsistent with the others", lattice,
             detection);
}

}  // namespace

// One refinement pass over all features. Mappings are fitted to the positions
// before the pass.
struct RefinementPass {
  const SymmetrySamples* samples;
  double max_move_px, max_move_squares;  // the larger one applies
  double noise;                          // standard deviation, grey levels
  bool is_last_pass;
  double tone = 0;  // see TagCornerOptions
};

struct FeatureRefiner::Data {
  Board board;
  DetectionOptions options;
  std::vector<SymmetryMask> masks;
  SymmetrySamples rough_samples, samples;
  // Null for boards with point-symmetric features.
  std::unique_ptr<TagCornerRefiner> tag_corners;

  double MaxMovePx(const LocalMapping& start, const RefinementPass& pass) const;
  double EstimateToneResponse(const GreyImage& image,
                              const FeatureLattice& lattice,
                              double noise) const;
  WindowFit Symmetry(const GreyImage& image, const Feature& feature,
                     const LocalMapping& start, bool center_only,
                     const RefinementPass& pass) const;
  WindowFit FitTagCorner(const GreyImage& image, const Feature& feature,
                         const LocalMapping& start, bool has_known_edges,
                         const RefinementPass& pass) const;
  WindowFit Fit(const GreyImage& image, const Feature& feature,
                const LocalMapping& start, bool center_only,
                const RefinementPass& pass) const;
  std::string RefineOne(const GreyImage& image, const Feature& feature,
                        const RefinementPass& pass,
                        const FeatureLattice& lattice, WindowMappings* windows,
                        Eigen::Vector2d* pixel) const;
  void RefineOnce(const GreyImage& image, const RefinementPass& pass,
                  FeatureLattice* lattice, ImageDetection* detection) const;
  void RefineWithSymmetry(const GreyImage& image, FeatureLattice* lattice,
                          ImageDetection* detection) const;
  void RefineWithCornerModel(const GreyImage& image, FeatureLattice* lattice,
                             ImageDetection* detection) const;
};

FeatureRefiner::FeatureRefiner(const Board& board,
                               const DetectionOptions& options)
    : data_(new Data{
          board, options, SymmetryMask::MakeBoardMasks(board),
          MakeSymmetrySamples(options.window_px, kRoughSamplesPerPixel),
          MakeSymmetrySamples(options.window_px, kSamplesPerPixel),
          board.HasSymmetricFeatures()
              ? nullptr
              : std::make_unique<TagCornerRefiner>(board)}) {}
FeatureRefiner::~FeatureRefiner() = default;

// At most a third of the window, so that the window contains the feature.
double FeatureRefiner::Data::MaxMovePx(const LocalMapping& start,
                                       const RefinementPass& pass) const {
  return std::clamp(pass.max_move_squares * start.SpacingPx(), pass.max_move_px,
                    std::max(pass.max_move_px, options.window_px / 3.0));
}

WindowFit FeatureRefiner::Data::Symmetry(const GreyImage& image,
                                         const Feature& feature,
                                         const LocalMapping& start,
                                         bool center_only,
                                         const RefinementPass& pass) const {
  SymmetryOptions symmetry;
  symmetry.refinement = options.refinement;
  symmetry.inverts_colors = ReflectionInvertsColors(board);
  symmetry.center_only = center_only;
  symmetry.noise = pass.noise;
  symmetry.max_move_px = MaxMovePx(start, pass);
  return RefineSymmetry(image, *pass.samples,
                        masks[board.PointIndex(feature.column, feature.row)],
                        start, symmetry);
}

WindowFit FeatureRefiner::Data::FitTagCorner(const GreyImage& image,
                                             const Feature& feature,
                                             const LocalMapping& start,
                                             bool has_known_edges,
                                             const RefinementPass& pass) const {
  TagCornerOptions corner;
  corner.window_px = options.window_px;
  corner.has_known_edges = has_known_edges;
  corner.max_move_px = MaxMovePx(start, pass);
  corner.noise = pass.noise;
  corner.tone = pass.tone;
  return tag_corners->Refine(image, {feature.column, feature.row, start},
                             corner);
}

double FeatureRefiner::Data::EstimateToneResponse(const GreyImage& image,
                                                  const FeatureLattice& lattice,
                                                  double noise) const {
  if (!tag_corners) return 0;
  WindowMappings windows(board, lattice, image.size, options.window_px);
  std::vector<TagCorner> corners;
  for (const Feature& feature : lattice.Features()) {
    WindowMapping window = windows.At(feature.column, feature.row);
    window.mapping.center = feature.pixel;
    if (window.degree > 0)
      corners.push_back({feature.column, feature.row, window.mapping});
  }
  TagCornerOptions corner;
  corner.window_px = options.window_px;
  corner.noise = noise;
  return tag_corners->EstimateTone(image, corners, corner);
}

// center_only: the mapping is accurate except for its centre.
WindowFit FeatureRefiner::Data::Fit(const GreyImage& image,
                                    const Feature& feature,
                                    const LocalMapping& start, bool center_only,
                                    const RefinementPass& pass) const {
  return tag_corners ? FitTagCorner(image, feature, start, false, pass)
                     : Symmetry(image, feature, start, center_only, pass);
}

const std::vector<SymmetryMask>& FeatureRefiner::masks() const {
  return data_->masks;
}

// Returns an empty string, or the reason for rejecting the feature.
std::string FeatureRefiner::Data::RefineOne(const GreyImage& image,
                                            const Feature& feature,
                                            const RefinementPass& pass,
                                            const FeatureLattice& lattice,
                                            WindowMappings* windows,
                                            Eigen::Vector2d* pixel) const {
  const WindowMapping window = windows->At(feature.column, feature.row);
  if (window.degree == 0) return "too few neighbours";
  LocalMapping start = window.mapping;
  const bool center_only = window.degree > 1;
  if (start.CircleWidthPx() < kMinCircleWidthPx) return "too small";
  start.center = feature.pixel;
  WindowFit result = Fit(image, feature, start, center_only, pass);
  LocalMapping predicted;
  if (!result.is_converged && PredictPosition(lattice, feature, &predicted))
    result = Fit(image, feature, predicted, center_only, pass);
  if (!result.is_converged)
    return tag_corners ? "no corner nearby" : "no centre of symmetry nearby";
  // At the image's edge, a tag corner is constrained from one side only.
  if (tag_corners &&
      !WholeImage(image.size)
           .Contains(result.mapping.center, -kMinTagCornerInsidePx))
    return "at the image border";
  if (result.contrast < kMinRefinedContrast) return "no contrast";
  // The RMS includes the noise of one value (tag corners), or of both values of
  // a difference (symmetry).
  const double noise2 = pass.noise * pass.noise;
  const double signal2 = std::pow(result.contrast, 2) - noise2;
  if (tag_corners &&
      std::pow(result.rms, 2) - noise2 > std::pow(kMaxUnlikeness, 2) * signal2)
    return "does not match the pattern";
  if (!tag_corners && std::pow(result.rms, 2) - 2 * noise2 >
                          std::pow(kMaxAsymmetry, 2) * signal2)
    return "not symmetric";
  if (pass.is_last_pass && !(result.stddev_px < kMaxStdDevPx))
    return "below the noise";
  if (pass.is_last_pass &&
      !(std::hypot(result.stddev_px, window.sagitta_stddev_px) < kMaxStdDevPx))
    return "too much distortion";
  *pixel = result.mapping.center;
  return {};
}

void FeatureRefiner::Data::RefineOnce(const GreyImage& image,
                                      const RefinementPass& pass,
                                      FeatureLattice* lattice,
                                      ImageDetection* detection) const {
  FeatureLattice refined = *lattice;
  WindowMappings windows(board, *lattice, image.size, options.window_px);
  for (const Feature& feature : lattice->Features()) {
    Eigen::Vector2d pixel;
    const std::string reason =
        RefineOne(image, feature, pass, *lattice, &windows, &pixel);
    if (reason.empty())
      refined.Set(feature.column, feature.row, pixel);
    else
      Reject(board, feature.column, feature.row, reason, &refined, detection);
  }
  *lattice = refined;
  RejectOutliers(board, image.size, kFineTolerance, options.window_px, lattice,
                 detection);
}

// First a coarse pass to make the neighbours accurate, then a fine pass with
// the curvature estimated from them.
void FeatureRefiner::Data::RefineWithSymmetry(const GreyImage& image,
                                              FeatureLattice* lattice,
                                              ImageDetection* detection) const {
  const double noise = EstimateNoise(image);
  RefineOnce(image, {&rough_samples, kMaxMovePx, kMaxMoveSquares, noise, false},
             lattice, detection);
  // Tag corners may move farther, since the tone is applied only now.
  RefineOnce(image,
             {&samples, tag_corners ? kMaxMovePx / 2 : kMaxMovePx / 4, 0, noise,
              true, EstimateToneResponse(image, *lattice, noise)},
             lattice, detection);
}

void FeatureRefiner::Data::RefineWithCornerModel(
    const GreyImage& image, FeatureLattice* lattice,
    ImageDetection* detection) const {
  const cv::Mat view(image.size.height, image.size.width, CV_8U,
                     const_cast<uint8_t*>(image.bytes.data()));
  const int half = options.window_px / 2;
  for (const Feature& f : lattice->Features()) {
    std::vector<cv::Point2f> corner = {
        {static_cast<float>(f.pixel.x()), static_cast<float>(f.pixel.y())}};
    cv::cornerSubPix(
        view, corner, cv::Size(half, half), cv::Size(-1, -1),
        cv::TermCriteria(cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 100,
                         1e-4));
    const Eigen::Vector2d pixel(corner[0].x, corner[0].y);
    if ((pixel - f.pixel).norm() > kMaxMovePx)
      Reject(board, f.column, f.row, "no corner nearby", lattice, detection);
    else
      lattice->Set(f.column, f.row, pixel);
  }
}

ImageDetection FeatureRefiner::Refine(
    const GreyImage& image, const std::vector<Feature>& approximate) const {
  ImageDetection detection;
  FeatureLattice lattice(data_->board);
  for (const Feature& feature : approximate)
    lattice.Set(feature.column, feature.row, feature.pixel);
  RejectOutliers(data_->board, image.size, kCoarseTolerance,
                 data_->options.window_px, &lattice, &detection);
  switch (data_->options.refinement) {
    case Refinement::kNone:
      break;
    case Refinement::kCornerSubpix:
      data_->RefineWithCornerModel(image, &lattice, &detection);
      RejectOutliers(data_->board, image.size, kFineTolerance,
                     data_->options.window_px, &lattice, &detection);
      break;
    default:
      data_->RefineWithSymmetry(image, &lattice, &detection);
  }
  RejectIsolatedFeatures(data_->board, &lattice, &detection);
  RejectIsolatedGroups(data_->board, &lattice, &detection);
  detection.features = lattice.Features();
  return detection;
}

std::vector<Feature> FeatureRefiner::RefineWith(
    const GreyImage& image, std::vector<Feature> features,
    const MappingCallback& get_mapping) const {
  if (data_->options.refinement == Refinement::kNone ||
      data_->options.refinement == Refinement::kCornerSubpix)
    return features;
  RefinementPass pass = {&data_->samples, kMaxMovePx / 4, 0, 0, true};
  if (data_->tag_corners) {
    FeatureLattice lattice(data_->board);
    for (const Feature& f : features) lattice.Set(f.column, f.row, f.pixel);
    pass.tone =
        data_->EstimateToneResponse(image, lattice, EstimateNoise(image));
  }
  for (Feature& feature : features) {
    const auto mapping = get_mapping(feature);
    if (!mapping) continue;
    const WindowFit result =
        data_->tag_corners
            ? data_->FitTagCorner(image, feature, *mapping, true, pass)
            : data_->Symmetry(image, feature, *mapping, true, pass);
    if (result.is_converged) feature.pixel = result.mapping.center;
  }
  return features;
}

}  // namespace raygrid
