// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/lights.h"

#include <algorithm>
#include <cmath>

#include "core/colour.h"
#include "render/geometry.h"
#include "render/punctual_shared.h"

namespace stillray::render {
namespace {

// Points per edge of the grid on which a triangle's textured emission is averaged.
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

// cos(max(a - b, 0)) and sin likewise, for angles in 0..pi given by cosine and sine.
struct Angle {
  float cosine, sine;
};
Angle Less(Angle a, Angle b) {
  return a.cosine >= b.cosine
             ? Angle{1.0f, 0.0f}
             : Angle{a.cosine * b.cosine + a.sine * b.sine, a.sine * b.cosine - a.cosine * b.sine};
}

vec3 Axis(const mat4& world) {
  return SafeNormalize(-vec3(world[2]), vec3(0.0f, 0.0f, -1.0f));
}

}  // namespace

LightSet::LightSet(const SceneState& state)
    : state_(state), environment_(state.scene().environment) {
  CollectAreas(state);
}

void LightSet::CollectAreas(const SceneState& state) {
  first_area_.assign(state.instances().size(), -1);
  for (uint32_t i = 0; i < state.instances().size(); ++i) {
    const PlacedInstance& instance = state.instance(i);
    if (!instance.material->emits()) {
      continue;
    }
    first_area_[i] = static_cast<int64_t>(areas_.size());
    const auto count = static_cast<uint32_t>(instance.mesh->indices.size() / 3);
    for (uint32_t p = 0; p < count; ++p) {
      AreaLight light;
      light.instance = i;
      light.primitive = p;
      light.mean_luminance = MeanEmission(state, i, p);
      areas_.push_back(light);
    }
  }
}

bool LightSet::TwoSided(const AreaLight& light) const {
  return state_.instance(light.instance).material->double_sided;
}

void LightSet::PlaceAreas() {
  all_in_clusters_ = true;
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
    const float intensity = light.area * light.mean_luminance * (TwoSided(light) ? 2.0f : 1.0f);
    if (intensity > 0.0f && std::isfinite(intensity)) {
      Element element;
      element.area = static_cast<uint32_t>(&light - areas_.data());
      element.low = min(min(triangle.p0, triangle.p1), triangle.p2);
      element.high = max(max(triangle.p0, triangle.p1), triangle.p2);
      element.centre = (element.low + element.high) * 0.5f;
      element.intensity = intensity;
      elements_.push_back(element);
    } else {
      all_in_clusters_ = false;
    }
  }
}

void LightSet::PlacePunctual() {
  points_.clear();
  distant_.clear();
  std::vector<float> weights;
  distant_irradiance_ = 0;
  for (const PunctualLight& light : state_.scene().lights) {
    const mat4& world = state_.nodes()[static_cast<size_t>(light.node)];
    const float intensity = Luminance709(light.intensity);
    if (!(intensity > 0.0f)) {
      continue;
    }
    const PointLight placed{&light, vec3(world[3]), Axis(world)};
    if (light.type == LightType::kDirectional) {
      distant_.push_back(placed);
      weights.push_back(intensity);
      distant_irradiance_ += intensity;
      continue;
    }
    Element element;
    element.is_area = false;
    element.point = static_cast<uint32_t>(points_.size());
    element.centre = element.low = element.high = placed.position;
    element.intensity = intensity;
    elements_.push_back(element);
    points_.push_back(placed);
  }
  distant_table_.resize(distant_.size());
  FillAliasTable(weights.data(), weights.size(), distant_table_.data());
}

// The two triangles of a quad light are better left together.
bool LightSet::WorthSplitting(const Cluster& group) const {
  if (group.count != 2) {
    return group.count > 2;
  }
  const Element& a = elements_[group.first];
  const Element& b = elements_[group.first + 1];
  return !a.is_area || !b.is_area || areas_[a.area].instance != areas_[b.area].instance;
}

// Cuts the group whose light is most spread out, until there are enough or nothing is left to cut.
void LightSet::SplitElements(std::vector<Cluster>* groups) {
  const auto extent = [&](const Cluster& group) {
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
    Cluster& group = (*groups)[static_cast<size_t>(widest)];
    const vec3 size = extent(group).first;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const auto first = elements_.begin() + group.first;
    std::stable_sort(first, first + group.count, [axis](const Element& a, const Element& b) {
      return a.centre[axis] < b.centre[axis];
    });
    Cluster upper;
    upper.count = group.count / 2;
    upper.first = group.first + group.count - upper.count;
    group.count -= upper.count;
    groups->push_back(upper);
  }
}

