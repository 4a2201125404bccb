// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Renderers with a choice of strategy, for tests.
#pragma once

#include <memory>

#include "render/trace_context.h"

namespace stillray::render {

/// Renderer::Create, for one way to find light.
Result<std::unique_ptr<Renderer>> CreateRenderer(const Scene& scene, const RenderSettings& settings,
                                                 LightStrategy strategy);

}  // namespace stillray::render
