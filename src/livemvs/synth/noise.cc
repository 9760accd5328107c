#include "livemvs/synth/noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "livemvs/synth/random.h"

namespace livemvs::synth {
namespace {

constexpr int kPeriod = 256;  // of the lattice, in cells

// A random permutation of 0 ... 255, twice in a row so that sums of two bytes index it.
const std::array<std::uint8_t, 2 * kPeriod>& Permutation() {
  static const auto table = [] {
    std::array<std::uint8_t, 2 * kPeriod> p;
    std::iota(p.begin(), p.begin() + kPeriod, std::uint8_t{0});
    Random random(2011);
    for (int i = kPeriod - 1; i > 0; --i) {
      std::swap(p[i], p[static_cast<int>(random.Uniform() * (i + 1))]);
    }
    std::copy(p.begin(), p.begin() + kPeriod, p.begin() + kPeriod);
    return p;
  }();
  return table;
}

// One of twelve gradients towards the edges of a cube, dotted with the offset.
inline float DotGradient(std::uint8_t hash, float x, float y, float z) {
  const int h = hash & 15;
  const float u = h < 8 ? x : y;
  const float v = h < 4 ? y : (h == 12 || h == 14) ? x : z;
  return ((h & 1) ? -u : u) + ((h & 2) ? -v : v);
}

inline float Fade(float t) { return t * t * t * (t * (t * 6.f - 15.f) + 10.f); }

inline float Lerp(float t, float a, float b) { return a + t * (b - a); }

std::uint32_t LatticeHash(int x, int y, int z) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8DA6B343u;
  h ^= static_cast<std::uint32_t>(y) * 0xD8163841u;
  h ^= static_cast<std::uint32_t>(z) * 0xCB1AB31Fu;
  h = (h ^ (h >> 16)) * 0x7FEB352Du;
  h = (h ^ (h >> 15)) * 0x846CA68Bu;
  return h ^ (h >> 16);
}

// Ten bits as a number in [0, 1).
float Fraction(std::uint32_t bits) { return static_cast<float>(bits & 1023) / 1024.f; }

}  // namespace

float GradientNoise(const Eigen::Vector3f& p) {
  static const auto& perm = Permutation();
  const float fx = std::floor(p.x()), fy = std::floor(p.y()), fz = std::floor(p.z());
  const int ix = static_cast<int>(fx) & 255;
  const int iy = static_cast<int>(fy) & 255;
  const int iz = static_cast<int>(fz) & 255;
  const float x = p.x() - fx, y = p.y() - fy, z = p.z() - fz;
  const float u = Fade(x), v = Fade(y), w = Fade(z);
  const int a = perm[ix] + iy, b = perm[ix + 1] + iy;
  const int aa = perm[a] + iz, ab = perm[a + 1] + iz;
  const int ba = perm[b] + iz, bb = perm[b + 1] + iz;
  const float z0 =
      Lerp(v,
           Lerp(u, DotGradient(perm[aa], x, y, z), DotGradient(perm[ba], x - 1, y, z)),
           Lerp(u, DotGradient(perm[ab], x, y - 1, z), DotGradient(perm[bb], x - 1, y - 1, z)));
  const float z1 = Lerp(
      v,
      Lerp(u, DotGradient(perm[aa + 1], x, y, z - 1), DotGradient(perm[ba + 1], x - 1, y, z - 1)),
      Lerp(u,
           DotGradient(perm[ab + 1], x, y - 1, z - 1),
           DotGradient(perm[bb + 1], x - 1, y - 1, z - 1)));
  return Lerp(w, z0, z1);
}

float FractalNoise(const Eigen::Vector3f& p, float wavelength, float gain, float footprint) {
  constexpr int kMaxOctaves = 12;
  constexpr float kLacunarity = 2.07f;  // not 2: lattices of the octaves do not coincide
  const Eigen::Vector3f shift(17.31f, 5.77f, 43.13f);
  float sum = 0.f, amplitude = 1.f;
  Eigen::Vector3f q = p / wavelength;
  float cells_per_pixel = footprint / wavelength;
  for (int i = 0; i < kMaxOctaves; ++i) {
    const float visible = 1.f - SmoothStep(0.5f, 0.9f, cells_per_pixel);
    if (visible <= 0.f) break;
    sum += amplitude * visible * GradientNoise(q);
    amplitude *= gain;
    q = q * kLacunarity + shift;
    cells_per_pixel *= kLacunarity;
  }
  return 1.6f * std::sqrt(1.f - gain * gain) * sum;
}

Cell NearestCell(const Eigen::Vector3f& p) {
  const int ix = static_cast<int>(std::floor(p.x()));
  const int iy = static_cast<int>(std::floor(p.y()));
  const int iz = static_cast<int>(std::floor(p.z()));
  float first = std::numeric_limits<float>::max(), second = first;
  Cell cell;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const std::uint32_t h = LatticeHash(ix + dx, iy + dy, iz + dz);
        const Eigen::Vector3f site(static_cast<float>(ix + dx) + Fraction(h),
                                   static_cast<float>(iy + dy) + Fraction(h >> 10),
                                   static_cast<float>(iz + dz) + Fraction(h >> 20));
        const float d2 = (site - p).squaredNorm();
        if (d2 < first) {
          second = first;
          first = d2;
          cell.id = h;
        } else {
          second = std::min(second, d2);
        }
      }
    }
  }
  cell.edge = 0.5f * (std::sqrt(second) - std::sqrt(first));
  return cell;
}

float LatticeUniform(int x, int y, int z) {
  return static_cast<float>(LatticeHash(x, y, z) >> 8) * 0x1.0p-24f;
}

}  // namespace livemvs::synth
