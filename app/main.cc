#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>

#include "commands.h"
#include "livemvs/core/error.h"
#include "livemvs/core/log.h"

namespace livemvs::app {
namespace {

int Fail(const std::exception& e, ExitCode code) {
  std::fprintf(stderr, "livemvs: error: %s\n", e.what());
  return code;
}

int ExitCodeOf(const Error& e) {
  switch (e.kind()) {
    case ErrorKind::kBadInput:
      return kExitBadInput;
    case ErrorKind::kOutOfResource:
      return kExitOutOfResources;
    case ErrorKind::kFailed:
      break;
  }
  return kExitFailed;
}

int Main(int argc, char** argv) {
  SetLogCallback([](LogLevel level, const std::string& message) {
    const char* prefix = level == LogLevel::kWarning ? "livemvs: warning: " : "";
    std::fprintf(stderr, "%s%s\n", prefix, message.c_str());
  });
  CLI::App app("livemvs: dense 3-D models from video, while the video is being filmed.", "livemvs");
  app.set_version_flag("--version", LIVEMVS_VERSION);
  app.require_subcommand(1);
  app.footer("Run 'livemvs COMMAND --help' for a command's options and examples.");
  AddRunCommand(app);
  AddScanCommand(app);
  AddCamerasCommand(app);
  AddInfoCommand(app);
  AddSynthCommand(app);
  AddEvalCommand(app);
  AddMeshCommand(app);
  AddDepthCheckCommand(app);
  AddRenderCommand(app);
  AddViewCommand(app);
  AddBoardCommand(app);
  AddCalibrateCommand(app);
  AddTrackCommand(app);
  AddExportCommand(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& e) {
    return e.get_exit_code();
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kExitDone : kExitUsage;
  } catch (const Error& e) {
    return Fail(e, static_cast<ExitCode>(ExitCodeOf(e)));
  } catch (const std::invalid_argument& e) {
    return Fail(e, kExitUsage);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "livemvs: error: out of memory; try fewer --seeds or smaller frames\n");
    return kExitOutOfResources;
  } catch (const std::exception& e) {
    return Fail(e, kExitFailed);
  }
  return kExitDone;
}

}  // namespace
}  // namespace livemvs::app

int main(int argc, char** argv) { return livemvs::app::Main(argc, argv); }
