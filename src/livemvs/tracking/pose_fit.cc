#include "livemvs/tracking/pose_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "livemvs/tracking/projection.h"

namespace livemvs {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kRobustSteps = 12;
constexpr int kFinalSteps = 4;
constexpr double kDone = 1e-9;          // size of a step that changes nothing any more
constexpr double kMinDepth = 1e-3;      // [m]
constexpr double kBehind = 1e12;        // squared error of a point behind the camera
constexpr double kMaxCondition = 1e14;  // of the normal equations, radians against metres

struct Normal {
  Matrix6 h = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double cost = 0;
};

// Squared error in units of its expectation.
double Chi2(const Camera& camera, const Rigid3d& pose, const PointObservation& o, double sigma) {
  const Eigen::Vector3d p = pose * o.point;
  if (p.z() < kMinDepth) return kBehind;
  const auto d = ProjectWithDerivatives(camera, p, false);
  return (d.pixel - o.pixel).squaredNorm() / (sigma * sigma);
}

class Solver {
 public:
  Solver(const Camera& camera, const std::vector<PointObservation>& obs, const PoseFitOptions& o)
      : camera_(camera), observations_(obs), options_(o), used_(obs.size(), true) {}

  double Sigma(const PointObservation& o) const {
    return std::hypot(o.sigma_px, options_.floor_px);
  }

  Normal Linearise(const Rigid3d& pose, double robust_scale) const {
    Normal n;
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      if (!used_[i]) continue;
      const PointObservation& o = observations_[i];
      const Eigen::Vector3d p = pose * o.point;
      if (p.z() < kMinDepth) {
        n.cost += kBehind;
        continue;
      }
      const PointProjection projection = ProjectWithDerivatives(camera_, p, false);
      const Eigen::Vector2d r = projection.pixel - o.pixel;
      const double inverse = 1 / (Sigma(o) * Sigma(o));
      const double chi2 = r.squaredNorm() * inverse;
      const double scale2 = robust_scale * robust_scale;
      const double weight = robust_scale > 0 ? inverse / (1 + chi2 / scale2) : inverse;
      const Eigen::Matrix<double, 2, 6> j = ByMotion(projection, p);
      n.h += weight * j.transpose() * j;
      n.g += weight * j.transpose() * r;
      n.cost += robust_scale > 0 ? scale2 * std::log1p(chi2 / scale2) : chi2;
    }
    return n;
  }

  // Levenberg-Marquardt. @return False where it breaks down.
  bool Minimise(int steps, double robust_scale, Rigid3d* pose) const {
    double lambda = 1e-6;
    Normal now = Linearise(*pose, robust_scale);
    for (int i = 0; i < steps; ++i) {
      Matrix6 h = now.h;
      h.diagonal() *= 1 + lambda;
      const Vector6 step = -h.ldlt().solve(now.g);
      if (!step.allFinite()) return false;
      const Rigid3d trial = Moved(*pose, step);
      const Normal next = Linearise(trial, robust_scale);
      if (next.cost <= now.cost) {
        *pose = trial;
        now = next;
        lambda = std::max(1e-9, 0.1 * lambda);
      } else {
        lambda *= 30;
      }
      if (step.norm() < kDone) break;
    }
    return true;
  }

  // Leaves out what does not fit. @return Number of inliers.
  int Classify(const Rigid3d& pose, double scale) {
    int count = 0;
    const double limit = std::pow(options_.outlier_sigmas * scale, 2) * 2;
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      const PointObservation& o = observations_[i];
      used_[i] = Chi2(camera_, pose, o, Sigma(o)) <= limit;
      count += used_[i] ? 1 : 0;
    }
    return count;
  }

  // Ratio of what the errors are to what they should be, from the middle one; at least 1.
  double MedianScale(const Rigid3d& pose) const {
    std::vector<double> chi2;
    for (const PointObservation& o : observations_) {
      chi2.push_back(Chi2(camera_, pose, o, Sigma(o)));
    }
    const auto middle = chi2.begin() + static_cast<std::ptrdiff_t>(chi2.size() / 2);
    std::nth_element(chi2.begin(), middle, chi2.end());
    constexpr double kMedianOfChi2 = 1.386;  // with two degrees of freedom
    return std::clamp(std::sqrt(*middle / kMedianOfChi2), 1.0, 20.0);
  }

  std::optional<PoseFit> Finish(const Rigid3d& pose, int inliers) const {
    PoseFit fit;
    fit.cam_from_world = pose;
    fit.inlier = used_;
    fit.inliers = inliers;
    double squares = 0, chi2 = 0;
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      if (!used_[i]) continue;
      const double own = Chi2(camera_, pose, observations_[i], 1);
      squares += own;
      chi2 += own / std::pow(Sigma(observations_[i]), 2);
    }
    fit.rms_px = std::sqrt(squares / inliers);
    const Matrix6 h = Linearise(pose, 0).h;
    const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(h);
    if (!(eigen.eigenvalues()[0] * kMaxCondition > eigen.eigenvalues()[5])) return std::nullopt;
    const double excess = std::max(1.0, chi2 / std::max(1, 2 * inliers - 6));
    fit.covariance = excess * h.inverse();
    if (!pose.translation.allFinite() || !fit.covariance.allFinite()) return std::nullopt;
    return fit;
  }

 private:
  const Camera& camera_;
  const std::vector<PointObservation>& observations_;
  PoseFitOptions options_;
  std::vector<bool> used_;
};

}  // namespace

std::optional<PoseFit> FitPose(const Camera& camera,
                               const std::vector<PointObservation>& observations,
                               const Rigid3d& initial,
                               const PoseFitOptions& options) {
  if (static_cast<int>(observations.size()) < std::max(4, options.min_inliers)) return std::nullopt;
  Solver solver(camera, observations, options);
  Rigid3d pose = initial;
  double scale = solver.MedianScale(pose);
  // First with the scale of the errors at the start, then of those that remain.
  for (int round = 0; round < 2; ++round) {
    if (!solver.Minimise(kRobustSteps, 2 * scale, &pose)) return std::nullopt;
    scale = solver.MedianScale(pose);
  }
  int inliers = 0;
  for (int round = 0; round < 2; ++round) {
    inliers = solver.Classify(pose, scale);
    if (inliers < std::max(4, options.min_inliers)) return std::nullopt;
    if (!solver.Minimise(kFinalSteps, 0, &pose)) return std::nullopt;
  }
  return solver.Finish(pose, inliers);
}

}  // namespace livemvs
