#include "livemvs/synth/texture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "livemvs/synth/noise.h"
#include "livemvs/synth/printed_sheet.h"

namespace livemvs::synth {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

Vector3f Mix(const Vector3f& a, const Vector3f& b, float t) { return a + (b - a) * t; }

// Coordinates in the plane of a flat face: along its horizontal and up its slope.
Vector2f FaceCoordinates(const Vector3f& p, const Vector3f& n) {
  if (std::abs(n.z()) > 0.95f) return p.head<2>();
  const Vector3f along = Vector3f(-n.y(), n.x(), 0.f).normalized();
  const Vector3f up(n.y() * along.z() - n.z() * along.y(),
                    n.z() * along.x() - n.x() * along.z(),
                    n.x() * along.y() - n.y() * along.x());
  return {along.dot(p), up.dot(p)};
}

// What every texture is made from: the place, shifted by the seed, and the grain there.
struct Place {
  const Material& m;
  Vector3f p;       // [m], shifted
  Vector3f object;  // [m], not shifted
  Vector3f normal;
  float footprint;

  float Fractal(const Vector3f& q, float wavelength, float gain) const {
    return FractalNoise(q, wavelength, gain, footprint);
  }
  // Factor of the fine grain of every natural surface.
  float Grain(float wavelength) const {
    return std::max(0.1f, 1.f + m.contrast * Fractal(p, wavelength, 0.75f));
  }
};

// A row of stones: courses of height h, stones of width w, shifted by half a stone every course.
struct Stone {
  float edge;    // distance to the joint [m]
  float shade;   // uniform per stone
  float height;  // 0 at the lower, 1 at the upper edge of the course
};

Stone Masonry(const Vector2f& at, float w, float h) {
  const float row = std::floor(at.y() / h);
  const int iy = static_cast<int>(row);
  const float x = at.x() / w + ((iy & 1) ? 0.5f : 0.f);
  const float column = std::floor(x);
  const float fx = x - column, fy = at.y() / h - row;
  return {std::min(std::min(fx, 1.f - fx) * w, std::min(fy, 1.f - fy) * h),
          LatticeUniform(static_cast<int>(column), iy, 7),
          fy};
}

Vector3f Clouds(const Place& s) {
  const float t = 0.5f + 1.3f * s.Fractal(s.p, s.m.scale, 0.65f);
  return Mix(s.m.base, s.m.second, std::clamp(t, 0.f, 1.f)) * s.Grain(0.15f * s.m.scale);
}

Vector3f Wood(const Place& s, const Vector3f& q) {
  // Grain: noise stretched along x; rings: bands of the distance to a wandering axis.
  const Vector3f stretched(q.x() * 0.08f, q.y(), q.z());
  const float wander = s.Fractal(Vector3f(q.x() * 0.2f, q.y(), q.z()), 2.f * s.m.scale, 0.5f);
  const float ring = 0.5f + 0.5f * std::sin(6.2832f * (q.y() / s.m.scale + 2.2f * wander));
  const float fibre = s.Fractal(stretched, 0.12f * s.m.scale, 0.8f);
  const float pores = SmoothStep(0.25f, 0.55f, s.Fractal(stretched, 0.07f * s.m.scale, 0.6f));
  const Vector3f color = Mix(s.m.base, s.m.second, 0.15f + 0.6f * ring * ring);
  return Mix(color, s.m.accent, 0.6f * pores) * std::max(0.1f, 1.f + s.m.contrast * fibre);
}

Vector3f Parquet(const Place& s) {
  const float width = 4.f * s.m.scale;
  const Stone plank = Masonry(Vector2f(s.object.x(), s.object.y()), 9.f * width, width);
  Vector3f q = s.p;
  q.z() += 3.f * plank.shade;  // each plank is of another tree
  const float joint = SmoothStep(0.0003f, 0.0009f + s.footprint, plank.edge);
  return Wood(s, q) * ((0.8f + 0.35f * plank.shade) * (0.35f + 0.65f * joint));
}

Vector3f Brick(const Place& s) {
  const float h = s.m.scale;
  const Stone brick = Masonry(FaceCoordinates(s.object, s.normal), 2.2f * h, h);
  const float ragged = 0.05f * h * s.Fractal(s.p, 0.4f * h, 0.6f);
  const float inside = SmoothStep(0.04f * h, 0.09f * h + s.footprint, brick.edge + ragged);
  const Vector3f color = Mix(s.m.base, s.m.second, brick.shade);
  return Mix(s.m.accent, color, inside) * s.Grain(0.5f * h);
}

Vector3f Tiles(const Place& s) {
  const float h = s.m.scale;
  const Stone tile = Masonry(FaceCoordinates(s.object, s.normal), 0.8f * h, h);
  const float shade = SmoothStep(0.02f, 0.3f, tile.height) * (1.f - 0.3f * tile.height);
  const float joint = SmoothStep(0.02f * h, 0.06f * h + s.footprint, tile.edge);
  const Vector3f color = Mix(s.m.base, s.m.second, tile.shade);
  return color * ((0.35f + 0.75f * shade) * (0.5f + 0.5f * joint) * s.Grain(0.4f * h));
}

Vector3f StoneTexture(const Place& s) {
  const float patches = s.Fractal(s.p, 2.f * s.m.scale, 0.6f);
  const float pits = SmoothStep(0.3f, 0.6f, s.Fractal(s.p, 0.1f * s.m.scale, 0.7f));
  const Vector3f color = Mix(s.m.base, s.m.second, std::clamp(0.5f + 1.4f * patches, 0.f, 1.f)) *
                         s.Grain(0.3f * s.m.scale);
  return Mix(color, s.m.accent, 0.7f * pits);
}

Vector3f Terrazzo(const Place& s) {
  const Vector3f warped =
      s.p + 0.25f * s.m.scale * Vector3f::Constant(s.Fractal(s.p, 0.8f * s.m.scale, 0.5f));
  const Cell chip = NearestCell(warped / s.m.scale);
  const float edge = chip.edge * s.m.scale;
  const float size = 0.05f + 0.22f * static_cast<float>(chip.id >> 16 & 255) / 255.f;
  const float inside =
      SmoothStep(size - 0.03f, size + 0.03f + s.footprint / s.m.scale, edge / s.m.scale);
  const float kind = static_cast<float>(chip.id >> 24) / 255.f;
  const Vector3f color = kind < 0.4f ? s.m.second : Mix(s.m.accent, s.m.second, kind - 0.4f);
  return Mix(s.m.base, color, inside) * s.Grain(0.5f * s.m.scale);
}

Vector3f Marble(const Place& s) {
  const float warp = s.Fractal(s.p, 1.5f * s.m.scale, 0.6f);
  const float wave = std::sin((s.p.x() + 0.6f * s.p.z()) * 6.2832f / s.m.scale + 9.f * warp);
  const float vein = std::pow(1.f - std::abs(wave), 3.f);
  return Mix(Mix(s.m.base, s.m.second, 0.5f + warp), s.m.accent, 0.8f * vein) *
         s.Grain(0.2f * s.m.scale);
}

Vector3f Glaze(const Place& s) {
  const float wobble = 0.08f * s.m.scale * s.Fractal(s.p, s.m.scale, 0.6f);
  const float band = (s.object.z() + wobble) / s.m.scale;
  const float inside = std::abs(band - std::floor(band) - 0.5f);
  const float painted = SmoothStep(0.3f, 0.33f + s.footprint / s.m.scale, inside);
  const float zigzag = std::sin(8.f * std::atan2(s.object.y(), s.object.x())) * 0.12f;
  const float line =
      1.f - SmoothStep(0.03f, 0.07f + s.footprint / s.m.scale, std::abs(inside + zigzag - 0.15f));
  const Vector3f ground = Mix(s.m.base, s.m.second, painted);
  const float speckle = SmoothStep(0.28f, 0.5f, s.Fractal(s.p, 0.09f * s.m.scale, 0.6f));
  return Mix(Mix(ground, s.m.accent, line), s.m.accent, 0.6f * speckle) * s.Grain(0.5f * s.m.scale);
}

Vector3f Print(const Place& s) {
  const float soft = 0.02f + 0.3f * s.footprint / s.m.scale;
  const float big = SmoothStep(-soft, soft, s.Fractal(s.p, s.m.scale, 0.55f));
  const float small =
      SmoothStep(0.12f - soft, 0.12f + soft, s.Fractal(s.p, 0.3f * s.m.scale, 0.6f));
  return Mix(Mix(s.m.base, s.m.second, big), s.m.accent, small) * s.Grain(0.2f * s.m.scale);
}

Vector3f Stripes(const Place& s) {
  const float across = FaceCoordinates(s.object, s.normal).x() / s.m.scale;
  const float place = across - std::floor(across);
  const float soft = 0.5f * s.footprint / s.m.scale + 0.01f;
  const float dark = SmoothStep(0.25f - soft, 0.25f + soft, std::abs(place - 0.5f));
  return Mix(s.m.base, s.m.second, dark);
}

Vector3f Weave(const Place& s) {
  const Vector2f at = FaceCoordinates(s.object, s.normal) / s.m.scale;
  const int column = static_cast<int>(std::floor(at.x()));
  const int row = static_cast<int>(std::floor(at.y()));
  const bool along_x = ((column + row) & 1) != 0;  // which thread lies on top
  const float across = along_x ? at.y() - std::floor(at.y()) : at.x() - std::floor(at.x());
  const float dye = along_x ? LatticeUniform(0, row, 11) : LatticeUniform(column, 0, 12);
  const float round = 1.f - 2.2f * (across - 0.5f) * (across - 0.5f);
  return Mix(s.m.base, along_x ? s.m.second : s.m.accent, 0.25f + 0.75f * dye) * round *
         s.Grain(0.8f * s.m.scale);
}

Vector3f Text(const Place& s) {
  constexpr float kPitch = 1.7f;  // of the lines, in heights of a letter
  const float h = s.m.scale;
  const Vector2f at = FaceCoordinates(s.object, s.normal) / h;
  const float line = std::floor(at.y() / kPitch);
  const float letter = std::floor(at.x() / 0.75f);
  const int i = static_cast<int>(letter), j = static_cast<int>(line);
  // A letter is made of 3 x 5 strokes, each there or not; the fourth column keeps letters apart.
  const int u = static_cast<int>((at.x() - 0.75f * letter) / 0.1875f);
  const int v = static_cast<int>((at.y() - kPitch * line) * 5.f);
  const bool ink = u < 3 && v < 5 && LatticeUniform(i, j, 3) > 0.2f &&
                   LatticeUniform(4 * i + u, 5 * j + v, 5) < 0.6f;
  const float visible = 1.f - SmoothStep(0.1f * h, 0.4f * h, s.footprint);
  const float coverage = visible * (ink ? 1.f : 0.f) + (1.f - visible) * 0.22f;
  return Mix(s.m.base, s.m.accent, coverage) * s.Grain(0.3f * h);
}

Vector3f Dots(const Place& s) {
  // Turned, so that no flat face shows the lattice.
  static const Eigen::Matrix3f turn =
      Eigen::AngleAxisf(0.9f, Vector3f(1.f, 0.6f, -0.4f).normalized()).toRotationMatrix();
  Vector3f color = s.m.base;
  float size = s.m.scale;
  for (int layer = 0; layer < 3; ++layer, size *= 0.55f) {
    // One ball in each cube of a lattice, which it does not leave.
    const Vector3f q = turn * s.p / size + Vector3f::Constant(0.37f * static_cast<float>(layer));
    const Vector3f low = q.array().floor();
    const int x = static_cast<int>(low.x()), y = static_cast<int>(low.y());
    const int z = static_cast<int>(low.z());
    const float radius = 0.16f + 0.3f * LatticeUniform(x, y, z + 50 * layer);
    const Vector3f free(LatticeUniform(y, z, x), LatticeUniform(z, x, y), LatticeUniform(x, z, y));
    const Vector3f center = Vector3f::Constant(radius) + (1.f - 2.f * radius) * free;
    const float soft = 0.03f + 0.5f * s.footprint / size;
    const float inside = 1.f - SmoothStep(radius - soft, radius + soft, (q - low - center).norm());
    color = Mix(color, layer == 1 ? s.m.second : s.m.accent, 0.85f * inside);
  }
  return color * s.Grain(0.3f * s.m.scale);
}

Vector3f Brushed(const Place& s) {
  const Vector3f stretched(0.03f * s.p.x(), s.p.y(), s.p.z());
  const float line = s.Fractal(stretched, s.m.scale, 0.8f);
  const float stain = s.Fractal(s.p, 12.f * s.m.scale, 0.5f);
  const float t = 0.5f + 2.f * s.m.contrast * line + 0.5f * s.m.contrast * stain;
  return Mix(s.m.base, s.m.second, std::clamp(t, 0.f, 1.f));
}

Vector3f Printed(const Place& s) {
  if (s.normal.z() < 0.9f || s.m.printed == nullptr) return s.m.base;
  return Mix(s.m.second, s.m.base, s.m.printed->PaperAt(s.object.x(), s.object.y(), s.footprint));
}

}  // namespace

