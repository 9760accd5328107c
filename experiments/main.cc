#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments.h"

namespace livemvs::experiments {
namespace {

namespace fs = std::filesystem;

// What the experiments look at, made when the first one asks for it.
class Data {
 public:
  explicit Data(bool quick) : quick_(quick) {}

  const PixelSet& relief() { return relief_ ? *relief_ : relief_.emplace(MakeRelief(quick_)); }
  const PixelSet& video() { return video_ ? *video_ : video_.emplace(MakeVideo(quick_)); }

 private:
  bool quick_;
  std::optional<PixelSet> relief_, video_;
};

struct Experiment {
  const char* name;
  void (*run)(const Settings& settings, Data* data);
};

constexpr Experiment kExperiments[] = {
    {"float", [](const Settings& s, Data*) { FloatUpdates(s); }},
    {"fig2", [](const Settings& s, Data* data) { NccCurves(s, data->relief()); }},
    {"fig3", [](const Settings& s, Data* data) { Posteriors(s, data->video()); }},
    {"fig4", [](const Settings& s, Data* data) { Evolution(s, data->video()); }},
    {"fig5", [](const Settings& s, Data* data) { SensorKinds(s, data->video()); }},
    {"fig7", [](const Settings& s, Data*) { House(s); }},
    {"em", [](const Settings& s, Data* data) { LocalOptima(s, data->relief()); }},
    {"table1", [](const Settings& s, Data* data) { Table1(s, data->relief()); }},
};

void RunAll(const Settings& settings, const std::vector<std::string>& only) {
  Data data(settings.quick);
  for (const Experiment& e : kExperiments) {
    if (!only.empty() && std::find(only.begin(), only.end(), e.name) == only.end()) continue;
    const auto started = std::chrono::steady_clock::now();
    e.run(settings, &data);
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
