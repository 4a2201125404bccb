// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// All lights of a scene at one moment, and the choice among them.
///
/// Lights that have a place (emissive triangles, point and spot lights) are grouped into a few
/// clusters. A shading point picks a cluster, the environment or the directional lights by what
/// they could send it at most (power, distance, the cone of the emitters' normals), then one light
/// of the cluster in proportion to its power through an alias table: constant time with thousands
/// of lights. The bounds follow Conty Estevez and Kulla (2018), "Importance Sampling of Many Lights
/// with Adaptive Tree Splitting", for one level of clusters.
#pragma once

#include <vector>

#include "render/alias_table.h"
#include "render/environment.h"
#include "render/scene_state.h"

namespace stillray::render {

inline constexpr int kMaxClusters = 16;
/// Clusters, then directional lights, then the environment.
inline constexpr int kMaxLightChoices = kMaxClusters + 2;

struct LightSample {
  vec3 direction;      ///< unit, towards the light
  float distance = 0;  ///< infinity for lights without a place
  vec3 radiance;       ///< of area lights and the environment; else what arrives, irradiance
  float density = 0;   ///< per solid angle, the choice included; 0: no light
  bool delta = false;  ///< cannot be found by chance: density is that of the choice alone
  vec3 point;          ///< on an area light
  vec3 normal;         ///< there, on the side of the shading point
};

/// How a shading point weighs its choices of light: running sums of their importances.
struct LightChoices {
  int count = 0;
  float sums[kMaxLightChoices];

  float total() const { return count > 0 ? sums[count - 1] : 0.0f; }
};

class LightSet {
 public:
  explicit LightSet(const SceneState& state);

  /// Follows the state's transforms.
  void Update(bool moved);

  bool empty() const { return choice_count_ == 0; }
  const EnvironmentLight& environment() const { return environment_; }

  /// What each choice could send to `point`.
  void Weigh(vec3 point, LightChoices* choices) const;

  /// Draws light for a surface. u: (u.x, u.y) the place, u.z the light.
  /// \param choices  as Weigh gives them for the point
  LightSample Sample(vec3 point, vec3 normal, const LightChoices& choices, vec4 u) const;

  /// Whether a ray could bring light by meeting an emitter or leaving the scene. False is certain,
  /// as long as the ray goes straight; it costs much less than tracing the ray.
  bool MayBeMet(vec3 origin, vec3 direction) const;

  /// Density with which Sample, at `point`, gives the place on an emitter that a ray of unit
  /// direction met at `distance`.
  /// \param total  LightChoices::total() there
  float DensityOfHit(vec3 point, float total, const Hit& hit, vec3 direction, float distance) const;
  /// The same for the environment.
  float DensityOfEnvironment(vec3 normal, float total, vec3 direction) const;

  size_t memory_bytes() const;

 private:
  struct AreaLight {
    uint32_t instance = 0;
    uint32_t primitive = 0;
    float mean_luminance = 0;  // of the emission over the triangle
    vec3 p0, edge1, edge2;
    vec3 normal;  // unit, of the emitting side
    float area = 0;
    float choice = 0;  // probability within its cluster
    uint32_t cluster = 0;
  };
  struct PointLight {
    const PunctualLight* light = nullptr;
    vec3 position;
    vec3 axis;  // along which it shines
  };
  // A light with a place, for building clusters.
  struct Element {
    uint32_t area = 0;   // index into areas_ if is_area
    uint32_t point = 0;  // index into points_ otherwise
    bool is_area = true;
    vec3 centre;
    vec3 low, high;  // bounds
    float intensity = 0;
  };
  struct Cluster {
    uint32_t first = 0;
    uint32_t count = 0;
    vec3 centre;
    float radius = 0;
    float intensity = 0;
    vec3 axis;
    float cone_cosine = -1;  // emission normals lie within this of the axis; -1: anywhere
    float cone_sine = 0;
    bool two_sided = false;
    vec3 low, high;  // bounds
  };

  void CollectAreas(const SceneState& state);
  void PlaceAreas();
  void PlacePunctual();
  void MakeClusters();
  bool WorthSplitting(const Cluster& group) const;
  void SplitElements(std::vector<Cluster>* groups);
  void FinishCluster(Cluster* cluster, uint32_t index);
  float ClusterImportance(const Cluster& cluster, vec3 point) const;
  bool TwoSided(const AreaLight& light) const;
  LightSample SampleArea(const AreaLight& light, vec3 point, float choice, float u0,
                         float u1) const;
  LightSample SamplePunctual(const PointLight& light, vec3 point, float choice) const;
  LightSample SampleCluster(const Cluster& cluster, vec3 point, float choice, vec4 u) const;

  const SceneState& state_;
  EnvironmentLight environment_;
  std::vector<AreaLight> areas_;
  std::vector<int64_t> first_area_;  // per instance: index of its triangle 0 in areas_, or -1
  std::vector<PointLight> points_;   // with a place
  std::vector<PointLight> distant_;  // directional
  std::vector<AliasEntry> distant_table_;
  float distant_irradiance_ = 0;
  float environment_irradiance_ = 0;
  std::vector<Element> elements_;  // cluster by cluster
  std::vector<AliasEntry> element_table_;
  std::vector<Cluster> clusters_;
  int choice_count_ = 0;
  bool all_in_clusters_ = true;  // no triangle emits without being an element
};

}  // namespace stillray::render
