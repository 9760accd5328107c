#include "commands.h"

namespace livemvs::app {

void AddSynthCommand(CLI::App&) {}

}  // namespace livemvs::app
