#ifndef RAYGRID_EXCHANGE_SKEWED_LENS_H
#define RAYGRID_EXCHANGE_SKEWED_LENS_H

#include <string>
#include <vector>

#include "exchange/lens_form.h"

namespace raygrid {

/// The grid nearest to a lens whose camera matrix has a skew. A remark says the
/// error that it leaves.
LensInForm GridOfSkewedLens(const LensInForm& lens,
                            std::vector<std::string>* remarks);

}  // namespace raygrid

#endif  // RAYGRID_EXCHANGE_SKEWED_LENS_H
