// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/hardware_scene.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <fmt/format.h>

#include "render/vulkan/device_arrays.h"

namespace stillray::render {
namespace {

using Instance = VkAccelerationStructureInstanceKHR;

/// Limit of the instance custom index (24 bits), which holds the placement.
constexpr size_t kMostPlacements = size_t{1} << 24;

VkDeviceAddress AlignUp(VkDeviceAddress address, VkDeviceAddress alignment) {
  return (address + alignment - 1) / alignment * alignment;
}

/// The indices of all triangles, sorted opaque first within each group.
std::vector<uint32_t> OrderOf(const GpuScene& scene) {
  std::vector<uint32_t> order(scene.triangles().size());
  for (const TriangleGroup& group : scene.groups()) {
    uint32_t opaque = group.first;
    uint32_t see_through = group.first + group.opaque;
    for (uint32_t i = group.first; i < group.first + group.count; ++i) {
      order[scene.triangles()[i].see_through == 0 ? opaque++ : see_through++] = i;
    }
  }
  return order;
}

/// Vertex indices, three per triangle.
std::vector<uint32_t> CornersOf(std::span<const uint32_t> order) {
  std::vector<uint32_t> corners;
  corners.reserve(3 * order.size());
  for (const uint32_t triangle : order) {
    corners.insert(corners.end(), {3 * triangle, 3 * triangle + 1, 3 * triangle + 2});
  }
  return corners;
}

/// Inputs of one acceleration structure build. Not copyable.
struct Build {
  VkAccelerationStructureBuildGeometryInfoKHR info = {};
  std::array<VkAccelerationStructureGeometryKHR, 2> geometries = {};
  std::array<VkAccelerationStructureBuildRangeInfoKHR, 2> ranges = {};
  VkAccelerationStructureBuildSizesInfoKHR sizes = {};

  Build() = default;
  Build(const Build&) = delete;
  Build& operator=(const Build&) = delete;

  void Begin(VkAccelerationStructureTypeKHR type, VkBuildAccelerationStructureFlagsKHR flags,
             uint32_t geometry_count) {
    info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    info.type = type;
    info.flags = flags;
    info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.geometryCount = geometry_count;
    info.pGeometries = geometries.data();
  }

  void FindSizes(const gpu::DeviceContext& c, const uint32_t* most_primitives) {
    sizes.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR;
    c.vk.GetAccelerationStructureBuildSizesKHR(
        c.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, most_primitives, &sizes);
  }

