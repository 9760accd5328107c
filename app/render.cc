#include "commands.h"

namespace livemvs::app {

void AddRenderCommand(CLI::App&) {}

}  // namespace livemvs::app
