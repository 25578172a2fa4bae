#ifndef RAYGRID_BAGS_TOPIC_CHOICE_H
#define RAYGRID_BAGS_TOPIC_CHOICE_H

#include <string>
#include <vector>

#include "bags/bag.h"

namespace raygrid {

/// Returns the index of topic `name` in `names`; "" selects the only topic.
/// `what` describes the messages of these topics in errors, e.g. "images".
/// Throws InputError if there are no topics; Error(kUsage), listing the nearest
/// names, if the name is unknown or missing.
size_t ChooseTopic(const Bag& bag, const std::vector<std::string>& names,
                   const std::string& name, const std::string& what);

}  // namespace raygrid

#endif  // RAYGRID_BAGS_TOPIC_CHOICE_H