  void Record(const gpu::DeviceContext& c, VkCommandBuffer commands, const gpu::Acceleration& to,
              const gpu::Buffer& scratch) {
    info.dstAccelerationStructure = to.handle();
    info.scratchData.deviceAddress = AlignUp(scratch.address, c.ray_tracing.scratch_alignment);
    const VkAccelerationStructureBuildRangeInfoKHR* first_range = ranges.data();
    c.vk.CmdBuildAccelerationStructuresKHR(commands, 1, &info, &first_range);
  }
};

/// Describes the build of a triangle group. Both geometries always exist, so that the geometry
/// index distinguishes opaque from see-through triangles.
/// \param indices  three vertex indices per entry of the order from `first_entry` on
void DescribeBottom(const TriangleGroup& group, size_t all_triangles, VkDeviceAddress triangles,
                    VkDeviceAddress indices, uint32_t first_entry,
                    VkBuildAccelerationStructureFlagsKHR flags, Build* build) {
  build->Begin(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, flags, 2);
  for (size_t i = 0; i < 2; ++i) {
    VkAccelerationStructureGeometryKHR& geometry = build->geometries[i];
    geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry.flags =
        i == 0 ? VK_GEOMETRY_OPAQUE_BIT_KHR : VK_GEOMETRY_NO_DUPLICATE_ANY_HIT_INVOCATION_BIT_KHR;
    VkAccelerationStructureGeometryTrianglesDataKHR& data = geometry.geometry.triangles;
    data.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
    data.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    data.vertexData.deviceAddress = triangles;
    data.vertexStride = sizeof(BvhTriangle) / 3;
    data.maxVertex = static_cast<uint32_t>(3 * all_triangles - 1);
    data.indexType = VK_INDEX_TYPE_UINT32;
    data.indexData.deviceAddress = indices;
    const uint32_t first = (i == 0 ? group.first : group.first + group.opaque) - first_entry;
    build->ranges[i].primitiveCount = i == 0 ? group.opaque : group.count - group.opaque;
    build->ranges[i].primitiveOffset = first * 3 * static_cast<uint32_t>(sizeof(uint32_t));
  }
}

/// Build flags of groups that do not deform.
constexpr VkBuildAccelerationStructureFlagsKHR kKept =
    VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR |
    VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
/// Build flags of groups that are rebuilt every frame.
constexpr VkBuildAccelerationStructureFlagsKHR kRebuilt =
    VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR;

void DescribeTop(VkDeviceAddress instances, uint32_t count, Build* build) {
  build->Begin(VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
               VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR, 1);
  VkAccelerationStructureGeometryKHR& geometry = build->geometries[0];
  geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
  geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
  VkAccelerationStructureGeometryInstancesDataKHR& data = geometry.geometry.instances;
  data.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
  data.data.deviceAddress = instances;
  build->ranges[0].primitiveCount = count;
}

/// Queries the compacted sizes of finished structures.
class CompactedSizes {
 public:
  explicit CompactedSizes(const gpu::DeviceContext* context) : context_(context) {}
  CompactedSizes(const CompactedSizes&) = delete;
  CompactedSizes& operator=(const CompactedSizes&) = delete;
  ~CompactedSizes() { context_->vk.DestroyQueryPool(context_->device, pool_, nullptr); }

