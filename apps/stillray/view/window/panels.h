// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The parts of the window around the image. Each function draws its part and writes changes to the
/// state.
#pragma once

#include "view/view_engine.h"
#include "view/window/layout.h"
#include "view/window/viewer_state.h"

namespace stillray::view {

void DrawMenu(ViewEngine* engine, ViewerState* state);
void DrawPlaybackBar(const Rect& area, ViewerState* state);
/// The side panel with all panels below.
void DrawSidePanel(const Rect& area, ViewerState* state);

void DrawViewPanel(ViewerState* state);
void DrawRenderPanel(ViewerState* state);
void DrawCameraPanel(ViewerState* state);
void DrawParameterPanel(ViewerState* state);
void DrawTimePanel(const ViewerState& state);
void DrawMeasurePanel(ViewerState* state);
void DrawInspectorPanel(ViewerState* state);

/// Path dialogs, the message box and the list of keys.
void DrawDialogs(ViewEngine* engine, ViewerState* state);
void OpenDialog(Dialog dialog, ViewerState* state);
/// Opens a dropped file: a scene, an environment for the current scene, or settings.
void OpenDropped(const std::string& path, ViewEngine* engine, ViewerState* state);

/// Keys of the whole window, except during text input.
void HandleKeys(ViewEngine* engine, ViewerState* state);

}  // namespace stillray::view
