// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/shared_imports.h"

#include <unistd.h>

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GL/gl.h>
#include <GL/glext.h>
#include <GLFW/glfw3.h>
#include <fmt/format.h>

namespace stillray::view {

#define STILLRAY_GL_FUNCTIONS(X)                             \
  X(PFNGLGENBUFFERSPROC, GenBuffers)                         \
  X(PFNGLBINDBUFFERPROC, BindBuffer)                         \
  X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                   \
  X(PFNGLFENCESYNCPROC, FenceSync)                           \
  X(PFNGLCLIENTWAITSYNCPROC, ClientWaitSync)                 \
  X(PFNGLDELETESYNCPROC, DeleteSync)                         \
  X(PFNGLGETUNSIGNEDBYTEVEXTPROC, GetUnsignedBytevEXT)       \
  X(PFNGLGETUNSIGNEDBYTEI_VEXTPROC, GetUnsignedBytei_vEXT)   \
  X(PFNGLCREATEMEMORYOBJECTSEXTPROC, CreateMemoryObjectsEXT) \
  X(PFNGLDELETEMEMORYOBJECTSEXTPROC, DeleteMemoryObjectsEXT) \
  X(PFNGLIMPORTMEMORYFDEXTPROC, ImportMemoryFdEXT)           \
  X(PFNGLBUFFERSTORAGEMEMEXTPROC, BufferStorageMemEXT)

/// Functions of OpenGL 3.3 and of the extensions; loaded at run time, since not all drivers support
/// the extensions.
struct SharedImports::Functions {
#define STILLRAY_GL_MEMBER_(type, name) type name = nullptr;
  STILLRAY_GL_FUNCTIONS(STILLRAY_GL_MEMBER_)
#undef STILLRAY_GL_MEMBER_
};

namespace {

void ForgetErrors() {
  while (glGetError() != GL_NO_ERROR) {
  }
}

Status Failed(const char* action) {
  const GLenum error = glGetError();
  return error == GL_NO_ERROR
             ? Status::Ok()
             : Status::Unsupported(fmt::format("OpenGL: {}: error {:#x}", action, error));
}

}  // namespace

SharedImports::SharedImports(std::unique_ptr<Functions> functions) : gl_(std::move(functions)) {}

Result<std::unique_ptr<SharedImports>> SharedImports::Create() {
  for (const char* extension : {"GL_EXT_memory_object", "GL_EXT_memory_object_fd"}) {
    if (glfwExtensionSupported(extension) != GLFW_TRUE) {
      return Status::Unsupported(fmt::format("OpenGL lacks {}", extension));
    }
  }
  auto functions = std::make_unique<Functions>();
#define STILLRAY_GL_LOAD_(type, name)                                       \
  functions->name = reinterpret_cast<type>(glfwGetProcAddress("gl" #name)); \
  if (functions->name == nullptr) {                                         \
    return Status::Unsupported("OpenGL lacks gl" #name);                    \
  }
  STILLRAY_GL_FUNCTIONS(STILLRAY_GL_LOAD_)
#undef STILLRAY_GL_LOAD_
  return std::unique_ptr<SharedImports>(new SharedImports(std::move(functions)));
}

SharedImports::~SharedImports() {
  for (const Copy& copy : copies_) {
    gl_->DeleteSync(static_cast<GLsync>(copy.done));
  }
  for (const Imported& imported : imports_) {
    Delete(imported);
  }
}

void SharedImports::Delete(const Imported& imported) const {
  gl_->DeleteBuffers(1, &imported.buffer);
  gl_->DeleteMemoryObjectsEXT(1, &imported.memory);
}

bool SharedImports::IsOnThisDevice(const SharedPicture& picture) const {
  SharedPicture::Uuid driver = {};
  gl_->GetUnsignedBytevEXT(GL_DRIVER_UUID_EXT, driver.data());
  GLint devices = 0;
  glGetIntegerv(GL_NUM_DEVICE_UUIDS_EXT, &devices);
  for (GLint i = 0; i < devices; ++i) {
    SharedPicture::Uuid device = {};
    gl_->GetUnsignedBytei_vEXT(GL_DEVICE_UUID_EXT, static_cast<GLuint>(i), device.data());
    if (device == picture.device_uuid() && driver == picture.driver_uuid()) {
      return true;
    }
  }
  return false;
}

Status SharedImports::Make(const SharedPicture& picture, Imported* imported) const {
  if (!IsOnThisDevice(picture)) {
    return Status::Unsupported("OpenGL draws on another device, or by another driver");
  }
  const Result<int> descriptor = picture.Export();
  STILLRAY_RETURN_IF_ERROR(descriptor.status());
  ForgetErrors();
  gl_->CreateMemoryObjectsEXT(1, &imported->memory);
  gl_->ImportMemoryFdEXT(imported->memory, picture.memory_bytes(), GL_HANDLE_TYPE_OPAQUE_FD_EXT,
                         *descriptor);
  if (const Status status = Failed("importing shared memory"); !status.ok()) {
    close(*descriptor);  // owned by the import after success
    return status;
  }
  const auto bytes = static_cast<GLsizeiptr>(picture.width()) * picture.height() * 4;
  gl_->GenBuffers(1, &imported->buffer);
  gl_->BindBuffer(GL_PIXEL_UNPACK_BUFFER, imported->buffer);
  gl_->BufferStorageMemEXT(GL_PIXEL_UNPACK_BUFFER, bytes, imported->memory, 0);
  gl_->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  return Failed("using shared memory as a buffer");
}

const SharedImports::Imported* SharedImports::Find(
    const std::shared_ptr<const SharedPicture>& picture) const {
  for (const Imported& imported : imports_) {
    if (imported.picture.lock() == picture) {
      return &imported;
    }
  }
  return nullptr;
}

Status SharedImports::Import(const std::shared_ptr<const SharedPicture>& picture) {
  LetGo();
  if (Find(picture) != nullptr) {
    return Status::Ok();
  }
  Imported imported;
  imported.picture = picture;
  if (const Status made = Make(*picture, &imported); !made.ok()) {
    Delete(imported);
    return made;
  }
  imports_.push_back(imported);
  return Status::Ok();
}

void SharedImports::LetGo() {
  while (!copies_.empty()) {
    const auto done = static_cast<GLsync>(copies_.front().done);
    if (gl_->ClientWaitSync(done, 0, 0) == GL_TIMEOUT_EXPIRED) {
      break;
    }
    gl_->DeleteSync(done);
    copies_.pop_front();
  }
  std::erase_if(imports_, [this](const Imported& imported) {
    const bool over = imported.picture.expired();
    if (over) {
      Delete(imported);
    }
    return over;
  });
}

Status SharedImports::CopyToTexture(const std::shared_ptr<const SharedPicture>& picture) {
  const Imported* imported = Find(picture);
  if (imported == nullptr) {
    return Status::Internal("OpenGL: a picture was not imported");
  }
  ForgetErrors();
  gl_->BindBuffer(GL_PIXEL_UNPACK_BUFFER, imported->buffer);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, picture->width(), picture->height(), GL_RGBA,
                  GL_UNSIGNED_BYTE, nullptr);
  gl_->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  STILLRAY_RETURN_IF_ERROR(Failed("copying from shared memory"));
  copies_.push_back({picture, gl_->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0)});
  return Status::Ok();
}

}  // namespace stillray::view
