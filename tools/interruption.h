#ifndef RAYGRID_TOOLS_INTERRUPTION_H
#define RAYGRID_TOOLS_INTERRUPTION_H

namespace raygrid {

/// From here on the first SIGINT or SIGTERM is only noted, so that what was
/// found so far can be written; the second one ends the program at once, as
/// each does otherwise.
void NoteInterruptions();

bool IsInterrupted();

}  // namespace raygrid

#endif  // RAYGRID_TOOLS_INTERRUPTION_H
