// The scenes table, sheet, board, house and plane.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "livemvs/synth/noise.h"
#include "livemvs/synth/printed_sheet.h"
#include "livemvs/synth/scene_builders.h"

namespace livemvs::synth {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// A ring whose thickness varies.
void AddRing(SceneWriter& writer, float ring_radius, float tube_radius) {
  writer->AddSurface(
      [=](float u, float v) {
        const float around = kTwoPi * (u - std::floor(u));
        const float tube = kTwoPi * (v - std::floor(v));
        const float r = tube_radius * (1.f + 0.07f * std::sin(7.f * around) * std::sin(3.f * tube));
        const float out = ring_radius + r * std::cos(tube);
        return Vector3f(out * std::cos(around),
                        out * std::sin(around),
                        1.05f * tube_radius + r * std::sin(tube));
      },
      128,
      48);
}

// A pebble: a ball with dents.
void AddPebble(SceneWriter& writer, float radius) {
  writer->AddSurface(
      [=](float u, float v) {
        const float longitude = kTwoPi * (u - std::floor(u));
        const float latitude = (v - 0.5f) * 0.5f * kTwoPi;
        const Vector3f unit(std::cos(latitude) * std::cos(longitude),
                            std::cos(latitude) * std::sin(longitude),
                            std::sin(latitude));
        const float r = radius * (1.f + 0.35f * GradientNoise(1.6f * unit + Vector3f(3, 1, 4)));
        return Vector3f(unit.x() * 1.25f * r, unit.y() * r, 0.75f * radius + 0.8f * r * unit.z());
      },
      96,
      48);
}

}  // namespace

Material WoodMaterial(const char* name, float scale) {
  return {.name = name,
          .texture = Texture::kWood,
          .base = FromSrgb(0xB08B66),
          .second = FromSrgb(0x80603F),
          .accent = FromSrgb(0x4A2E1A),
          .scale = scale,
          .contrast = 0.5f};
}

Material SheetMaterial() {
  return {.name = "sheet",
          .texture = Texture::kTerrazzo,
          .base = FromSrgb(0xB9B2A4),
          .second = FromSrgb(0x6F4E3E),
          .accent = FromSrgb(0x4F6670),
          .scale = 0.009f,
          .contrast = 0.55f};
}

void AddTableTop(SceneWriter& writer, float length, float width, float z) {
  Material planks = WoodMaterial("table", 0.028f);
  planks.texture = Texture::kParquet;
  planks.contrast = 0.45f;
  writer.Place(0, 0, 0, 0);
  writer.Use(planks);
  writer->AddBox({-length / 2, -width / 2, z - 0.03f}, {length / 2, width / 2, z});
}

void AddHouse(SceneWriter& writer, const Vector3f& size) {
  const float x = size.x() / 2, y = size.y() / 2, z = size.z();
  const float roof = 0.75f * y;        // height of the ridge above the walls
  const float eave = 0.18f * y;        // how far the roof stands out
  const float drop = eave * roof / y;  // and hangs down
  writer.Use({.name = "house walls",
              .texture = Texture::kBrick,
              .base = FromSrgb(0xA8553A),
              .second = FromSrgb(0xC98D66),
              .accent = FromSrgb(0xD9D2C3),
              .scale = 0.09f * z,
              .contrast = 0.45f,
              .repetitive = true});
  writer->AddBox({-x, -y, 0}, {x, y, z});
  writer->AddGable({-x, -y, z}, {x, y, z + roof});
  writer->AddBox({0.35f * x, 0.2f * y, z}, {0.6f * x, 0.5f * y, z + 1.15f * roof});
  writer.Use({.name = "house roof",
              .texture = Texture::kTiles,
              .base = FromSrgb(0x59616E),
              .second = FromSrgb(0x8C8F94),
              .scale = 0.14f * z,
              .contrast = 0.4f,
              .repetitive = true});
  const float lift = 0.03f * z, over = 0.08f * x;
  writer->AddGable({-x - over, -y - eave, z - drop + lift}, {x + over, y + eave, z + roof + lift});
  writer.Use(WoodMaterial("house woodwork", 0.08f * z));
  const float out = 0.012f * z;
  writer->AddBox({-0.16f * x, -y - out, 0}, {0.2f * x, -y, 0.58f * z});
  for (const float side : {-1.f, 1.f}) {
    writer->AddBox({(0.6f + 0.02f * side) * x * side - 0.15f * x, -y - out, 0.38f * z},
                   {(0.6f + 0.02f * side) * x * side + 0.15f * x, -y, 0.72f * z});
    const Vector3f low(side > 0 ? x : -x - out, -0.25f * y, 0.35f * z);
    writer->AddBox(low, low + Vector3f(out, 0.5f * y, 0.36f * z));
  }
}

