#ifndef RAYGRID_TOOLS_INTERRUPTION_H
#define RAYGRID_TOOLS_INTERRUPTION_H

namespace raygrid {

/// Installs a handler that only records the first SIGINT or SIGTERM, so that
/// intermediate results can be written. If IsInterrupted() is not called within
/// a second, because the current work does not poll it, or on a second signal,
/// the program ends as by the signal.
void InstallInterruptHandler();

bool IsInterrupted();

/// Makes a first signal no longer end the program if it is not polled: called
/// when results are complete or being written.
void IgnoreFirstSignal();

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_INTERRUPTION_H
