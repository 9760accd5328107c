// The scene bench: a desk with things on it that no other scene has. It is kept for measuring what
// was tuned on the others.

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "livemvs/synth/scene_builders.h"

namespace livemvs::synth {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

Material Cover(const char* name, std::uint32_t cloth, std::uint32_t ink, float letter) {
  return {.name = name,
          .texture = Texture::kText,
          .base = FromSrgb(cloth),
          .accent = FromSrgb(ink),
          .scale = letter,
          .contrast = 0.3f};
}

const Material& Pages() {
  static const Material pages{.name = "pages",
                              .texture = Texture::kBrushed,
                              .base = FromSrgb(0xE4DCC4),
                              .second = FromSrgb(0x9C927C),
                              .scale = 0.0012f,
                              .contrast = 0.5f};
  return pages;
}

// A book that lies on its back at height z, its spine towards -y.
void AddBook(SceneWriter& writer, const Material& cover, const Vector3f& size, float z) {
  constexpr float kBoard = 0.0022f;
  const float x = size.x() / 2, y = size.y() / 2, top = z + size.z();
  writer.Use(cover);
  writer->AddBox({-x, -y, z}, {x, y, z + kBoard});
  writer->AddBox({-x, -y, top - kBoard}, {x, y, top});
  writer->AddBox({-x, -y, z + kBoard}, {x, -y + kBoard, top - kBoard});
  writer.Use(Pages());
  writer->AddBox({-x + 0.003f, -y + kBoard, z + kBoard}, {x - 0.003f, y - 0.004f, top - kBoard});
}

void AddBooks(SceneWriter& writer) {
  writer.Place(-0.135, 0.085, 0, 8);
  AddBook(writer, Cover("green book", 0x3F5B45, 0xD9CFA6, 0.011f), {0.165f, 0.115f, 0.03f}, 0.f);
  writer.Place(-0.13, 0.082, 0, -9);
  AddBook(writer, Cover("red book", 0x86403A, 0xE8DCC8, 0.008f), {0.145f, 0.1f, 0.022f}, 0.03f);
  writer.Place(-0.142, 0.09, 0, 21);
  AddBook(writer, Cover("white book", 0xC9C4B6, 0x22303F, 0.005f), {0.12f, 0.08f, 0.016f}, 0.052f);
}

void AddMug(SceneWriter& writer) {
  writer.Place(0.02, 0.02, 0, -60);
  writer.Use({.name = "mug",
              .texture = Texture::kDots,
              .base = FromSrgb(0xC9CFCB),
              .second = FromSrgb(0x3A5A78),
              .accent = FromSrgb(0x7A6A52),
              .scale = 0.012f,
              .contrast = 0.2f,
              .gloss = 0.04f});
  writer->AddRevolution({{0.f, 0.f},
                         {0.03f, 0.f},
                         {0.034f, 0.006f},
                         {0.036f, 0.04f},
                         {0.037f, 0.085f},
                         {0.0355f, 0.087f},
                         {0.034f, 0.085f},
                         {0.033f, 0.04f},
                         {0.03f, 0.008f},
                         {0.f, 0.006f}},
                        96,
                        90);
  writer->AddSurface(
      [](float u, float v) {
        const float around = kTwoPi * (u - std::floor(u));
        const float along = std::numbers::pi_v<float> * (v - 0.5f);
        const float out = 0.02f + 0.0055f * std::cos(around);
        return Vector3f(0.0345f + 1.1f * out * std::cos(along),
                        0.006f * std::sin(around),
                        0.046f + 1.25f * out * std::sin(along));
      },
      32,
      48);
}

// A six-sided cup of board, open at the top, and pencils that lean in it.
void AddPencilCup(SceneWriter& writer) {
  constexpr float kOuter = 0.036f, kInner = 0.033f, kHeight = 0.085f;
  writer.Place(0.12, 0.1, 0, 14);
  writer.Use(Cover("pencil cup", 0xB9986A, 0x3A2C22, 0.006f));
  const auto corner = [](float radius, int i, float z) {
    const float angle = kTwoPi * static_cast<float>(i) / 6.f;
    return Vector3f(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  for (int i = 0; i < 6; ++i) {
    const auto outer = [&](int k, float z) { return corner(kOuter, i + k, z); };
    const auto inner = [&](int k, float z) { return corner(kInner, i + k, z); };
    writer->AddQuad(outer(0, 0.f), outer(1, 0.f), outer(1, kHeight), outer(0, kHeight));
    writer->AddQuad(inner(1, 0.f), inner(0, 0.f), inner(0, kHeight), inner(1, kHeight));
    writer->AddQuad(outer(0, kHeight), outer(1, kHeight), inner(1, kHeight), inner(0, kHeight));
    writer->AddTriangle(Vector3f(0, 0, 0.002f), inner(0, 0.002f), inner(1, 0.002f));
  }
  constexpr std::array<std::uint32_t, 5> kPaint = {
      0xC2A23A, 0x9C3B2E, 0x2F5D7C, 0x4C7A4A, 0x3A3A3E};
  for (int i = 0; i < 5; ++i) {
    const double azimuth = 1.1 + 1.27 * i, lean = 0.16 + 0.02 * i;
    const Vector3d axis(-std::sin(azimuth), std::cos(azimuth), 0);
    const Vector3d foot =
        Vector3d(0.12, 0.1, 0.006) - 0.012 * Vector3d(std::cos(azimuth), std::sin(azimuth), 0);
    writer->Place({Eigen::AngleAxisd(lean, axis).toRotationMatrix(), foot});
    writer.Use({.name = "pencil",
                .texture = Texture::kBrushed,
                .base = FromSrgb(kPaint[i]),
                .second = FromSrgb(0xD9C6A0),
                .scale = 0.006f,
                .contrast = 0.25f});
    writer->AddCylinder(0.0036f, 0.f, 0.135f + 0.008f * static_cast<float>(i % 3), 24);
  }
}

void AddBowlOfFruit(SceneWriter& writer) {
  writer.Place(-0.07, -0.085, 0, 0);
  writer.Use({.name = "bowl",
              .texture = Texture::kClouds,
              .base = FromSrgb(0x4F6F6A),
              .second = FromSrgb(0x9DB3A2),
              .scale = 0.014f,
              .contrast = 0.6f});
  writer->AddRevolution({{0.f, 0.f},
                         {0.026f, 0.f},
                         {0.032f, 0.008f},
                         {0.052f, 0.022f},
                         {0.062f, 0.04f},
                         {0.061f, 0.042f},
                         {0.059f, 0.04f},
                         {0.048f, 0.024f},
                         {0.026f, 0.011f},
                         {0.f, 0.009f}},
                        96,
                        90);
  const Material peel{.name = "orange",
                      .texture = Texture::kDots,
                      .base = FromSrgb(0xC9762C),
                      .second = FromSrgb(0x9E5217),
                      .accent = FromSrgb(0xE0A04E),
                      .scale = 0.005f,
                      .contrast = 0.35f};
  writer.Use(peel);
  writer->AddEllipsoid({-0.024f, -0.004f, 0.04f}, {0.028f, 0.028f, 0.026f}, 96);
  writer->AddEllipsoid({0.022f, -0.022f, 0.037f}, {0.025f, 0.025f, 0.024f}, 96);
  writer.Place(-0.055, -0.065, 0.02, 0);
  writer.Use({.name = "pear",
              .texture = Texture::kDots,
              .base = FromSrgb(0x9EA04A),
              .second = FromSrgb(0x6B5A2A),
              .accent = FromSrgb(0x7E7A34),
              .scale = 0.007f,
              .contrast = 0.5f});
  writer->AddRevolution({{0.f, 0.f},
                         {0.016f, 0.002f},
                         {0.025f, 0.018f},
                         {0.022f, 0.034f},
                         {0.012f, 0.05f},
                         {0.008f, 0.06f},
                         {0.f, 0.064f}},
                        72,
                        60);
}

// A plant: a pot, earth, and leaves that lean outwards.
void AddPlant(SceneWriter& writer) {
  const Vector3d at(0.19, 0.0, 0);
  writer.Place(at.x(), at.y(), 0, 0);
  writer.Use({.name = "pot",
              .texture = Texture::kClouds,
              .base = FromSrgb(0x9A5F42),
              .second = FromSrgb(0xB98A6C),
              .scale = 0.01f,
              .contrast = 0.6f});
  writer->AddRevolution({{0.f, 0.f},
                         {0.021f, 0.f},
                         {0.023f, 0.003f},
                         {0.031f, 0.048f},
                         {0.034f, 0.05f},
                         {0.034f, 0.06f},
                         {0.03f, 0.06f},
                         {0.028f, 0.05f},
                         {0.f, 0.048f}},
                        72,
                        72);
  for (int i = 0; i < 15; ++i) {
    const double azimuth = 2.4 * i, lean = 0.2 + 0.065 * i;
    const Vector3d axis(-std::sin(azimuth), std::cos(azimuth), 0);
    const Eigen::Matrix3d tilt =
        (Eigen::AngleAxisd(lean, axis) * Eigen::AngleAxisd(azimuth, Vector3d::UnitZ()))
            .toRotationMatrix();
    writer->Place({tilt, at + Vector3d(0, 0, 0.048)});
    writer.Use({.name = "leaf",
                .texture = Texture::kBrushed,
                .base = FromSrgb(0x3C6132),
                .second = FromSrgb(0x8FAE62),
                .scale = 0.004f,
                .contrast = 0.4f});
    writer->AddEllipsoid({0.f, 0.f, 0.034f}, {0.0012f, 0.0085f, 0.034f}, 48);
  }
}

// A calendar like a tent, a roll of tape and a tin with ribs.
void AddSmallThings(SceneWriter& writer) {
  writer.Place(0.1, -0.085, 0, 24);
  writer.Use(Cover("calendar", 0xD6D0C2, 0x2A3A55, 0.0065f));
  writer->AddGable({-0.05f, -0.024f, 0.f}, {0.05f, 0.024f, 0.062f});

  writer.Place(0.015, -0.115, 0, 0);
  writer.Use({.name = "tape",
              .texture = Texture::kBrushed,
              .base = FromSrgb(0xC8B27A),
              .second = FromSrgb(0x6E5A32),
              .scale = 0.0016f,
              .contrast = 0.5f});
  writer->AddSurface(
      [](float u, float v) {
        // Round the section, a rectangle with rounded corners.
        const auto bulge = [](float x) { return std::copysign(std::pow(std::abs(x), 0.25f), x); };
        const float around = kTwoPi * (u - std::floor(u));
        const float section = kTwoPi * (v - std::floor(v));
        const float radius = 0.0265f + 0.0075f * bulge(std::cos(section));
        return Vector3f(radius * std::cos(around),
                        radius * std::sin(around),
                        0.01f + 0.01f * bulge(std::sin(section)));
      },
      96,
      96);

  writer.Place(-0.195, -0.03, 0, 0);
  writer.Use({.name = "tin",
              .texture = Texture::kBrushed,
              .base = FromSrgb(0x8E9296),
              .second = FromSrgb(0x55595E),
              .scale = 0.003f,
              .contrast = 0.45f,
              .gloss = 0.1f});
  writer->AddSurface(
      [](float u, float v) {
        const float around = kTwoPi * (u - std::floor(u));
        const float radius = 0.027f + 0.0008f * std::sin(14.f * kTwoPi * v);
        return Vector3f(radius * std::cos(around), radius * std::sin(around), 0.08f * v);
      },
      96,
      120);
  writer->AddCylinder(0.0279f, 0.0775f, 0.0802f, 96);
}

}  // namespace

void DescribeBench(SceneWriter& writer, SceneDescription* scene) {
  scene->box = {{-0.24, -0.17, -0.005}, {0.24, 0.17, 0.17}};
  scene->lamp = {0.5f, -0.35f, 0.7f};
  scene->lamp_radius = 0.08f;
  scene->lamp_power = 1.05f;
  scene->sky_power = 0.3f;
  writer.Place(0, 0, 0, 0);
  writer.Use({.name = "desk",
              .texture = Texture::kDots,
              .base = FromSrgb(0x8C8478),
              .second = FromSrgb(0xB8AE9C),
              .accent = FromSrgb(0x5A5248),
              .scale = 0.016f,
              .contrast = 0.5f});
  writer->AddBox({-0.55f, -0.45f, -0.035f}, {0.55f, 0.45f, -0.003f});
  writer.Use({.name = "mat",
              .texture = Texture::kWeave,
              .base = FromSrgb(0x8A7F6C),
              .second = FromSrgb(0x4E5E72),
              .accent = FromSrgb(0xB9A98C),
              .scale = 0.0032f,
              .contrast = 0.5f,
              .repetitive = true});
  writer->AddBox({-0.24f, -0.17f, -0.003f}, {0.24f, 0.17f, 0.f});
  AddBooks(writer);
  AddMug(writer);
  AddPencilCup(writer);
  AddBowlOfFruit(writer);
  AddPlant(writer);
  AddSmallThings(writer);
}

}  // namespace livemvs::synth
