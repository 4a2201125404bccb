// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/spirv_interface.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

namespace stillray::gpu {
namespace spirv {
namespace {

// Numbers of the SPIR-V specification, sections "Instructions", "Decoration", "Storage Class",
// "Image Format" and "Execution Mode".
enum Op : uint32_t {
  kOpEntryPoint = 15,
  kOpExecutionMode = 16,
  kOpTypeBool = 20,
  kOpTypeInt = 21,
  kOpTypeFloat = 22,
  kOpTypeVector = 23,
  kOpTypeMatrix = 24,
  kOpTypeImage = 25,
  kOpTypeArray = 28,
  kOpTypeRuntimeArray = 29,
  kOpTypeStruct = 30,
  kOpTypePointer = 32,
  kOpConstantTrue = 41,
  kOpConstantFalse = 42,
  kOpConstant = 43,
  kOpSpecConstantTrue = 48,
  kOpSpecConstantFalse = 49,
  kOpSpecConstant = 50,
  kOpSpecConstantOp = 52,
  kOpFunction = 54,
  kOpFunctionEnd = 56,
  kOpFunctionCall = 57,
  kOpVariable = 59,
  kOpLoad = 61,
  kOpStore = 62,
  kOpAccessChain = 65,
  kOpInBoundsAccessChain = 66,
  kOpArrayLength = 68,
  kOpDecorate = 71,
  kOpMemberDecorate = 72,
  kOpImageRead = 98,
  kOpImageWrite = 99,
  kOpBitcast = 124,
  kOpIAdd = 128,
  kOpISub = 130,
  kOpIMul = 132,
  kOpUDiv = 134,
  kOpSDiv = 135,
  kOpUMod = 137,
  kOpSRem = 138,
  kOpSMod = 139,
  kOpLogicalOr = 166,
  kOpLogicalAnd = 167,
  kOpLogicalNot = 168,
  kOpSelect = 169,
  kOpIEqual = 170,
  kOpINotEqual = 171,
  kOpUGreaterThan = 172,
  kOpSGreaterThan = 173,
  kOpUGreaterThanEqual = 174,
  kOpSGreaterThanEqual = 175,
  kOpULessThan = 176,
  kOpSLessThan = 177,
  kOpULessThanEqual = 178,
  kOpSLessThanEqual = 179,
  kOpShiftRightLogical = 194,
  kOpShiftLeftLogical = 196,
  kOpBitwiseOr = 197,
  kOpBitwiseAnd = 199,
  kOpAtomicFirst = 227,  // OpAtomicLoad
  kOpAtomicLast = 242,   // OpAtomicXor
};
constexpr uint32_t kLocalSize = 17;
constexpr uint32_t kSpecId = 1;
constexpr uint32_t kArrayStride = 6;
constexpr uint32_t kNonWritable = 24;
constexpr uint32_t kNonReadable = 25;
constexpr uint32_t kBinding = 33;
constexpr uint32_t kDescriptorSet = 34;
constexpr uint32_t kOffset = 35;
constexpr uint32_t kUniformConstant = 0;
constexpr uint32_t kUniform = 2;
constexpr uint32_t kWorkgroup = 4;
constexpr uint32_t kPushConstant = 9;
constexpr uint32_t kStorageBuffer = 12;
constexpr uint32_t kStorageImage = 2;  // the operand "Sampled" of OpTypeImage
constexpr size_t kHeaderWords = 5;

const char* FormatName(uint32_t format) {
  static constexpr const char* kNames[] = {"",          "rgba32f",      "rgba16f",
                                           "r32f",      "rgba8",        "rgba8_snorm",
                                           "rg32f",     "rg16f",        "r11f_g11f_b10f",
                                           "r16f",      "rgba16",       "rgb10_a2",
                                           "rg16",      "rg8",          "r16",
                                           "r8",        "rgba16_snorm", "rg16_snorm",
                                           "rg8_snorm", "r16_snorm",    "r8_snorm",
                                           "rgba32i",   "rgba16i",      "rgba8i",
                                           "r32i",      "rg32i",        "rg16i",
                                           "rg8i",      "r16i",         "r8i",
                                           "rgba32ui",  "rgba16ui",     "rgba8ui",
                                           "r32ui",     "rgb10_a2ui",   "rg32ui",
                                           "rg16ui",    "rg8ui",        "r16ui",
                                           "r8ui"};
  return format < std::size(kNames) ? kNames[format] : "unknown";
}

/// An instruction without its first word.
struct Instruction {
  uint32_t op = 0;
  std::span<const uint32_t> operands;
};

/// Index of the operand that is the instruction's result id, or 0.
uint32_t ResultOf(const Instruction& i) {
  switch (i.op) {
    case kOpTypeBool:
    case kOpTypeInt:
    case kOpTypeFloat:
    case kOpTypeVector:
    case kOpTypeMatrix:
    case kOpTypeImage:
    case kOpTypeArray:
    case kOpTypeRuntimeArray:
    case kOpTypeStruct:
    case kOpTypePointer:
      return i.operands[0];
    case kOpConstantTrue:
    case kOpConstantFalse:
    case kOpConstant:
    case kOpSpecConstantTrue:
    case kOpSpecConstantFalse:
    case kOpSpecConstant:
    case kOpSpecConstantOp:
    case kOpVariable:
      return i.operands[1];
    default:
      return 0;
  }
}

/// Minimum number of operands of an instruction.
size_t LeastOperands(uint32_t op) {
  switch (op) {
    case kOpTypeBool:
    case kOpTypeStruct:
      return 1;
    case kOpTypeInt:
    case kOpTypeVector:
    case kOpTypeMatrix:
    case kOpTypeArray:
    case kOpTypePointer:
    case kOpVariable:
    case kOpConstant:
    case kOpSpecConstant:
    case kOpSpecConstantOp:
    case kOpFunctionCall:
    case kOpLoad:
    case kOpAccessChain:
    case kOpInBoundsAccessChain:
    case kOpArrayLength:
      return 3;
    case kOpTypeImage:
      return 8;
    case kOpTypeFloat:
    case kOpTypeRuntimeArray:
    case kOpConstantTrue:
    case kOpConstantFalse:
    case kOpSpecConstantTrue:
    case kOpSpecConstantFalse:
    case kOpFunction:
    case kOpStore:
    case kOpEntryPoint:
    case kOpDecorate:
    case kOpExecutionMode:
      return 2;
    case kOpMemberDecorate:
      return 3;
    default:
      return 0;
  }
}

class Module {
 public:
  Module(std::span<const uint32_t> code, const std::map<uint32_t, uint32_t>& constants)
      : code_(code), given_(constants) {}

