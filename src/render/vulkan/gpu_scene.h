// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A scene as arrays for storage buffers.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "render/lens.h"
#include "render/vulkan/texture_atlas.h"
#include "render/vulkan/wide_bvh.h"

namespace stillray::render {

/// The triangles of a bottom level: `count` of them, `opaque` of which are opaque.
struct TriangleGroup {
  uint32_t first = 0;
  uint32_t count = 0;
  uint32_t opaque = 0;
};

/// All static instances share one bottom level, in world space. Every moving mesh has a bottom
/// level shared by its instances; every deforming instance has its own. Data of deforming instances
/// is last in all arrays. The nodes start with the top level, which has a fixed size so that it can
/// be rebuilt when instances move.
class GpuScene {
 public:
  /// \param state  scene state at its first moment; must outlive this
  /// \param atlas  atlas of the scene's textures if they are sampled; nullptr: their texels are in
  ///     texels()
  /// \return kOutOfMemory; kUnsupported: too large for the indices, too deep
  static Result<std::unique_ptr<GpuScene>> Create(const SceneState& state,
                                                  const TextureAtlas* atlas = nullptr);

  /// Rebuilds the top level and the instances for the state's moment; refits the bottom levels of
  /// deforming instances.
  Status Update();

  const std::vector<BvhNode>& nodes() const { return nodes_; }
  size_t top_node_count() const { return top_nodes_; }
  const std::vector<BvhTriangle>& triangles() const { return triangles_; }
  /// In the order of the triangles; none is empty.
  const std::vector<TriangleGroup>& groups() const { return groups_; }
  /// Index of the first element of deforming instances in groups(), nodes() and triangles(), where
  /// it extends to the end, and in words(), where it has deforming_word_count() elements.
  size_t first_deforming_group() const { return first_deforming_group_; }
  size_t first_deforming_node() const { return first_deforming_node_; }
  size_t first_deforming_triangle() const { return first_deforming_triangle_; }
  size_t first_deforming_word() const { return first_deforming_word_; }
  size_t deforming_word_count() const { return deforming_words_; }
  /// Has its maximum size; only the first placed_count() elements are valid.
  const std::vector<Placement>& placements() const { return placements_; }
  size_t placed_count() const { return placed_count_; }
  const std::vector<GpuInstance>& instances() const { return instances_; }
  const std::vector<GpuMaterial>& materials() const { return materials_; }
  /// Whether any material has GpuLayers.
  bool with_layers() const { return with_layers_; }
  bool with_media() const { return with_media_; }  ///< whether any material has a scattering medium
  const std::vector<GpuTexture>& textures() const { return textures_; }
  const std::vector<uint32_t>& texels() const { return texels_; }
  const std::vector<uint32_t>& words() const { return words_; }
  const std::vector<float>& energies() const { return energies_; }
  const LensMasks& lens_masks() const { return lens_masks_; }
  /// Offset in words() of the cumulative sums of a texture's lens mask; 0 if the texture is no
  /// mask.
  uint32_t LensMaskWords(int texture) const;

 private:
  /// The bottom level of an instance, or of all static instances.
  struct Bottom {
    uint32_t instance = kNoInstance;
    uint32_t root = 0;
    uint32_t node_count = 0;
    TriangleGroup group;
    Aabb bounds;
    bool deforms = false;
    uint64_t shape = 0;  // PlacedInstance::shape of the current boxes, if deforming
  };

  explicit GpuScene(const SceneState& state) : state_(state), lens_masks_(state.scene()) {}
  Status AddMeshes();
  Status AddDeformedVertices();
  Status AddLensMasks();
  Status AddMaterials();
  Status AddTexels();
  void AddAtlas(const TextureAtlas& atlas);
  void AddEnergies();
  Status BuildBottomLevels();
  Status AddStatic();
  Result<Bottom> AddBottom(std::vector<BvhTriangle> triangles, const std::string& what);
  Status AddMoving();
  Status AddDeforming();
  void PlaceInstances();
  void UpdateDeforming();
  void UpdateVertices(size_t instance);
  void UpdateBottom(Bottom* bottom);

  const SceneState& state_;
  LensMasks lens_masks_;
  std::vector<uint32_t> mask_words_;  // in the order of the masks
  std::unique_ptr<WideBvhBuilder> builder_;
  std::vector<Bottom> bottoms_;
  size_t top_nodes_ = 0;
  std::vector<BvhNode> nodes_;
  std::vector<BvhTriangle> triangles_;
  std::vector<TriangleGroup> groups_;
  size_t first_deforming_group_ = 0;
  size_t first_deforming_node_ = 0;
  size_t first_deforming_triangle_ = 0;
  size_t first_deforming_word_ = 0;
  size_t deforming_words_ = 0;
  std::vector<std::array<uint32_t, 2>> previous_arrays_;  // by instance, if deforming
  std::vector<Placement> placements_;
  size_t placed_count_ = 0;
  std::vector<GpuInstance> instances_;
  std::vector<GpuMaterial> materials_;
  bool with_layers_ = false;
  bool with_media_ = false;
  std::vector<GpuTexture> textures_;
  std::vector<uint32_t> texels_;
  std::vector<uint32_t> words_;
  std::vector<float> energies_;
};

}  // namespace stillray::render
