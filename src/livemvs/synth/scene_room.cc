// A room of 5 x 4 m with table, shelves, crates and a carpet, to walk in.

#include <Eigen/Geometry>
#include <array>

#include "livemvs/synth/random.h"
#include "livemvs/synth/scene_builders.h"

namespace livemvs::synth {
namespace {

using Eigen::Vector3f;

constexpr float kHalfX = 2.5f, kHalfY = 2.f, kHeight = 2.5f;

void AddShell(SceneWriter& writer) {
  writer.Use({.name = "floor",
              .texture = Texture::kParquet,
              .base = FromSrgb(0xB98A58),
              .second = FromSrgb(0x8A5E37),
              .accent = FromSrgb(0x3E2615),
              .scale = 0.035f,
              .contrast = 0.5f});
  writer->AddQuad(
      {-kHalfX, -kHalfY, 0}, {kHalfX, -kHalfY, 0}, {kHalfX, kHalfY, 0}, {-kHalfX, kHalfY, 0});
  writer.Use({.name = "wallpaper",
              .texture = Texture::kClouds,
              .base = FromSrgb(0x9FA79A),
              .second = FromSrgb(0xC9C7B2),
              .scale = 0.12f,
              .contrast = 0.25f});
  const std::array<Vector3f, 4> corners = {Vector3f(-kHalfX, -kHalfY, 0),
                                           Vector3f(kHalfX, -kHalfY, 0),
                                           Vector3f(kHalfX, kHalfY, 0),
                                           Vector3f(-kHalfX, kHalfY, 0)};
  const Vector3f up(0, 0, kHeight);
  for (int i = 0; i < 3; ++i) {
    writer->AddQuad(corners[i + 1], corners[i], corners[i] + up, corners[i + 1] + up);
  }
  writer.Use({.name = "brick wall",
              .texture = Texture::kBrick,
              .base = FromSrgb(0x9C5A44),
              .second = FromSrgb(0xBF8F74),
              .accent = FromSrgb(0xC9C2B4),
              .scale = 0.075f,
              .contrast = 0.4f,
              .repetitive = true});
  writer->AddQuad(corners[0], corners[3], corners[3] + up, corners[0] + up);
  writer.Use({.name = "ceiling", .base = FromSrgb(0xD9D8D4), .textureless = true});
  writer->AddQuad(corners[0] + up, corners[3] + up, corners[2] + up, corners[1] + up);
}

// A shelf against the wall y = kHalfY, with books.
void AddShelf(SceneWriter& writer, Random& random, double x) {
  const float width = 1.2f, depth = 0.3f, board = 0.025f;
  writer.Place(x, kHalfY - depth, 0, 0);
  writer.Use({.name = "shelf",
              .texture = Texture::kWood,
              .base = FromSrgb(0xA9835A),
              .second = FromSrgb(0x7A5735),
              .accent = FromSrgb(0x3B2413),
              .scale = 0.04f,
              .contrast = 0.5f});
  for (const float side : {0.f, width - board}) {
    writer->AddBox({side, 0, 0}, {side + board, depth, 1.9f});
  }
  for (int i = 0; i < 5; ++i) {
    const float z = 0.08f + 0.45f * static_cast<float>(i);
    writer->AddBox({board, 0.01f, z}, {width - board, depth, z + board});
  }
  for (int color = 0; color < 4; ++color) {
    constexpr std::array<std::uint32_t, 4> kCovers = {0x7C2F2A, 0x2E4A66, 0x47603A, 0xC2A878};
    writer.Use({.name = "books",
                .texture = Texture::kPrint,
                .base = FromSrgb(kCovers[color]),
                .second = FromSrgb(kCovers[(color + 1) % 4]),
                .accent = FromSrgb(0xE5DCC3),
                .scale = 0.03f,
                .contrast = 0.4f});
    for (int row = 0; row < 4; ++row) {
      const float z = 0.08f + board + 0.45f * static_cast<float>(row);
      float at = board + 0.02f + 0.27f * static_cast<float>((color + row) % 4);
      const float end = at + 0.24f;
      while (at < end) {
        const float thick = static_cast<float>(random.Uniform(0.02, 0.05));
        const float tall = static_cast<float>(random.Uniform(0.2, 0.34));
        const float back = static_cast<float>(random.Uniform(0.03, 0.08));
        writer->AddBox({at, back, z}, {at + thick, depth - 0.02f, z + tall});
        at += thick + 0.001f;
      }
    }
  }
}

void AddTable(SceneWriter& writer) {
  writer.Place(0.5, -0.5, 0, 18);
  writer.Use({.name = "table",
              .texture = Texture::kWood,
              .base = FromSrgb(0x8F5F3A),
              .second = FromSrgb(0x6A4226),
              .accent = FromSrgb(0x2D1A0E),
              .scale = 0.05f,
              .contrast = 0.55f});
  writer->AddBox({-0.7f, -0.4f, 0.71f}, {0.7f, 0.4f, 0.75f});
  for (const float x : {-0.65f, 0.58f}) {
    for (const float y : {-0.36f, 0.29f}) writer->AddBox({x, y, 0}, {x + 0.07f, y + 0.07f, 0.71f});
  }
  writer.Use({.name = "jar",
              .texture = Texture::kGlaze,
              .base = FromSrgb(0xC9B78F),
              .second = FromSrgb(0x45708B),
              .accent = FromSrgb(0x5B3725),
              .scale = 0.08f,
              .contrast = 0.4f});
  writer.Place(0.35, -0.45, 0.75, 0);
  writer->AddRevolution(
      {{0.06f, 0}, {0.11f, 0.08f}, {0.1f, 0.2f}, {0.05f, 0.28f}, {0.07f, 0.32f}}, 64, 48);
  writer.Use({.name = "ball",
              .texture = Texture::kMarble,
              .base = FromSrgb(0x8A6E5A),
              .second = FromSrgb(0xC0A68C),
              .accent = FromSrgb(0xEDE3D2),
              .scale = 0.06f,
              .contrast = 0.45f});
  writer->AddEllipsoid({0.4f, -0.05f, 0.1f}, {0.1f, 0.1f, 0.1f}, 64);
}

void AddCrates(SceneWriter& writer) {
  writer.Use({.name = "crates",
              .texture = Texture::kParquet,
              .base = FromSrgb(0xC8A46F),
              .second = FromSrgb(0x9A7445),
              .accent = FromSrgb(0x54381D),
              .scale = 0.02f,
              .contrast = 0.5f});
  writer.Place(-1.7, 0.9, 0, 25);
  writer->AddBox({-0.3f, -0.25f, 0}, {0.3f, 0.25f, 0.45f});
  writer.Place(-1.75, 0.95, 0.45, -12);
  writer->AddBox({-0.2f, -0.2f, 0}, {0.2f, 0.2f, 0.35f});
  writer.Use({.name = "carton",
              .texture = Texture::kPrint,
              .base = FromSrgb(0xB58E5C),
              .second = FromSrgb(0xA57F50),
              .accent = FromSrgb(0x4A3A28),
              .scale = 0.08f,
              .contrast = 0.5f});
  writer.Place(1.9, -1.4, 0, 40);
  writer->AddBox({-0.25f, -0.25f, 0}, {0.25f, 0.25f, 0.5f});
  writer.Place(-1.6, -1.3, 0, 10);
  writer->AddBox({-0.3f, -0.2f, 0}, {0.3f, 0.2f, 0.3f});
  writer.Use({.name = "column", .base = FromSrgb(0xC9CED2), .textureless = true});
  writer.Place(-0.6, -1.5, 0, 0);
  writer->AddCylinder(0.15f, 0, 0.9f, 96);
}

}  // namespace

void DescribeRoom(SceneWriter& writer, SceneDescription* scene) {
  scene->box = {{-kHalfX, -kHalfY, 0}, {kHalfX, kHalfY, kHeight}};
  scene->lamp = {-0.3f, 0.2f, 2.4f};
  scene->lamp_radius = 0.35f;
  scene->lamp_power = 0.65f;
  scene->sky_power = 0.55f;
  scene->sky_distance = 0.6f;
  scene->light_spacing = 0.03f;
  Random random(1871);
  AddShell(writer);
  AddShelf(writer, random, -0.9);
  AddShelf(writer, random, 0.6);
  AddTable(writer);
  AddCrates(writer);
  writer.Place(0, 0, 0, -8);
  writer.Use({.name = "carpet",
              .texture = Texture::kPrint,
              .base = FromSrgb(0x7A2E2C),
              .second = FromSrgb(0xB88A4E),
              .accent = FromSrgb(0x2C3550),
              .scale = 0.15f,
              .contrast = 0.6f});
  writer->AddBox({-1.0f, -0.9f, 0}, {1.3f, 0.9f, 0.012f});
}

}  // namespace livemvs::synth
