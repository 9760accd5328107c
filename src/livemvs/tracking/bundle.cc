#include "livemvs/tracking/bundle.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace livemvs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kMinDepth = 1e-3;       // [m]
constexpr double kBehind = 1e9;          // cost of a point behind the camera
constexpr double kMedianOfChi2 = 1.386;  // with two degrees of freedom
constexpr double kDone = 1e-10;          // relative decrease of the cost that ends the steps

// What is estimated: what all views share, and a pose for each.
struct State {
  Camera camera;
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
  std::vector<Rigid3d> poses;
};

Eigen::Vector3d BendTerms(const Eigen::Vector3d& p) {
  return {p.x() * p.x(), p.x() * p.y(), p.y() * p.y()};
}

double* Intrinsic(Camera* c, int i) {
  double* const linear[4] = {&c->fx, &c->fy, &c->cx, &c->cy};
  return i < 4 ? linear[i] : &c->distortion[i - 4];
}

class Adjuster {
 public:
  Adjuster(const std::vector<BundleView>& views, const BundleOptions& options)
      : views_(views), options_(options) {
    for (int i = 0; i < kIntrinsics; ++i) {
      if (options.free[i] && !(i == 1 && options.equal_focal)) columns_.push_back(i);
    }
    shared_ = static_cast<int>(columns_.size()) + (options.bend ? 3 : 0);
    for (const BundleView& view : views) used_.emplace_back(view.observations.size(), true);
  }

  // The normal equations, the poses' part in blocks.
  struct System {
    double cost = 0;
    MatrixXd shared;
    VectorXd shared_gradient;
    std::vector<Matrix6> pose;
    std::vector<Vector6> pose_gradient;
    std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> mixed;
  };