  Result<ShaderInterface> Read() {
    STILLRAY_RETURN_IF_ERROR(ReadInstructions());
    ShaderInterface interface;
    interface.local_size = local_size_;
    FollowCalls(entry_);
    for (const auto& [id, variable] : variables_) {
      AddVariable(id, variable, &interface);
    }
    for (const auto& [id, number] : spec_ids_) {
      AddConstant(id, number, &interface);
    }
    const auto by_place = [](const ShaderBinding& b) { return std::pair(b.set, b.binding); };
    std::ranges::sort(interface.bindings, {}, by_place);
    std::ranges::sort(interface.constants, {}, &SpecialisationConstant::id);
    return status_.ok() ? Result<ShaderInterface>(std::move(interface))
                        : Result<ShaderInterface>(status_);
  }

 private:
  struct Variable {
    uint32_t type = 0;  ///< id of the pointer type
    uint32_t storage = 0;
  };
  /// Module variables used by a function, and its calls.
  struct Function {
    std::set<uint32_t> calls;
    std::set<uint32_t> uses;
    std::set<uint32_t> reads;
    std::set<uint32_t> writes;
  };

  void Fail(const std::string& what) {
    if (status_.ok()) {
      status_ = Status::BadData("SPIR-V: " + what);
    }
  }

