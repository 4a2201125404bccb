// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The table of the shaders, from their code, the names in their sources and the layouts of their
// descriptor sets.
#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/check.h"
#include "denoise/shader_pack.h"
#include "denoise/vulkan/layer_passes.h"
#include "denoise/vulkan/shader_names.h"
#include "denoise/vulkan/shaders.h"
#include "gpu/shader_folder.h"
#include "gpu/spirv_interface.h"

namespace stillray {
namespace vulkan::shader_table {
namespace {

const char* KindName(gpu::BindingKind kind) {
  switch (kind) {
    case gpu::BindingKind::kSampledImage:
      return "sampled_image";
    case gpu::BindingKind::kStorageImage:
      return "storage_image";
    case gpu::BindingKind::kUniformBlock:
      return "uniform_buffer";
    case gpu::BindingKind::kStorageBlock:
      return "storage_buffer";
  }
  return "";
}

PackSet SetOf(const gpu::SetShape& shape) {
  return {shape.sampled, shape.stored, shape.uniforms, shape.buffers};
}

/// Describes shaders one by one.
class Table {
 public:
  /// \param base  the name without precision
  Status Add(const std::string& base, PackedShader shader) {
    const Result<gpu::ShaderInterface> read = gpu::ReadInterface(shader.code);
    if (!read.ok()) {
      return Status::Internal(
          fmt::format("the shader {}: {}", shader.name, read.status().message()));
    }
    base_ = base;
    shader.local_size = read->local_size;
    shader.shared_bytes = read->shared_bytes;
    shader.push = MembersOf(names_.PushBlock(base), read->push, names_.FileOf(base));
    for (const gpu::SpecialisationConstant& c : read->constants) {
      const std::string name = names_.Constant(base, c.id);
      shader.constants.push_back({c.id, name, c.type, c.value, NoteOf(name)});
    }
    for (const gpu::ShaderBinding& b : read->bindings) {
      shader.bindings.push_back(Describe(b));
    }
    table_.shaders.push_back(std::move(shader));
    return Status::Ok();
  }

  ShaderTable Take() { return std::move(table_); }

 private:
  /// The note of a declaration in the shader's file, or in common.glsl.
  std::string NoteOf(const std::string& name) const {
    const std::string note = names_.Note(names_.FileOf(base_), name);
    return note.empty() ? names_.Note("common", name) : note;
  }

  /// \param where  where notes on members of the block itself are stored; empty: its name
  std::vector<PackMember> MembersOf(const std::string& structure,
                                    const std::vector<gpu::BlockMember>& members,
                                    const std::string& where) const {
    std::vector<PackMember> named;
    for (const gpu::BlockMember& m : members) {
      const ShaderNames::Member of = names_.MemberAt(base_, structure, m.path);
      const std::string own = of.name.substr(of.name.rfind('.') + 1);
      const bool outer = m.path.size() == 1 && !where.empty();
      named.push_back(
          {of.name, m.type, m.offset, m.bytes, names_.Note(outer ? where : of.block, own)});
    }
    return named;
  }

  PackBinding Describe(const gpu::ShaderBinding& b) {
    PackBinding described;
    described.set = b.set;
    described.binding = b.binding;
    described.kind = KindName(b.kind);
    described.reads = b.reads;
    described.writes = b.writes;
    if (b.kind == gpu::BindingKind::kUniformBlock || b.kind == gpu::BindingKind::kStorageBlock) {
      const std::string structure = names_.BlockAt(base_, b.set, b.binding);
      described.name = AddBlock(structure, MembersOf(structure, b.members, ""));
      return described;
    }
    described.name = names_.ImageAt(base_, b.set, b.binding);
    described.note = NoteOf(described.name);
    described.texels = b.texels;
    described.format = b.format;
    described.is_array = b.is_array;
    return described;
  }

  std::string AddBlock(const std::string& name, std::vector<PackMember> members) {
    const auto known = std::ranges::find(table_.blocks, name, &PackBlock::name);
    if (known == table_.blocks.end()) {
      table_.blocks.push_back({name, std::move(members)});
    } else {
      STILLRAY_CHECK(known->members == members);
    }
    return name;
  }

  const ShaderNames& names_ = ShaderNames::Get();
  std::string base_;
  ShaderTable table_;
};

/// A shader for a precision and a format of normals.
Status AddVariant(Shader shader, Storage storage, bool octahedral, Table* table) {
  const bool usual = octahedral == PacksNormalsByDefault(storage);
  const std::span<const uint32_t> code = CodeOf(shader, storage, octahedral);
  const bool of_both = CodeOf(shader, storage, !octahedral).data() == code.data();
  if (of_both && !usual) {
    return Status::Ok();  // already added
  }
  const ShaderInfo& info = InfoOf(shader);
  PackedShader packed;
  packed.name = gpu::EmbeddedNameOf(code);
  packed.stage = info.stage;
  packed.precision = storage == Storage::kHalf ? "half" : "float";
  packed.normals = of_both ? "any" : octahedral ? "octahedral" : "plain";
  packed.code = code;
  packed.push_bytes = info.push_bytes;
  packed.sets = {SetOf(kFrameSet), SetOf(OwnSet(info))};
  return table->Add(NameOf(shader), std::move(packed));
}

}  // namespace
}  // namespace vulkan::shader_table

Result<ShaderTable> MakeShaderTable() {
  using namespace vulkan;
  const std::vector<std::string> replaced = gpu::ReplacedShaders();
  if (!replaced.empty()) {
    return Status::InvalidArgument(
        fmt::format("{} replaces shaders ({}): a pack has those of the program, unset it",
                    gpu::kShaderFolderVariable, fmt::join(replaced, ", ")));
  }
  shader_table::Table table;
  for (size_t i = 0; i < ShaderCount(); ++i) {
    for (const Storage storage : {Storage::kHalf, Storage::kFloat}) {
      for (const bool octahedral : {true, false}) {
        STILLRAY_RETURN_IF_ERROR(
            shader_table::AddVariant(static_cast<Shader>(i), storage, octahedral, &table));
      }
    }
  }
  for (const LayerShader& shader : LayerShaders()) {
    PackedShader packed;
    packed.name = gpu::EmbeddedNameOf(shader.code);
    packed.stage = shader.stage;
    packed.precision = "any";
    packed.normals = "any";
    packed.code = shader.code;
    packed.push_bytes = shader.push_bytes;
    packed.sets = {{shader.reads, shader.writes, 0, 0}};
    const std::string base = packed.name;
    STILLRAY_RETURN_IF_ERROR(table.Add(base, std::move(packed)));
  }
  return table.Take();
}

}  // namespace stillray