void LightSet::FinishCluster(Cluster* cluster, uint32_t index) {
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
    directed = directed && element.is_area;
    if (element.is_area) {
      axis += areas_[element.area].normal * element.intensity;
      cluster->two_sided = cluster->two_sided || TwoSided(areas_[element.area]);
    }
  }
  cluster->low = low;
  cluster->high = high;
  cluster->centre = (low + high) * 0.5f;
  cluster->radius = 0.5f * length(high - low);
  cluster->axis = SafeNormalize(axis, vec3(0.0f));
  cluster->cone_cosine = directed && cluster->axis != vec3(0.0f) ? 1.0f : -1.0f;
  FillAliasTable(weights.data(), weights.size(), element_table_.data() + cluster->first);
  for (uint32_t i = cluster->first; i < cluster->first + cluster->count; ++i) {
    if (elements_[i].is_area) {
      AreaLight& light = areas_[elements_[i].area];
      light.cluster = index;
      light.choice = element_table_[i].probability;
      cluster->cone_cosine = min(cluster->cone_cosine, dot(light.normal, cluster->axis));
    }
  }
  // A rounding error must not put the axis itself outside of its cone.
  constexpr float kMargin = 1e-4f;
  cluster->cone_cosine = max(cluster->cone_cosine - kMargin, -1.0f);
  cluster->cone_sine = std::sqrt(1.0f - cluster->cone_cosine * cluster->cone_cosine);
}

void LightSet::MakeClusters() {
  clusters_.clear();
  if (elements_.empty()) {
    return;
  }
  Cluster all;
  all.count = static_cast<uint32_t>(elements_.size());
  clusters_.push_back(all);
  SplitElements(&clusters_);
  element_table_.resize(elements_.size());
  for (size_t i = 0; i < clusters_.size(); ++i) {
    FinishCluster(&clusters_[i], static_cast<uint32_t>(i));
  }
}

void LightSet::Update(bool moved) {
  // Nodes of punctual lights move without any instance moving.
  if (!moved && state_.scene().lights.empty()) {
    return;
  }
  elements_.clear();
  PlaceAreas();
  PlacePunctual();
  MakeClusters();
  environment_irradiance_ = kPi * environment_.mean_luminance();
  choice_count_ = static_cast<int>(clusters_.size()) + 2;
  if (clusters_.empty() && distant_.empty() && environment_.dark()) {
    choice_count_ = 0;
  }
}

// A bound on the irradiance at `point`, up to a constant factor; 0 only where no light arrives.
float LightSet::ClusterImportance(const Cluster& cluster, vec3 point) const {
  const vec3 offset = point - cluster.centre;
  const float radius2 = cluster.radius * cluster.radius;
  const float distance2 = dot(offset, offset);
  const float base = cluster.intensity / max(max(distance2, radius2), 1e-30f);
  if (cluster.cone_cosine <= -1.0f || distance2 <= radius2) {
    return base;
  }
  const float inverse2 = 1.0f / distance2;
  float cosine = min(dot(offset, cluster.axis) * std::sqrt(inverse2), 1.0f);
  cosine = cluster.two_sided ? std::abs(cosine) : max(cosine, -1.0f);
  const Angle to_axis{cosine, std::sqrt(max(1.0f - cosine * cosine, 0.0f))};
  const float seen2 = min(radius2 * inverse2, 1.0f);
  const Angle seen{std::sqrt(1.0f - seen2), std::sqrt(seen2)};
  const Angle cone{cluster.cone_cosine, cluster.cone_sine};
  return base * max(Less(Less(to_axis, cone), seen).cosine, 0.0f);
}

void LightSet::Weigh(vec3 point, LightChoices* choices) const {
  choices->count = choice_count_;
  if (choice_count_ == 0) {
    return;
  }
  float sum = 0;
  int i = 0;
  for (const Cluster& cluster : clusters_) {
    sum += ClusterImportance(cluster, point);
    choices->sums[i++] = sum;
  }
  choices->sums[i++] = sum + distant_irradiance_;
  choices->sums[i] = sum + distant_irradiance_ + environment_irradiance_;
}

bool LightSet::MayBeMet(vec3 origin, vec3 direction) const {
  if (!environment_.dark() || !all_in_clusters_) {
    return true;
  }
  // The ray's origin lies a little off the surface, in a direction that is not known here.
  constexpr float kSlack = 1e-4f;
  const vec3 inverse = 1.0f / direction;
  for (const Cluster& cluster : clusters_) {
    const vec3 slack = (abs(cluster.low) + abs(cluster.high) + abs(origin)) * kSlack + kSlack;
    const vec3 t0 = (cluster.low - slack - origin) * inverse;
    const vec3 t1 = (cluster.high + slack - origin) * inverse;
    const vec3 nearer = min(t0, t1);
    const vec3 farther = max(t0, t1);
    const float enter = MaxComponent(nearer);
    const float leave = min(farther.x, min(farther.y, farther.z));
    // Not a number, where a component of the direction is zero on the very edge: may be.
    if (!(enter > leave) && !(leave < 0.0f)) {
      return true;
    }
  }
  return false;
}

