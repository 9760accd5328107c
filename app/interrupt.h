#pragma once

namespace livemvs::app {

/// From here on SIGINT, SIGTERM and SIGHUP only set a flag, so that the cloud so far can be
/// written. A second signal ends the program at once.
void CatchInterrupts();

/// True once a signal has come.
bool Interrupted();

}  // namespace livemvs::app