  Status ReadInstructions() {
    constexpr uint32_t kMagic = 0x07230203;
    if (code_.size() <= kHeaderWords || code_[0] != kMagic) {
      return Status::BadData("SPIR-V: the module has no header");
    }
    for (size_t at = kHeaderWords; at < code_.size();) {
      const size_t length = code_[at] >> 16;
      const uint32_t op = code_[at] & 0xffffu;
      if (length == 0 || length > code_.size() - at || length - 1 < LeastOperands(op)) {
        return Status::BadData(fmt::format(
            "SPIR-V: the instruction {} at word {} has {} words, {} are left, expected {} or more",
            op, at, length, code_.size() - at, LeastOperands(op) + 1));
      }
      Take({op, code_.subspan(at + 1, length - 1)});
      at += length;
    }
    if (entry_ == 0) {
      return Status::BadData("SPIR-V: the module has no entry point");
    }
    return Status::Ok();
  }

  void Take(const Instruction& i) {
    const uint32_t made = ResultOf(i);
    if (made != 0) {
      by_id_[made] = i;
    }
    const auto o = i.operands;
    switch (i.op) {
      case kOpEntryPoint:
        entry_ = o[1];
        break;
      case kOpExecutionMode:
        if (o[1] == kLocalSize && o.size() >= 5) {
          local_size_ = {o[2], o[3], o[4]};
        }
        break;
      case kOpDecorate:
        TakeDecoration(o);
        break;
      case kOpMemberDecorate:
        if (o[2] == kOffset && o.size() >= 4) {
          offsets_[{o[0], o[1]}] = o[3];
        }
        break;
      case kOpFunction:
        function_ = o.size() >= 2 ? o[1] : 0;
        break;
      case kOpFunctionEnd:
        function_ = 0;
        break;
      case kOpVariable:
        if (function_ == 0) {
          variables_[o[1]] = {o[0], o[2]};
        }
        break;
      default:
        if (function_ != 0) {
          TakeUse(i);
        }
    }
  }

  void TakeDecoration(std::span<const uint32_t> o) {
    if (o[1] == kNonWritable || o[1] == kNonReadable) {
      (o[1] == kNonWritable ? not_written_ : not_read_).insert(o[0]);
    }
    if (o.size() < 3) {
      return;
    }
    switch (o[1]) {
      case kSpecId:
        spec_ids_[o[0]] = o[2];
        break;
      case kBinding:
        bindings_[o[0]] = o[2];
        break;
      case kDescriptorSet:
        sets_[o[0]] = o[2];
        break;
      case kArrayStride:
        strides_[o[0]] = o[2];
        break;
      default:
        break;
    }
  }

  /// Processes an instruction of a function body. Images are loaded from their variable and blocks
  /// accessed through access chains: GLSL does not pass either to functions as pointers.
  void TakeUse(const Instruction& i) {
    Function& f = functions_[function_];
    const auto o = i.operands;
    const auto variable_of = [&](uint32_t id) {
      const auto found = base_.find(id);
      return found != base_.end() ? found->second : id;
    };
    const auto reads = [&](uint32_t id) { f.reads.insert(variable_of(id)); };
    const auto writes = [&](uint32_t id) { f.writes.insert(variable_of(id)); };
    switch (i.op) {
      case kOpFunctionCall:
        f.calls.insert(o[2]);
        f.uses.insert(o.begin() + 3, o.end());
        passed_.insert(o.begin() + 3, o.end());
        break;
      case kOpAccessChain:
      case kOpInBoundsAccessChain:
        base_[o[1]] = variable_of(o[2]);
        f.uses.insert(variable_of(o[2]));
        break;
      case kOpLoad:
        base_[o[1]] = variable_of(o[2]);  // variable of an image
        f.uses.insert(variable_of(o[2]));
        reads(o[2]);
        break;
      case kOpArrayLength:
        f.uses.insert(variable_of(o[2]));
        break;
      case kOpStore:
        f.uses.insert(variable_of(o[0]));
        writes(o[0]);
        break;
      case kOpImageWrite:
        image_writes_.insert(variable_of(o[0]));
        break;
      case kOpImageRead:
        image_reads_.insert(o.size() > 2 ? variable_of(o[2]) : 0);
        break;
      default:
        if (i.op >= kOpAtomicFirst && i.op <= kOpAtomicLast) {
          // OpAtomicStore is the only atomic without a result.
          constexpr uint32_t kOpAtomicStore = 228;
          const uint32_t pointer = i.op == kOpAtomicStore ? o[0] : o.size() > 2 ? o[2] : 0;
          reads(pointer);
          writes(pointer);
        }
    }
  }

