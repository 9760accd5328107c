#include "livemvs/io/dataset_consistency.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

namespace livemvs {
namespace {

constexpr int kHalf = 5;             // of an 11 x 11 patch
constexpr int kSearch = 32;          // [px] in x and y
constexpr int kGrid = 10;            // patches are spread over a grid of 10 x 10 cells
constexpr double kMinNcc = 0.92;     // below, a match may be anything
constexpr double kAmbiguous = 0.03;  // the runner-up elsewhere must be worse by this much
constexpr double kMinMotion = 2.0;   // [px]; still patches say nothing

using Grey = Image<std::uint8_t>;

struct Match {
  Eigen::Vector2d a, b;  // [px]
};

// Patch statistics: mean and the root of the sum of squared deviations.
struct Patch {
  double mean = 0;
  double norm = 0;
};

Patch Measure(const Grey& image, int cx, int cy) {
  constexpr int kPixels = (2 * kHalf + 1) * (2 * kHalf + 1);
  int sum = 0, squares = 0;
  for (int y = cy - kHalf; y <= cy + kHalf; ++y) {
    const std::uint8_t* row = image.Row(y);
    for (int x = cx - kHalf; x <= cx + kHalf; ++x) {
      sum += row[x];
      squares += row[x] * row[x];
    }
  }
  const double mean = static_cast<double>(sum) / kPixels;
  return {mean, std::sqrt(std::max(0.0, squares - mean * sum))};
}

double Ncc(const Grey& a, const Patch& pa, int ax, int ay, const Grey& b, int bx, int by) {
  const Patch pb = Measure(b, bx, by);
  if (!(pb.norm > 1)) return -1;
  int products = 0;
  for (int dy = -kHalf; dy <= kHalf; ++dy) {
    const std::uint8_t* ra = a.Row(ay + dy) + ax;
    const std::uint8_t* rb = b.Row(by + dy) + bx;
    for (int dx = -kHalf; dx <= kHalf; ++dx) products += ra[dx] * rb[dx];
  }
  constexpr int kPixels = (2 * kHalf + 1) * (2 * kHalf + 1);
  return (products - kPixels * pa.mean * pb.mean) / (pa.norm * pb.norm);
}

// Texture in both directions: the smaller eigenvalue of the structure tensor.
double Cornerness(const Grey& image, int cx, int cy) {
  double xx = 0, xy = 0, yy = 0;
  for (int y = cy - kHalf; y <= cy + kHalf; ++y) {
    for (int x = cx - kHalf; x <= cx + kHalf; ++x) {
      const double gx = image(x + 1, y) - image(x - 1, y);
      const double gy = image(x, y + 1) - image(x, y - 1);
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  }
  return 0.5 * (xx + yy - std::sqrt((xx - yy) * (xx - yy) + 4 * xy * xy));
}

// The best-textured place of each cell of a grid.
std::vector<Eigen::Vector2i> FindPatches(const Grey& image) {
  constexpr int kBorder = kHalf + 1;
  constexpr double kMinCornerness = 20000;  // a gradient of about 6 grey levels in all directions
  std::vector<Eigen::Vector2i> patches;
  const int cell_w = (image.width() - 2 * kBorder) / kGrid;
  const int cell_h = (image.height() - 2 * kBorder) / kGrid;
  if (cell_w < 1 || cell_h < 1) return patches;
  const int step = std::max(2, std::min(cell_w, cell_h) / 16);
  for (int cell = 0; cell < kGrid * kGrid; ++cell) {
    const int x0 = kBorder + cell % kGrid * cell_w, y0 = kBorder + cell / kGrid * cell_h;
    double best = kMinCornerness;
    std::optional<Eigen::Vector2i> place;
    for (int y = y0; y < y0 + cell_h; y += step) {
      for (int x = x0; x < x0 + cell_w; x += step) {
        const double c = Cornerness(image, x, y);
        if (c > best) best = c, place = Eigen::Vector2i(x, y);
      }
    }
    if (place) patches.push_back(*place);
  }
  return patches;
}

double SubPixel(double left, double middle, double right) {
  const double curvature = left - 2 * middle + right;
  return curvature < -1e-9 ? std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5) : 0;
}

std::optional<Match> FindMatch(const Grey& a, const Eigen::Vector2i& p, const Grey& b) {
  const Patch patch = Measure(a, p.x(), p.y());
  if (!(patch.norm > 1)) return std::nullopt;
  constexpr int kSide = 2 * kSearch + 1;
  std::vector<double> scores(kSide * kSide, -1);
  int best = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const int x = p.x() + i % kSide - kSearch, y = p.y() + i / kSide - kSearch;
    if (x < kHalf || y < kHalf || x >= b.width() - kHalf || y >= b.height() - kHalf) continue;
    scores[static_cast<std::size_t>(i)] = Ncc(a, patch, p.x(), p.y(), b, x, y);
    if (scores[static_cast<std::size_t>(i)] > scores[static_cast<std::size_t>(best)]) best = i;
  }
  const auto score = [&](int x, int y) { return scores[static_cast<std::size_t>(y * kSide + x)]; };
  const int bx = best % kSide, by = best / kSide;
  const double top = score(bx, by);
  if (top < kMinNcc || bx == 0 || by == 0 || bx == kSide - 1 || by == kSide - 1) {
    return std::nullopt;
  }
  constexpr int kSamePeak = 3;  // [px]
  for (int i = 0; i < kSide * kSide; ++i) {
    const bool elsewhere =
        std::abs(i % kSide - bx) > kSamePeak || std::abs(i / kSide - by) > kSamePeak;
    if (elsewhere && score(i % kSide, i / kSide) > top - kAmbiguous) return std::nullopt;
  }
  const Eigen::Vector2d offset(SubPixel(score(bx - 1, by), top, score(bx + 1, by)),
                               SubPixel(score(bx, by - 1), top, score(bx, by + 1)));
  const Eigen::Vector2d from = p.cast<double>();
  return Match{from, from + Eigen::Vector2d(bx - kSearch, by - kSearch) + offset};
}

Rigid3d Read(const Rigid3d& cam_from_world, PoseReading reading) {
  const bool inverse =
      reading == PoseReading::kInverse || reading == PoseReading::kInverseFlippedAxes;
  Rigid3d pose = inverse ? cam_from_world.Inverse() : cam_from_world;
  if (reading == PoseReading::kFlippedAxes || reading == PoseReading::kInverseFlippedAxes) {
    pose.rotation.bottomRows<2>() *= -1;
    pose.translation.tail<2>() *= -1;
  }
  return pose;
}

// Distance of the match's end from the epipolar line of its start, to first order (Sampson), [px].
std::optional<double> EpipolarError(const Match& match,
                                    const PosedFrame& a,
                                    const PosedFrame& b,
                                    PoseReading reading) {
  const std::optional<Eigen::Vector3d> ray_a = Projector(a.camera).Unproject(match.a);
  const std::optional<Eigen::Vector3d> ray_b = Projector(b.camera).Unproject(match.b);
  if (!ray_a || !ray_b) return std::nullopt;
  const Rigid3d b_from_a =
      Read(b.cam_from_world, reading) * Read(a.cam_from_world, reading).Inverse();
  const double baseline = b_from_a.translation.norm();
  if (!(baseline > 0)) return std::nullopt;
  Eigen::Matrix3d cross;
  const Eigen::Vector3d t = b_from_a.translation / baseline;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  const Eigen::Matrix3d essential = cross * b_from_a.rotation;
  const Eigen::Vector3d line_b = essential * *ray_a;
  const Eigen::Vector3d line_a = essential.transpose() * *ray_b;
  const double scale = std::sqrt(line_a.head<2>().squaredNorm() + line_b.head<2>().squaredNorm());
  if (!(scale > 1e-12)) return std::nullopt;
  return std::abs(ray_b->dot(line_b)) / scale * std::sqrt(2.0) * b.camera.fx;
}

std::vector<Match> MatchFrames(const PosedFrame& a, const PosedFrame& b) {
  std::vector<Match> matches;
  for (const Eigen::Vector2i& p : FindPatches(a.picture->grey)) {
    const std::optional<Match> match = FindMatch(a.picture->grey, p, b.picture->grey);
    if (match && (match->a - match->b).norm() >= kMinMotion) matches.push_back(*match);
  }
  return matches;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::string ToString(PoseReading reading) {
  switch (reading) {
    case PoseReading::kInverse:
      return "inverted";
    case PoseReading::kFlippedAxes:
      return "with y and z turned round";
    case PoseReading::kInverseFlippedAxes:
      return "inverted, with y and z turned round";
    case PoseReading::kAsIs:
      break;
  }
  return "as read";
}

EpipolarReport CheckEpipolarConsistency(const std::vector<PosedFrame>& frames) {
  constexpr std::size_t kStarts = 4, kEnoughOfPair = 20;
  EpipolarReport report;
  std::array<std::vector<double>, kPoseReadings> errors;
  for (std::size_t s = 0; s < kStarts; ++s) {
    const std::size_t start = s * frames.size() / kStarts;
    // The widest of a few baselines at which patches still look the same tells most.
    std::vector<Match> matches;
    std::size_t end = start;
    for (const std::size_t gap : {8, 4, 2, 1}) {
      if (start + gap >= frames.size()) continue;
      std::vector<Match> candidate = MatchFrames(frames[start], frames[start + gap]);
      if (candidate.size() <= matches.size()) continue;
      matches = std::move(candidate);
      end = start + gap;
      if (matches.size() >= kEnoughOfPair) break;
    }
    report.matches += matches.size();
    for (const Match& match : matches) {
      for (std::size_t r = 0; r < kPoseReadings; ++r) {
        const auto reading = static_cast<PoseReading>(r);
        const auto error = EpipolarError(match, frames[start], frames[end], reading);
        if (error) errors[r].push_back(*error);
      }
    }
  }
  for (std::size_t r = 0; r < kPoseReadings; ++r) {
    report.median_error_px[r] = Median(errors[r]);
    const double best = report.median_error_px[static_cast<std::size_t>(report.best)];
    if (report.median_error_px[r] < best) report.best = static_cast<PoseReading>(r);
  }
  return report;
}

}  // namespace livemvs
