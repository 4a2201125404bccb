// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/lights.h"

#include <algorithm>
#include <cmath>

#include "core/colour.h"
#include "render/alias_table.h"

namespace stillray::render {
namespace {

/// Points per edge of the grid on which a triangle's textured emission is averaged.
constexpr int kEmissionGrid = 8;

float MeanEmission(const SceneState& state, uint32_t instance, uint32_t primitive) {
  if (state.instance(instance).material->emissive_texture.texture < 0) {
    return Luminance709(state.instance(instance).material->emission);
  }
  float sum = 0;
  int count = 0;
  for (int i = 0; i < kEmissionGrid; ++i) {
    for (int j = 0; i + j < kEmissionGrid; ++j) {
      const float u = (static_cast<float>(i) + 1.0f / 3.0f) / kEmissionGrid;
      const float v = (static_cast<float>(j) + 1.0f / 3.0f) / kEmissionGrid;
      sum += Luminance709(state.Emission({0, u, v, instance, primitive}));
      ++count;
    }
  }
  return sum / static_cast<float>(count);
}

vec3 Axis(const mat4& world) {
  return SafeNormalize(-vec3(world[2]), vec3(0.0f, 0.0f, -1.0f));
}

}  // namespace

LightSet::LightSet(const SceneState& state)
    : state_(state), environment_(state.scene().environment) {
  CollectAreas();
}

void LightSet::CollectAreas() {
  first_area_.assign(state_.instances().size(), -1);
  for (uint32_t i = 0; i < state_.instances().size(); ++i) {
    const PlacedInstance& instance = state_.instance(i);
    if (!instance.material->emits()) {
      continue;
    }
    first_area_[i] = static_cast<int64_t>(areas_.size());
    const auto count = static_cast<uint32_t>(instance.mesh->indices.size() / 3);
    for (uint32_t p = 0; p < count; ++p) {
      AreaLight light = {};
      light.instance = i;
      light.primitive = p;
      light.two_sided = instance.material->double_sided ? 1 : 0;
      light.mean_luminance = MeanEmission(state_, i, p);
      areas_.push_back(light);
    }
  }
}

void LightSet::PlaceAreas() {
  arrays_.all_in_clusters = 1;
  for (AreaLight& light : areas_) {
    const PlacedInstance& instance = state_.instance(light.instance);
    const Triangle triangle = state_.TriangleOf(instance, light.primitive);
    light.p0 = triangle.p0;
    light.edge1 = triangle.p1 - triangle.p0;
    light.edge2 = triangle.p2 - triangle.p0;
    const vec3 across = cross(light.edge1, light.edge2);
    const float length2 = dot(across, across);
    const bool usable = length2 > 0.0f && std::isfinite(length2);
    light.area = usable ? 0.5f * std::sqrt(length2) : 0.0f;
    light.normal = SafeNormalize(across, vec3(0.0f, 0.0f, 1.0f)) * instance.orientation;
    light.choice = 0;
    const float intensity =
        light.area * light.mean_luminance * (light.two_sided != 0 ? 2.0f : 1.0f);
    if (intensity > 0.0f && std::isfinite(intensity)) {
      Element element;
      element.item = static_cast<uint32_t>(&light - areas_.data());
      element.low = min(min(triangle.p0, triangle.p1), triangle.p2);
      element.high = max(max(triangle.p0, triangle.p1), triangle.p2);
      element.centre = (element.low + element.high) * 0.5f;
      element.intensity = intensity;
      elements_.push_back(element);
    } else {
      arrays_.all_in_clusters = 0;
    }
  }
}

void LightSet::PlacePunctual() {
  punctuals_.clear();
  distant_.clear();
  for (const PunctualLight& light : state_.scene().lights) {
    const mat4& world = state_.nodes()[static_cast<size_t>(light.node)];
    const float intensity = Luminance709(light.intensity);
    if (!(intensity > 0.0f)) {
      continue;
    }
    const auto number = static_cast<uint32_t>(punctuals_.size());
    PunctualSource placed = {};
    placed.position = vec3(world[3]);
    placed.type = static_cast<int>(light.type);
    placed.axis = Axis(world);
    placed.range = light.range;
    placed.intensity = light.intensity;
    placed.inner_cosine = std::cos(light.inner_cone_angle);
    placed.outer_cosine = std::cos(light.outer_cone_angle);
    punctuals_.push_back(placed);
    if (light.type == LightType::kDirectional) {
      distant_.push_back(number);
      continue;
    }
    Element element;
    element.item = number | kPunctualItem;
    element.centre = element.low = element.high = placed.position;
    element.intensity = intensity;
    elements_.push_back(element);
  }
}
static_assert(static_cast<int>(LightType::kPoint) == kLightPoint &&
              static_cast<int>(LightType::kSpot) == kLightSpot &&
              static_cast<int>(LightType::kDirectional) == kLightDirectional);

/// Adds the entries of directional lights behind the entries of the elements.
void LightSet::AddDistant() {
  std::vector<float> weights;
  arrays_.distant_irradiance = 0;
  arrays_.first_distant = static_cast<uint32_t>(entries_.size());
  arrays_.distant_count = static_cast<uint32_t>(distant_.size());
  for (const uint32_t number : distant_) {
    const float intensity = Luminance709(punctuals_[number].intensity);
    weights.push_back(intensity);
    arrays_.distant_irradiance += intensity;
    entries_.push_back({0, 0, 0, number | kPunctualItem});
  }
  FillAliasTable(weights.data(), weights.size(), entries_.data() + arrays_.first_distant);
}

/// Whether splitting the group helps; not for the two triangles of a quad light.
bool LightSet::WorthSplitting(const LightCluster& group) const {
  if (group.count != 2) {
    return group.count > 2;
  }
  const Element& a = elements_[group.first];
  const Element& b = elements_[group.first + 1];
  return !a.is_area() || !b.is_area() || areas_[a.item].instance != areas_[b.item].instance;
}

/// Repeatedly splits the group with the largest squared extent times intensity, until kMaxClusters
/// is reached or no group is worth splitting.
void LightSet::SplitElements(std::vector<LightCluster>* groups) {
  const auto extent = [&](const LightCluster& group) {
    vec3 low = elements_[group.first].low;
    vec3 high = elements_[group.first].high;
    float intensity = 0;
    for (uint32_t i = group.first; i < group.first + group.count; ++i) {
      low = min(low, elements_[i].low);
      high = max(high, elements_[i].high);
      intensity += elements_[i].intensity;
    }
    return std::pair<vec3, float>(high - low, intensity);
  };
  while (static_cast<int>(groups->size()) < kMaxClusters) {
    int widest = -1;
    float most = 0;
    for (size_t g = 0; g < groups->size(); ++g) {
      const auto [size, intensity] = extent((*groups)[g]);
      const float spread = dot(size, size) * intensity;
      if (WorthSplitting((*groups)[g]) && spread > most) {
        most = spread;
        widest = static_cast<int>(g);
      }
    }
    if (widest < 0) {
      return;
    }
    LightCluster& group = (*groups)[static_cast<size_t>(widest)];
    const vec3 size = extent(group).first;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const auto first = elements_.begin() + group.first;
    std::stable_sort(first, first + group.count, [axis](const Element& a, const Element& b) {
      return a.centre[axis] < b.centre[axis];
    });
    LightCluster upper = {};
    upper.count = group.count / 2;
    upper.first = group.first + group.count - upper.count;
    group.count -= upper.count;
    groups->push_back(upper);
  }
}

void LightSet::FinishCluster(LightCluster* cluster, uint32_t index) {
  vec3 low(std::numeric_limits<float>::infinity());
  vec3 high = -low;
  vec3 axis(0.0f);
  bool directed = true;
  std::vector<float> weights;
  for (uint32_t i = cluster->first; i < cluster->first + cluster->count; ++i) {
    const Element& element = elements_[i];
    low = min(low, element.low);
    high = max(high, element.high);
    weights.push_back(element.intensity);
    cluster->intensity += element.intensity;
    directed = directed && element.is_area();
    if (element.is_area()) {
      const AreaLight& light = areas_[element.item];
      axis += light.normal * element.intensity;
      cluster->two_sided = cluster->two_sided | light.two_sided;
    }
  }
  cluster->low = low;
  cluster->high = high;
  cluster->centre = (low + high) * 0.5f;
  cluster->radius = 0.5f * length(high - low);
  cluster->axis = SafeNormalize(axis, vec3(0.0f));
  cluster->cone_cosine = directed && cluster->axis != vec3(0.0f) ? 1.0f : -1.0f;
  FillAliasTable(weights.data(), weights.size(), entries_.data() + cluster->first);
  for (uint32_t i = cluster->first; i < cluster->first + cluster->count; ++i) {
    entries_[i].item = elements_[i].item;
    if (elements_[i].is_area()) {
      AreaLight& light = areas_[elements_[i].item];
      light.cluster = index;
      light.choice = entries_[i].probability;
      cluster->cone_cosine = min(cluster->cone_cosine, dot(light.normal, cluster->axis));
    }
  }
  // Keeps the axis inside the cone despite rounding.
  constexpr float kMargin = 1e-4f;
  cluster->cone_cosine = max(cluster->cone_cosine - kMargin, -1.0f);
  cluster->cone_sine = std::sqrt(1.0f - cluster->cone_cosine * cluster->cone_cosine);
}

void LightSet::MakeClusters() {
  entries_.resize(elements_.size());
  std::vector<LightCluster> clusters;
  if (!elements_.empty()) {
    LightCluster all = {};
    all.count = static_cast<uint32_t>(elements_.size());
    clusters.push_back(all);
    SplitElements(&clusters);
  }
  for (size_t i = 0; i < clusters.size(); ++i) {
    FinishCluster(&clusters[i], static_cast<uint32_t>(i));
    arrays_.clusters[i] = clusters[i];
  }
  arrays_.cluster_count = static_cast<int>(clusters.size());
}

bool LightSet::Update(bool moved) {
  // Nodes of punctual lights can move while no instance moves.
  if (!moved && state_.scene().lights.empty()) {
    return false;
  }
  elements_.clear();
  PlaceAreas();
  PlacePunctual();
  MakeClusters();
  AddDistant();
  arrays_.environment = environment_.arrays();
  arrays_.environment_irradiance = kPi * environment_.arrays().mean_luminance;
  const bool any = !elements_.empty() || !distant_.empty() || !environment_.dark();
  arrays_.choice_count = any ? arrays_.cluster_count + 2 : 0;
  const bool one = entries_.size() == 1 && (entries_[0].item & kPunctualItem) != 0;
  arrays_.is_one_point = one && environment_.dark() ? 1 : 0;
  arrays_.entries = entries_.data();
  arrays_.areas = areas_.data();
  arrays_.punctuals = punctuals_.data();
  return true;
}

LightSample LightSet::Sample(vec3 point, vec3 normal, const LightChoices& choices, vec4 u) const {
  LightSample sample = SampleLights(arrays_, point, normal, choices, u);
  if (sample.area >= 0) {
    const AreaLight& light = areas_[static_cast<size_t>(sample.area)];
    const Hit hit{sample.distance, sample.u, sample.v, light.instance, light.primitive};
    sample.radiance = state_.Emission(hit) * state_.Opacity(hit);
  }
  return sample;
}

float LightSet::DensityOfHit(vec3 point, float total, const Hit& hit, vec3 direction,
                             float distance) const {
  const int64_t first = first_area_[hit.instance];
  if (first < 0) {
    return 0.0f;
  }
  const AreaLight& light = areas_[static_cast<size_t>(first) + hit.primitive];
  return DensityOfArea(arrays_, light, point, total, direction, distance);
}

size_t LightSet::memory_bytes() const {
  return areas_.capacity() * sizeof(AreaLight) + elements_.capacity() * sizeof(Element) +
         entries_.capacity() * sizeof(AliasEntry) + first_area_.capacity() * sizeof(int64_t) +
         environment_.memory_bytes();
}

}  // namespace stillray::render
