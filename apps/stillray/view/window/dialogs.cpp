// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Path dialogs, the message box, and the list of keys.
#include <algorithm>
#include <filesystem>

#include <imgui.h>
#include <imgui_stdlib.h>

#include "core/lower_case.h"
#include "view/window/panels.h"
#include "view/window/settings_io.h"

namespace stillray::view {
namespace {

struct DialogText {
  const char* title;
  const char* prompt;
  const char* initial;
};

DialogText TextOf(Dialog dialog) {
  switch (dialog) {
    case Dialog::kOpenScene:
      return {"Open a scene", "A .gltf, .glb or .obj file, or builtin:NAME", ""};
    case Dialog::kOpenEnvironment:
      return {"Environment map", "An .hdr or .exr file around the scene; empty: that of the scene",
              ""};
    case Dialog::kSavePicture:
      return {"Save what is shown",
              ".png or .jpg as displayed, .exr with all numbers, .hdr with radiance",
              "stillray.png"};
    case Dialog::kRecordClip:
      return {"Record a clip", "A video (.mp4) of all frames until Ctrl+R", "stillray.mp4"};
    case Dialog::kLoadSettings:
      return {"Load settings", "A file of name=value lines", "stillray.settings"};
    case Dialog::kSaveSettings:
      return {"Save settings", "A file of name=value lines, for --settings", "stillray.settings"};
    case Dialog::kNone:
      break;
  }
  return {"", "", ""};
}

bool Writes(Dialog dialog) {
  return dialog == Dialog::kSavePicture || dialog == Dialog::kRecordClip ||
         dialog == Dialog::kSaveSettings;
}

/// Whether the question to overwrite the current path is shown.
bool AsksToOverwrite(const ViewerState& state) {
  return !state.dialog_path.empty() && state.overwrite_path == state.dialog_path;
}

/// A file is overwritten only after a second confirmation.
Status CheckOverwrite(ViewerState* state) {
  std::error_code ignored;
  if (!Writes(state->dialog) || AsksToOverwrite(*state) ||
      !std::filesystem::exists(state->dialog_path, ignored)) {
    return Status::Ok();
  }
  state->overwrite_path = state->dialog_path;
  return Status::InvalidArgument("'" + state->dialog_path + "' exists. Overwrite it?");
}

/// Executes the dialog's action. \return an error of the path if it is known immediately
Status Confirm(ViewEngine* engine, ViewerState* state) {
  const std::string& path = state->dialog_path;
  if (path.empty() && state->dialog != Dialog::kOpenEnvironment) {
    return Status::InvalidArgument("the path is empty");
  }
  STILLRAY_RETURN_IF_ERROR(CheckOverwrite(state));
  switch (state->dialog) {
    case Dialog::kOpenScene:
      state->request = {path, ""};
      engine->Open(state->request);
      break;
    case Dialog::kOpenEnvironment:
      state->request.environment = path;
      engine->Open(state->request);
      break;
    case Dialog::kSavePicture:
      engine->Save(path);
      break;
    case Dialog::kRecordClip:
      engine->StartClip(path, state->settings.fps);
      break;
    case Dialog::kLoadSettings:
      return LoadViewSettings(path, state);
    case Dialog::kSaveSettings:
      SaveViewSettings(path, *state, engine);
      break;
    case Dialog::kNone:
      break;
  }
  return Status::Ok();
}

void DrawPathDialog(ViewEngine* engine, ViewerState* state) {
  const DialogText text = TextOf(state->dialog);
  if (state->dialog_opening) {
    ImGui::OpenPopup(text.title);
    state->dialog_opening = false;
  }
  const ImVec2 middle = ImGui::GetMainViewport()->GetCenter();
  ImGui::SetNextWindowPos(middle, ImGuiCond_Appearing, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(35 * ImGui::GetFontSize(), middle.x * 2 - 20), 0});
  if (!ImGui::BeginPopupModal(text.title, nullptr, ImGuiWindowFlags_AlwaysAutoResize)) {
    return;
  }
  ImGui::TextUnformatted(text.prompt);
  if (ImGui::IsWindowAppearing()) {
    ImGui::SetKeyboardFocusHere();
  }
  ImGui::SetNextItemWidth(-1);
  bool confirmed =
      ImGui::InputText("##path", &state->dialog_path, ImGuiInputTextFlags_EnterReturnsTrue);
  if (!state->dialog_error.empty()) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextColored({1.0f, 0.45f, 0.4f, 1.0f}, "%s", state->dialog_error.c_str());
    ImGui::PopTextWrapPos();
  }
  const float em = ImGui::GetFontSize();
  // The question has taken the keyboard focus from the field; a held key is not an answer.
  confirmed |= AsksToOverwrite(*state) &&
               ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter), /*repeat=*/false);
  confirmed |= ImGui::Button(AsksToOverwrite(*state) ? "Overwrite##ok" : "OK##ok", {6 * em, 0});
  ImGui::SameLine();
  const bool cancelled = ImGui::Button("Cancel", {6 * em, 0}) ||
                         ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape));
  if (confirmed && !cancelled) {
    const Status status = Confirm(engine, state);
    state->dialog_error = status.message();
    confirmed = status.ok();
  }
  if (confirmed || cancelled) {
    ImGui::CloseCurrentPopup();
    state->dialog = Dialog::kNone;
  }
  ImGui::EndPopup();
}

