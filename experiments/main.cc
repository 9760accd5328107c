#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiments.h"

namespace livemvs::experiments {
namespace {

namespace fs = std::filesystem;

struct Experiment {
  const char* name;
  std::function<void(const Settings&, const Relief*)> run;
  bool needs_relief;
};

// An experiment with the relief's pixels.
auto OnRelief(void (*run)(const Settings&, const Relief&)) {
  return [run](const Settings& settings, const Relief* relief) { run(settings, *relief); };
}

// An experiment with a scene of its own.
auto OnItsOwn(void (*run)(const Settings&)) {
  return [run](const Settings& settings, const Relief*) { run(settings); };
}

const std::vector<Experiment>& Experiments() {
  static const std::vector<Experiment> experiments = {
      {"float", OnItsOwn(FloatUpdates), false},
      {"fig5", OnItsOwn(SensorKinds), false},
      {"fig7", OnItsOwn(House), false},
      {"fig2", OnRelief(NccCurves), true},
      {"fig3", OnRelief(Posteriors), true},
      {"fig4", OnRelief(Evolution), true},
      {"em", OnRelief(LocalOptima), true},
      {"table1", OnRelief(Table1), true},
  };
  return experiments;
}

void RunAll(const Settings& settings, const std::vector<std::string>& only) {
  std::optional<Relief> relief;
  for (const Experiment& e : Experiments()) {
    if (!only.empty() && std::find(only.begin(), only.end(), e.name) == only.end()) continue;
    const auto started = std::chrono::steady_clock::now();
    if (e.needs_relief && !relief) relief.emplace(MakeRelief(settings.quick));
    e.run(settings, relief ? &*relief : nullptr);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - started;
    std::fprintf(stderr, "%s: done in %.0f s\n", e.name, seconds.count());
  }
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Computes the tables of the paper's experiments; scripts/reproduce_paper draws them.");
  std::string folder;
  std::vector<std::string> only;
  Settings settings;
  app.add_option("FOLDER", folder, "Where the tables go")->required();
  app.add_option("--only", only, "Names of experiments: float fig2 fig3 fig4 fig5 fig7 em table1");
  app.add_option("--temple", settings.temple, "Folder of Middlebury's templeRing");
  app.add_flag("--quick", settings.quick, "Tiny sizes: shows only that everything works");
  CLI11_PARSE(app, argc, argv);
  settings.tables = fs::path(folder) / "tables";
  settings.maps = fs::path(folder) / "maps";
  fs::create_directories(settings.tables);
  fs::create_directories(settings.maps);
  RunAll(settings, only);
  return 0;
}

}  // namespace
}  // namespace livemvs::experiments

int main(int argc, char** argv) {
  try {
    return livemvs::experiments::Main(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "paper_experiments: error: %s\n", e.what());
    return 1;
  }
}
