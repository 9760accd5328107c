#include "commands.h"

namespace livemvs::app {

void AddInfoCommand(CLI::App&) {}

}  // namespace livemvs::app
