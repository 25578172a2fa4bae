"""raygrid where the calibrator's package is not: the module raygrid_runtime by the name that programs
import on either."""
from raygrid_runtime import *
from raygrid_runtime import __doc__  # noqa: F401