// The smaller half of the still life.
void AddSmallerHalf(SceneWriter& writer) {
  writer.Place(-0.012, -0.028, 0, 30);
  writer.Use({.name = "ball",
              .texture = Texture::kMarble,
              .base = FromSrgb(0x7E9A7C),
              .second = FromSrgb(0xB9C7A4),
              .accent = FromSrgb(0xE9E4D2),
              .scale = 0.03f,
              .contrast = 0.45f});
  writer->AddEllipsoid({0.f, 0.f, 0.034f}, {0.034f, 0.034f, 0.034f}, 96);

  writer.Place(0.105, -0.065, 0, 0);
  writer.Use({.name = "ring",
              .texture = Texture::kStone,
              .base = FromSrgb(0xC98F52),
              .second = FromSrgb(0xE3C08C),
              .accent = FromSrgb(0x6B4423),
              .scale = 0.02f,
              .contrast = 0.5f});
  AddRing(writer, 0.036f, 0.016f);

  writer.Place(-0.118, -0.062, 0, 0);
  writer.Use({.name = "plain cylinder",
              .texture = Texture::kPlain,
              .base = FromSrgb(0xB8C4CC),
              .textureless = true});
  writer->AddCylinder(0.027f, 0.f, 0.075f, 128);

  writer.Place(0.02, -0.108, 0, 20);
  writer.Use({.name = "pebble",
              .texture = Texture::kStone,
              .base = FromSrgb(0x7B7F86),
              .second = FromSrgb(0xA9A59C),
              .accent = FromSrgb(0x3B3D42),
              .scale = 0.016f,
              .contrast = 0.5f});
  AddPebble(writer, 0.021f);
}

void AddStillLife(SceneWriter& writer) {
  writer.Place(-0.115, 0.055, 0, -14);
  AddHouse(writer, {0.105f, 0.08f, 0.062f});

  writer.Place(0.02, 0.082, 0, 0);
  writer.Use({.name = "vase",
              .texture = Texture::kGlaze,
              .base = FromSrgb(0xC8B48E),
              .second = FromSrgb(0x3E6A86),
              .accent = FromSrgb(0x5A3423),
              .scale = 0.032f,
              .contrast = 0.35f});
  writer->AddRevolution({{0.021f, 0.f},
                         {0.031f, 0.02f},
                         {0.041f, 0.05f},
                         {0.038f, 0.085f},
                         {0.022f, 0.115f},
                         {0.016f, 0.135f},
                         {0.019f, 0.15f},
                         {0.025f, 0.16f},
                         {0.022f, 0.159f},
                         {0.014f, 0.14f},
                         {0.f, 0.12f}},
                        96,
                        120);

  writer.Place(0.132, 0.06, 0, -28);
  writer.Use({.name = "box",
              .texture = Texture::kPrint,
              .base = FromSrgb(0xD8C9A2),
              .second = FromSrgb(0xB5563C),
              .accent = FromSrgb(0x36474F),
              .scale = 0.03f,
              .contrast = 0.35f});
  writer->AddBox({-0.036f, -0.026f, 0.f}, {0.036f, 0.026f, 0.098f});

  AddSmallerHalf(writer);
}

void DescribeTable(SceneWriter& writer, SceneDescription* scene) {
  scene->box = {{-0.21, -0.15, -0.005}, {0.21, 0.15, 0.2}};
  AddTableTop(writer, 1.0f, 0.8f, -0.004f);
  writer.Use(SheetMaterial());
  writer->AddBox({-0.21f, -0.15f, -0.004f}, {0.21f, 0.15f, 0.f});
  AddStillLife(writer);
}

