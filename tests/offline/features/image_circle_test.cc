// The image circle that images of a fisheye show.
#include <algorithm>
#include <cmath>
#include <functional>

#include "features/image_circle_detection.h"
#include "support.h"

namespace raygrid {
namespace {

constexpr ImageSize kSeenSize = {1280, 960};

using Brightness = std::function<double(const Eigen::Vector2d& pixel)>;

GreyLevels SimulateImageFeatures(const Brightness& brightness) {
  GreyLevels image;
  image.size = kSeenSize;
  for (int y = 0; y < kSeenSize.height; ++y)
    for (int x = 0; x < kSeenSize.width; ++x)
      image.levels.push_back(
          static_cast<float>(std::clamp(brightness({x, y}), 0.0, 255.0)));
  return image;
}

std::optional<ImageCircle> FoundIn(const std::vector<Brightness>& images) {
  BrightestCells cells = BrightestCells::Over(kSeenSize);
  for (const Brightness& image : images)
    cells.Add(SimulateImageFeatures(image));
  return FindImageCircle(cells);
}

double SensorNoise(const Eigen::Vector2d& pixel) {
  return 5 + std::fmod(37 * pixel.x() + 91 * pixel.y(), 7);
}

// A lens's light: less towards the edge, none beyond, over a few pixels.
double LightOf(const Eigen::Vector2d& pixel, const Eigen::Vector2d& center,
               double radius_px) {
  const double part = (pixel - center).norm() / radius_px;
  return (1 - 0.5 * part * part) *
         std::clamp(0.5 + (1 - part) * radius_px / 3, 0.0, 1.0);
}

// A scene in which a bright board stands at a place.
Brightness SceneWithBoard(const Eigen::Vector2d& center, double radius_px,
                          const Eigen::Vector2d& board) {
  return [=](const Eigen::Vector2d& pixel) {
    const bool is_board = (pixel - board).cwiseAbs().maxCoeff() < 200;
    return SensorNoise(pixel) +
           (is_board ? 220 : 90) * LightOf(pixel, center, radius_px);
  };
}

TEST(ImageCircle, IsFoundWhereverItLies) {
  for (const auto& [center, radius_px] :
       {std::pair(Eigen::Vector2d(640, 480), 450.0),     // whole
        std::pair(Eigen::Vector2d(655, 470), 700.0),     // cut at four sides
        std::pair(Eigen::Vector2d(700, 430), 480.0),     // cut at the top
        std::pair(Eigen::Vector2d(620, 500), 735.0)}) {  // corners are dark
    const auto found = FoundIn({SceneWithBoard(center, radius_px, {300, 300}),
                                SceneWithBoard(center, radius_px, {900, 600})});
    ASSERT_TRUE(found) << radius_px;
    EXPECT_LT((found->center - center).norm(), 2) << radius_px;
    EXPECT_NEAR(found->radii_px.x(), radius_px, 3);
    EXPECT_EQ(found->radii_px.x(), found->radii_px.y());
  }
}

TEST(ImageCircle, IsFoundThoughAPartOfItsRoundIsNeverLit) {
  const Eigen::Vector2d center(640, 480);
  const Brightness dark_wall = [&](const Eigen::Vector2d& pixel) {
    return pixel.x() < 330 ? SensorNoise(pixel)
                           : SceneWithBoard(center, 450, {700, 500})(pixel);
  };
  const auto found = FoundIn({dark_wall});
  ASSERT_TRUE(found);
  EXPECT_LT((found->center - center).norm(), 4);
  EXPECT_NEAR(found->radii_px.x(), 450, 4);
}

TEST(ImageCircle, IsNotFoundWhereThereIsNone) {
  const Eigen::Vector2d center(640, 480);
  const std::vector<std::pair<const char*, Brightness>> scenes = {
      {"evenly lit",
       [](const Eigen::Vector2d& p) { return 100 + SensorNoise(p); }},
      {"black", SensorNoise},
      {"strong vignetting",
       [&](const Eigen::Vector2d& p) {
         return SensorNoise(p) +
                230 * std::pow(1 + (p - center).squaredNorm() / (450.0 * 450.0),
                               -2);
       }},
      {"a spot that fades",
       [&](const Eigen::Vector2d& p) {
         return SensorNoise(p) + 230 * std::exp(-(p - center).squaredNorm() /
                                                (2 * 250.0 * 250.0));
       }},
      {"a lit rectangle",
       [&](const Eigen::Vector2d& p) {
         return SensorNoise(p) +
                ((p - center).cwiseAbs().maxCoeff() < 350 ? 200 : 0);
       }},
      {"a finger in one corner",
       [&](const Eigen::Vector2d& p) {
         return SensorNoise(p) +
                ((p - Eigen::Vector2d(1280, 960)).norm() > 400 ? 150 : 0);
       }},
      {"light beyond, as a reflection", [&](const Eigen::Vector2d& p) {
         return SceneWithBoard(center, 450, {600, 400})(p) +
                ((p - Eigen::Vector2d(60, 60)).norm() < 60 ? 150 : 0);
       }}};
  for (const auto& [name, scene] : scenes)
    EXPECT_FALSE(FoundIn({scene})) << name;
}

// A board that is only here and there shows no edge, and one more image that
// lights a corner ends the belief.
TEST(ImageCircle, IsNotFoundOnceAnImageIsLitBeyond) {
  const Eigen::Vector2d center(640, 480);
  const Brightness seen = SceneWithBoard(center, 450, {600, 400});
  ASSERT_TRUE(FoundIn({seen}));
  EXPECT_FALSE(FoundIn({seen, [](const Eigen::Vector2d& p) {
                          return p.x() + p.y() < 500 ? 120.0 : SensorNoise(p);
                        }}));
}

TEST(ImageCircle, TakesSmallImages) {
  for (const ImageSize size :
       {ImageSize{1, 1}, ImageSize{3, 2}, ImageSize{40, 30}}) {
    BrightestCells cells = BrightestCells::Over(size);
    GreyLevels image;
    image.size = size;
    image.levels.assign(static_cast<size_t>(size.width) * size.height, 0.f);
    cells.Add(image);
    EXPECT_FALSE(FindImageCircle(cells));
  }
}

}  // namespace
}  // namespace raygrid
