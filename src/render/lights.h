// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The lights of a scene, prepared for lights_shared.h.
#pragma once

#include <vector>

#include "render/environment.h"
#include "render/lights_shared.h"
#include "render/scene_state.h"

namespace stillray::render {

class LightSet {
 public:
  /// \param state  must outlive this
  explicit LightSet(const SceneState& state);
  LightSet(const LightSet&) = delete;
  LightSet& operator=(const LightSet&) = delete;

  /// Updates the lights to the state's current transforms.
  /// \return whether any light has changed
  bool Update(bool moved);

  bool empty() const { return arrays_.choice_count == 0; }
  const EnvironmentLight& environment() const { return environment_; }
  /// Valid until the next Update.
  const LightArrays& arrays() const { return arrays_; }

  /// SampleLights, including the emitted radiance of area lights.
  LightSample Sample(vec3 point, vec3 normal, const LightChoices& choices, vec4 u) const;
  /// DensityOfArea of the hit triangle; 0 if it does not emit.
  float DensityOfHit(vec3 point, float total, const Hit& hit, vec3 direction, float distance) const;

  size_t memory_bytes() const;

  const std::vector<AreaLight>& areas() const { return areas_; }
  /// Per instance: index of the area light of its triangle 0; -1 if it does not emit.
  const std::vector<int64_t>& first_areas() const { return first_area_; }
  const std::vector<PunctualSource>& punctuals() const { return punctuals_; }
  /// Maximum number of punctual lights at any moment.
  size_t most_punctuals() const { return state_.scene().lights.size(); }
  const std::vector<AliasEntry>& entries() const { return entries_; }

 private:
  // A light with a position, from which clusters are built.
  struct Element {
    uint32_t item = 0;  // see AliasEntry
    vec3 centre;
    vec3 low, high;  // bounds
    float intensity = 0;

    bool is_area() const { return (item & kPunctualItem) == 0; }
  };

  void CollectAreas();
  void PlaceAreas();
  void PlacePunctual();
  void MakeClusters();
  void AddDistant();
  bool WorthSplitting(const LightCluster& group) const;
  void SplitElements(std::vector<LightCluster>* groups);
  void FinishCluster(LightCluster* cluster, uint32_t index);

  const SceneState& state_;
  EnvironmentLight environment_;
  LightArrays arrays_{};
  std::vector<AreaLight> areas_;
  std::vector<int64_t> first_area_;
  std::vector<PunctualSource> punctuals_;
  std::vector<uint32_t> distant_;    // indices of the directional lights in punctuals_
  std::vector<Element> elements_;    // sorted by cluster
  std::vector<AliasEntry> entries_;  // alias tables of the elements, then of the directional lights
};

}  // namespace stillray::render
