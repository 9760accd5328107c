#pragma once

namespace livemvs::app {

/// From here on SIGINT, SIGTERM and SIGHUP only set a flag, so that the cloud so far can be
/// written. A second signal ends the program at once.
void CatchInterrupts();

/// True once a signal has come.
bool Interrupted();

/// How many have come. Who goes on after one calls CatchInterrupts() again, so that the next, too,
/// only counts.
int Interruptions();

}  // namespace livemvs::app