  Status Create(uint32_t count) {
    VkQueryPoolCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    info.queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
    info.queryCount = count;
    return gpu::ToStatus(context_->vk.CreateQueryPool(context_->device, &info, nullptr, &pool_),
                         "creating queries of acceleration structures");
  }
  void Record(VkCommandBuffer commands, std::span<const gpu::Acceleration> structures) const {
    std::vector<VkAccelerationStructureKHR> handles;
    for (const gpu::Acceleration& structure : structures) {
      handles.push_back(structure.handle());
    }
    const auto count = static_cast<uint32_t>(handles.size());
    context_->vk.CmdResetQueryPool(commands, pool_, 0, count);
    context_->vk.CmdWriteAccelerationStructuresPropertiesKHR(
        commands, count, handles.data(), VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
        pool_, 0);
  }
  Status Read(std::vector<VkDeviceSize>* sizes) const {
    return gpu::ToStatus(
        context_->vk.GetQueryPoolResults(
            context_->device, pool_, 0, static_cast<uint32_t>(sizes->size()),
            sizes->size() * sizeof(VkDeviceSize), sizes->data(), sizeof(VkDeviceSize),
            VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
        "reading the sizes of acceleration structures");
  }

 private:
  const gpu::DeviceContext* context_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
};

VkTransformMatrixKHR TransformOf(const GpuScene& scene, const Placement& placement) {
  if (placement.instance == kNoInstance) {
    return {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  }
  const GpuInstance& of = scene.instances()[placement.instance];
  VkTransformMatrixKHR transform;
  const vec4 rows[3] = {of.world_x, of.world_y, of.world_z};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      transform.matrix[row][column] = rows[row][column];
    }
  }
  return transform;
}

Status AddBuffer(gpu::Arena* arena, size_t bytes, VkBufferUsageFlags usage, gpu::BufferPlace place,
                 const gpu::Buffer** out) {
  constexpr size_t kLeast = 256;  // minimum buffer size: no buffer is empty
  const Result<const gpu::Buffer*> buffer = arena->AddBuffer(std::max(bytes, kLeast), usage, place);
  if (buffer.ok()) {
    *out = *buffer;
  }
  return buffer.status();
}

constexpr VkBufferUsageFlags kScratchUsage =
    VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

}  // namespace

Status HardwareScene::CheckLimits() const {
  const gpu::RayTracing& limits = device_->context().ray_tracing;
  for (const TriangleGroup& group : scene_.groups()) {
    if (group.count > limits.most_triangles) {
      return Status::Unsupported(fmt::format(
          "{}: {} triangles are static or of one mesh, hardware ray tracing supports {}",
          device_->info().name, group.count, limits.most_triangles));
    }
  }
  const uint64_t most = std::min<uint64_t>(limits.most_instances, kMostPlacements);
  if (scene_.placements().size() > most) {
    return Status::Unsupported(
        fmt::format("{}: {} instances move, ray tracing by hardware takes {}", device_->info().name,
                    scene_.placements().size(), most));
  }
  return Status::Ok();
}

Status HardwareScene::AddBuffers() {
  const size_t most = scene_.placements().size();
  Build top;
  DescribeTop(0, static_cast<uint32_t>(most), &top);
  top.FindSizes(device_->context(), &top.ranges[0].primitiveCount);
  STILLRAY_RETURN_IF_ERROR(AddBuffer(&arena_, scene_.triangles().size() * sizeof(uint32_t),
                                     VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::BufferPlace::kDevice,
                                     &order_));
  STILLRAY_RETURN_IF_ERROR(
      AddBuffer(&arena_, most * sizeof(Instance), 0, gpu::BufferPlace::kUpload, &staging_));
  STILLRAY_RETURN_IF_ERROR(AddBuffer(&arena_, most * sizeof(Instance), kTriangleUsage,
                                     gpu::BufferPlace::kDevice, &instances_));
  STILLRAY_RETURN_IF_ERROR(AddBuffer(&arena_, top.sizes.accelerationStructureSize,
                                     gpu::Acceleration::kUsage, gpu::BufferPlace::kDevice,
                                     &top_memory_));
  STILLRAY_RETURN_IF_ERROR(AddBuffer(
      &arena_, top.sizes.buildScratchSize + device_->context().ray_tracing.scratch_alignment,
      kScratchUsage, gpu::BufferPlace::kDevice, &scratch_));
  return arena_.Allocate();
}

/// Inputs and scratch memory of the bottom levels' builds; freed after compaction.
struct HardwareScene::BottomBuffers {
  const gpu::Buffer* corners = nullptr;  // three vertex indices per entry of the order
  const gpu::Buffer* scratch = nullptr;
  std::vector<const gpu::Buffer*> structures;  // uncompacted structures of the groups
};

Status HardwareScene::BuildBottoms(const gpu::Buffer& triangles,
                                   const std::vector<uint32_t>& order) {
  const gpu::DeviceContext& c = device_->context();
  const std::span groups(scene_.groups().data(), scene_.first_deforming_group());
  if (groups.empty()) {
    return Status::Ok();
  }
  const std::vector<uint32_t> corners =
      CornersOf({order.data(), scene_.first_deforming_triangle()});
  gpu::Arena arena(&c);
  BottomBuffers buffers;
  buffers.structures.resize(groups.size());
  STILLRAY_RETURN_IF_ERROR(AddBuffer(&arena, corners.size() * sizeof(uint32_t), kTriangleUsage,
                                     gpu::BufferPlace::kDevice, &buffers.corners));
  VkDeviceSize most_scratch = 0;
  for (size_t i = 0; i < groups.size(); ++i) {
    Build build;
    DescribeBottom(groups[i], order.size(), 0, 0, 0, kKept, &build);
    const uint32_t counts[2] = {build.ranges[0].primitiveCount, build.ranges[1].primitiveCount};
    build.FindSizes(c, counts);
    most_scratch = std::max(most_scratch, build.sizes.buildScratchSize);
    STILLRAY_RETURN_IF_ERROR(AddBuffer(&arena, build.sizes.accelerationStructureSize,
                                       gpu::Acceleration::kUsage, gpu::BufferPlace::kDevice,
                                       &buffers.structures[i]));
  }
  STILLRAY_RETURN_IF_ERROR(AddBuffer(&arena, most_scratch + c.ray_tracing.scratch_alignment,
                                     kScratchUsage, gpu::BufferPlace::kDevice, &buffers.scratch));
  STILLRAY_RETURN_IF_ERROR(arena.Allocate());
  const std::array<HostArray, 1> arrays = {MakeArray("corners of triangles", corners)};
  const std::array<const gpu::Buffer*, 1> targets = {buffers.corners};
  STILLRAY_RETURN_IF_ERROR(UploadArrays(device_, arrays, targets));
  std::vector<gpu::Acceleration> loose;
  STILLRAY_RETURN_IF_ERROR(RunBuilds(triangles, buffers, &loose));
  return Compact(loose);
}

/// In sequence: they share the scratch memory.
Status HardwareScene::RunBuilds(const gpu::Buffer& triangles, const BottomBuffers& buffers,
                                std::vector<gpu::Acceleration>* built) {
  const gpu::DeviceContext& c = device_->context();
  const std::span groups(scene_.groups().data(), scene_.first_deforming_group());
  const gpu::FairLock lock = device_->Lock();
  const Result<VkCommandBuffer> commands = device_->Begin();
  STILLRAY_RETURN_IF_ERROR(commands.status());
  gpu::MemoryBarrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                     VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                     VK_ACCESS_SHADER_READ_BIT);
  for (size_t i = 0; i < groups.size(); ++i) {
    Result<gpu::Acceleration> made = gpu::Acceleration::Create(
        &c, *buffers.structures[i], VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    STILLRAY_RETURN_IF_ERROR(made.status());
    built->push_back(std::move(*made));
    Build build;
    DescribeBottom(groups[i], scene_.triangles().size(), triangles.address,
                   buffers.corners->address, 0, kKept, &build);
    build.Record(c, *commands, built->back(), *buffers.scratch);
    gpu::WaitForBuilds(c, *commands);
  }
  return device_->Run();
}

/// Copies the structures to buffers of their compacted sizes.
Status HardwareScene::Compact(std::span<const gpu::Acceleration> loose) {
  const gpu::DeviceContext& c = device_->context();
  CompactedSizes queries(&c);
  STILLRAY_RETURN_IF_ERROR(queries.Create(static_cast<uint32_t>(loose.size())));
  const gpu::FairLock lock = device_->Lock();
  Result<VkCommandBuffer> commands = device_->Begin();
  STILLRAY_RETURN_IF_ERROR(commands.status());
  queries.Record(*commands, loose);
  STILLRAY_RETURN_IF_ERROR(device_->Run());
  std::vector<VkDeviceSize> sizes(loose.size());
  STILLRAY_RETURN_IF_ERROR(queries.Read(&sizes));
  std::vector<const gpu::Buffer*> memory(loose.size());
  for (size_t i = 0; i < loose.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(AddBuffer(&bottom_arena_, sizes[i], gpu::Acceleration::kUsage,
                                       gpu::BufferPlace::kDevice, &memory[i]));
  }
  STILLRAY_RETURN_IF_ERROR(bottom_arena_.Allocate());
  commands = device_->Begin();
  STILLRAY_RETURN_IF_ERROR(commands.status());
  for (size_t i = 0; i < loose.size(); ++i) {
    Result<gpu::Acceleration> made =
        gpu::Acceleration::Create(&c, *memory[i], VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    STILLRAY_RETURN_IF_ERROR(made.status());
    bottoms_.push_back(std::move(*made));
    VkCopyAccelerationStructureInfoKHR copy = {};
    copy.sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR;
    copy.src = loose[i].handle();
    copy.dst = bottoms_.back().handle();
    copy.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
    c.vk.CmdCopyAccelerationStructureKHR(*commands, &copy);
  }
  gpu::WaitForBuilds(c, *commands);
  return device_->Run();
}

/// Creates the structures that RecordDeforming builds.
Status HardwareScene::MakeDeforming(const gpu::Buffer& triangles,
                                    const std::vector<uint32_t>& order) {
  const gpu::DeviceContext& c = device_->context();
  const size_t first = scene_.first_deforming_triangle();
  const std::vector<TriangleGroup>& groups = scene_.groups();
  if (scene_.first_deforming_group() == groups.size()) {
    return Status::Ok();
  }
  triangles_ = &triangles;
  const std::vector<uint32_t> corners = CornersOf({order.data() + first, order.size() - first});
  STILLRAY_RETURN_IF_ERROR(AddBuffer(&deforming_arena_, corners.size() * sizeof(uint32_t),
                                     kTriangleUsage, gpu::BufferPlace::kDevice,
                                     &deforming_corners_));
  std::vector<const gpu::Buffer*> memory(groups.size(), nullptr);
  VkDeviceSize most_scratch = 0;
  for (size_t i = scene_.first_deforming_group(); i < groups.size(); ++i) {
    Build build;
    DescribeBottom(groups[i], order.size(), 0, 0, static_cast<uint32_t>(first), kRebuilt, &build);
    const uint32_t counts[2] = {build.ranges[0].primitiveCount, build.ranges[1].primitiveCount};
    build.FindSizes(c, counts);
    most_scratch = std::max(most_scratch, build.sizes.buildScratchSize);
    STILLRAY_RETURN_IF_ERROR(AddBuffer(&deforming_arena_, build.sizes.accelerationStructureSize,
                                       gpu::Acceleration::kUsage, gpu::BufferPlace::kDevice,
                                       &memory[i]));
  }
  STILLRAY_RETURN_IF_ERROR(AddBuffer(&deforming_arena_,
                                     most_scratch + c.ray_tracing.scratch_alignment, kScratchUsage,
                                     gpu::BufferPlace::kDevice, &deforming_scratch_));
  STILLRAY_RETURN_IF_ERROR(deforming_arena_.Allocate());
  for (size_t i = scene_.first_deforming_group(); i < groups.size(); ++i) {
    Result<gpu::Acceleration> made =
        gpu::Acceleration::Create(&c, *memory[i], VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR);
    STILLRAY_RETURN_IF_ERROR(made.status());
    deforming_.push_back(std::move(*made));
  }
  const std::array<HostArray, 1> arrays = {MakeArray("corners of triangles that deform", corners)};
  const std::array<const gpu::Buffer*, 1> targets = {deforming_corners_};
  return UploadArrays(device_, arrays, targets);
}

/// In sequence: they share the scratch memory.
void HardwareScene::RecordDeforming(VkCommandBuffer commands) const {
  const gpu::DeviceContext& c = device_->context();
  for (size_t i = 0; i < deforming_.size(); ++i) {
    Build build;
    DescribeBottom(scene_.groups()[scene_.first_deforming_group() + i], scene_.triangles().size(),
                   triangles_->address, deforming_corners_->address,
                   static_cast<uint32_t>(scene_.first_deforming_triangle()), kRebuilt, &build);
    build.Record(c, commands, deforming_[i], *deforming_scratch_);
    gpu::WaitForBuilds(c, commands);
  }
}

Status HardwareScene::MakeSet() {
  STILLRAY_RETURN_IF_ERROR(sets_.CreatePool(1, kShape));
  const Result<VkDescriptorSet> set =
      sets_.Find(kShape, {{}, {}, {order_->buffer}, {top_.handle()}});
  if (set.ok()) {
    set_ = *set;
  }
  return set.status();
}

Result<std::unique_ptr<HardwareScene>> HardwareScene::Create(gpu::Device* device,
                                                             const GpuScene& scene,
                                                             const gpu::Buffer& triangles) {
  std::unique_ptr<HardwareScene> made(new HardwareScene(device, scene));
  STILLRAY_RETURN_IF_ERROR(made->CheckLimits());
  STILLRAY_RETURN_IF_ERROR(made->AddBuffers());
  const std::vector<uint32_t> order = OrderOf(scene);
  const std::array<HostArray, 1> arrays = {MakeArray("order of triangles", order)};
  const std::array<const gpu::Buffer*, 1> buffers = {made->order_};
  STILLRAY_RETURN_IF_ERROR(UploadArrays(device, arrays, buffers));
  STILLRAY_RETURN_IF_ERROR(made->BuildBottoms(triangles, order));
  STILLRAY_RETURN_IF_ERROR(made->MakeDeforming(triangles, order));
  Result<gpu::Acceleration> top = gpu::Acceleration::Create(
      &device->context(), *made->top_memory_, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR);
  STILLRAY_RETURN_IF_ERROR(top.status());
  made->top_ = std::move(*top);
  STILLRAY_RETURN_IF_ERROR(made->MakeSet());
  STILLRAY_RETURN_IF_ERROR(made->Update());
  return made;
}

VkDeviceAddress HardwareScene::BottomOf(const Placement& placement) const {
  const std::vector<TriangleGroup>& groups = scene_.groups();
  const auto group =
      std::lower_bound(groups.begin(), groups.end(), placement.first_triangle,
                       [](const TriangleGroup& g, uint32_t first) { return g.first < first; });
  const auto index = static_cast<size_t>(group - groups.begin());
  return index < bottoms_.size() ? bottoms_[index].address()
                                 : deforming_[index - bottoms_.size()].address();
}

Status HardwareScene::Update() {
  for (size_t i = 0; i < scene_.placed_count(); ++i) {
    const Placement& placement = scene_.placements()[i];
    Instance instance = {};
    instance.transform = TransformOf(scene_, placement);
    instance.instanceCustomIndex = static_cast<uint32_t>(i) & 0xffffffu;
    instance.mask = 0xff;
    instance.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
    instance.accelerationStructureReference = BottomOf(placement);
    std::memcpy(static_cast<char*>(staging_->mapped) + i * sizeof(Instance), &instance,
                sizeof(Instance));
  }
  return arena_.Flush();
}

void HardwareScene::RecordUpdate(VkCommandBuffer commands) const {
  const gpu::DeviceContext& c = device_->context();
  const auto count = static_cast<uint32_t>(scene_.placed_count());
  constexpr VkPipelineStageFlags kBuild = VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
  gpu::MemoryBarrier(c, commands, kBuild, 0, VK_PIPELINE_STAGE_TRANSFER_BIT, 0);
  if (count > 0) {
    const VkBufferCopy region = {0, 0, count * sizeof(Instance)};
    c.vk.CmdCopyBuffer(commands, staging_->buffer, instances_->buffer, 1, &region);
  }
  gpu::MemoryBarrier(
      c, commands,
      VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_RAY_TRACING_SHADER_BIT_KHR | kBuild,
      VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR, kBuild,
      VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
          VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR);
  RecordDeforming(commands);
  Build top;
  DescribeTop(instances_->address, count, &top);
  top.Record(c, commands, top_, *scratch_);
  gpu::MemoryBarrier(c, commands, kBuild, VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
                     VK_PIPELINE_STAGE_RAY_TRACING_SHADER_BIT_KHR,
                     VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR);
}

gpu::MemoryUse HardwareScene::memory() const {
  gpu::MemoryUse use = arena_.Need();
  use += bottom_arena_.Need();
  use += deforming_arena_.Need();
  return use;
}

}  // namespace stillray::render