LightSample LightSet::SampleArea(const AreaLight& light, vec3 point, float choice, float u0,
                                 float u1) const {
  LightSample sample;
  // Uniform over the triangle.
  const float root = std::sqrt(u0);
  const float u = root * (1.0f - u1);
  const float v = root * u1;
  sample.point = light.p0 + light.edge1 * u + light.edge2 * v;
  const vec3 offset = sample.point - point;
  const float distance2 = dot(offset, offset);
  if (!(distance2 > 0.0f)) {
    return sample;
  }
  sample.distance = std::sqrt(distance2);
  sample.direction = offset / sample.distance;
  const float cosine = -dot(sample.direction, light.normal);
  if (cosine == 0.0f || (cosine < 0.0f && !TwoSided(light))) {
    return sample;
  }
  sample.normal = cosine > 0.0f ? light.normal : -light.normal;
  const Hit hit{sample.distance, u, v, light.instance, light.primitive};
  sample.radiance = state_.Emission(hit) * state_.Opacity(hit);
  sample.density = choice * distance2 / (light.area * std::abs(cosine));
  return sample;
}

LightSample LightSet::SamplePunctual(const PointLight& light, vec3 point, float choice) const {
  LightSample sample;
  sample.delta = true;
  if (light.light->type == LightType::kDirectional) {
    sample.direction = -light.axis;
    sample.distance = std::numeric_limits<float>::infinity();
    sample.radiance = light.light->intensity;
    sample.density = choice;
    return sample;
  }
  const vec3 offset = light.position - point;
  const float distance2 = dot(offset, offset);
  if (!(distance2 > 0.0f)) {
    return sample;
  }
  sample.distance = std::sqrt(distance2);
  sample.direction = offset / sample.distance;
  float attenuation = RangeAttenuation(sample.distance, light.light->range) / distance2;
  if (light.light->type == LightType::kSpot) {
    attenuation *=
        SpotAttenuation(-dot(sample.direction, light.axis), std::cos(light.light->inner_cone_angle),
                        std::cos(light.light->outer_cone_angle));
  }
  sample.radiance = light.light->intensity * attenuation;
  sample.density = attenuation > 0.0f ? choice : 0.0f;
  return sample;
}

LightSample LightSet::SampleCluster(const Cluster& cluster, vec3 point, float choice,
                                    vec4 u) const {
  const AliasEntry* table = element_table_.data() + cluster.first;
  const AliasChoice picked = ChooseByAlias(table, cluster.count, u.z);
  const Element& element = elements_[cluster.first + picked.index];
  const float density = choice * table[picked.index].probability;
  return element.is_area ? SampleArea(areas_[element.area], point, density, u.x, u.y)
                         : SamplePunctual(points_[element.point], point, density);
}

LightSample LightSet::Sample(vec3 point, vec3 normal, const LightChoices& choices, vec4 u) const {
  const float total = choices.total();
  if (!(total > 0.0f) || !std::isfinite(total)) {
    return {};
  }
  // The first choice whose running sum exceeds the mark: never one without importance, since the
  // mark is below the total.
  const float mark = min(u.z * total, std::nextafter(total, 0.0f));
  int choice = 0;
  while (choices.sums[choice] <= mark) {
    ++choice;
  }
  const float below = choice > 0 ? choices.sums[choice - 1] : 0.0f;
  const float importance = choices.sums[choice] - below;
  u.z = clamp((mark - below) / importance, 0.0f, 0.99999994f);
  const float probability = importance / total;
  const int clusters = static_cast<int>(clusters_.size());
  if (choice < clusters) {
    return SampleCluster(clusters_[static_cast<size_t>(choice)], point, probability, u);
  }
  if (choice == clusters) {
    const AliasChoice picked = ChooseByAlias(distant_table_.data(), distant_.size(), u.z);
    return SamplePunctual(distant_[picked.index], point,
                          probability * distant_table_[picked.index].probability);
  }
  const EnvironmentSample from = environment_.Sample(normal, u.x, u.y);
  LightSample sample;
  sample.direction = from.direction;
  sample.distance = std::numeric_limits<float>::infinity();
  sample.radiance = from.radiance;
  sample.density = from.density * probability;
  return sample;
}

float LightSet::DensityOfHit(vec3 point, float total, const Hit& hit, vec3 direction,
                             float distance) const {
  const int64_t first = first_area_[hit.instance];
  if (first < 0 || !(total > 0.0f) || !std::isfinite(total)) {
    return 0.0f;
  }
  const AreaLight& light = areas_[static_cast<size_t>(first) + hit.primitive];
  if (light.choice <= 0.0f) {
    return 0.0f;
  }
  const float cosine = std::abs(dot(direction, light.normal));
  const float choice = ClusterImportance(clusters_[light.cluster], point) / total * light.choice;
  return cosine > 0.0f ? choice * distance * distance / (light.area * cosine) : 0.0f;
}

float LightSet::DensityOfEnvironment(vec3 normal, float total, vec3 direction) const {
  if (!(total > 0.0f) || !std::isfinite(total)) {
    return 0.0f;
  }
  return environment_.Density(normal, direction) * environment_irradiance_ / total;
}

size_t LightSet::memory_bytes() const {
  return areas_.capacity() * sizeof(AreaLight) + elements_.capacity() * sizeof(Element) +
         element_table_.capacity() * sizeof(AliasEntry) + first_area_.capacity() * sizeof(int64_t) +
         environment_.memory_bytes();
}

}  // namespace stillray::render
