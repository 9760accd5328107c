#include "commands.h"

namespace livemvs::app {

void AddDepthCheckCommand(CLI::App&) {}

}  // namespace livemvs::app