  System Linearise(const State& s, double robust_scale) const {
    System n;
    n.shared = MatrixXd::Zero(shared_, shared_);
    n.shared_gradient = VectorXd::Zero(shared_);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      n.pose.emplace_back(Matrix6::Zero());
      n.pose_gradient.emplace_back(Vector6::Zero());
      n.mixed.emplace_back(Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, shared_));
      for (std::size_t i = 0; i < views_[v].observations.size(); ++i) {
        if (used_[v][i]) AddObservation(s, v, views_[v].observations[i], robust_scale, &n);
      }
    }
    return n;
  }

  // A step of damped normal equations. @return False where they have no solution.
  bool Step(const System& n, double lambda, State* s) const {
    MatrixXd reduced = n.shared;
    reduced.diagonal() *= 1 + lambda;
    VectorXd right = -n.shared_gradient;
    std::vector<Matrix6> inverse(views_.size());
    for (std::size_t v = 0; v < views_.size(); ++v) {
      Matrix6 h = n.pose[v];
      h.diagonal() *= 1 + lambda;
      h.diagonal().array() += 1e-9;  // a view without inliers stays where it is
      inverse[v] = h.inverse();
      reduced -= n.mixed[v].transpose() * inverse[v] * n.mixed[v];
      right += n.mixed[v].transpose() * (inverse[v] * n.pose_gradient[v]);
    }
    const VectorXd shared = shared_ > 0 ? VectorXd(reduced.ldlt().solve(right)) : VectorXd();
    if (!shared.allFinite()) return false;
    Apply(shared, s);
    for (std::size_t v = 0; v < views_.size(); ++v) {
      Vector6 step = -n.pose_gradient[v];
      if (shared_ > 0) step -= n.mixed[v] * shared;
      step = inverse[v] * step;
      if (!step.allFinite()) return false;
      s->poses[v] = Moved(s->poses[v], step);
    }
    return s->camera.fx > 0 && s->camera.fy > 0;
  }

  bool Minimise(double robust_scale, State* state) const {
    double lambda = 1e-4;
    System now = Linearise(*state, robust_scale);
    for (int i = 0; i < options_.max_steps && lambda < 1e8; ++i) {
      State trial = *state;
      if (!Step(now, lambda, &trial)) {
        lambda *= 10;
        continue;
      }
      System next = Linearise(trial, robust_scale);
      if (!(next.cost <= now.cost)) {
        lambda *= 10;
        continue;
      }
      const bool done = now.cost - next.cost <= kDone * now.cost;
      *state = std::move(trial);
      now = std::move(next);
      lambda = std::max(1e-9, 0.1 * lambda);
      if (done) break;
    }
    return std::isfinite(now.cost);
  }

  double MedianScale(const State& s) const {
    std::vector<double> chi2;
    ForEach(s, [&](std::size_t, std::size_t, double squared, double sigma) {
      chi2.push_back(squared / (sigma * sigma));
    });
    if (chi2.empty()) return 1;
    const auto middle = chi2.begin() + static_cast<std::ptrdiff_t>(chi2.size() / 2);
    std::nth_element(chi2.begin(), middle, chi2.end());
    return std::clamp(std::sqrt(*middle / kMedianOfChi2), 1.0, 1000.0);
  }

  void Classify(const State& s, double scale) {
    const double limit = 2 * std::pow(options_.outlier_sigmas * scale, 2);
    ForEach(s, [&](std::size_t v, std::size_t i, double squared, double sigma) {
      used_[v][i] = squared <= limit * sigma * sigma;
    });
  }

  void Finish(const State& s, BundleResult* result) const {
    double squares = 0, chi2 = 0;
    std::vector<int> counts(views_.size(), 0);
    result->view_rms_px.assign(views_.size(), 0);
    ForEach(s, [&](std::size_t v, std::size_t i, double squared, double sigma) {
      if (!used_[v][i]) return;
      result->view_rms_px[v] += squared;
      ++counts[v];
      squares += squared;
      chi2 += squared / (sigma * sigma);
    });
    for (std::size_t v = 0; v < views_.size(); ++v) {
      result->view_rms_px[v] = std::sqrt(result->view_rms_px[v] / std::max(1, counts[v]));
      result->inliers += counts[v];
    }
    const int freedom = 2 * result->inliers - shared_ - 6 * static_cast<int>(views_.size());
    if (freedom < 1) return;
    result->rms_px = std::sqrt(squares / result->inliers);
    result->camera = s.camera;
    result->bend = s.bend;
    result->cam_from_world = s.poses;
    result->converged = true;
    SetSigmas(s, std::max(1.0, chi2 / freedom), result);
  }

  const std::vector<int>& columns() const { return columns_; }

 private:
  double Sigma(const PointObservation& o) const {
    return std::hypot(o.sigma_px, options_.floor_px);
  }

  void AddObservation(const State& s,
                      std::size_t v,
                      const PointObservation& o,
                      double robust_scale,
                      System* n) const {
    Eigen::Vector3d point = o.point;
    point.z() += s.bend.dot(BendTerms(o.point));
    const Eigen::Vector3d p = s.poses[v] * point;
    if (p.z() < kMinDepth) {
      n->cost += kBehind;
      return;
    }
    const PointProjection projection = ProjectWithDerivatives(s.camera, p, true);
    const Eigen::Vector2d r = projection.pixel - o.pixel;
    const double inverse = 1 / std::pow(Sigma(o), 2), chi2 = r.squaredNorm() * inverse;
    const double scale2 = robust_scale * robust_scale;
    const double weight = robust_scale > 0 ? inverse / (1 + chi2 / scale2) : inverse;
    n->cost += robust_scale > 0 ? scale2 * std::log1p(chi2 / scale2) : chi2;
    const Eigen::Matrix<double, 2, 6> by_pose = ByMotion(projection, p);
    Eigen::Matrix<double, 2, Eigen::Dynamic> by_shared(2, shared_);
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      by_shared.col(k) = projection.by_camera.col(columns_[k]);
      if (columns_[k] == 0 && options_.equal_focal) by_shared.col(k) += projection.by_camera.col(1);
    }
    if (options_.bend) {
      by_shared.rightCols<3>() =
          projection.by_point * s.poses[v].rotation.col(2) * BendTerms(o.point).transpose();
    }
    n->pose[v] += weight * by_pose.transpose() * by_pose;
    n->pose_gradient[v] += weight * by_pose.transpose() * r;
    n->mixed[v] += weight * by_pose.transpose() * by_shared;
    n->shared += weight * by_shared.transpose() * by_shared;
    n->shared_gradient += weight * by_shared.transpose() * r;
  }

  void Apply(const VectorXd& step, State* s) const {
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      *Intrinsic(&s->camera, columns_[k]) += step[static_cast<Eigen::Index>(k)];
      if (columns_[k] == 0 && options_.equal_focal) s->camera.fy += step[0];
    }
    if (options_.bend) s->bend += step.tail<3>();
  }

  void SetSigmas(const State& s, double excess, BundleResult* result) const {
    const System n = Linearise(s, 0);
    MatrixXd reduced = n.shared;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      Matrix6 h = n.pose[v];
      h.diagonal().array() += 1e-9;
      reduced -= n.mixed[v].transpose() * h.inverse() * n.mixed[v];
    }
    if (shared_ == 0) return;
    const MatrixXd covariance = reduced.inverse();
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      const double variance = excess * covariance(at, at);
      // Not determined at all: anything goes.
      result->sigma[columns_[k]] =
          variance > 0 && std::isfinite(variance) ? std::sqrt(variance) : 1e9;
    }
    if (options_.equal_focal && options_.free[0]) result->sigma[1] = result->sigma[0];
  }

  template <typename F>
  void ForEach(const State& s, F&& f) const {
    for (std::size_t v = 0; v < views_.size(); ++v) {
      for (std::size_t i = 0; i < views_[v].observations.size(); ++i) {
        const PointObservation& o = views_[v].observations[i];
        Eigen::Vector3d point = o.point;
        point.z() += s.bend.dot(BendTerms(o.point));
        const Eigen::Vector3d p = s.poses[v] * point;
        const double squared =
            p.z() < kMinDepth
                ? kBehind
                : (ProjectWithDerivatives(s.camera, p, false).pixel - o.pixel).squaredNorm();
        f(v, i, squared, Sigma(o));
      }
    }
  }

  const std::vector<BundleView>& views_;
  const BundleOptions& options_;
  std::vector<int> columns_;  // intrinsics that are free
  int shared_ = 0;            // number of what all views share
  std::vector<std::vector<bool>> used_;
};

}  // namespace

BundleResult AdjustBundle(const Camera& camera,
                          const std::vector<BundleView>& views,
                          const BundleOptions& options) {
  BundleResult result;
  result.camera = camera;
  State state;
  state.camera = camera;
  for (const BundleView& view : views) {
    state.poses.push_back(view.cam_from_world);
    result.cam_from_world.push_back(view.cam_from_world);
  }
  if (views.empty()) return result;
  Adjuster adjuster(views, options);
  for (int round = 0; round < 2; ++round) {
    if (!adjuster.Minimise(2 * adjuster.MedianScale(state), &state)) return result;
  }
  for (int round = 0; round < 2; ++round) {
    adjuster.Classify(state, adjuster.MedianScale(state));
    if (!adjuster.Minimise(0, &state)) return result;
  }
  adjuster.Finish(state, &result);
  return result;
}

}  // namespace livemvs