void DescribeSheet(SceneWriter& writer, SceneDescription* scene) {
  const double x = 0.5 * scene->sheet->width(), y = 0.5 * scene->sheet->height();
  constexpr double kWhite = 0.012;  // around what is printed [m]
  scene->box = {{-x, -y, -0.005}, {x, y, 0.2}};
  AddTableTop(writer, 1.0f, 0.8f, -0.004f);
  writer.Use({.name = "paper",
              .texture = Texture::kPlain,
              .base = FromSrgb(0xF2F0EA),
              .textureless = true});
  const auto out_x = static_cast<float>(x + kWhite), out_y = static_cast<float>(y + kWhite);
  writer->AddBox({-out_x, -out_y, -0.004f}, {out_x, out_y, -0.0001f});
  writer.Use({.name = "print",
              .texture = Texture::kPrinted,
              .base = FromSrgb(0xF2F0EA),
              .second = FromSrgb(0x22211F),
              .printed = scene->sheet});
  const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
  writer->AddQuad({-fx, -fy, 0}, {fx, -fy, 0}, {fx, fy, 0}, {-fx, fy, 0});
}

void DescribeBoard(SceneWriter& writer, SceneDescription* scene) {
  DescribeSheet(writer, scene);
  AddStillLife(writer);
}

void DescribeHouse(SceneWriter& writer, SceneDescription* scene) {
  scene->box = {{-0.2, -0.2, -0.005}, {0.2, 0.2, 0.26}};
  AddTableTop(writer, 1.0f, 1.0f, -0.012f);
  writer.Use({.name = "garden",
              .texture = Texture::kClouds,
              .base = FromSrgb(0x4E6B2E),
              .second = FromSrgb(0x93A05A),
              .scale = 0.03f,
              .contrast = 0.7f});
  writer->AddBox({-0.2f, -0.2f, -0.012f}, {0.2f, 0.2f, 0.f});
  writer.Use({.name = "path",
              .texture = Texture::kTerrazzo,
              .base = FromSrgb(0x9A958A),
              .second = FromSrgb(0x70685C),
              .accent = FromSrgb(0xB8B2A0),
              .scale = 0.016f,
              .contrast = 0.45f});
  writer->AddBox({-0.02f, -0.2f, 0.f}, {0.024f, -0.08f, 0.002f});
  writer.Place(0, 0, 0, 0);
  AddHouse(writer, {0.22f, 0.16f, 0.12f});

  const Material bark = WoodMaterial("bark", 0.008f);
  const Material leaves = {.name = "leaves",
                           .texture = Texture::kClouds,
                           .base = FromSrgb(0x2F5427),
                           .second = FromSrgb(0x7FA045),
                           .scale = 0.012f,
                           .contrast = 0.8f};
  for (const Vector2f& at : {Vector2f(-0.15f, -0.14f), Vector2f(0.15f, -0.12f)}) {
    writer.Place(at.x(), at.y(), 0, 40 * at.x());
    writer.Use(bark);
    writer->AddCylinder(0.009f, 0.f, 0.05f, 32);
    writer.Place(at.x(), at.y(), 0.055, 100 * at.x());
    writer.Use(leaves);
    AddPebble(writer, 0.034f);
  }
  writer.Place(0, 0, 0, 0);
  writer.Use(WoodMaterial("fence", 0.006f));
  for (int i = 0; i < 24; ++i) {
    const float x = -0.186f + 0.016f * static_cast<float>(i);
    writer->AddBox({x, 0.182f, 0.f}, {x + 0.009f, 0.187f, 0.045f});
  }
  writer->AddBox({-0.19f, 0.187f, 0.02f}, {0.19f, 0.191f, 0.027f});
}

void DescribePlane(SceneWriter& writer, SceneDescription* scene) {
  scene->box = {{-1, -1, -0.01}, {1, 1, 0.01}};
  scene->light_spacing = 0.05f;
  writer.Use({.name = "plane",
              .texture = Texture::kClouds,
              .base = FromSrgb(0x6B5B4A),
              .second = FromSrgb(0xCFC3AE),
              .scale = 0.05f,
              .contrast = 0.8f});
  writer->AddQuad({-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0});
}

}  // namespace livemvs::synth
