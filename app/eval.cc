#include "commands.h"

namespace livemvs::app {

void AddEvalCommand(CLI::App&) {}

}  // namespace livemvs::app