  void FollowCalls(uint32_t function) {
    if (!reached_.insert(function).second) {
      return;
    }
    const Function& f = functions_[function];
    used_.insert(f.uses.begin(), f.uses.end());
    read_.insert(f.reads.begin(), f.reads.end());
    written_.insert(f.writes.begin(), f.writes.end());
    for (const uint32_t called : f.calls) {
      FollowCalls(called);
    }
  }

  const Instruction& Find(uint32_t id) {
    static const Instruction kNone;
    const auto found = by_id_.find(id);
    if (found == by_id_.end()) {
      Fail(fmt::format("id {} is not defined", id));
      return kNone;
    }
    return found->second;
  }

  /// The value of a 32-bit constant.
  uint32_t ValueOf(uint32_t id) {
    const auto spec = spec_ids_.find(id);
    if (spec != spec_ids_.end()) {
      const auto given = given_.find(spec->second);
      if (given != given_.end()) {
        return given->second;
      }
    }
    const Instruction& i = Find(id);
    switch (i.op) {
      case kOpConstantTrue:
      case kOpSpecConstantTrue:
        return 1;
      case kOpConstantFalse:
      case kOpSpecConstantFalse:
        return 0;
      case kOpConstant:
      case kOpSpecConstant:
        return i.operands[2];
      case kOpSpecConstantOp:
        return ValueOfOperation(i.operands);
      default:
        Fail(fmt::format("id {} is no constant", id));
        return 0;
    }
  }

  uint32_t ValueOfOperation(std::span<const uint32_t> o) {
    const uint32_t op = o[2];
    const bool has_one = op == kOpLogicalNot || op == kOpBitcast;
    const size_t operands = op == kOpSelect ? 3 : has_one ? 1 : 2;
    if (o.size() != 3 + operands) {
      Fail(fmt::format("operation {} on constants is not known", op));
      return 0;
    }
    const uint32_t a = ValueOf(o[3]);
    if (has_one) {
      return op == kOpBitcast ? a : a == 0 ? 1 : 0;
    }
    const uint32_t b = ValueOf(o[4]);
    return op == kOpSelect ? (a != 0 ? b : ValueOf(o[5])) : ValueOfTwo(op, a, b);
  }

  uint32_t ValueOfTwo(uint32_t op, uint32_t a, uint32_t b) {
    const auto x = static_cast<int32_t>(a);
    const auto y = static_cast<int32_t>(b);
    const bool divides = op >= kOpUDiv && op <= kOpSMod;
    if (divides && b == 0) {
      Fail("a division of constants by zero");
      return 0;
    }
    switch (op) {
      case kOpIAdd:
        return a + b;
      case kOpISub:
        return a - b;
      case kOpIMul:
        return a * b;
      case kOpUDiv:
        return a / b;
      case kOpSDiv:
        return static_cast<uint32_t>(x / y);
      case kOpUMod:
        return a % b;
      case kOpSRem:
        return static_cast<uint32_t>(x % y);
      case kOpSMod:  // result has the sign of the divisor
        return static_cast<uint32_t>(((x % y) + y) % y);
      case kOpShiftRightLogical:
        return b < 32 ? a >> b : 0;
      case kOpShiftLeftLogical:
        return b < 32 ? a << b : 0;
      case kOpBitwiseOr:
      case kOpLogicalOr:
        return a | b;
      case kOpBitwiseAnd:
      case kOpLogicalAnd:
        return a & b;
      default:
        return ValueOfComparison(op, a, b) ? 1 : 0;
    }
  }

