/// Approximate localization of features for each kind of target.
#ifndef RAYGRID_FEATURES_BOARD_VIEW_LOCATORS_H
#define RAYGRID_FEATURES_BOARD_VIEW_LOCATORS_H

#include <functional>

#include "dataset/kinds/target_kind.h"
#include "features/board_view/detection.h"

namespace raygrid {

/// Detects a board's features approximately. Empty for star boards, which are
/// detected jointly.
using Locator = std::function<ImageDetection(const GreyImage&)>;

#define RAYGRID_TARGET_KIND(Name) Locator Make##Name##Locator(const Board&);
#include "dataset/kinds/kind_list.inc"
#undef RAYGRID_TARGET_KIND

}  // namespace raygrid

#endif  // RAYGRID_FEATURES_BOARD_VIEW_LOCATORS_H
