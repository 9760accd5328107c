// The scene hazards: what misleads a depth filter, each thing with its label, on ordinary ground.

#include <Eigen/Geometry>

#include "livemvs/synth/scene_builders.h"

namespace livemvs::synth {
namespace {

Material Plain(const char* name, std::uint32_t srgb) {
  return {.name = name, .texture = Texture::kPlain, .base = FromSrgb(srgb), .textureless = true};
}

Material Striped(const char* name, float period) {
  return {.name = name,
          .texture = Texture::kStripes,
          .base = FromSrgb(0xD8D2C4),
          .second = FromSrgb(0x3C5468),
          .scale = period,
          .repetitive = true};
}

// Walls at the back, cards on the ground, a cylinder and a block: nothing to match, or too much.
void AddPlainAndRepetitive(SceneWriter& writer) {
  writer.Place(0, 0, 0, 0);
  writer.Use(Plain("plain wall", 0xC4BFB2));
  writer->AddBox({-0.21f, 0.135f, 0.f}, {-0.005f, 0.141f, 0.13f});
  writer.Use(Striped("striped wall", 0.012f));
  writer->AddBox({0.005f, 0.135f, 0.f}, {0.21f, 0.141f, 0.13f});

  writer.Place(-0.15, -0.095, 0, 12);
  writer.Use(Plain("plain card", 0xAEB7BD));
  writer->AddBox({-0.045f, -0.032f, 0.f}, {0.045f, 0.032f, 0.001f});
  writer.Place(0.14, -0.1, 0, -10);
  writer.Use(Striped("striped card", 0.007f));
  writer->AddBox({-0.048f, -0.034f, 0.f}, {0.048f, 0.034f, 0.001f});

  writer.Place(0.165, 0.04, 0, 0);
  writer.Use(Plain("plain cylinder", 0xB8C4CC));
  writer->AddCylinder(0.026f, 0.f, 0.085f, 128);
  writer.Place(0.035, 0.095, 0, 25);
  writer.Use({.name = "bricks",
              .texture = Texture::kBrick,
              .base = FromSrgb(0xA8553A),
              .second = FromSrgb(0xB0603F),
              .accent = FromSrgb(0xD9D2C3),
              .scale = 0.008f,
              .contrast = 0.1f,
              .repetitive = true});
  writer->AddBox({-0.03f, -0.02f, 0.f}, {0.03f, 0.02f, 0.06f});
}

// A ball of lacquer and a cylinder of polished metal, which show the ground where it is not.
void AddGlossy(SceneWriter& writer) {
  writer.Place(0.0, -0.035, 0, 0);
  writer.Use({.name = "glossy ball",
              .texture = Texture::kPlain,
              .base = FromSrgb(0x5A1E1C),
              .gloss = 0.12f});
  writer->AddEllipsoid({0.f, 0.f, 0.036f}, {0.036f, 0.036f, 0.036f}, 128);
  writer.Place(0.092, 0.01, 0, 0);
  writer.Use({.name = "polished cylinder",
              .texture = Texture::kPlain,
              .base = FromSrgb(0x6E7276),
              .gloss = 0.65f});
  writer->AddCylinder(0.022f, 0.f, 0.095f, 128);
}

// Rods before a picture: most of what is seen between them now is behind one of them soon.
void AddGrating(SceneWriter& writer) {
  writer.Place(-0.12, 0.085, 0, 0);
  writer.Use({.name = "picture",
              .texture = Texture::kPrint,
              .base = FromSrgb(0xD8C9A2),
              .second = FromSrgb(0x3F6F8C),
              .accent = FromSrgb(0x7C2F2A),
              .scale = 0.02f,
              .contrast = 0.4f});
  writer->AddBox({-0.075f, 0.f, 0.f}, {0.075f, 0.004f, 0.095f});
  writer.Use(WoodMaterial("rods", 0.004f));
  for (int i = 0; i < 12; ++i) {
    writer.Place(-0.192 + 0.013 * i, 0.055, 0, 31 * i);
    writer->AddCylinder(0.003f, 0.f, 0.1f, 24);
  }
}

}  // namespace

void DescribeHazards(SceneWriter& writer, SceneDescription* scene) {
  scene->box = {{-0.215, -0.15, -0.005}, {0.215, 0.145, 0.14}};
  AddTableTop(writer, 1.0f, 0.8f, -0.004f);
  writer.Use(SheetMaterial());
  writer->AddBox({-0.215f, -0.15f, -0.004f}, {0.215f, 0.145f, 0.f});
  AddPlainAndRepetitive(writer);
  AddGlossy(writer);
  AddGrating(writer);
  writer.Place(-0.055, -0.105, 0, 40);
  writer.Use({.name = "stone",
              .texture = Texture::kStone,
              .base = FromSrgb(0x7B7F86),
              .second = FromSrgb(0xA9A59C),
              .accent = FromSrgb(0x3B3D42),
              .scale = 0.014f,
              .contrast = 0.5f});
  writer->AddEllipsoid({0.f, 0.f, 0.018f}, {0.03f, 0.022f, 0.02f}, 96);
}

}  // namespace livemvs::synth
