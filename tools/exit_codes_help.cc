#include "commands.h"

namespace raygrid {
namespace {

// The exit codes in the words of README.md.
constexpr char kExitCodes[] =
    "Exit codes:\n"
    "  0  done\n"
    "  1  wrong usage\n"
    "  2  an input cannot be read or is malformed\n"
    "  3  too few features or images\n"
    "  4  initialisation failed\n"
    "  5  did not converge: calibrate was interrupted, its files are written,\n"
    "     or an earlier result kept; or fit found no model that fits\n"
    "  6  a quality gate failed: calibrate's verdict is fail, or check says\n"
    "     DEGRADED, either with all its output; or no blob, table or export\n"
    "     holds the camera within its bounds\n"
    "  7  an output cannot be written\n"
    "  8  a blob is corrupt, unsupported or does not match";

}  // namespace

std::string ExitCodesHelp() { return kExitCodes; }

}  // namespace raygrid
