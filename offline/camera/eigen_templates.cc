#define RAYGRID_TEMPLATE template
#include "camera/eigen_templates.h"
