#include "commands.h"

namespace raygrid {
namespace {

constexpr char kExitCodes[] =
    "Exit codes:\n"
    "  0  success\n"
    "  1  usage error\n"
    "  2  an input cannot be read or is malformed\n"
    "  3  too few features or images\n"
    "  4  initialization failed\n"
    "  5  no convergence, or calibrate was interrupted (best state is "
    "written)\n"
    "  6  quality gate failed: verdict fail, check DEGRADED, or an error bound "
    "of\n"
    "     a blob, table or export exceeded\n"
    "  7  an output cannot be written\n"
    "  8  a blob is corrupt, unsupported or does not match";

}  // namespace

std::string ExitCodesHelp() { return kExitCodes; }

}  // namespace raygrid
