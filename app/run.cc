#include "commands.h"

namespace livemvs::app {

void AddRunCommand(CLI::App&) {}

}  // namespace livemvs::app
