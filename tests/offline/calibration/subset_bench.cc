// Calibrates random subsets of the images of sets, and compares the errors with
// those of the same grid from other starts: lenses of all images, which few
// images do not lead astray. A line a subset, in a CSV that is gone on with:
//   subset_bench --set NAME,features.csv,pattern.yaml,1280x960 ...
//                [--seed 0] [--count 500] [--list subsets.csv]
// Without sets, or every second time, images are those of simulated lenses.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "calibration/calibration.h"
#include "calibration/camera_evaluation.h"
#include "calibration/camera_initialization.h"
#include "calibration/divergence.h"
#include "calibration/knot_spacing_selection.h"
#include "calibration/model_adjustment.h"
#include "dataset/csv.h"
#include "dataset/error.h"
#include "dataset/memory_retention.h"
#include "dataset/pattern.h"
#include "evaluation/residual_statistics.h"
#include "random_calibration.h"

namespace raygrid {
namespace {

constexpr int kLeastImages = 5;

struct ImageSet {
  std::string name;
  Pattern pattern;
  Dataset dataset;
};

ImageSet ReadSet(const std::string& text) {
  std::stringstream stream(text);
  std::string name, features, pattern, width, height;
  std::getline(stream, name, ',');
  std::getline(stream, features, ',');
  std::getline(stream, pattern, ',');
  std::getline(stream, width, 'x');
  std::getline(stream, height);
  ImageSet set = {name, ReadPattern(pattern), ReadFeatures(features).at("")};
  set.dataset.image_size = {std::stoi(width), std::stoi(height)};
  return set;
}

ImageSet SimulatedSet(int seed) {
  RandomCalibration c = MakeRandomCalibration(seed, 10, 40);
  return {"sim-" + c.lens, c.pattern, std::move(c.dataset)};
}

// Lenses of all images, by model. None where they lead to none.
std::vector<std::unique_ptr<CameraModel>> LensesOf(const ImageSet& set) {
  AdjustmentOptions options;
  options.num_threads = 1;
  std::vector<std::unique_ptr<CameraModel>> lenses;
  for (const char* model : {"central-radial", "opencv", "thin-prism-fisheye"})
    try {
      AdjustmentResult lens =
          InitializeCamera(set.dataset, set.pattern, options);
      OptimizeModel(set.pattern, model, {0}, options, &lens);
      lenses.push_back(lens.state.camera().Clone());
    } catch (const Error&) {  // no lens
    }
  return lenses;
}

// The mean of errors, no larger than a cap, which features without any have.
double ErrorPx(const CameraModel& camera, const Dataset& dataset,
               const Pattern& pattern) {
  const Evaluation evaluation = EvaluateCamera(camera, dataset, pattern, 1);
  const double cap_px = ErrorCapPx(dataset.image_size);
  const auto count = static_cast<double>(dataset.num_features());
  double less = 0;
  for (const FeatureResidual& residual : evaluation.residuals)
    less += cap_px - std::min(residual.error_px.norm(), cap_px);
  return count > 0 ? cap_px - less / count : 0;
}

struct Errors {
  double training_px = INFINITY, held_out_px = INFINITY;
};

struct Subset {
  Dataset training, rest;
};

Subset DrawSubset(const ImageSet& set, TestRandom* random) {
  std::vector<ImageFeatures> images = set.dataset.images;
  for (size_t i = images.size(); i > 1; --i)
    std::swap(images[i - 1], images[random->Index(static_cast<int>(i))]);
  const auto most = static_cast<double>(images.size());
  const double part = std::pow(most / kLeastImages, random->Uniform(0, 1));
  const auto count =
      std::min(images.size(), static_cast<size_t>(kLeastImages * part + 0.5));
  Subset subset = {{set.dataset.image_size, {}}, {set.dataset.image_size, {}}};
  subset.training.images.assign(images.begin(), images.begin() + count);
  subset.rest.images.assign(images.begin() + count, images.end());
  return subset;
}

Errors ErrorsOf(const CameraModel& camera, const Subset& subset,
                const Pattern& pattern) {
  return {ErrorPx(camera, subset.training, pattern),
          ErrorPx(camera, subset.rest, pattern)};
}

// The least training errors, from the lenses of all images, with boards as the
// calibration has them: a camera whose boards bend errs more with rigid ones.
Errors BestOfStarts(const ImageSet& set, const Subset& subset,
                    const std::vector<std::unique_ptr<CameraModel>>& lenses,
                    double knot_spacing_px, bool per_view_deformation) {
  AdjustmentOptions options;
  options.num_threads = 1;
  options.rigid_boards = !per_view_deformation;
  Errors best;
  for (const auto& known : lenses) try {
      AdjustmentResult adjusted =
          InitializeCamera(subset.training, set.pattern, options,
                           AreaChoice::kWholeImage, known.get());
      OptimizeModel(set.pattern, "central-generic", {knot_spacing_px}, options,
                    &adjusted);
      const Errors errors =
          ErrorsOf(adjusted.state.camera(), subset,
                   MakeEstimatedPattern(set.pattern, adjusted));
      if (errors.training_px < best.training_px) best = errors;
    } catch (const Error&) {  // no start
    }
  return best;
}

std::string Run(int seed, const ImageSet& set,
                const std::vector<std::unique_ptr<CameraModel>>& lenses,
                TestRandom* random) {
  const Subset subset = DrawSubset(set, random);
  CalibrationOptions options;
  options.compare_models = true;
  options.num_threads = 1;
  Errors errors;
  std::string word;
  double knot_spacing_px = MediumKnotSpacingPx(subset.training, options.model);
  bool per_view_deformation = false;
  try {
    const CalibrationResult result =
        Calibrate(subset.training, set.pattern, options);
    errors = ErrorsOf(*result.camera.camera, subset, result.pattern);
    word = result.assessment.word;
    knot_spacing_px = result.knot_spacing_px;
    per_view_deformation = result.bends.has_value();
  } catch (const Error& error) {
    word = error.what();
    std::replace(word.begin(), word.end(), ',', ';');
  }
  const Errors best =
      BestOfStarts(set, subset, lenses, knot_spacing_px, per_view_deformation);
  std::ostringstream line;
  line.precision(4);
  line << seed << ',' << set.name << ',' << subset.training.images.size() << ','
       << knot_spacing_px << ',' << errors.training_px << ','
       << best.training_px << ',' << errors.training_px / best.training_px
       << ',' << errors.held_out_px << ',' << best.held_out_px << ','
       << errors.held_out_px / best.held_out_px << ','
       << (per_view_deformation ? "bend" : "rigid") << ',' << word;
  return line.str();
}

std::set<int> SeedsIn(const std::string& path) {
  std::set<int> seeds;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (!line.empty() && std::isdigit(static_cast<unsigned char>(line[0])))
      seeds.insert(std::stoi(line));
  return seeds;
}

}  // namespace
}  // namespace raygrid

