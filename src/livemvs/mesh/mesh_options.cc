#include "livemvs/mesh/mesh_options.h"

#include <stdexcept>

namespace livemvs {
namespace {

void Require(bool valid, const char* name, double value, const char* what) {
  if (valid) return;
  throw std::invalid_argument(std::string(name) + ": must be " + what + ", is " +
                              std::to_string(value));
}

}  // namespace

void MeshOptions::Check() const {
  const auto positive = [](const char* name, double v) {
    Require(v > 0 && v < 1e6, name, v, "> 0");
  };
  const auto not_negative = [](const char* name, double v) {
    Require(v >= 0 && v < 1e6, name, v, ">= 0");
  };
  Require(resolution >= 0 && resolution < 1e18, "resolution", resolution, ">= 0");
  Require(memory_mb >= 50 && memory_mb <= 1'000'000,
          "memory_mb",
          static_cast<double>(memory_mb),
          "from 50 to 1000000");
  positive("free_gain", free_gain);
  positive("free_limit", free_limit);
  positive("inside_gain", inside_gain);
  positive("inside_limit", inside_limit);
  not_negative("inside_prior", inside_prior);
  not_negative("coarse_trust", coarse_trust);
  positive("vote_gain", vote_gain);
  Require(rho_min > 0 && rho_min <= 1, "rho_min", rho_min, "in (0, 1]");
  positive("lambda", lambda);
  Require(reach >= 1 && reach <= 6, "reach", reach, "from 1 to 6");
  Require(smoothing_rounds >= 0 && smoothing_rounds <= 10000,
          "smoothing_rounds",
          smoothing_rounds,
          "from 0 to 10000");
  not_negative("smoothing", smoothing);
  positive("support", support);
  positive("held", held);
  Require(least_facing >= 0 && least_facing < 1, "least_facing", least_facing, "in [0, 1)");
  Require(fairing_rounds >= 0 && fairing_rounds <= 10000,
          "fairing_rounds",
          fairing_rounds,
          "from 0 to 10000");
  Require(
      least_component >= 0 && least_component < 1, "least_component", least_component, "in [0, 1)");
}

void MeshWatch::Check() const {
  if (stop && stop()) throw MeshInterrupted();
}

}  // namespace livemvs
