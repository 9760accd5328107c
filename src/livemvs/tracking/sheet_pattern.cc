#include "livemvs/tracking/sheet_pattern.h"

#include <algorithm>
#include <cmath>

#include "livemvs/tracking/dictionary.h"
#include "livemvs/tracking/downsample.h"
#include "livemvs/tracking/projection.h"

namespace livemvs {
namespace {

constexpr int kMaxSpots = 700;             // of Align
constexpr int kMaxSteps = 12;              // of its search, to each side [coarse px]
constexpr double kCoarseSquare = 9;        // a square's side in the picture it looks at [coarse px]
constexpr double kMinStandOut = 0.25;      // least correlation of the pattern with the picture
constexpr double kMinMarkerContrast = 10;  // [grey levels]

// Grey level between pixels; the place must be at least a pixel inside.
double GreyAt(ImageView<std::uint8_t> image, const Eigen::Vector2d& p) {
  const int x = static_cast<int>(p.x()), y = static_cast<int>(p.y());
  const double fx = p.x() - x, fy = p.y() - y;
  const double top = image(x, y) * (1 - fx) + image(x + 1, y) * fx;
  const double bottom = image(x, y + 1) * (1 - fx) + image(x + 1, y + 1) * fx;
  return top * (1 - fy) + bottom * fy;
}

// What the search needs of a spot: its pixel in the coarse picture.
struct Mark {
  int x, y;
  bool white;
};

// Correlation of the pattern, ±1, with the grey levels at a shift.
double Correlation(ImageView<std::uint8_t> image, const std::vector<Mark>& marks, int dx, int dy) {
  int n = 0, whites = 0;
  std::int64_t sum = 0, squares = 0, white_sum = 0;
  for (const Mark& m : marks) {
    const unsigned x = static_cast<unsigned>(m.x + dx), y = static_cast<unsigned>(m.y + dy);
    if (x >= static_cast<unsigned>(image.width) || y >= static_cast<unsigned>(image.height)) {
      continue;
    }
    const int value = image(static_cast<int>(x), static_cast<int>(y));
    ++n;
    sum += value;
    squares += value * value;
    white_sum += m.white ? value : 0;
    whites += m.white ? 1 : 0;
  }
  const double variance = static_cast<double>(squares * n - sum * sum);
  const double spread = static_cast<double>(whites) * (n - whites);
  if (n < 30 || variance <= 0 || spread <= 0) return 0;
  return static_cast<double>(white_sum * n - sum * whites) / std::sqrt(variance * spread);
}

// Offset of a parabola's top through three values, the middle one the largest.
double Top(double before, double top, double after) {
  const double bend = before - 2 * top + after;
  return bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
}

}  // namespace

SheetPattern::SheetPattern(const Board& board) : square_(board.square) {
  std::vector<Spot> all;
  for (const BoardMarker& m : MarkersOf(board)) {
    const MarkerBits bits = BitsOf(board.dictionary, m.id);
    const int cells = bits.side + 2;
    const auto at = [&](double x, double y) -> Eigen::Vector3d {
      return m.corners[0] + (m.corners[1] - m.corners[0]) * (x / cells) +
             (m.corners[3] - m.corners[0]) * (y / cells);
    };
    Marker marker;
    marker.max_wrong = bits.side * bits.side / 16;
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        const bool inside = x > 0 && y > 0 && x <= bits.side && y <= bits.side;
        const bool white = inside && bits.white[(y - 1) * bits.side + x - 1] != 0;
        (inside ? marker.bits : marker.border).push_back({at(x + 0.5, y + 0.5), white});
      }
    }
    const double margin = 0.5 * (board.square - board.marker) / board.marker * cells;
    for (int i = 0; i < 4; ++i) {
      const double along = (i + 0.5) * cells / 4, out = 0.5 * margin;
      marker.border.push_back({at(along, -out), true});
      marker.border.push_back({at(along, cells + out), true});
      marker.border.push_back({at(-out, along), true});
      marker.border.push_back({at(cells + out, along), true});
    }
    all.insert(all.end(), marker.bits.begin(), marker.bits.end());
    all.insert(all.end(), marker.border.begin(), marker.border.end());
    markers_.push_back(std::move(marker));
  }
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      if (!board.IsBlack(column, row) || board.IsPlain(column, row)) continue;
      for (const double x : {0.25, 0.75}) {
        for (const double y : {0.25, 0.75}) {
          all.push_back({board.PointAt(column + x, row + y), false});
        }
      }
    }
  }
  // Steps of a prime that is larger than any row keep the choice spread over the sheet.
  const std::size_t count = std::min<std::size_t>(kMaxSpots, all.size());
  for (std::size_t i = 0; i < count; ++i) spots_.push_back(all[(i * 10007) % all.size()]);
}