void DrawMessageBox(ViewerState* state) {
  constexpr const char* kTitle = "Error";
  if (state->errors.empty()) {
    return;
  }
  if (!ImGui::IsPopupOpen(kTitle)) {
    ImGui::OpenPopup(kTitle);
  }
  const ImVec2 middle = ImGui::GetMainViewport()->GetCenter();
  ImGui::SetNextWindowPos(middle, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(37 * ImGui::GetFontSize(), middle.x * 2 - 20), 0});
  if (!ImGui::BeginPopupModal(kTitle, nullptr, ImGuiWindowFlags_AlwaysAutoResize)) {
    return;
  }
  for (const std::string& error : state->errors) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextUnformatted(error.c_str());
    ImGui::PopTextWrapPos();
    ImGui::Spacing();
  }
  if (ImGui::Button("OK", {6 * ImGui::GetFontSize(), 0}) ||
      ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape)) ||
      ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter))) {
    state->errors.clear();
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

void DrawHelp(ViewerState* state) {
  if (!state->show_help) {
    return;
  }
  static constexpr const char* kKeys[][2] = {
      {"left drag", "orbit"},
      {"right drag", "look around"},
      {"middle drag, Shift + left drag", "pan"},
      {"wheel", "nearer, farther; with Ctrl: angle of view"},
      {"click, double click", "orbit around what is there, turn to it"},
      {"W A S D, Q E", "fly; with Shift: faster"},
      {"Home", "the file's camera"},
      {"O", "camera on an orbit, or at rest"},
      {"1 ... 9, with Ctrl", "go to a saved view, save it"},
      {"Space", "play or pause"},
      {", .", "one frame back, forward"},
      {"Tab", "denoised; noisy | denoised; noisy | denoised | reference"},
      {"P", "next preset"},
      {"R", "reset accumulation"},
      {"I", "pixel inspector; pin and release the pixel"},
      {"Shift + I", "pixel inspector off"},
      {"F1, F2, F11", "this list, side panel, full screen"},
      {"Ctrl + O, S, R, Q", "open, save, record, quit"}};
  ImGui::SetNextWindowPos(ImGui::GetMainViewport()->GetCenter(), ImGuiCond_Appearing, {0.5f, 0.5f});
  if (ImGui::Begin("Keys and mouse", &state->show_help,
                   ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                       ImGuiWindowFlags_NoSavedSettings)) {
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit)) {
      for (const auto& key : kKeys) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(key[0]);
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(key[1]);
      }
      ImGui::EndTable();
    }
  }
  ImGui::End();
}

}  // namespace

void OpenDialog(Dialog dialog, ViewerState* state) {
  state->dialog = dialog;
  state->dialog_opening = true;
  state->dialog_error.clear();
  state->overwrite_path.clear();
  const std::string initial = TextOf(dialog).initial;
  state->dialog_path = dialog == Dialog::kOpenScene         ? state->request.scene
                       : dialog == Dialog::kOpenEnvironment ? state->request.environment
                                                            : initial;
}

void OpenDropped(const std::string& path, ViewEngine* engine, ViewerState* state) {
  const std::string extension = LowerExtension(path);
  if (extension == ".glb" || extension == ".gltf" || extension == ".obj") {
    state->request = {path, ""};
    engine->Open(state->request);
  } else if (extension == ".hdr" || extension == ".exr") {
    state->request.environment = path;
    engine->Open(state->request);
  } else if (extension == ".settings") {
    const Status status = LoadViewSettings(path, state);
    if (!status.ok()) {
      AddError(status.message(), state);
    }
  } else {
    AddError("'" + path + "' is none of .glb, .gltf, .hdr, .exr and .settings", state);
  }
}

void DrawDialogs(ViewEngine* engine, ViewerState* state) {
  if (state->dialog != Dialog::kNone) {
    DrawPathDialog(engine, state);
  }
  DrawMessageBox(state);
  DrawHelp(state);
}

}  // namespace stillray::view