Vector3f FromSrgb(std::uint32_t rgb) {
  const auto linear = [](std::uint32_t byte) {
    return std::pow((static_cast<float>(byte & 255) / 255.f + 0.055f) / 1.055f, 2.4f);
  };
  return {linear(rgb >> 16), linear(rgb >> 8), linear(rgb)};
}

float ToSrgbLevel(float linear) {
  const float x = std::clamp(linear, 0.f, 1.f);
  return 255.f * (x < 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.f / 2.4f) - 0.055f);
}

Rgb ToSrgb(const Vector3f& linear) {
  Rgb rgb;
  for (int i = 0; i < 3; ++i) {
    rgb[i] = static_cast<std::uint8_t>(std::lround(ToSrgbLevel(linear[i])));
  }
  return rgb;
}

Vector3f Reflectance(const Material& material,
                     const Vector3f& p,
                     const Vector3f& normal,
                     float footprint) {
  const Place place{material, p + material.shift, p, normal, footprint};
  switch (material.texture) {
    case Texture::kPlain:
      return material.base;
    case Texture::kClouds:
      return Clouds(place);
    case Texture::kWood:
      return Wood(place, place.p);
    case Texture::kParquet:
      return Parquet(place);
    case Texture::kBrick:
      return Brick(place);
    case Texture::kTiles:
      return Tiles(place);
    case Texture::kStone:
      return StoneTexture(place);
    case Texture::kTerrazzo:
      return Terrazzo(place);
    case Texture::kMarble:
      return Marble(place);
    case Texture::kGlaze:
      return Glaze(place);
    case Texture::kPrint:
      return Print(place);
    case Texture::kStripes:
      return Stripes(place);
    case Texture::kWeave:
      return Weave(place);
    case Texture::kText:
      return Text(place);
    case Texture::kDots:
      return Dots(place);
    case Texture::kBrushed:
      return Brushed(place);
    case Texture::kPrinted:
      return Printed(place);
  }
  return material.base;
}

}  // namespace livemvs::synth
