#include "calibration/knot_spacing_search.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <tuple>

#include "adjustment/reprojection_error.h"

namespace raygrid {
namespace {

// Minimum gain of a finer grid, in standard deviations; finer grids are slower.
constexpr double kMinFinerZScore = 2;

bool Try(std::vector<int> resolutions,
         const KnotSpacingSearch::Measure& measure, KnotSpacingSearch* search) {
  resolutions.erase(
      std::remove_if(resolutions.begin(), resolutions.end(),
                     [&](int i) { return search->tried.count(i) > 0; }),
      resolutions.end());
  if (resolutions.empty()) return true;
  std::vector<std::vector<FeatureResidual>> measured = measure(resolutions);
  if (measured.size() < resolutions.size()) return false;
  for (size_t i = 0; i < resolutions.size(); ++i)
    search->tried[resolutions[i]] = std::move(measured[i]);
  return true;
}

// Selects the residuals in images that also occur in `others`.
std::vector<FeatureResidual> SelectResidualsInImages(
    const std::vector<FeatureResidual>& reference,
    const std::vector<FeatureResidual>& residuals) {
  std::set<std::string> images;
  for (const FeatureResidual& other : reference) images.insert(other.image);
  std::vector<FeatureResidual> in_images;
  for (const FeatureResidual& residual : residuals)
    if (images.count(residual.image) > 0) in_images.push_back(residual);
  return in_images;
}

}  // namespace

double ComputeLossZScore(const std::vector<FeatureResidual>& reference,
                         const std::vector<FeatureResidual>& residuals,
                         double huber_px) {
  // A feature that is missing in one of the sets counts with an error of
  // huber_px.
  struct Losses {
    double reference, candidate;
  };
  const double unknown = HuberLoss(huber_px, huber_px);
  std::map<std::tuple<std::string, int, int, int>, Losses> features;
  const auto of = [&features,
                   unknown](const FeatureResidual& residual) -> Losses& {
    const std::tuple feature(residual.image, residual.board, residual.column,
                             residual.row);
    return features.emplace(feature, Losses{unknown, unknown}).first->second;
  };
  for (const FeatureResidual& residual : reference)
    of(residual).reference = HuberLoss(residual.error_px.norm(), huber_px);
  for (const FeatureResidual& residual : residuals)
    of(residual).candidate = HuberLoss(residual.error_px.norm(), huber_px);
  struct Sum {
    double improvement = 0, count = 0;
  };
  std::map<std::string, Sum> images;
  Sum all;
  for (const auto& [feature, losses] : features)
    for (Sum* sum : {&images[std::get<std::string>(feature)], &all}) {
      sum->improvement += losses.reference - losses.candidate;
      ++sum->count;
    }
  if (images.size() < 2) return 0;
  double squares = 0;
  for (const auto& [name, image] : images)
    squares += std::pow(
        image.improvement - all.improvement / all.count * image.count, 2);
  const double num_images = static_cast<double>(images.size());
  const double stddev = std::sqrt(squares * num_images / (num_images - 1));
  return stddev > 0 ? all.improvement / stddev : 0;
}

std::optional<KnotSpacingSearch> KnotSpacingSearch::Run(int num_resolutions,
                                                        int medium,
                                                        const Measure& measure,
                                                        const Probe& probe) {
  KnotSpacingSearch search;
  const auto improvement = [&search](int to) {
    return ComputeLossZScore(search.tried.at(search.chosen),
                             search.tried.at(to));
  };
  const auto can_improve = [&](int to) {
    if (!probe || search.tried.count(to) > 0) return true;
    const std::vector<FeatureResidual> part = probe(to);
    if (part.empty()) return true;  // cancelled
    return ComputeLossZScore(
               SelectResidualsInImages(part, search.tried.at(search.chosen)),
               part) > 0;
  };
  medium = std::min(medium, num_resolutions - 1);
  search.chosen = medium;
  if (!Try({medium}, measure, &search)) return std::nullopt;
  for (int coarser = medium - 1; coarser >= 0; --coarser) {
    if (coarser < medium - 1 && !can_improve(coarser)) break;
    if (!Try({coarser}, measure, &search)) return std::nullopt;
    if (improvement(coarser) < kMinCoarserZScore) break;
    search.chosen = coarser;
  }
  if (search.chosen < medium) return search;
  for (int finer = medium + 1; finer < num_resolutions; ++finer) {
    if (!can_improve(finer)) break;
    if (!Try({finer}, measure, &search)) return std::nullopt;
    if (improvement(finer) < kMinFinerZScore) break;
    search.chosen = finer;
  }
  return search;
}

}  // namespace raygrid