  bool ValueOfComparison(uint32_t op, uint32_t a, uint32_t b) {
    const auto x = static_cast<int32_t>(a);
    const auto y = static_cast<int32_t>(b);
    switch (op) {
      case kOpIEqual:
        return a == b;
      case kOpINotEqual:
        return a != b;
      case kOpUGreaterThan:
        return a > b;
      case kOpSGreaterThan:
        return x > y;
      case kOpUGreaterThanEqual:
        return a >= b;
      case kOpSGreaterThanEqual:
        return x >= y;
      case kOpULessThan:
        return a < b;
      case kOpSLessThan:
        return x < y;
      case kOpULessThanEqual:
        return a <= b;
      case kOpSLessThanEqual:
        return x <= y;
      default:
        Fail(fmt::format("operation {} on constants is not known", op));
        return false;
    }
  }

  std::string TypeName(uint32_t type) {
    const Instruction& i = Find(type);
    const auto o = i.operands;
    switch (i.op) {
      case kOpTypeBool:
        return "bool";
      case kOpTypeInt:
        return o[2] != 0 ? "int" : "uint";
      case kOpTypeFloat:
        return "float";
      case kOpTypeVector: {
        const std::string of = TypeName(o[1]);
        const std::string prefix = of == "float" ? "" : of.substr(0, 1);
        return fmt::format("{}vec{}", prefix, o[2]);
      }
      case kOpTypeArray:
        return fmt::format("{}[{}]", TypeName(o[1]), ValueOf(o[2]));
      case kOpTypeRuntimeArray:
        return TypeName(o[1]) + "[]";
      case kOpTypeStruct:
        return "struct";
      default:
        Fail(fmt::format("a block has a member of type {}, expected numbers and structures", i.op));
        return "";
    }
  }

  /// Size of a type in bytes; arrays in blocks use their stride.
  uint32_t BytesOf(uint32_t type) {
    const Instruction& i = Find(type);
    const auto o = i.operands;
    switch (i.op) {
      case kOpTypeBool:
        return 4;
      case kOpTypeInt:
      case kOpTypeFloat:
        return o[1] / 8;
      case kOpTypeVector:
        return BytesOf(o[1]) * o[2];
      case kOpTypeArray: {
        const auto stride = strides_.find(type);
        return ValueOf(o[2]) * (stride != strides_.end() ? stride->second : BytesOf(o[1]));
      }
      case kOpTypeStruct: {
        uint32_t bytes = 0;
        for (uint32_t k = 0; k + 1 < o.size(); ++k) {
          const auto offset = offsets_.find({type, k});
          bytes = (offset != offsets_.end() ? offset->second : bytes) + BytesOf(o[k + 1]);
        }
        return bytes;
      }
      default:
        return 0;
    }
  }

  void AddMembers(uint32_t type, uint32_t start, const std::vector<uint32_t>& path,
                  std::vector<BlockMember>* members) {
    const Instruction& i = Find(type);
    if (i.op != kOpTypeStruct) {
      Fail("a block is no structure");
      return;
    }
    for (uint32_t k = 0; k + 1 < i.operands.size(); ++k) {
      const uint32_t of_member = i.operands[k + 1];
      const uint32_t offset = start + offsets_[{type, k}];
      std::vector<uint32_t> place = path;
      place.push_back(k);
      if (Find(of_member).op == kOpTypeStruct) {
        AddMembers(of_member, offset, place, members);
      } else {
        members->push_back({place, TypeName(of_member), offset, BytesOf(of_member)});
      }
    }
  }