std::optional<Rigid3d> SheetPattern::Align(ImageView<std::uint8_t> image,
                                           const Camera& camera,
                                           const Rigid3d& predicted,
                                           double radius_px) const {
  const Eigen::Vector3d middle = predicted.translation;  // of the sheet, in camera axes
  if (middle.z() <= 0) return std::nullopt;
  const double square_px = camera.FocalLength() * square_ / middle.z();
  int factor = 1;
  while (factor < 8 && square_px / (2 * factor) >= kCoarseSquare) factor *= 2;
  const Image<std::uint8_t> small = Downsample(image, factor);
  std::vector<Mark> marks;
  for (const Spot& spot : spots_) {
    const Eigen::Vector3d p = predicted * spot.point;
    if (p.z() <= 0.01) continue;
    const Eigen::Vector2d pixel = ProjectWithDerivatives(camera, p, false).pixel;
    if (!camera.Contains(pixel, -radius_px)) continue;
    marks.push_back({static_cast<int>(std::floor((pixel.x() + 0.5) / factor)),
                     static_cast<int>(std::floor((pixel.y() + 0.5) / factor)),
                     spot.white});
  }
  const int steps = std::clamp(static_cast<int>(std::ceil(radius_px / factor)), 1, kMaxSteps);
  double best = 0;
  int bx = 0, by = 0;
  for (int dy = -steps; dy <= steps; ++dy) {
    for (int dx = -steps; dx <= steps; ++dx) {
      const double c = Correlation(small.view(), marks, dx, dy);
      if (c > best) std::tie(best, bx, by) = std::tuple(c, dx, dy);
    }
  }
  if (best < kMinStandOut) return std::nullopt;
  const auto near = [&](int dx, int dy) {
    return Correlation(small.view(), marks, bx + dx, by + dy);
  };
  const double x = bx + Top(near(-1, 0), best, near(1, 0));
  const double y = by + Top(near(0, -1), best, near(0, 1));
  Rigid3d aligned = predicted;
  aligned.translation.x() += factor * x * middle.z() / camera.fx;
  aligned.translation.y() += factor * y * middle.z() / camera.fy;
  return aligned;
}

MarkerCheck SheetPattern::Check(ImageView<std::uint8_t> image,
                                const Projector& projector,
                                const Rigid3d& cam_from_world) const {
  MarkerCheck check;
  const auto grey = [&](const Spot& spot) -> std::optional<double> {
    const auto pixel = projector.Project(cam_from_world * spot.point);
    if (!pixel || !projector.camera().Contains(*pixel, 2)) return std::nullopt;
    return GreyAt(image, *pixel);
  };
  for (const Marker& marker : markers_) {
    double white = 0, black = 0;
    int whites = 0, blacks = 0;
    bool seen = true;
    for (const Spot& spot : marker.border) {
      const auto value = grey(spot);
      if (!(seen = value.has_value())) break;
      (spot.white ? white : black) += *value;
      (spot.white ? whites : blacks) += 1;
    }
    if (!seen) continue;
    const double contrast = white / whites - black / blacks;
    const double middle = 0.5 * (white / whites + black / blacks);
    int wrong = 0;
    for (const Spot& spot : marker.bits) {
      const auto value = grey(spot);
      wrong += value && (*value > middle) == spot.white ? 0 : 1;
    }
    const bool good = contrast >= kMinMarkerContrast && wrong <= marker.max_wrong;
    (good ? check.read : check.different) += 1;
  }
  return check;
}

}  // namespace livemvs
