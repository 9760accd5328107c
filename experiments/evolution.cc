#include <cmath>

#include "csv.h"
#include "experiments.h"

namespace livemvs::experiments {
namespace {

// [VH11] Sec. 4.2.
// Rays shorter than this in the box leave little to be seen [scene].
constexpr double kLongRay = 0.12;

double SigmaOfPi(const Posterior<double>& q) {
  const double n = q.a + q.b;
  return std::sqrt(q.a * q.b / (n * n * (n + 1)));
}

}  // namespace

void Evolution(const Settings& settings, const PixelSet& video) {
  const PixelSensor& sensor = video.Find([](const PixelSensor& s) {
    const auto count = static_cast<int>(s.measurements.size());
    const Posterior<double> q = UpdateInTurn(s, PriorOf(s, kPrior, kPrior), count);
    // Right, and with outliers enough to be seen.
    return s.visible_share > 0.9 && count >= 100 && s.range() > kLongRay &&
           std::abs(q.mu - s.z_true) < 0.005 * s.range() && InlierRatio(q) > 0.5 &&
           InlierRatio(q) < 0.75;
  });
  Csv evolution(settings.tables / "fig4_evolution.csv",
                "update,mu [mm],sigma [mm],inlier ratio,sigma of inlier ratio,true depth [mm],"
                "Zmin [mm],Zmax [mm]");
  Csv measurements(settings.tables / "fig4_measurements.csv", "update,depth [mm],tau [mm]");
  Posterior<double> q = PriorOf(sensor, kPrior, kPrior);
  for (std::size_t n = 0; n <= sensor.measurements.size(); ++n) {
    if (n > 0) {
      const reference::DepthMeasurement& m = sensor.measurements[n - 1];
      q = Fuse(q, m.x, m.tau2, sensor.u()).posterior;
      measurements.Row(n, kMillimetres * m.x, kMillimetres * std::sqrt(m.tau2));
    }
    evolution.Row(n,
                  kMillimetres * q.mu,
                  kMillimetres * std::sqrt(q.sigma2),
                  InlierRatio(q),
                  SigmaOfPi(q),
                  kMillimetres * sensor.z_true,
                  kMillimetres * sensor.z_min,
                  kMillimetres * sensor.z_max);
  }
}

}  // namespace livemvs::experiments