int main(int argc, char** argv) {
  using namespace raygrid;
  CLI::App app("Do calibrations of few images end as well as from any start?");
  int first = 0, count = 500;
  std::vector<std::string> texts;
  std::string path = "subsets.csv";
  app.add_option("--set", texts, "NAME,features.csv,pattern.yaml,WxH");
  app.add_option("--seed", first, "of the first subset");
  app.add_option("--count", count)->capture_default_str();
  app.add_option("--list", path, "the CSV")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  RetainFreedMemory();  // as raygrid does
  std::vector<ImageSet> sets;
  for (const std::string& text : texts) sets.push_back(ReadSet(text));
  std::map<std::string, std::vector<std::unique_ptr<CameraModel>>> lenses;
  const std::set<int> done = SeedsIn(path);
  std::ofstream file(path, std::ios::app);
  if (done.empty())
    file << "seed,set,images,cell_px,training_px,best_training_px,ratio,"
            "held_out_px,best_held_out_px,held_out_ratio,boards,verdict\n";
  for (int seed = first; seed < first + count; ++seed) {
    if (done.count(seed) > 0) continue;
    TestRandom random(seed);
    random.Index(2);  // the first number of neighbouring seeds is much alike
    const bool is_simulated = sets.empty() || random.Index(2) == 0;
    const ImageSet simulated = is_simulated ? SimulatedSet(seed) : ImageSet();
    const ImageSet& set =
        is_simulated ? simulated
                     : sets[random.Index(static_cast<int>(sets.size()))];
    if (is_simulated || lenses.count(set.name) == 0)
      lenses[set.name] = LensesOf(set);
    file << Run(seed, set, lenses[set.name], &random) << std::endl;
  }
  return 0;
}
