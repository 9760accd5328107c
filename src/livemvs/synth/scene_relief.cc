// The front of a small temple, carved in sandstone.

#include <algorithm>
#include <cmath>

#include "livemvs/synth/noise.h"
#include "livemvs/synth/scene_builders.h"

namespace livemvs::synth {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

}  // namespace

void DescribeRelief(SceneWriter& writer, SceneDescription* scene) {
  scene->box = {{-0.16, -0.075, -0.005}, {0.16, 0.075, 0.235}};
  AddTableTop(writer, 1.2f, 1.2f, 0.f);
  const Material stone = {.name = "sandstone",
                          .texture = Texture::kStone,
                          .base = FromSrgb(0xB9A27C),
                          .second = FromSrgb(0xD9C9A8),
                          .accent = FromSrgb(0x7A6547),
                          .scale = 0.02f,
                          .contrast = 0.4f};
  writer.Use(stone);
  for (int i = 0; i < 3; ++i) {
    const float step = 0.008f * static_cast<float>(i);
    writer->AddBox({-0.155f + step, -0.07f + 1.6f * step, step},
                   {0.155f - step, 0.07f, step + 0.008f});
  }
  writer->AddBox({-0.13f, 0.02f, 0.024f}, {0.13f, 0.066f, 0.16f});
  // The carved front of the back wall: medallions and rough stone.
  writer->AddSurface(
      [](float u, float v) {
        const float x = -0.13f + 0.26f * u, z = 0.024f + 0.136f * v;
        const float cell = (x + 0.13f) / 0.052f;
        const Vector2f from_center((cell - std::floor(cell) - 0.5f) * 0.052f, z - 0.095f);
        const float r = from_center.norm();
        const float medallion = 0.007f * (1.f - SmoothStep(0.014f, 0.021f, r)) +
                                0.005f * (1.f - SmoothStep(0.002f, 0.008f, std::abs(r - 0.010f)));
        const float rough = 0.004f * FractalNoise(Vector3f(x, 1.f, z), 0.03f, 0.6f, 0.002f);
        // At its borders the carving sinks into the wall, so that there is no gap behind it.
        const float to_border = std::min(0.13f - std::abs(x), 0.16f - z);
        const float carved = SmoothStep(0.f, 0.004f, to_border);
        return Vector3f(x, 0.0205f - carved * (0.0045f + medallion + rough), z);
      },
      208,
      108);
  writer->AddBox({-0.147f, -0.055f, 0.16f}, {0.147f, 0.068f, 0.178f});
  writer->AddBox({-0.15f, -0.058f, 0.178f}, {0.15f, 0.07f, 0.184f});
  // A gable across the front: AddGable's ridge runs along x, so turn it.
  writer.Place(0, 0.006, 0, 0);
  const Vector3f a(-0.15f, -0.062f, 0.184f), b(0.15f, -0.062f, 0.184f), c(0.f, -0.062f, 0.232f);
  const Vector3f depth(0.f, 0.124f, 0.f);
  writer->AddTriangle(a, b, c);
  writer->AddTriangle(b + depth, a + depth, c + depth);
  writer->AddQuad(b, b + depth, c + depth, c);
  writer->AddQuad(a + depth, a, c, c + depth);
  for (int i = 0; i < 6; ++i) {
    writer.Place(-0.125 + 0.05 * i, -0.03, 0, 13.0 * i);
    writer.Use(stone);
    writer->AddCylinder(0.0165f, 0.024f, 0.031f, 64);
    writer->AddSurface(
        [](float u, float v) {
          const float angle = kTwoPi * (u - std::floor(u));
          const float flutes = 0.0009f * std::cos(16.f * angle);
          const float r = 0.0135f - 0.002f * v + flutes;
          return Vector3f(r * std::cos(angle), r * std::sin(angle), 0.031f + 0.118f * v);
        },
        128,
        24);
    writer->AddRevolution({{0.0115f, 0.149f}, {0.0165f, 0.155f}, {0.018f, 0.16f}}, 64, 8);
  }
}

}  // namespace livemvs::synth
