#pragma once

#include <optional>
#include <string>

#include "livemvs/eval/canvas.h"
#include "livemvs/eval/splat.h"
#include "livemvs/eval/view.h"

namespace livemvs {

/// What the colours of a rendered cloud mean.
enum class RenderColor {
  kRgb,          ///< The points' own; grey where the cloud has none.
  kNormal,       ///< Right, up and towards the viewer as red, green and blue.
  kSigma,        ///< Standard deviation of the depth, logarithmic.
  kInlierRatio,  ///< 0 to 1.
  kHeight,       ///< Along `up`.
};

struct CloudRenderOptions {
  RenderColor color = RenderColor::kRgb;
  double point_size = 1;       ///< Multiple of the size that just closes the surface.
  int supersampling = 2;       ///< Samples per pixel each way, 1 to 4.
  bool scale_bar = true;       ///< Draws a bar of round length into the lower left corner.
  std::string unit;            ///< Name of the scene unit, for the labels; may be empty.
  bool plain_normals = false;  ///< Shade with the normals as they are; otherwise estimate them.

  /// @throws std::invalid_argument naming the field.
  void Check() const;
};

/// Draws a cloud as it is to look at: lit from the upper left, edges of depth darkened, on a light
/// background.
class CloudRenderer {
 public:
  /// Estimates normals and point sizes, which all pictures of the cloud share. The cloud may hold
  /// points that are not finite; they are not drawn.
  CloudRenderer(const PointCloud& cloud, const CloudRenderOptions& options);

  /// A picture of the cloud; RenderColor::kHeight goes along view.up.
  RgbImage Draw(const RenderView& view) const;

 private:
  PointCloud cloud_;
  std::vector<float> radius_;
  CloudRenderOptions options_;
};

/// Draws a mesh in the same light; without colours it is grey.
RgbImage RenderMesh(const TriangleMesh& mesh,
                    const RenderView& view,
                    const CloudRenderOptions& options);

/// Lights the fragments, darkens edges of depth and averages `scale` x `scale` of them per pixel.
/// @param focal_px    Of the fragments' camera. [px of a fragment]
/// @param true_color  Colours that already hold the light of the scene are shaded less.
RgbImage ShadeFragments(const FragmentImage& image, int scale, double focal_px, bool true_color);

}  // namespace livemvs
