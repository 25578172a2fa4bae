#ifndef RAYGRID_TOOLS_INTERRUPTION_H
#define RAYGRID_TOOLS_INTERRUPTION_H

namespace raygrid {

/// From here on the first SIGINT or SIGTERM is only noted, so that what was
/// found so far can be written. If nothing has asked IsInterrupted() a second
/// later, work that hears nothing is being done: the program ends, as by each
/// second signal, and as by the first one otherwise.
void InstallInterruptHandler();

bool IsInterrupted();

/// From here on results are complete or being written, and a first signal no
/// longer ends the program by not being heard.
void IgnoreFirstSignal();

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_INTERRUPTION_H