  void AddVariable(uint32_t id, const Variable& variable, ShaderInterface* interface) {
    const Instruction& pointer = Find(variable.type);
    if (pointer.op != kOpTypePointer) {
      Fail(fmt::format("the variable {} has no type", id));
      return;
    }
    const uint32_t type = pointer.operands[2];
    if (variable.storage == kWorkgroup && used_.contains(id)) {
      interface->shared_bytes += BytesOf(type);
    } else if (variable.storage == kPushConstant) {
      AddMembers(type, 0, {}, &interface->push);
    }
    const auto binding = bindings_.find(id);
    if (binding == bindings_.end() || !used_.contains(id)) {
      return;
    }
    ShaderBinding b;
    b.set = sets_[id];
    b.binding = binding->second;
    if (variable.storage == kUniformConstant) {
      DescribeImage(id, type, &b);
    } else if (variable.storage == kUniform || variable.storage == kStorageBuffer) {
      b.kind =
          variable.storage == kUniform ? BindingKind::kUniformBlock : BindingKind::kStorageBlock;
      b.reads = read_.contains(id);
      b.writes = written_.contains(id);
      AddMembers(type, 0, {}, &b.members);
    } else {
      Fail(fmt::format("the binding {} of set {} is of storage class {}", b.binding, b.set,
                       variable.storage));
    }
    interface->bindings.push_back(std::move(b));
  }

  void DescribeImage(uint32_t id, uint32_t type, ShaderBinding* b) {
    const Instruction& image = Find(type);
    if (image.op != kOpTypeImage) {
      Fail(fmt::format("the binding {} of set {} is no image", b->binding, b->set));
      return;
    }
    b->kind = image.operands[6] == kStorageImage ? BindingKind::kStorageImage
                                                 : BindingKind::kSampledImage;
    b->texels = TypeName(image.operands[1]);
    b->is_array = image.operands[4] != 0;
    b->format = FormatName(image.operands[7]);
    const bool passed = b->kind == BindingKind::kStorageImage && passed_.contains(id);
    b->reads = b->kind == BindingKind::kSampledImage || image_reads_.contains(id) ||
               (passed && !not_read_.contains(id));
    b->writes = image_writes_.contains(id) || (passed && !not_written_.contains(id));
  }

  void AddConstant(uint32_t id, uint32_t number, ShaderInterface* interface) {
    const Instruction& i = Find(id);
    uint32_t value = 0;
    if (i.op == kOpSpecConstantTrue || i.op == kOpSpecConstantFalse) {
      value = i.op == kOpSpecConstantTrue ? 1 : 0;
    } else if (i.op == kOpSpecConstant) {
      value = i.operands[2];
    } else {
      Fail(fmt::format("the specialisation constant {} has no value", number));
      return;
    }
    interface->constants.push_back({number, TypeName(i.operands[0]), value});
  }

  std::span<const uint32_t> code_;
  const std::map<uint32_t, uint32_t>& given_;
  Status status_;
  std::map<uint32_t, Instruction> by_id_;
  std::map<uint32_t, Variable> variables_;
  std::map<uint32_t, uint32_t> spec_ids_, bindings_, sets_, strides_;
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> offsets_;
  /// Variables from which pointers and loaded images are derived.
  std::map<uint32_t, uint32_t> base_;
  std::map<uint32_t, Function> functions_;
  std::set<uint32_t> image_reads_, image_writes_;
  std::set<uint32_t> passed_;  ///< variables passed to functions
  std::set<uint32_t> not_read_, not_written_;
  std::set<uint32_t> reached_, used_, read_, written_;
  uint32_t function_ = 0;  ///< function being processed
  uint32_t entry_ = 0;
  std::array<uint32_t, 3> local_size_ = {1, 1, 1};
};

}  // namespace
}  // namespace spirv

Result<ShaderInterface> ReadInterface(std::span<const uint32_t> code,
                                      const std::map<uint32_t, uint32_t>& constants) {
  return spirv::Module(code, constants).Read();
}

}  // namespace stillray::gpu
