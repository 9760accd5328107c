#include "livemvs/core/epipolar.h"

#include <cmath>

namespace livemvs {

template <typename T>
RelativeView<T> MakeRelativeView(const Camera& ref,
                                 const Rigid3d& ref_from_world,
                                 const Camera& cur,
                                 const CameraParams<T>& cur_params,
                                 const Rigid3d& cur_from_world) {
  const Rigid3d cur_from_ref = cur_from_world * ref_from_world.Inverse();
  RelativeView<T> view;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) view.r[3 * i + j] = static_cast<T>(cur_from_ref.rotation(i, j));
    view.t[i] = static_cast<T>(cur_from_ref.translation[i]);
  }
  view.camera = cur_params;
  view.width = static_cast<T>(cur.width);
  view.height = static_cast<T>(cur.height);
  // The rotation nearest to the upper left 2 x 2 block turns the picture about the optical axis. A
  // negative fy mirrors both pictures alike, and with them the sense of the rotation.
  const double mirror = cur.fy < 0 ? -1 : 1;
  const double c = cur_from_ref.rotation(0, 0) + cur_from_ref.rotation(1, 1);
  const double s = (cur_from_ref.rotation(1, 0) - cur_from_ref.rotation(0, 1)) * mirror;
  const double norm = std::hypot(c, s);
  view.roll_cos = static_cast<T>(norm > 1e-9 ? c / norm : 1);
  view.roll_sin = static_cast<T>(norm > 1e-9 ? s / norm : 0);
  view.focal_ratio =
      static_cast<T>(std::sqrt(std::abs(cur.fx * cur.fy)) / std::sqrt(std::abs(ref.fx * ref.fy)));
  return view;
}

template RelativeView<float> MakeRelativeView(
    const Camera&, const Rigid3d&, const Camera&, const CameraParams<float>&, const Rigid3d&);
template RelativeView<double> MakeRelativeView(
    const Camera&, const Rigid3d&, const Camera&, const CameraParams<double>&, const Rigid3d&);

}  // namespace livemvs
