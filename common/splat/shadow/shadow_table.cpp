// SPDX-License-Identifier: Apache-2.0
// The blur of an occluder by its distance is that of percentage-closer soft shadows (Fernando 2005); the
// light is a uniform sky, as in ambient occlusion fields (Kontkanen and Laine 2005).
#include "splat/shadow_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "splat/shadow/shadow_layout.h"

namespace livegs {
namespace {

constexpr int kLevels = 4, kBands = 5;
// Darkness under a body that covers the sky; larger: harder contrasts.
constexpr float kDarkest = 0.85f;
// Standard deviation of the blur per metre of gap. The light of a uniform sky gives 0.85; less keeps the
// shape of the body longer.
constexpr float kBlurPerGap = 0.6f;
constexpr float kMinBlur = 0.6f;    // texels; less shows the texels
constexpr float kBlurReach = 2.5f;  // standard deviations at which the blur is cut off
// Upper ends of the bands, relative to the height of the body. Narrow at the bottom, where contacts are.
constexpr std::array<float, kBands - 1> kBandEnds = {0.06f, 0.15f, 0.3f, 0.6f};
// Receivers' heights: one relative to the height of the body, the others in widths below its lowest point.
constexpr float kHighLevel = 0.3f, kGapLevels[] = {0.0f, 0.25f, 0.75f}, kReach = 2.0f;
// Border of the map around the body, in widths; its outer part fades out.
constexpr float kBorder = 0.75f, kFadeShare = 0.4f;
constexpr float kMaxTexels = 48;       // along the longer side; more costs time in proportion to the square
constexpr float kMinTexel_m = 0.004f;  // about the size of the kernels of a detailed floor
constexpr double kTrimmed = 0.01;      // share of kernels at each end that may be floaters
constexpr float kMaxCells = 32;        // of the header's grid along its longer side

struct Map {
  int nx = 0, nz = 0;
  std::vector<float> values;
};

// Gaussian blur, zero outside. Rows are added as a whole, so that the loop over x is vectorised; the result
// is transposed, so that two calls blur both directions.
Map blurred_across(const Map& map, std::span<const float> half) {
  std::vector<float> row(static_cast<size_t>(map.nx));
  Map turned{map.nz, map.nx, std::vector<float>(map.values.size())};
  const int reach = static_cast<int>(half.size()) - 1;
  for (int z = 0; z < map.nz; ++z) {
    std::fill(row.begin(), row.end(), 0.0f);
    for (int other = std::max(0, z - reach); other <= std::min(map.nz - 1, z + reach); ++other) {
      const float weight = half[static_cast<size_t>(std::abs(other - z))];
      const float* from = map.values.data() + static_cast<ptrdiff_t>(other) * map.nx;
      for (int x = 0; x < map.nx; ++x) row[static_cast<size_t>(x)] += weight * from[x];
    }
    for (int x = 0; x < map.nx; ++x)
      turned.values[static_cast<size_t>(x * map.nz + z)] = row[static_cast<size_t>(x)];
  }
  return turned;
}

Map blurred(const Map& map, float deviation_texels) {
  const int reach = static_cast<int>(std::ceil(kBlurReach * deviation_texels));
  std::vector<float> half(static_cast<size_t>(reach) + 1);
  float sum = 0;
  for (int i = 0; i <= reach; ++i) {
    const float t = static_cast<float>(i) / deviation_texels;
    half[static_cast<size_t>(i)] = std::exp(-0.5f * t * t);
    sum += (i == 0 ? 1.0f : 2.0f) * half[static_cast<size_t>(i)];
  }
  for (float& weight : half) weight /= sum;
  return blurred_across(blurred_across(map, half), half);
}

struct Bands {
  std::array<Map, kBands> covered;  // share of each texel
  std::array<float, kBands> height_m{};
};

// Adds the area of a kernel, as a level rectangle with the same variances, to the texels that it covers.
void add_area(const Eigen::Vector2f& middle, const Eigen::Vector2f& half, float area, Map& map) {
  const auto first = [](float from) { return std::max(0, static_cast<int>(std::floor(from + 0.5f))); };
  const auto last = [](float to, int count) {
    return std::min(count - 1, static_cast<int>(std::floor(to + 0.5f)));
  };
  const auto share = [](int texel, float from, float to) {  // of the interval that lies in the texel
    const auto at = static_cast<float>(texel);
    return std::max(0.0f, std::min(to, at + 0.5f) - std::max(from, at - 0.5f)) / (to - from);
  };
  const Eigen::Vector2f low = middle - half, high = middle + half;
  if (!(high.x() > -0.5f && high.y() > -0.5f && low.x() < static_cast<float>(map.nx) &&
        low.y() < static_cast<float>(map.nz)))
    return;
  for (int z = first(low.y()); z <= last(high.y(), map.nz); ++z) {
    const float along = area * share(z, low.y(), high.y());
    for (int x = first(low.x()); x <= last(high.x(), map.nx); ++x)
      map.values[static_cast<size_t>(z * map.nx + x)] += along * share(x, low.x(), high.x());
  }
}

Bands bands_of(const ShadowShape& shape, std::span<const uint32_t> kernels, const SceneShadows::Body& body,
               float lowest_m, float tall_m) {
  Bands bands;
  std::array<double, kBands> areas{}, moments{};
  for (Map& map : bands.covered) {
    map = {static_cast<int>(body.texels_x), static_cast<int>(body.texels_z), {}};
    map.values.assign(static_cast<size_t>(map.nx * map.nz), 0.0f);
  }
  const Eigen::Vector2f corner(body.x_m, body.z_m);
  for (const uint32_t k : kernels) {
    const Eigen::Vector3f& at = shape.positions_m[k];
    const Symmetric3f& s = shape.covariances_m2[k];
    const auto band = static_cast<size_t>(
        std::upper_bound(kBandEnds.begin(), kBandEnds.end(), (at.y() - lowest_m) / tall_m) -
        kBandEnds.begin());
    const Eigen::Vector2f deviations_m(std::sqrt(std::max(0.0f, s[0])), std::sqrt(std::max(0.0f, s[5])));
    const float det_m4 = std::max(0.0f, s[0] * s[5] - s[2] * s[2]);
    const float area = 2.0f * static_cast<float>(M_PI) * std::sqrt(det_m4) * shape.weights[k] *
                       body.texels_per_m * body.texels_per_m;
    // A kernel stands for its neighbours too, so it covers at least a texel.
    const Eigen::Vector2f half = (std::sqrt(3.0f) * body.texels_per_m * deviations_m).cwiseMax(0.5f);
    add_area(body.texels_per_m * (Eigen::Vector2f(at.x(), at.z()) - corner), half, area, bands.covered[band]);
    areas[band] += static_cast<double>(area);
    moments[band] += static_cast<double>(area) * static_cast<double>(at.y());
  }
  for (size_t b = 0; b < kBands; ++b) {
    for (float& value : bands.covered[b].values)
      value = 1.0f - std::exp(-value);  // kernels overlap at random
    bands.height_m[b] =
        areas[b] > 0 ? static_cast<float>(moments[b] / areas[b]) : -std::numeric_limits<float>::infinity();
  }
  return bands;
}

// 0 at the edge of the map, 1 inside, along one side.
float edge_fade(uint32_t texel, uint32_t count, float width) {
  const auto from_edge = static_cast<float>(std::min(texel, count - 1 - texel));
  const float t = std::min(1.0f, from_edge / width);
  return t * t * (3.0f - 2.0f * t);
}

SceneShadows::Body shadow_of(const ShadowShape& shape, std::span<const uint32_t> kernels) {
  SceneShadows::Body body;
  if (kernels.empty()) return body;
  Eigen::Vector3f low, high;
  std::vector<float> along(kernels.size());
  for (int axis = 0; axis < 3; ++axis) {
    constexpr int kDiagonal[3] = {0, 3, 5};
    for (const int side : {-1, 1}) {
      for (size_t i = 0; i < kernels.size(); ++i) {
        const float variance = shape.covariances_m2[kernels[i]][static_cast<size_t>(kDiagonal[axis])];
        along[i] = shape.positions_m[kernels[i]][axis] +
                   static_cast<float>(side) * std::sqrt(std::max(0.0f, variance));
      }
      const auto rank = along.begin() + static_cast<ptrdiff_t>((side < 0 ? kTrimmed : 1 - kTrimmed) *
                                                               static_cast<double>(along.size() - 1));
      std::nth_element(along.begin(), rank, along.end());
      (side < 0 ? low : high)[axis] = *rank;
    }
  }
  const Eigen::Vector3f size = (high - low).cwiseMax(1e-4f);
  const float wide_m = std::max(size.x(), size.z()), border_m = kBorder * wide_m;
  const float texel_m = std::max((wide_m + 2 * border_m) / kMaxTexels, kMinTexel_m);
  const auto texels = [&](float of_m) {
    return static_cast<uint32_t>(std::ceil((of_m + 2 * border_m) / texel_m)) + 2;
  };
  body.texels_x = texels(size.x());
  body.texels_z = texels(size.z());
  body.texels_per_m = 1.0f / texel_m;
  body.x_m = 0.5f * (low.x() + high.x() - texel_m * static_cast<float>(body.texels_x - 1));
  body.z_m = 0.5f * (low.z() + high.z() - texel_m * static_cast<float>(body.texels_z - 1));
  body.heights_m[0] = low.y() + size.y();
  body.heights_m[1] = low.y() + kHighLevel * size.y();
  for (int i = 0; i < 3; ++i) body.heights_m[2 + i] = low.y() - kGapLevels[i] * wide_m;
  body.heights_m[5] = low.y() - kReach * wide_m;

  const Bands bands = bands_of(shape, kernels, body, low.y(), size.y());
  const size_t count = size_t{body.texels_x} * body.texels_z;
  body.darkness.assign(count * kLevels, 0.0f);
  const float reach_m = kReach * wide_m + size.y();
  for (size_t level = 0; level < kLevels; ++level) {
    for (size_t b = 0; b < kBands; ++b) {
      const float gap_m = bands.height_m[b] - body.heights_m[1 + level];
      if (!(gap_m > -0.02f * size.y())) continue;  // the band is empty or does not lie above
      const float strength = kDarkest * std::max(0.0f, 1.0f - std::max(0.0f, gap_m) / reach_m);
      const Map map = blurred(bands.covered[b], kMinBlur + kBlurPerGap * std::max(0.0f, gap_m) / texel_m);
      for (size_t i = 0; i < count; ++i) {
        float& dark = body.darkness[kLevels * i + level];
        dark = std::max(dark, strength * map.values[i]);
      }
    }
  }
  const float fade = kFadeShare * border_m / texel_m;
  for (uint32_t z = 0; z < body.texels_z; ++z) {
    for (uint32_t x = 0; x < body.texels_x; ++x) {
      const float share = edge_fade(x, body.texels_x, fade) * edge_fade(z, body.texels_z, fade);
      for (size_t level = 0; level < kLevels; ++level)
        body.darkness[kLevels * (size_t{z} * body.texels_x + x) + level] *= share;
    }
  }
  return body;
}

float float_at(std::span<const uint32_t> words, uint32_t place) { return std::bit_cast<float>(words[place]); }
uint32_t bits(float value) { return std::bit_cast<uint32_t>(value); }

float darkness_of(std::span<const uint32_t> words, uint32_t body, const Eigen::Vector3f& at_m) {
  const float top = float_at(words, body + kShadowHeights),
              bottom = float_at(words, body + kShadowHeights + 5);
  if (!(at_m.y() < top && at_m.y() > bottom)) return 0.0f;
  const float scale = float_at(words, body + kShadowScale);
  const float x = scale * (at_m.x() - float_at(words, body + kShadowX));
  const float z = scale * (at_m.z() - float_at(words, body + kShadowZ));
  const uint32_t texels_x = words[body + kShadowTexelsX], texels_z = words[body + kShadowTexelsZ];
  if (!(x >= 0.0f && z >= 0.0f && x < static_cast<float>(texels_x - 1) &&
        z < static_cast<float>(texels_z - 1)))
    return 0.0f;
  const auto column = static_cast<uint32_t>(x), row = static_cast<uint32_t>(z);
  const uint32_t texel = words[body + kShadowTexels] + 4 * (row * texels_x + column);
  const float right = x - static_cast<float>(column), below = z - static_cast<float>(row);
  float sum = 0.0f;
  for (uint32_t level = 0; level < kLevels; ++level) {
    const float above = (float_at(words, body + kShadowHeights + level) - at_m.y()) *
                        float_at(words, body + kShadowSlopes + level);
    const float under = (at_m.y() - float_at(words, body + kShadowHeights + level + 2)) *
                        float_at(words, body + kShadowSlopes + level + 1);
    const float weight = std::clamp(std::min(above, under), 0.0f, 1.0f);
    const auto dark = [&](uint32_t place) { return float_at(words, place + level); };
    const uint32_t next = texel + 4 * texels_x;
    const float near = dark(texel) * (1.0f - right) + dark(texel + 4) * right;
    const float far = dark(next) * (1.0f - right) + dark(next + 4) * right;
    sum += weight * (near * (1.0f - below) + far * below);
  }
  return sum;
}

struct Placed {
  uint32_t object_id = 0;
  const SceneShadows::Body* body = nullptr;
  Eigen::Vector2f low() const { return {body->x_m, body->z_m}; }
  Eigen::Vector2f high() const {
    return low() +
           Eigen::Vector2f(static_cast<float>(body->texels_x - 1), static_cast<float>(body->texels_z - 1)) /
               body->texels_per_m;
  }
};

void add_body(const Placed& placed, uint32_t texels, std::vector<uint32_t>& words) {
  const SceneShadows::Body& body = *placed.body;
  const size_t first = words.size();
  words.insert(words.end(), {placed.object_id, bits(body.x_m), bits(body.z_m), bits(body.texels_per_m),
                             body.texels_x, body.texels_z, texels});
  for (const float height_m : body.heights_m) words.push_back(bits(height_m));
  for (int i = 0; i < 5; ++i) words.push_back(bits(1.0f / (body.heights_m[i] - body.heights_m[i + 1])));
  words.resize(first + kShadowBodyWords, 0);
}

std::vector<uint32_t> packed(std::span<const Placed> bodies) {
  Eigen::Vector2f low = bodies[0].low(), high = bodies[0].high();
  for (const Placed& placed : bodies) {
    low = low.cwiseMin(placed.low());
    high = high.cwiseMax(placed.high());
  }
  const float scale = kMaxCells / std::max((high - low).maxCoeff(), 1e-3f);
  const auto cells = [&](float extent_m) { return static_cast<uint32_t>(std::floor(scale * extent_m)) + 1; };
  const uint32_t cells_x = cells(high.x() - low.x()), cells_z = cells(high.y() - low.y());
  std::vector<uint32_t> words = {bits(low.x()), bits(low.y()), bits(scale),
                                 cells_x,       cells_z,       kShadowHeaderWords};
  words.resize(kShadowHeaderWords, 0);

  // The cells that a body may darken; one more on each side covers rounding.
  std::vector<std::vector<uint32_t>> over(size_t{cells_x} * cells_z);
  for (uint32_t b = 0; b < bodies.size(); ++b) {
    const auto cell = [&](float at_m, float from_m, int more, uint32_t count) {
      return static_cast<uint32_t>(std::clamp(static_cast<int>(std::floor(scale * (at_m - from_m))) + more, 0,
                                              static_cast<int>(count) - 1));
    };
    const Eigen::Vector2f from = bodies[b].low(), to = bodies[b].high();
    for (uint32_t z = cell(from.y(), low.y(), -1, cells_z); z <= cell(to.y(), low.y(), 1, cells_z); ++z) {
      for (uint32_t x = cell(from.x(), low.x(), -1, cells_x); x <= cell(to.x(), low.x(), 1, cells_x); ++x)
        over[size_t{z} * cells_x + x].push_back(b);
    }
  }
  size_t entries = 0;
  for (const auto& cell : over) entries += cell.size();
  const size_t first_entry = words.size() + over.size() + 1, first_body = first_entry + entries;
  size_t next = first_entry;
  for (const auto& cell : over) {
    words.push_back(static_cast<uint32_t>(next));
    next += cell.size();
  }
  words.push_back(static_cast<uint32_t>(next));
  for (const auto& cell : over) {
    for (const uint32_t b : cell)
      words.push_back(static_cast<uint32_t>(first_body + size_t{b} * kShadowBodyWords));
  }
  LIVEGS_ASSERT(words.size() == first_body);
  size_t texels = first_body + bodies.size() * kShadowBodyWords;
  for (const Placed& placed : bodies) {
    add_body(placed, static_cast<uint32_t>(texels), words);
    texels += placed.body->darkness.size();
  }
  words.reserve(texels);
  for (const Placed& placed : bodies) {
    for (const float dark : placed.body->darkness) words.push_back(bits(dark));
  }
  return words;
}

}  // namespace

float shadow_light(std::span<const uint32_t> words, const Eigen::Vector3f& at_m, uint32_t object_id) {
  if (words.empty() || words[kShadowGridCellsX] == 0) return 1.0f;
  const uint32_t cells_x = words[kShadowGridCellsX], cells_z = words[kShadowGridCellsZ];
  const float scale = float_at(words, kShadowGridScale);
  const float x = scale * (at_m.x() - float_at(words, kShadowGridX));
  const float z = scale * (at_m.z() - float_at(words, kShadowGridZ));
  if (!(x >= 0.0f && z >= 0.0f && x < static_cast<float>(cells_x) && z < static_cast<float>(cells_z)))
    return 1.0f;
  const uint32_t start =
      words[kShadowGridStarts] + static_cast<uint32_t>(z) * cells_x + static_cast<uint32_t>(x);
  float light = 1.0f;
  for (uint32_t entry = words[start]; entry < words[start + 1]; ++entry) {
    const uint32_t body = words[entry];
    if (words[body + kShadowObject] != object_id) light *= 1.0f - darkness_of(words, body, at_m);
  }
  return light;
}

void SceneShadows::set(uint32_t object_id, const ShadowShape& shape) {
  LIVEGS_ASSERT(shape.covariances_m2.size() == shape.positions_m.size() &&
                shape.weights.size() == shape.positions_m.size() &&
                shape.bodies.size() == shape.positions_m.size());
  std::map<uint32_t, std::vector<uint32_t>> kernels;
  for (uint32_t k = 0; k < shape.bodies.size(); ++k) {
    const Symmetric3f& s = shape.covariances_m2[k];
    if (shape.positions_m[k].allFinite() && std::isfinite(s[0] + s[1] + s[2] + s[3] + s[4] + s[5]))
      kernels[shape.bodies[k]].push_back(k);
  }
  std::vector<const std::vector<uint32_t>*> of_body;
  for (const auto& [body, indices] : kernels) of_body.push_back(&indices);
  std::vector<Body>& bodies = objects_[object_id];
  bodies.assign(of_body.size(), {});
  parallel_for(bodies.size(), 1, [&](size_t begin, size_t end) {
    for (size_t b = begin; b < end; ++b) bodies[b] = shadow_of(shape, *of_body[b]);
  });
  changed_ = true;
}

void SceneShadows::keep(std::span<const uint32_t> object_ids) {
  const size_t removed = std::erase_if(objects_, [&](const auto& object) {
    return std::find(object_ids.begin(), object_ids.end(), object.first) == object_ids.end();
  });
  changed_ = changed_ || removed > 0;
}

const ShadowTable& SceneShadows::table() {
  if (!changed_) return table_;
  std::vector<Placed> placed;
  for (const auto& [object_id, bodies] : objects_) {
    for (const Body& body : bodies) {
      if (body.texels_x > 0) placed.push_back({object_id, &body});
    }
  }
  table_.words = placed.empty() ? std::vector<uint32_t>{} : packed(placed);
  ++table_.version;
  changed_ = false;
  return table_;
}

}  // namespace livegs
